"""Data of a reproduced table or figure, and the verdict that follows from its checks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from hcss_paper.inputs import AssumedInput, assumed, in_words, origin
from hcss_twin.providers import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Verdict = Literal["reproduced", "reproduced with fitted inputs", "not reproducible"]


@dataclass(frozen=True)
class Row:
    """One printed number and the computed ones.

    Attributes
    ----------
    label : str
        Row and column of the table, or quantity of the figure: ``"3.0-5.0 um, 20 deg"``.
    unit : str
        Unit of the numbers; ``"1"`` for dimensionless ones.
    published : float or None
        As printed; None if the paper shows a picture without numbers.
    computed : float or None
        Computed with the paper's equations (``as-printed``); None if they do not give it.
    physical : float or None
        Computed with the corrected physics, if it differs from the printed equations.
    mixture : float or None
        Clear and opaque column mixed with a fitted effective cover, beside the cube at the printed coverage. It decides
        no verdict, because no scene contains it.
    """

    label: str
    unit: str
    published: float | None
    computed: float | None
    physical: float | None = None
    mixture: float | None = None

    @property
    def difference(self) -> float | None:
        """Computed minus published, in the row's unit."""
        if self.published is None or self.computed is None:
            return None
        return self.computed - self.published


@dataclass(frozen=True)
class Check:
    """One statement about the rows, with the measured number and its limit, that holds or fails.

    Attributes
    ----------
    statement : str
    holds : bool
    source : str
        Where the paper makes this statement: ``"section IV-B"``, ``"Fig 4"``; empty if it does not.
    """

    statement: str
    holds: bool
    source: str = ""


@dataclass(frozen=True)
class Drawing:
    """A figure of the item; ``alternative`` is its text description."""

    title: str
    figure: Figure
    alternative: str


@dataclass(frozen=True)
class Reproduction:
    """A recomputed table or figure.

    Attributes
    ----------
    verdict : {"reproduced", "reproduced with fitted inputs", "not reproducible"}
    reason : str
        What agrees, or why the item is not reproducible.
    rows : sequence of Row
    checks : sequence of Check
        All hold unless the verdict is "not reproducible".
    fitted_inputs : sequence of AssumedInput
        Inputs and interpretations that the paper does not state and that were fitted or chosen.
    notes : sequence of str
        Differences from the printed equations and their reasons; origin of inputs.
    drawings : sequence of Drawing
    """

    verdict: Verdict
    reason: str
    rows: Sequence[Row]
    checks: Sequence[Check] = ()
    fitted_inputs: Sequence[AssumedInput] = ()
    notes: Sequence[str] = ()
    drawings: Sequence[Drawing] = ()


def verdict_of(rows: Sequence[Row], checks: Sequence[Check], fitted_inputs: Sequence[AssumedInput]) -> Verdict:
    """Return the verdict that follows from rows and checks.

    Raises
    ------
    ValueError
        If there is no check, or if neither a row has a printed number nor a check tests a statement of the paper.
    """
    if not checks:
        raise ValueError("checks: none given, allowed: one or more; a verdict needs something that can fail")
    if all(row.difference is None for row in rows) and not any(check.source for check in checks):
        raise ValueError(
            "rows and checks: no printed number is compared and no check has a source; allowed: at least one of them, "
            "because a verdict is about what the paper prints"
        )
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
        Reason if all checks hold, and if one fails.
    inputs : sequence of str
        Names of the fitted inputs; the method of the fit is added to the notes.
    choices : sequence of str
        Interpretations and inputs in words that were chosen because they give the printed numbers.
    chosen : sequence of AssumedInput
        Both kinds, for figures that collect them themselves.
    missing : str
        Required data that are not published: the item is then not reproducible, whatever its checks.
    """
    taken = (*assumed(inputs), *in_words(*choices), *chosen)
    verdict = verdict_of(rows, checks, taken)
    reason = f"{missing} {fails if verdict == 'not reproducible' else holds}".strip()
    if missing:
        verdict = "not reproducible"
    return Reproduction(verdict, reason, rows, checks, taken, (*notes, *([origin(inputs)] if inputs else [])), drawings)


def settled(item: Reproduction) -> Reproduction:
    """Return an item whose verdict is consistent with its checks and inputs.

    With a failed check it is "not reproducible"; with fitted inputs it is not "reproduced".
    """
    failed = [check.statement for check in item.checks if not check.holds]
    if item.verdict == "not reproducible":
        return item
    if failed:
        reason = f"{item.reason} But this check fails: {'; '.join(failed)}."
        return replace(item, verdict="not reproducible", reason=reason)
    if item.fitted_inputs and item.verdict == "reproduced":
        return replace(item, verdict="reproduced with fitted inputs")
    return item


def rms_percent(computed: Array, printed: Array) -> float:
    """Return the rms of the relative differences of two rows (N,)."""
    return 100.0 * float(np.sqrt(np.mean((computed / printed - 1.0) ** 2)))


def rms_check(label: str, computed: Array, printed: Array, limit: float) -> Check:
    """Compare two rows (N,) by the rms of their relative differences; ``limit`` is relative."""
    rms = rms_percent(computed, printed)
    return Check(f"{label}: rms of relative differences {rms:.2g} %, at most {100 * limit:.2g} %", rms <= 100 * limit)


def largest_share_check(label: str, computed: Array, printed: Array, limit: float) -> Check:
    """Compare two rows (N,) by their largest relative difference; ``limit`` is relative."""
    largest = float(np.max(np.abs(computed / printed - 1.0)))
    statement = f"{label}: largest relative difference {100 * largest:.2g} %, at most {100 * limit:.2g} %"
    return Check(statement, largest <= limit)


def largest_check(label: str, computed: Array, printed: Array, limit: float, unit: str) -> Check:
    """Compare two rows (N,) by their largest difference; ``limit`` is in ``unit``."""
    largest = float(np.max(np.abs(computed - printed)))
    return Check(f"{label}: largest difference {largest:.2g} {unit}, at most {limit:.2g}", largest <= limit)
