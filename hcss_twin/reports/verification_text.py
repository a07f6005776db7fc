"""Verification of a cube against its recomputation, as text for a terminal."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from hcss_twin.engine.cube_comparison import TOLERANCE, ValueAt, VariableCheck
from hcss_twin.engine.provenance import Change
from hcss_twin.engine.verification import Verdict, Verification
from hcss_twin.reports.tables import Table

_RULES = {
    "value": "relative to the value",
    "largest": "relative to the largest of the frame",
    "exact": "which must be exact",
}

Rows = Iterator[tuple[str, str]]


def verification_text(check: Verification) -> str:
    """Describe the result, the location of the first differences, and their possible causes."""
    rows = (Table.labelled(label, text, 12) for label, text in _rows(check))
    return "\n".join([f"{check.cube}: {_verdict(check)}", *rows])


def _rows(check: Verification) -> Rows:
    yield from (("problem", problem) for problem in check.problems)
    if check.problems:
        yield "base", f"relative paths of the scenario start at {check.base} (--base)"
    yield from _changes("cube", check.layout, "in the cube", "by its scenario")
    for variable in check.variables:
        if variable.unequal:
            yield from _variable(variable)
    for file in check.files:
        yield "file", f"{file.name}{f', now {file.now_at}' if file.now_at != file.name else ''}: {file.state}"
        yield "", f"recorded sha256 {file.recorded_sha256 or 'none'}"
        yield "", f"now      sha256 {file.now_sha256 or 'none'}"
    yield from _changes("provider", check.providers)
    yield from _changes("version", check.versions)
    yield from _changes("attribute", check.attributes)
    causes = check.files or check.providers or check.versions or check.attributes
    if check.verdict in (Verdict.EQUAL, Verdict.DIFFERENT) and not causes:
        yield (
            "cause",
            "none recorded: files, packages and scenario match those of the cube. Its values were changed later, code "
            "was changed within the same version, or another processor rounds differently",
        )


def _verdict(check: Verification) -> str:
    every = check.frames_checked == check.frames
    frames = f"all {check.frames} frames" if every else f"{check.frames_checked} of {check.frames} frames"
    largest = f"the largest relative difference is {check.largest:.1e}"
    match check.verdict:
        case Verdict.IDENTICAL:
            return f"bit-identical ({frames})"
        case Verdict.EQUAL:
            return f"equal within {TOLERANCE:g}; {largest} ({frames})"
        case Verdict.DIFFERENT:
            if any(variable.beyond for variable in check.variables):
                return f"different; {largest} ({frames})"
            compared = check.frames_checked and any(variable.values for variable in check.variables)
            common = "common variables are equal" if compared else "nothing to compare"
            return f"different from the result of its scenario; {common} ({frames})"
        case Verdict.NOT_RECOMPUTED:
            return "cannot be recomputed"


def _changes(label: str, changes: Iterable[Change], recorded: str = "recorded", now: str = "now") -> Rows:
    return ((label, f"{change.what}: {recorded} {change.recorded}; {now} {change.now}") for change in changes)


def _variable(check: VariableCheck) -> Rows:
    count = check.beyond or check.unequal
    how = "differ" if check.beyond else "differ in their last bits"
    size = "infinity (one of the two is missing)" if math.isinf(check.largest) else f"{check.largest:.1e}"
    rule = _RULES[check.relative_to]
    yield "values", f"{check.name}: {count} of {check.values} {how}, by up to {size}, {rule}"
    if check.first is not None:
        yield "", f"first at {_place(check.first)}"
    if check.largest_at is not None and check.largest_at != check.first:
        yield "", f"most at {_place(check.largest_at)}"


def _place(value_at: ValueAt) -> str:
    position = ", ".join(f"{name} {value}" for name, value in value_at.position.items())
    where = f"{position}: " if position else ""
    return f"{where}{value_at.cube:.9g} in the cube, {value_at.recomputed:.9g} recomputed"
