"""The check of a cube as text for a terminal."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from hcss_twin.engine.cube_comparison import TOLERANCE, ValueAt, VariableCheck
from hcss_twin.engine.provenance import Change
from hcss_twin.engine.verification import Verdict, Verification

_RULES = {
    "value": "relative to the value",
    "largest": "relative to the largest of the frame",
    "exact": "which must be exact",
}


def verification_text(found: Verification) -> str:
    """Describe what came out, where it differs first, and what may be why."""
    return "\n".join(_lines(found))


def _lines(found: Verification) -> Iterator[str]:
    yield f"{found.cube}: {_verdict(found)}"
    for problem in found.problems:
        yield f"  problem     {problem}"
    if found.problems:
        yield f"  base        relative paths of the scenario lead to {found.base} (--base)"
    yield from _changes("cube", found.layout, "in the cube", "by its scenario")
    for check in found.variables:
        if check.unequal:
            yield from _variable(check)
    for file in found.files:
        at = f", now {file.now_at}" if file.now_at != file.name else ""
        yield f"  file        {file.name}{at}: {file.state}"
        yield f"              recorded sha256 {file.recorded_sha256 or 'none'}"
        yield f"              now      sha256 {file.now_sha256 or 'none'}"
    yield from _changes("provider", found.providers)
    yield from _changes("version", found.versions)
    yield from _changes("attribute", found.attributes)
    causes = found.files or found.providers or found.versions or found.attributes
    if found.verdict in (Verdict.EQUAL, Verdict.DIFFERENT) and not causes:
        yield (
            "  cause       none recorded: files, packages and scenario are those of the cube; its values were changed "
            "since, code was changed under the same version, or another processor rounds otherwise"
        )


def _verdict(found: Verification) -> str:
    every = found.frames_checked == found.frames
    where = f"all {found.frames} frames" if every else f"{found.frames_checked} of {found.frames} frames"
    match found.verdict:
        case Verdict.IDENTICAL:
            return f"identical to the bit ({where})"
        case Verdict.EQUAL:
            return f"equal within {TOLERANCE:g}; the largest relative difference is {found.largest:.1e} ({where})"
        case Verdict.DIFFERENT:
            if any(each.beyond for each in found.variables):
                return f"different; the largest relative difference is {found.largest:.1e} ({where})"
            values = [each.values for each in found.variables]
            told = "what both have is equal" if found.frames_checked and any(values) else "nothing to compare"
            return f"different from what its scenario makes; {told} ({where})"
        case Verdict.NOT_RECOMPUTED:
            return "cannot be recomputed"


def _changes(label: str, changes: Iterable[Change], recorded: str = "recorded", now: str = "now") -> Iterator[str]:
    for each in changes:
        yield f"  {label:<11} {each.what}: {recorded} {each.recorded}; {now} {each.now}"


def _variable(check: VariableCheck) -> Iterator[str]:
    count = check.beyond or check.unequal
    how = "differ" if check.beyond else "differ in their last bits"
    yield (
        f"  values      {check.name}: {count} of {check.values} {how}, by up to {_number(check.largest)}, "
        f"{_RULES[check.relative_to]}"
    )
    if check.first is not None:
        yield f"              first at {_place(check.first)}"
    if check.largest_at is not None and check.largest_at != check.first:
        yield f"              most at {_place(check.largest_at)}"


def _place(place: ValueAt) -> str:
    position = ", ".join(f"{name} {value}" for name, value in place.position.items())
    where = f"{position}: " if position else ""
    return f"{where}{place.cube:.9g} in the cube, {place.recomputed:.9g} recomputed"


def _number(value: float) -> str:
    return "more than any number (one of both is missing)" if math.isinf(value) else f"{value:.1e}"
