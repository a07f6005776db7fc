"""One time of profile files with several: the nearest to that of the scenario."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Self

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError


@dataclass(frozen=True)
class TimeChoice:
    """One time of a file with several.

    Attributes
    ----------
    dimension : str
        Of the times; empty if there is one.
    index : int
        Of the chosen one.
    notes : tuple of str
        Which one it is.
    """

    dimension: str = ""
    index: int = 0
    notes: tuple[str, ...] = ()

    @classmethod
    def of(cls, dataset: Any, name: str, time: datetime | None) -> Self:
        """Choose the time of a file nearest to another.

        Raises
        ------
        CatalogError
            If the file has several times and none is asked for.
        """
        from netCDF4 import num2date

        for label, variable in dataset.variables.items():
            units = str(getattr(variable, "units", ""))
            if variable.ndim != 1 or variable.size < 2 or " since " not in units:
                continue
            calendar = str(getattr(variable, "calendar", "standard"))
            found: Any = num2date(variable[:], units, calendar)
            dates = [_utc(date) for date in found]
            if time is None:
                raise CatalogError(
                    f"{name}: '{label}' has {len(dates)} times; allowed: one, or a scenario's time to choose by"
                )
            index = nearest(dates, time)
            return cls(variable.dimensions[0], index, (chosen(name, "time", dates[index], time, "%Y-%m-%d %H:%M"),))
        return cls()

    def values_of(self, variable: Any) -> Array:
        """Return the values of a variable at this time, with one element along the times; missing ones are NaN."""
        values = values_of(variable)
        if self.dimension in variable.dimensions:
            return np.take(values, [self.index], axis=variable.dimensions.index(self.dimension))
        return values


def _utc(date: Any) -> datetime:
    return datetime(date.year, date.month, date.day, date.hour, date.minute, date.second, tzinfo=UTC)


def nearest(dates: Sequence[datetime], time: datetime) -> int:
    """Return the index of the date nearest to a time."""
    return min(range(len(dates)), key=lambda index: abs(dates[index] - time))


def chosen(name: str, what: str, date: datetime, time: datetime, form: str) -> str:
    """Return a note on a chosen date, and how far it is from the scenario's time."""
    hours = (date - time).total_seconds() / 3600.0
    side = "after" if hours > 0.0 else "before"
    return f"profile '{name}': {what} {date:{form}} UTC of the file, {abs(hours):.3g} h {side} the scenario's"


def values_of(variable: Any) -> Array:
    """Return the values of a variable; missing ones are NaN."""
    filled: Array = np.ma.filled(np.ma.asarray(variable[:]).astype(np.float64), np.nan)
    return filled
