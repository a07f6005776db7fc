"""What the check of a cube against its own recomputation found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from hcss_twin.json_numbers import json_number, json_value

TOLERANCE = 1e-6
"""Largest difference of what counts as equal; single precision resolves 6e-8."""


class Verdict(StrEnum):
    """Outcome of a check."""

    IDENTICAL = "identical"
    EQUAL = "equal"
    DIFFERENT = "different"
    NOT_RECOMPUTED = "not recomputed"


@dataclass(frozen=True)
class Change:
    """Something that is not as the cube records it.

    Attributes
    ----------
    what : str
        A library, a kind of provider, a key of the scenario, a dimension.
    recorded, now : str
        What the cube says or holds, and what its recomputation has.
    """

    what: str
    recorded: str
    now: str


@dataclass(frozen=True)
class FileChange:
    """A file of which the recomputation does not read what the cube was made from.

    Attributes
    ----------
    name : str
        Name in the catalog or path, as the cube records it.
    state : str
        ``changed``, ``missing``, ``no longer read`` or ``not read before``.
    recorded_sha256, now_sha256 : str or None
        Hashes; None where there is no such file.
    now_at : str
        Where the file of today was found.
    """

    name: str
    state: str
    recorded_sha256: str | None
    now_sha256: str | None
    now_at: str


@dataclass(frozen=True)
class Place:
    """One value of a variable.

    Attributes
    ----------
    position : mapping
        Frame, row and column by number from 0, band and layer by name.
    cube, recomputed : float
        Both values.
    """

    position: Mapping[str, int | str]
    cube: float
    recomputed: float


@dataclass(frozen=True)
class VariableCheck:
    """The comparison of one variable.

    Attributes
    ----------
    name : str
    relative_to : str
        What differences are relative to: ``value``, ``largest`` (of the variable in the frame, or in the tile of a
        large one) or ``exact`` where any difference counts.
    values, unequal, beyond : int
        Values compared, those that are not the same to the bit, and those beyond the tolerance.
    largest : float
        Largest relative difference; infinite where only one of both is a number.
    largest_at, first : Place or None
        Where it is, and the first value beyond the tolerance, or without such the first that is unequal.
    """

    name: str
    relative_to: str
    values: int
    unequal: int
    beyond: int
    largest: float
    largest_at: Place | None
    first: Place | None


@dataclass(frozen=True)
class Verification:
    """A cube compared with what its own provenance makes today.

    Attributes
    ----------
    cube, base : str
        The file, and the folder where relative paths of its scenario lead.
    frames, frames_checked : int
        Frames of the cube, and how many of them were recomputed.
    problems : tuple of str
        Why it could not be recomputed; empty where it was.
    layout : tuple of Change
        Dimensions, variables and types that are not those the scenario makes.
    files : tuple of FileChange
    versions, providers, attributes : tuple of Change
        Possible causes; they do not make a cube different by themselves.
    variables : tuple of VariableCheck
        Coordinates first.
    """

    cube: str
    base: str
    frames: int
    frames_checked: int = 0
    problems: tuple[str, ...] = ()
    layout: tuple[Change, ...] = ()
    files: tuple[FileChange, ...] = ()
    versions: tuple[Change, ...] = ()
    providers: tuple[Change, ...] = ()
    attributes: tuple[Change, ...] = ()
    variables: tuple[VariableCheck, ...] = ()

    @property
    def verdict(self) -> Verdict:
        """Outcome."""
        if self.problems:
            return Verdict.NOT_RECOMPUTED
        if self.layout or any(each.beyond for each in self.variables):
            return Verdict.DIFFERENT
        if any(each.unequal for each in self.variables):
            return Verdict.EQUAL
        return Verdict.IDENTICAL

    @property
    def passed(self) -> bool:
        """Whether the cube is identical, or equal within the tolerance."""
        return self.verdict in (Verdict.IDENTICAL, Verdict.EQUAL)

    @property
    def largest(self) -> float:
        """Largest relative difference of all variables."""
        return max((each.largest for each in self.variables), default=0.0)

    def as_dict(self) -> dict[str, Any]:
        """Plain values for ``hcss verify --json``; numbers that JSON does not have are None."""
        return {
            "verdict": str(self.verdict),
            "passed": self.passed,
            "tolerance": TOLERANCE,
            "largest_difference": json_number(self.largest),
            **{
                name: [_plain(each) for each in value] if isinstance(value, tuple) else value
                for name, value in vars(self).items()
            },
        }


def _plain(value: Any) -> Any:
    if isinstance(value, Change | FileChange | Place | VariableCheck):
        return {name: _plain(each) for name, each in vars(value).items()}
    return json_value(value)
