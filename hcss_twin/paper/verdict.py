"""Verdicts follow from checks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.paper.fitted import origin, taken
from hcss_twin.paper.item import Check, Reproduction, Row, TakenInput, Verdict, in_words


def verdict_of(checks: Sequence[Check], fitted_inputs: Sequence[TakenInput]) -> Verdict:
    """Return what the checks say.

    Raises
    ------
    ValueError
        If there is no check: nothing would be known.
    """
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
    inputs: Sequence[str] = (),
    notes: Sequence[str] = (),
    choices: Sequence[str] = (),
) -> Reproduction:
    """Return an item with the verdict of its checks.

    Parameters
    ----------
    rows, checks, notes
        As in :class:`Reproduction`.
    holds, fails : str
        The reason where all checks hold, and where one does not.
    inputs : sequence of str
        Names of the fitted inputs it rests on (:mod:`hcss_twin.paper.fitted`).
    choices : sequence of str
        Readings and inputs without a number of their own that were chosen because they give the printed numbers.
    """
    chosen = (*taken(inputs), *in_words(*choices))
    verdict = verdict_of(checks, chosen)
    reason = fails if verdict == "not reproducible" else holds
    ways = (origin(inputs),) if inputs else ()
    return Reproduction(verdict, reason, rows, checks, chosen, (*notes, *ways))


def settled(found: Reproduction) -> Reproduction:
    """Return an item whose verdict claims no more than its checks and inputs allow.

    A failed check makes it "not reproducible", fitted inputs keep it from "reproduced".
    """
    failed = [check.statement for check in found.checks if not check.holds]
    if found.verdict == "not reproducible":
        return found
    if failed:
        reason = f"{found.reason} But this does not hold: {'; '.join(failed)}."
        return replace(found, verdict="not reproducible", reason=reason)
    if found.fitted_inputs and found.verdict == "reproduced":
        return replace(found, verdict="reproduced with fitted inputs")
    return found


def rms_check(what: str, computed: Array, printed: Array, limit: float) -> Check:
    """Compare two rows by the root mean square of their relative differences.

    Parameters
    ----------
    what : str
        Which rows.
    computed, printed : ndarray (N,)
    limit : float
        Largest that holds, as a share.
    """
    rms = float(np.sqrt(np.mean((computed / printed - 1.0) ** 2)))
    statement = f"{what}: rms of relative differences {100 * rms:.2g} %, at most {100 * limit:.2g} %"
    return Check(statement, rms <= limit)


def deviation_check(what: str, computed: Array, printed: Array, limit: float, unit: str) -> Check:
    """Compare two rows by the root mean square of their differences.

    Parameters
    ----------
    what, computed, printed
        As for :func:`rms_check`.
    limit : float
        Largest that holds, in ``unit``.
    """
    rms = float(np.sqrt(np.mean((computed - printed) ** 2)))
    return Check(f"{what}: rms of differences {rms:.2g} {unit}, at most {limit:.2g}", rms <= limit)


def largest_check(what: str, computed: Array, printed: Array, limit: float, unit: str) -> Check:
    """Compare two rows by the largest of their differences.

    Parameters
    ----------
    what, computed, printed
        As for :func:`rms_check`.
    limit : float
        Largest that holds, in ``unit``.
    """
    largest = float(np.max(np.abs(computed - printed)))
    return Check(f"{what}: largest difference {largest:.2g} {unit}, at most {limit:.2g}", largest <= limit)
