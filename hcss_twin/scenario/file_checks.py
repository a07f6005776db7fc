"""Checks of files that describe more than one scene: `hcss validate` asks the package that computes them.

A package names a function in the entry point group ``hcss_twin.checks``; the name of the entry point is the section of
a scenario file that makes it a file of the package, such as ``sweep``. The function takes the name of the file, the
overrides (dotted key to value), and what wraps an iterable of its length to show progress. It returns one line of text
and the same as a mapping for ``--json``; it raises ScenarioError with all problems.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeAlias

from hcss_twin.core.errors import HcssError, ScenarioError
from hcss_twin.core.plugins import FAILURES, describe, installed
from hcss_twin.scenario.models import ScenarioModel
from hcss_twin.scenario.scenario import MANY, Scenario

GROUP = "hcss_twin.checks"

Progress: TypeAlias = Callable[[Iterable[Any], int], Iterable[Any]]
Check: TypeAlias = Callable[[str, Mapping[str, Any], Progress], tuple[str, Mapping[str, Any]]]

FOLDERS = ("scenarios", "sweeps")
"""Catalog folders in which names are looked up."""


def check_of(source: str) -> Check | None:
    """Return the function that checks a file of another package; None for a scenario, or if it cannot be read.

    Raises
    ------
    ScenarioError
        If it is the file of a sweep or data set and the package that makes them is not installed.
    HcssError
        If the function cannot be imported.
    """
    try:
        raw: Any = Scenario.read_file(source, FOLDERS)[0]
    except ScenarioError:
        return None
    unknown = set(raw) - set(ScenarioModel.model_fields) if isinstance(raw, Mapping) else set()
    for origin, entry in installed(GROUP) if unknown else ():
        if not isinstance(entry, BaseException) and entry.name in unknown:
            try:
                found: Check = entry.load()
            except FAILURES as error:
                raise HcssError(f"check '{entry.name}' of {origin} cannot be imported: {describe(error)}") from error
            return found
    if unknown.intersection(MANY):
        Scenario.from_dict(raw, origin=source)  # names the package
    return None
