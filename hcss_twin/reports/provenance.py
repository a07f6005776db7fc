"""Provenance of a file, for its reproduction: blocks for all reports."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from datetime import datetime
from typing import Any, TypeVar

from hcss_twin.cube.header import SCENARIO_ATTRIBUTE
from hcss_twin.cube.metadata import AS_SPECIFIED, NOT_AS_SPECIFIED, NOT_CHECKED, creation_time
from hcss_twin.reports.page import Markup
from hcss_twin.reports.tables import Table

_VERDICTS: Mapping[str, tuple[str, Markup.Tone]] = {
    AS_SPECIFIED: (AS_SPECIFIED, "good"),
    NOT_AS_SPECIFIED: (NOT_AS_SPECIFIED, "bad"),
    NOT_CHECKED: (NOT_CHECKED, "fair"),
    "PASSED": (AS_SPECIFIED, "good"),
    "FAILED": (NOT_AS_SPECIFIED, "bad"),
    "NOTHING CHECKED": (NOT_CHECKED, "fair"),
}
"""First words of a certificate, those of cubes of earlier versions included: what they mean, and how they look."""

_KELVIN = re.compile(r"differ by at most [^(;]*?([\d.e-]+ K)")

__all__ = ["Provenance"]

_T = TypeVar("_T", list[Any], dict[str, Any])


class Provenance:
    """What attributes of a file say of its origin, as blocks of pages."""

    @staticmethod
    def value(attributes: Mapping[str, Any], name: str, default: _T) -> _T:
        """Return a parsed JSON attribute; the default if it is absent, invalid or of another type."""
        try:
            value: _T = json.loads(str(attributes[name]))
        except (KeyError, ValueError):
            return default
        return value if isinstance(value, type(default)) else default

    @staticmethod
    def badge(certificate: object, prefix: str = "") -> Markup | None:
        """Return the verdict of a certificate, with the largest error in kelvin; None without a certificate."""
        words = str(certificate or "")
        for verdict, (meaning, tone) in _VERDICTS.items():
            if words.startswith(verdict):
                kelvin = _KELVIN.search(words)
                return Markup.badge(f"{prefix}{meaning}{f', within {kelvin[1]}' if kelvin else ''}", tone)
        return None

    @staticmethod
    def blocks(
        attributes: Mapping[str, Any],
        file: str,
        keys: Mapping[str, str],
        inputs: Sequence[tuple[str, str]] = (),
        shown: Callable[[str], bool] = lambda name: False,
    ) -> Iterator[Markup.Block]:
        """Yield file, versions, inputs and all other attributes of a file.

        Parameters
        ----------
        attributes : mapping
            Global attributes of the file.
        file : str
            Its name and size.
        keys : mapping of str to str
            Attribute names and labels of the entries shown first.
        inputs : sequence of (str, str)
            Input files with their SHA-256.
        shown : callable
            Whether an attribute is shown elsewhere on the page.
        """
        versions = Provenance.versions(Provenance.value(attributes, "hcss_versions", {}))
        pairs = [
            ("file", file),
            *((label, str(attributes[name])) for name, label in keys.items() if name in attributes),
        ]
        yield Markup.facts([*pairs, ("versions", versions)] if versions else pairs)
        if inputs:
            yield Table(["file", "SHA-256"], inputs, "Files that were read.", text_columns=2)
        others = [(name, str(value)) for name, value in attributes.items() if name not in keys and not shown(name)]
        others = [(name, value) for name, value in others if value not in ("", "unknown")]
        if others:
            yield Markup.folded("All other global attributes", Markup.facts(others))

    @staticmethod
    def creation_time() -> datetime:
        """Return the current time, or the time set by the environment variable SOURCE_DATE_EPOCH; raises CubeError."""
        return creation_time()

    @staticmethod
    def versions(versions: Mapping[str, Any]) -> str:
        """Return names of packages with their versions."""
        return ", ".join(f"{name} {version}" for name, version in versions.items())

    @staticmethod
    def origin(attributes: Mapping[str, Any]) -> Iterator[Markup.Block]:
        """Yield providers, hashes of the files read, and the scenario of a cube."""
        providers = Provenance.value(attributes, "hcss_providers", {})
        if providers:
            header = ["kind", "provider", "distribution", "version"]
            keys = ("name", "distribution", "version")
            rows = [[kind, *(str(provider.get(key, "")) for key in keys)] for kind, provider in providers.items()]
            yield Table(header, rows, text_columns=4)
        hashes = Provenance.value(attributes, "hcss_files_sha256", {})
        if hashes:
            listed = Table(["file", "SHA-256"], list(hashes.items()), text_columns=2)
            yield Markup.folded("SHA-256 of the files that were read", listed)
        if SCENARIO_ATTRIBUTE in attributes:
            yield Provenance.scenario(
                attributes[SCENARIO_ATTRIBUTE], " (saved as NAME.json, hcss run reproduces the cube)"
            )

    @staticmethod
    def scenario(text: object, use: str = "") -> Markup:
        """Return the scenario of a file in a collapsible block."""
        return Markup.folded(f"The scenario with every default filled in{use}", Markup.preformatted(str(text)))

    @staticmethod
    def names_in(names: Collection[str], *prefixes: str) -> Callable[[str], bool]:
        """Return whether an attribute has one of the names or prefixes."""
        return lambda name: name in names or name.startswith(prefixes)
