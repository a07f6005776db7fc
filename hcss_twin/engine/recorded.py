"""What the check of a cube against its own recomputation found.

What a cube records about how it was made, and what of it is different today.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path, PurePath
from typing import Any

import numpy as np

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.environment import installed_version, versions
from hcss_twin.core.errors import CubeError, ProviderError
from hcss_twin.core.json_numbers import json_number, json_value
from hcss_twin.cube.header import FORMAT_ATTRIBUTE, SCENARIO_ATTRIBUTE
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.registry import Registry

TOLERANCE = 1e-6
"""Largest difference of what counts as equal; single precision resolves 6e-8."""


class Verdict(StrEnum):
    """Outcome of a check."""

    IDENTICAL = "identical"
    EQUAL = "equal"
    DIFFERENT = "different"
    NOT_RECOMPUTED = "not recomputed"


@dataclass(frozen=True)
class Change:
    """Something that is not as the cube records it.

    Attributes
    ----------
    what : str
        A library, a kind of provider, a key of the scenario, a dimension.
    recorded, now : str
        What the cube says or holds, and what its recomputation has.
    """

    what: str
    recorded: str
    now: str


@dataclass(frozen=True)
class FileChange:
    """A file of which the recomputation does not read what the cube was made from.

    Attributes
    ----------
    name : str
        Name in the catalog or path, as the cube records it.
    state : str
        ``changed``, ``missing``, ``no longer read`` or ``not read before``.
    recorded_sha256, now_sha256 : str or None
        Hashes; None where there is no such file.
    now_at : str
        Where the file of today was found.
    """

    name: str
    state: str
    recorded_sha256: str | None
    now_sha256: str | None
    now_at: str


@dataclass(frozen=True)
class Place:
    """One value of a variable.

    Attributes
    ----------
    position : mapping
        Frame, row and column by number from 0, band and layer by name.
    cube, recomputed : float
        Both values.
    """

    position: Mapping[str, int | str]
    cube: float
    recomputed: float


@dataclass(frozen=True)
class VariableCheck:
    """The comparison of one variable.

    Attributes
    ----------
    name : str
    relative_to : str
        What differences are relative to: ``value``, ``largest`` (of the variable in the frame, or in the tile of a
        large one) or ``exact`` where any difference counts.
    values, unequal, beyond : int
        Values compared, those that are not the same to the bit, and those beyond the tolerance.
    largest : float
        Largest relative difference; infinite where only one of both is a number.
    largest_at, first : Place or None
        Where it is, and the first value beyond the tolerance, or without such the first that is unequal.
    """

    name: str
    relative_to: str
    values: int
    unequal: int
    beyond: int
    largest: float
    largest_at: Place | None
    first: Place | None


@dataclass(frozen=True)
class Verification:
    """A cube compared with what its own provenance makes today.

    Attributes
    ----------
    cube, base : str
        The file, and the folder where relative paths of its scenario lead.
    frames, frames_checked : int
        Frames of the cube, and how many of them were recomputed.
    problems : tuple of str
        Why it could not be recomputed; empty where it was.
    layout : tuple of Change
        Dimensions, variables and types that are not those the scenario makes.
    files : tuple of FileChange
    versions, providers, attributes : tuple of Change
        Possible causes; they do not make a cube different by themselves.
    variables : tuple of VariableCheck
        Coordinates first.
    """

    cube: str
    base: str
    frames: int
    frames_checked: int = 0
    problems: tuple[str, ...] = ()
    layout: tuple[Change, ...] = ()
    files: tuple[FileChange, ...] = ()
    versions: tuple[Change, ...] = ()
    providers: tuple[Change, ...] = ()
    attributes: tuple[Change, ...] = ()
    variables: tuple[VariableCheck, ...] = ()

    @property
    def verdict(self) -> Verdict:
        """Outcome."""
        if self.problems:
            return Verdict.NOT_RECOMPUTED
        if self.layout or any(each.beyond for each in self.variables):
            return Verdict.DIFFERENT
        if any(each.unequal for each in self.variables):
            return Verdict.EQUAL
        return Verdict.IDENTICAL

    @property
    def passed(self) -> bool:
        """Whether the cube is identical, or equal within the tolerance."""
        return self.verdict in (Verdict.IDENTICAL, Verdict.EQUAL)

    @property
    def largest(self) -> float:
        """Largest relative difference of all variables."""
        return max((each.largest for each in self.variables), default=0.0)

    def as_dict(self) -> dict[str, Any]:
        """Plain values for ``hcss verify --json``; numbers that JSON does not have are None."""
        return {
            "verdict": str(self.verdict),
            "passed": self.passed,
            "tolerance": TOLERANCE,
            "largest_difference": json_number(self.largest),
            **{
                name: [_plain(each) for each in value] if isinstance(value, tuple) else value
                for name, value in vars(self).items()
            },
        }


def _plain(value: Any) -> Any:
    if isinstance(value, Change | FileChange | Place | VariableCheck):
        return {name: _plain(each) for name, each in vars(value).items()}
    return json_value(value)


_VERSIONS, _PROVIDERS, _FILES = "hcss_versions", "hcss_providers", "hcss_files_sha256"
_TOLD_APART = (SCENARIO_ATTRIBUTE, _VERSIONS, _PROVIDERS, _FILES)
CERTIFICATE = (
    "hcss_certificate",
    "hcss_accuracy_achieved",
    "hcss_accuracy_achieved_kelvin",
    "hcss_certificate_terms",
    "hcss_certificate_pixels",
    "hcss_certificate_strata",
)
"""The certificate: what was checked then is not checked again, because all of it is."""

CLEAN_CERTIFICATE = "hcss_clean_certificate"
"""That of the clean cube, as a measured one quotes it."""

_NOT_REPEATED = (*CERTIFICATE, CLEAN_CERTIFICATE)

_LONGEST = 120


@dataclass(frozen=True)
class Recorded:
    """Provenance of a cube.

    Parameters
    ----------
    attributes : mapping
        Global attributes of the file.
    scenario : mapping
        The scenario, as JSON holds it.
    versions : mapping of str to str
        By distribution.
    providers : mapping
        ``name``, ``distribution`` and ``version`` by kind; clouds of several layers are numbered.
    files : mapping of str to str
        SHA-256 by name in the catalog, or by absolute path.
    """

    attributes: Mapping[str, Any]
    scenario: Mapping[str, Any]
    versions: Mapping[str, str]
    providers: Mapping[str, Mapping[str, str]]
    files: Mapping[str, str]

    @classmethod
    def of(cls, attributes: Mapping[str, Any], path: str) -> Recorded:
        """Read the attributes of a cube.

        Raises
        ------
        CubeError
            If one is missing or malformed.
        """
        scenario, made_with, providers, files = (_table(attributes, name, path) for name in _TOLD_APART)
        for name, table in (
            (_VERSIONS, made_with),
            (_FILES, files),
            *((_PROVIDERS, each) for each in providers.values()),
        ):
            if not isinstance(table, dict) or not all(isinstance(each, str) for each in table.values()):
                raise CubeError(f"{path}: the global attribute {name} is malformed; texts by name are needed")
        for kind, provider in providers.items():
            if not {"name", "distribution", "version"} <= set(provider):
                raise CubeError(f"{path}: the global attribute {_PROVIDERS} does not say who brought '{kind}'")
        return cls(attributes, scenario, made_with, providers, files)

    def bases(self) -> list[Path]:
        """Return the folders from which relative paths of the scenario lead to files the cube was made from."""
        found: dict[Path, None] = {}
        for text in _texts(self.scenario):
            relative = PurePath(text)
            count = len(relative.parts)
            for file in map(Path, self.files):
                if 0 < count < len(file.parts) and file.is_absolute() and file.parts[-count:] == relative.parts:
                    found[file.parents[count - 1]] = None
        return [folder for folder in found if folder.is_dir()]

    def version_changes(self) -> tuple[Change, ...]:
        """Return the distributions that are installed in another version."""
        now = versions()
        return tuple(
            Change(name, version, now.get(name) or installed_version(name))
            for name, version in self.versions.items()
            if (now.get(name) or installed_version(name)) != version
        )

    def provider_changes(self, entries: Mapping[str, Entry] | None) -> tuple[Change, ...]:
        """Return the providers that another package or version brings, or nobody.

        Parameters
        ----------
        entries : mapping of str to Entry or None
            Those of the recomputation, by kind; None where it did not come so far.
        """
        registry = Registry.discover()
        changes = []
        for kind, each in self.providers.items():
            before = f"{each['name']} of {each['distribution']} {each['version']}"
            entry = None if entries is None else entries.get(kind)
            now = _who(registry, kind, each) if entry is None else f"{entry.name} of {entry.origin}"
            if now != before:
                changes.append(Change(kind, before, now))
        return tuple(changes)

    def file_changes(self, used: Mapping[str, str] | None) -> tuple[FileChange, ...]:
        """Return the files that are not those the cube was made from.

        Parameters
        ----------
        used : mapping of str to str or None
            SHA-256 of the files that the recomputation read, by name; None where it did not come so far.
        """
        changes = []
        new = {name: digest for name, digest in (used or {}).items() if name not in self.files}
        for name, recorded in self.files.items():
            at, now, state = name, (used or {}).get(name), "changed"
            if now is None and (moved := _moved(name, new)):
                at, now = moved, new.pop(moved)
            if now is None:
                now = _digest(name)
                if now is None:
                    state = "missing"
                elif used is not None:
                    state = "no longer read"
            if now != recorded or state != "changed":
                changes.append(FileChange(name, state, recorded, now, at))
        changes += [FileChange(name, "not read before", None, digest, name) for name, digest in new.items()]
        return tuple(changes)

    def attribute_changes(self, now: Mapping[str, Any]) -> tuple[Change, ...]:
        """Return keys of the scenario, and attributes the engine writes, that come out otherwise.

        Parameters
        ----------
        now : mapping
            The attributes of the recomputation.
        """
        before = dict(_leaves(self.scenario, ""))
        after = dict(_leaves(json.loads(now[SCENARIO_ATTRIBUTE]), ""))
        changes = [
            Change(f"scenario key {key}", _short(before.get(key)), _short(after.get(key)))
            for key in dict.fromkeys((*before, *after))
            if before.get(key) != after.get(key)
        ]
        engine = dict.fromkeys((*self.attributes, *now))
        for name in engine:
            if name.startswith("hcss_") and name not in (*_TOLD_APART, *_NOT_REPEATED, FORMAT_ATTRIBUTE):
                recorded, value = self.attributes.get(name), now.get(name)
                if not np.array_equal(recorded, value):  # type: ignore[arg-type]
                    changes.append(Change(name, _short(recorded), _short(value)))
        return tuple(changes)


def _table(attributes: Mapping[str, Any], name: str, path: str) -> dict[str, Any]:
    text = attributes.get(name)
    if not isinstance(text, str):
        raise CubeError(f"{path} carries no {name}; this global attribute is needed to recompute a cube")
    try:
        table = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise CubeError(f"{path}: the global attribute {name} is not valid JSON: {error}") from error
    if not isinstance(table, dict):
        raise CubeError(f"{path}: the global attribute {name} is malformed; a table is needed")
    return table


def _who(registry: Registry, kind: str, provider: Mapping[str, str]) -> str:
    """Say who would bring a provider today."""
    distribution, name = provider["distribution"], provider["name"]
    try:
        entry = registry.resolve(kind.partition("[")[0], f"{distribution}/{name}")
    except (ProviderError, ValueError):
        version = installed_version(distribution)
        return (
            f"{distribution} is not installed"
            if version == "not installed"
            else (f"{distribution} {version} does not bring it")
        )
    return f"{entry.name} of {entry.origin}"


def _moved(name: str, new: Mapping[str, str]) -> str | None:
    """Find a user's file of the same name elsewhere."""
    if not Path(name).is_absolute():
        return None
    alike = [each for each in new if Path(each).is_absolute() and Path(each).name == Path(name).name]
    return alike[0] if len(alike) == 1 else None


def _digest(name: str) -> str | None:
    """Hash a recorded file as it is today; None where there is none, or a name that leads out of the catalog."""
    path = Path(name) if Path(name).is_absolute() else Catalog().root / name
    if ".." in path.parts:
        return None
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else None
    except (OSError, ValueError):
        return None


def _texts(value: Any) -> Iterator[str]:
    for _, leaf in _leaves(value, ""):
        if isinstance(leaf, str):
            yield leaf


def _leaves(value: Any, key: str) -> Iterator[tuple[str, Any]]:
    """Yield values by their dotted keys; empty tables and lists count as values."""
    if isinstance(value, dict) and value:
        for name, each in value.items():
            yield from _leaves(each, f"{key}.{name}" if key else name)
    elif isinstance(value, list) and value:
        for index, each in enumerate(value):
            yield from _leaves(each, f"{key}[{index}]")
    else:
        yield key, value


def _short(value: Any) -> str:
    text = "none" if value is None else str(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."
