"""What an effect cannot be computed with: one table an effect, in its own file, and one message for all.

An effect that a scenario switches on is refused beside anything of its table; one that is left to the plan (``"auto"``)
is not computed there, and the plan says why.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from hcss_twin.core.errors import Problem, ScenarioError

__all__ = ["Excluded"]

LAYER_TOPS = "a generator with one top of the layer (closest is 'fractal')"
"""What is allowed in place of cloud tops that vary with the generator."""


def goes_on_with(generator: object) -> str:
    """Return what is allowed in place of clouds that end with their image."""
    own = getattr(generator, "goes_on_with", "")
    return f"{own}, or clouds.generator = 'fractal'" if own else "clouds.generator = 'fractal'"


class Excluded(NamedTuple):
    """What a scene may not have beside an effect.

    Attributes
    ----------
    field : str
        Key of the scenario that brings it.
    present : bool
        Whether this scene has it.
    what : str
        What it is, as the subject of the message.
    allowed : str
        Value of the key that the effect allows.
    """

    field: str
    present: bool
    what: str
    allowed: str

    @staticmethod
    def require_none(effect: str, table: Iterable[Excluded], otherwise: str = "") -> None:
        """Refuse a scene that has anything of a table.

        Raises
        ------
        ScenarioError
            Names the field of everything that it has.
        """
        if problems := problems_beside(effect, table, otherwise):
            raise ScenarioError(problems)


def present(table: Iterable[Excluded]) -> Iterator[Excluded]:
    """Yield what a scene has of a table."""
    return (excluded for excluded in table if excluded.present)


def problems_beside(effect: str, table: Iterable[Excluded], otherwise: str = "") -> list[Problem]:
    """Return a problem for everything of a table that a scene has.

    Parameters
    ----------
    effect : str
        What excludes it, with its key and value where it has one.
    otherwise : str
        What else is allowed, for all of them: how to do without the effect.
    """
    rest = f", or {otherwise}" if otherwise else ""
    return [
        Problem(field, f"{what} cannot be computed with {effect}; allowed: {allowed}{rest}")
        for field, _, what, allowed in present(table)
    ]


class NotComputed(NamedTuple):
    """Why an effect is not computed.

    Attributes
    ----------
    why : str
    needs : str
        Key and value with which it would be; empty if none is known.
    switched_off : bool
        Whether the scenario says so.
    """

    why: str
    needs: str = ""
    switched_off: bool = False


def why_not(key: str, value: str, table: Iterable[Excluded]) -> NotComputed | None:
    """Return why an effect is not computed; None if it is.

    Parameters
    ----------
    key, value : str
        Key of the effect, and what the scenario says: "auto", "on" or "off".

    Raises
    ------
    ScenarioError
        If it is on beside something that excludes it.
    """
    if value == "off":
        return NotComputed(f"{key} is off", f'{key} = "on"', switched_off=True)
    beside = list(present(table))
    if value == "on":
        Excluded.require_none(f"{key} = 'on'", beside, f"{key} = 'off'")
    if not beside:
        return None
    first = beside[0]
    value_allowed = re.fullmatch("'([^']*)'", first.allowed)
    needs = f'{first.field} = "{value_allowed[1]}"' if value_allowed else f"{first.field}: {first.allowed}"
    return NotComputed(f"the scene has {first.what.rstrip(',')}", needs)
