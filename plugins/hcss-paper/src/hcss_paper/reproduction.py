"""What a reproduced table or figure consists of, and the verdict that follows from its checks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from hcss_paper.inputs import AssumedInput, assumed, in_words, origin
from hcss_twin.core.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Verdict = Literal["reproduced", "reproduced with fitted inputs", "not reproducible"]


@dataclass(frozen=True)
class Row:
    """One printed number and what is computed for it.

    Attributes
    ----------
    label : str
        Row and column of the table, or what is read from the figure: ``"3.0-5.0 um, 20 deg"``.
    unit : str
        Of the numbers; ``"1"`` for pure numbers.
    published : float or None
        As printed; None where the paper shows a picture without numbers.
    computed : float or None
        By the paper's equations (``as-printed``); None where they give nothing.
    physical : float or None
        By the corrected physics, where it differs from the printed equations.
    """

    label: str
    unit: str
    published: float | None
    computed: float | None
    physical: float | None = None

    @property
    def difference(self) -> float | None:
        """Computed less published, in the row's unit."""
        if self.published is None or self.computed is None:
            return None
        return self.computed - self.published


@dataclass(frozen=True)
class Check:
    """One statement about the rows, with the measured number and its limit, that holds or fails."""

    statement: str
    holds: bool


@dataclass(frozen=True)
class Drawing:
    """A picture that belongs to the item; ``alternative`` says what it shows."""

    title: str
    figure: Figure
    alternative: str


@dataclass(frozen=True)
class Reproduction:
    """A table or figure, computed again.

    Attributes
    ----------
    verdict : {"reproduced", "reproduced with fitted inputs", "not reproducible"}
    reason : str
        What agrees, or why it cannot.
    rows : sequence of Row
    checks : sequence of Check
        All hold unless the verdict is "not reproducible".
    fitted_inputs : sequence of AssumedInput
        Inputs and readings that the paper does not state and that were fitted or chosen.
    notes : sequence of str
        What differs from the printed equations and why, where inputs come from.
    drawings : sequence of Drawing
    """

    verdict: Verdict
    reason: str
    rows: Sequence[Row]
    checks: Sequence[Check] = ()
    fitted_inputs: Sequence[AssumedInput] = ()
    notes: Sequence[str] = ()
    drawings: Sequence[Drawing] = ()


def verdict_of(checks: Sequence[Check], fitted_inputs: Sequence[AssumedInput]) -> Verdict:
    """Return the verdict of checks; raises ValueError if there is none, because nothing could fail then."""
    if not checks:
        raise ValueError("checks: none given, allowed: one or more; a verdict needs something that can fail")
    if not all(check.holds for check in checks):
        return "not reproducible"
    return "reproduced with fitted inputs" if fitted_inputs else "reproduced"


def judged(
    rows: Sequence[Row],
    checks: Sequence[Check],
    holds: str,
    fails: str,
    *,
    inputs: Sequence[str] = (),
    choices: Sequence[str] = (),
    chosen: Sequence[AssumedInput] = (),
    notes: Sequence[str] = (),
    drawings: Sequence[Drawing] = (),
    missing: str = "",
) -> Reproduction:
    """Return an item with the verdict of its checks.

    Parameters
    ----------
    rows, checks, notes, drawings
        As in :class:`Reproduction`.
    holds, fails : str
        The reason where all checks hold, and where one does not.
    inputs : sequence of str
        Names of the fitted inputs that it uses; how they were fitted is added to the notes.
    choices : sequence of str
        Readings and inputs without a number of their own that were chosen because they give the printed numbers.
    chosen : sequence of AssumedInput
        Both kinds where a figure collects them itself.
    missing : str
        What it would take and is not published: the item is then not reproducible whatever its checks say.
    """
    taken = (*assumed(inputs), *in_words(*choices), *chosen)
    verdict = verdict_of(checks, taken)
    reason = f"{missing} {fails if verdict == 'not reproducible' else holds}".strip()
    if missing:
        verdict = "not reproducible"
    return Reproduction(verdict, reason, rows, checks, taken, (*notes, *([origin(inputs)] if inputs else [])), drawings)


def settled(item: Reproduction) -> Reproduction:
    """Return an item whose verdict claims no more than its checks and inputs allow.

    A failed check makes it "not reproducible"; fitted inputs keep it from "reproduced".
    """
    failed = [check.statement for check in item.checks if not check.holds]
    if item.verdict == "not reproducible":
        return item
    if failed:
        reason = f"{item.reason} But this does not hold: {'; '.join(failed)}."
        return replace(item, verdict="not reproducible", reason=reason)
    if item.fitted_inputs and item.verdict == "reproduced":
        return replace(item, verdict="reproduced with fitted inputs")
    return item


def rms_check(label: str, computed: Array, printed: Array, limit: float) -> Check:
    """Compare two rows (N,) by the root mean square of their relative differences; ``limit`` is a share."""
    rms = float(np.sqrt(np.mean((computed / printed - 1.0) ** 2)))
    statement = f"{label}: rms of relative differences {100 * rms:.2g} %, at most {100 * limit:.2g} %"
    return Check(statement, rms <= limit)


def deviation_check(label: str, computed: Array, printed: Array, limit: float, unit: str) -> Check:
    """Compare two rows (N,) by the root mean square of their differences; ``limit`` is in ``unit``."""
    rms = float(np.sqrt(np.mean((computed - printed) ** 2)))
    return Check(f"{label}: rms of differences {rms:.2g} {unit}, at most {limit:.2g}", rms <= limit)


def largest_check(label: str, computed: Array, printed: Array, limit: float, unit: str) -> Check:
    """Compare two rows (N,) by the largest of their differences; ``limit`` is in ``unit``."""
    largest = float(np.max(np.abs(computed - printed)))
    return Check(f"{label}: largest difference {largest:.2g} {unit}, at most {limit:.2g}", largest <= limit)
