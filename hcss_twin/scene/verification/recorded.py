"""What a cube records about how it was made, and what of it is different today."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePath
from typing import Any

import numpy as np

from hcss_twin.catalog import Catalog
from hcss_twin.cube.header import FORMAT_ATTRIBUTE, SCENARIO_ATTRIBUTE
from hcss_twin.errors import CubeError, ProviderError
from hcss_twin.registry.discovery import Entry
from hcss_twin.registry.registry import Registry
from hcss_twin.scene.verification.verification import Change, FileChange
from hcss_twin.versions import installed_version, versions

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
                raise CubeError(
                    f"{path}: the global attribute {_PROVIDERS} does not say who brought '{kind}'"
                )
        return cls(attributes, scenario, made_with, providers, files)

    def bases(self) -> list[Path]:
        """Return the folders from which relative paths of the scenario lead to files the cube was made from."""
        found: dict[Path, None] = {}
        for text in _texts(self.scenario):
            relative = PurePath(text)
            count = len(relative.parts)
            for file in map(Path, self.files):
                if (
                    0 < count < len(file.parts)
                    and file.is_absolute()
                    and file.parts[-count:] == relative.parts
                ):
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
