"""What a plan leaves out, as a short table: the largest first, what loses nothing in one line."""

from __future__ import annotations

import re
from collections.abc import Iterator

from hcss_twin.scene.ledger.entry import Skipped
from hcss_twin.scene.plan import Plan

_NUMBERED = re.compile(r"(.*?)(\d+)")


def left_out(plan: Plan) -> Iterator[tuple[str, str]]:
    """Yield bound and text of each line; what ``hcss plan --json`` says at length is cut to its first clause."""
    # Of several layers the ledger names the layer, too.
    own = {
        (what if len(plan.layers) == 1 else f"{layer.name}: {what}"): what
        for layer, generator in zip(plan.layers, plan.generators, strict=True)
        for what, _ in getattr(generator, "skipped", ())
    }
    bounded = [item for item in plan.skipped if item.bound]
    for item in sorted(bounded, key=lambda item: -(item.bound or 0.0)):
        yield _share(item.bound or 0.0), _told(item)
    for item in plan.skipped:
        if item.bound is None and item.what not in own:
            yield "unknown", _told(item)
    nothing = [item for item in plan.skipped if item.bound == 0.0]
    if nothing:
        yield "nothing", "; ".join(f"{item.what} ({_reason(item.why)})" for item in nothing)
    details = [own[item.what] for item in plan.skipped if item.bound is None and item.what in own]
    if details:
        yield "in law", f"equal in law or nearly, not by pixel: {'; '.join(_gathered(details))}"


def _told(item: Skipped) -> str:
    return f"{item.what}: {_first_clause(item.why)}"


def _first_clause(why: str) -> str:
    return why.partition(";")[0]


def _reason(why: str) -> str:
    """First clause without the list that may follow it."""
    return _first_clause(why).partition(":")[0]


def _share(bound: float) -> str:
    """Write a share of the radiance."""
    return f"{bound:.2g} x" if bound >= 1.0 else f"{100.0 * bound:.2g} %"


def _gathered(details: list[str]) -> Iterator[str]:
    """Gather what is said of several octaves, as ``interpolation of octave 5 along x``, from the first to the last."""
    groups: dict[str, list[str]] = {}
    for what in details:
        match = _NUMBERED.fullmatch(what.partition(" along ")[0])
        name, number = match.groups() if match else (what, "")
        groups.setdefault(name, []).append(number)
    for name, numbers in groups.items():
        distinct = sorted(set(numbers), key=lambda number: int(number or 0))
        yield name + (distinct[0] if len(distinct) == 1 else f"{distinct[0]} to {distinct[-1]}")
