"""What ``hcss run`` says: what was written, whether it is right, how true it is, what is left out, what to do next."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hcss_twin.plan.error_budget import ErrorBudget
from hcss_twin.plan.few_columns import OMISSION_SHARE, SWITCHED_OFF, Omission
from hcss_twin.plan.plan import Plan

if TYPE_CHECKING:
    from hcss_twin.engine.certificate.certificate import Certificate

MOST_BANDS, MOST_CLASSES = 4, 2
"""Columns and rows of the table of errors; ``--verbose`` has all."""

_ALIKE = 1.5
"""An omission is one share of the radiance for all bands: it is a temperature only where these agree so far."""


def run_text(plan: Plan, certificate: Certificate | None, output: Path, written: Sequence[str]) -> Iterator[str]:
    """Yield what a run says, about eight lines.

    Parameters
    ----------
    certificate : Certificate or None
        None if no pixel was checked.
    output : Path
        The cube.
    written : sequence of str
        A line for each file.
    """
    yield from written
    if certificate is not None:
        yield certificate.verdict
        if certificate.budget is not None:
            yield from _errors(certificate.budget)
    elif plan.needs_radiance:
        yield "computed, NOT CHECKED: output.certificate is 0"
    left_out = [*_left_out(plan, certificate, _kelvin_of_one(certificate))]
    if left_out:
        yield "; ".join(left_out)
    if filled := plan.filled_in:
        yield "assumed: " + "; ".join(f"{item.field} = {item.value}" for item in filled)
    yield f"next: hcss preview {output}; hcss report {output}"


def _kelvin_of_one(certificate: Certificate | None) -> float:
    """Return a change of brightness temperature over the relative change of radiance; 0 where bands differ in it."""
    budget = certificate.budget if certificate is not None else None
    cells = budget.contributions.values() if budget is not None else ()
    found = [(cell[0].kelvin or 0.0) / cell[0].relative for cell in cells if cell[0].relative]
    return max(found) if found and max(found) < _ALIKE * min(found) else 0.0


def _left_out(plan: Plan, certificate: Certificate | None, kelvin_of_one: float) -> Iterator[str]:
    """Yield what is left out beyond its share of the accuracy: no model has it, the user's choice, the plan's."""
    if certificate is not None and certificate.beyond:
        yield f"NOT WITHIN the accuracy: {_first(certificate.beyond)}"
    limit = OMISSION_SHARE * plan.accuracy.relative
    large = [omission for omission in plan.omissions if omission.decision and omission.exceeds(limit)]
    large.sort(key=lambda omission: -(omission.size or 0.0))
    for heading, by_user in (("switched off by you", True), ("left out for its time", False)):
        chosen = [omission for omission in large if (omission.decision == SWITCHED_OFF) == by_user]
        if chosen:
            yield f"{heading}, not in these figures: {_first([_omitted(each, kelvin_of_one) for each in chosen])}"


def _errors(budget: ErrorBudget) -> Iterator[str]:
    """Yield a table of the total error by class and band, with the largest cause."""
    bands = [*dict.fromkeys(band for _, band in budget.contributions)]
    classes = [*dict.fromkeys(of for of, _ in budget.contributions)]
    if len(classes) > MOST_CLASSES:  # the classes with the largest error
        classes = sorted(classes, key=lambda of: -max(budget.total((of, band))[1] for band in bands))[:MOST_CLASSES]
    shown = bands[:MOST_BANDS]
    rows = [["how true: rms error of models, not of your inputs (>: part unknown)", *shown]]
    rows += [[f"  {of}", *(_cell(budget, of, band) for band in shown)] for of in classes]
    widths = [max(len(row[column]) for row in rows) for column in range(len(shown) + 1)]
    for row in rows:
        yield "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip()


def _cell(budget: ErrorBudget, of: str, band: str) -> str:
    largest = max(budget.contributions[of, band], key=lambda contribution: contribution.relative or 0.0)
    least = "> " if budget.unknown((of, band)) else ""
    unknown = [contribution for contribution in budget.contributions[of, band] if contribution.unknown]
    unknown.sort(key=lambda contribution: contribution.relative is not None)  # what has no figure at all goes first
    part = "part of " if unknown and unknown[0].relative is not None else ""
    rest = f"; {part}{unknown[0].name} unknown" if unknown else ""
    return f"{least}{budget.total((of, band))[1]:.2g} K, {largest.name}{rest}"


def _omitted(omission: Omission, kelvin_of_one: float) -> str:
    size = omission.size or 0.0
    kelvin = f", about {size * kelvin_of_one:.2g} K" if kelvin_of_one and " K" not in omission.sense else ""
    sense = omission.sense or "at most, any pixel"
    return f"{omission.what}, {100.0 * size:.2g} %{kelvin} ({sense}), needs {omission.needs}"


def _first(texts: Sequence[str]) -> str:
    more = f", and {len(texts) - 1} more" if len(texts) > 1 else ""
    return texts[0] + more
