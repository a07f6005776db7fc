"""Tables of consecutive spans of time, as the segments of an ephemeris message."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from hcss_payload.checks import NoStateAtTimeError
from hcss_twin.providers import Array


class _Table(Protocol):
    @property
    def times_s(self) -> Array:
        """Times (N,) of its points."""
        ...

    def at(self, time_s: float) -> Array:
        """Return the value at a time."""
        ...


_AnyTable = TypeVar("_AnyTable", bound=_Table)


@dataclass(frozen=True, eq=False)
class Spans(Generic[_AnyTable]):
    """Tables, of which each holds in its own span of time; nothing is interpolated from one to the next.

    Parameters
    ----------
    field : str
        Name for messages.
    tables : sequence of PositionTable or of AttitudeTable
        In the order of time.
    usable_s : sequence of (float, float)
        First and last time of each; where two meet, the earlier one holds.
    """

    field: str
    tables: Sequence[_AnyTable]
    usable_s: Sequence[tuple[float, float]]

    def at(self, time_s: float) -> Array:
        """Return the value of the table of a time; a time outside all spans is an error."""
        for table, (first, last) in zip(self.tables, self.usable_s, strict=True):
            if first <= time_s <= last:
                return table.at(time_s)
        whole = [
            (first, last) == (table.times_s[0], table.times_s[-1])
            for table, (first, last) in zip(self.tables, self.usable_s, strict=True)
        ]
        spans = ", ".join(f"{first:g} to {last:g} s" for first, last in self.usable_s)
        usable = "" if all(whole) else " between USEABLE_START_TIME and USEABLE_STOP_TIME"
        raise NoStateAtTimeError(f"{self.field}: time {time_s:g} s; the table holds {spans}{usable}")
