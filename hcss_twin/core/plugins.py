"""Installed plugins: entry points of a group, read per distribution so that a broken one does not affect the others.

``hcss --help`` imports this module, so it uses the standard library only.
"""

from __future__ import annotations

import importlib.metadata
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

OWN_DISTRIBUTION = "hcss-twin"
"""Distribution that contains the default providers."""

FAILURES = (Exception, SystemExit)
"""Exceptions of a plugin that do not stop the program; a keyboard interrupt does."""


@dataclass(frozen=True)
class Origin:
    """Distribution of a plugin."""

    entry_point: str
    distribution: str
    version: str

    def __str__(self) -> str:
        return f"{self.distribution} {self.version}".strip()


@dataclass(frozen=True)
class BrokenPlugin:
    """A plugin, or part of one, that cannot be used.

    Attributes
    ----------
    entry_point, distribution, version : str
        Origin of the plugin.
    error : str
        Cause, as text.
    offered : tuple of (Kind, str)
        Providers that it was to define, as far as known.
    cause : BaseException or None
        The original exception, for chaining.
    """

    entry_point: str
    distribution: str
    version: str
    error: str
    offered: tuple[tuple[str, str], ...] = ()
    cause: BaseException | None = field(default=None, compare=False, repr=False)

    def __str__(self) -> str:
        return f"{self.distribution} {self.version} (entry point '{self.entry_point}'): {self.error}"


@dataclass(frozen=True)
class Remark:
    """What ``hcss plugins`` says of a plugin that works.

    Attributes
    ----------
    topic : {"optional hook", "unknown hook", "slow import"}
        A hook that this version lacks, marked as optional or not, or an import above :data:`SLOW_IMPORT_S`.
    """

    origin: Origin
    topic: Literal["optional hook", "unknown hook", "slow import"]
    text: str

    def __str__(self) -> str:
        return f"{self.origin} (entry point '{self.origin.entry_point}'): {self.text}"


SLOW_IMPORT_S = 0.3
"""Seconds of an import of a plugin's hooks above which ``hcss plugins`` names it."""


def slow_import(origin: Origin, module: str, seconds: float) -> tuple[Remark, ...]:
    """Return a remark on an import that took too long."""
    if seconds <= SLOW_IMPORT_S:
        return ()
    text = (
        f"the import of '{module}' took {seconds:.1f} s, for which commands of hcss wait; allowed: {SLOW_IMPORT_S:g} "
        "s. The module with the hooks should import no other module of the plugin"
    )
    return (Remark(origin, "slow import", text),)


MOVING = "docs/how-to/moving-to-api-3.md"
"""Page that tells how to move a plugin to the present version of the provider API."""


def describe(error: BaseException) -> str:
    """Describe an exception in one line; of a plugin that imports what this package had, name the page that helps."""
    text = " ".join(str(error).split())
    if isinstance(error, ImportError) and (error.name or "").partition(".")[0] == "hcss_twin":
        text += f"; plugins written for an older provider API import it: {MOVING}"
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def normalised(distribution: str) -> str:
    """Return the normalised distribution name (PEP 503)."""
    return re.sub(r"[-_.]+", "-", distribution).lower()


def installed(group: str) -> Iterator[tuple[Origin, importlib.metadata.EntryPoint | BaseException]]:
    """Yield each entry point of a group, or the error raised while reading it.

    Distributions are read one by one, because a single malformed ``entry_points.txt`` makes
    ``importlib.metadata.entry_points()`` fail for all. If a distribution is on the path twice, the first is
    used, as for imports.
    """
    seen: set[str] = set()
    for distribution in importlib.metadata.distributions():
        try:
            text = distribution.read_text("entry_points.txt")
        except FAILURES:
            continue  # unreadable metadata of a package that may be unrelated
        if not text or group not in text:
            continue
        name, version = _identity(distribution)
        if normalised(name) in seen:
            continue
        seen.add(normalised(name))
        try:
            selected = sorted(distribution.entry_points.select(group=group), key=lambda entry_point: entry_point.name)
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
