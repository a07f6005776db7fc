"""What a reproduced table or figure consists of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

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
    """One statement about the rows that decides the verdict.

    Attributes
    ----------
    statement : str
        What was measured, with the limit: ``"rms of relative differences 0.36 %, at most 0.5 %"``.
    holds : bool
    """

    statement: str
    holds: bool


@dataclass(frozen=True)
class Drawing:
    """A picture that belongs to the item.

    Attributes
    ----------
    title : str
    figure : matplotlib Figure
    alternative : str
        What there is to see.
    """

    title: str
    figure: Figure
    alternative: str


@dataclass(frozen=True)
class TakenInput:
    """An input or a reading that the paper does not state, and what is taken for it.

    Attributes
    ----------
    text : str
        One line for a report, with the value.
    name : str or None
        Of a fitted input (:mod:`hcss_twin.paper.fitted`); None for a choice, which is in words alone.
    value : float or None
    unit : str or None
        ``"1"`` for pure numbers.
    """

    text: str
    name: str | None = None
    value: float | None = None
    unit: str | None = None


def in_words(*texts: str) -> tuple[TakenInput, ...]:
    """Return choices that have no number of their own."""
    return tuple(map(TakenInput, texts))


@dataclass(frozen=True)
class Reproduction:
    """A table or figure, computed again.

    Attributes
    ----------
    verdict : {"reproduced", "reproduced with fitted inputs", "not reproducible"}
    reason : str
        Why: what agrees, or why it cannot.
    rows : sequence of Row
    checks : sequence of Check
        All hold unless the verdict is "not reproducible".
    fitted_inputs : sequence of TakenInput
        Inputs and readings that the paper does not state and that were fitted or chosen.
    notes : sequence of str
        What differs from the printed equations and why, where inputs come from.
    drawings : sequence of Drawing
    """

    verdict: Verdict
    reason: str
    rows: Sequence[Row]
    checks: Sequence[Check] = ()
    fitted_inputs: Sequence[TakenInput] = ()
    notes: Sequence[str] = ()
    drawings: Sequence[Drawing] = ()


@dataclass(frozen=True)
class Item:
    """A table or figure of the paper that can be computed.

    Attributes
    ----------
    name : str
        ``table-2`` or ``figure-12``.
    title : str
        What the paper shows there, in our words.
    target : str
        ``"package.module:function"`` that takes the seed of random fields and returns a
        :class:`Reproduction`; imported when it is asked for.
    seconds : float
        About how long it takes, tables compiled, one processor.
    """

    name: str
    title: str
    target: str
    seconds: float
