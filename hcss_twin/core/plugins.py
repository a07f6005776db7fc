"""Installed plugins: entry points of a group, read one distribution at a time so that a broken one harms no other.

Imported by ``hcss --help``: nothing beyond the standard library.
"""

from __future__ import annotations

import importlib.metadata
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

OWN_DISTRIBUTION = "hcss-twin"
"""Distribution that brings the defaults."""

FAILURES = (Exception, SystemExit)
"""What a plugin may raise without stopping the program; a user's interrupt is not among them."""


@dataclass(frozen=True)
class Origin:
    """Where a plugin comes from."""

    entry_point: str
    distribution: str
    version: str

    def __str__(self) -> str:
        return f"{self.distribution} {self.version}".strip()


@dataclass(frozen=True)
class BrokenPlugin:
    """A plugin, or a part of one, that cannot be used.

    Attributes
    ----------
    entry_point, distribution, version : str
        Where it comes from.
    error : str
        What went wrong.
    offered : tuple of (Kind, str)
        Providers it would have brought, as far as they became known.
    cause : BaseException or None
        The error itself, to raise from.
    """

    entry_point: str
    distribution: str
    version: str
    error: str
    offered: tuple[tuple[str, str], ...] = ()
    cause: BaseException | None = field(default=None, compare=False, repr=False)

    def __str__(self) -> str:
        return f"{self.distribution} {self.version} (entry point '{self.entry_point}'): {self.error}"


def describe(error: BaseException) -> str:
    """Name an exception in one line."""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def normalised(distribution: str) -> str:
    """Return the form in which distribution names are compared (PEP 503)."""
    return re.sub(r"[-_.]+", "-", distribution).lower()


def installed(group: str) -> Iterator[tuple[Origin, importlib.metadata.EntryPoint | BaseException]]:
    """Yield each entry point of a group, or the error that kept it from being read.

    Distributions are read one by one, because a single malformed ``entry_points.txt`` makes
    ``importlib.metadata.entry_points()`` fail for all. Of a distribution that is twice on the path the first counts,
    as for imports.
    """
    seen: set[str] = set()
    for distribution in importlib.metadata.distributions():
        try:
            text = distribution.read_text("entry_points.txt")
        except FAILURES:
            continue  # unreadable metadata of a package that may have nothing to do with this one
        if not text or group not in text:
            continue
        name, version = _identity(distribution)
        if normalised(name) in seen:
            continue
        seen.add(normalised(name))
        try:
            selected = sorted(distribution.entry_points.select(group=group), key=lambda each: each.name)
        except FAILURES as error:
            yield Origin("entry_points.txt", name, version), error
            continue
        for entry_point in selected:
            yield Origin(entry_point.name, name, version), entry_point


def _identity(distribution: importlib.metadata.Distribution) -> tuple[str, str]:
    try:
        metadata = distribution.metadata
        return str(metadata["Name"] or "unnamed-distribution"), str(metadata["Version"] or "(no version)")
    except FAILURES:
        return "unnamed-distribution", "(no version)"
