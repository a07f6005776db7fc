"""The printed numbers of the paper, and the inputs that it does not state, which are fitted or chosen."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin.physics.sun import sun_position
from hcss_twin.providers import Array, CatalogError, Sun, choose_from

DATA = Path(__file__).parent / "data"
FITTED_FILE = DATA / "fitted-inputs.json"

FIT_COMMAND = "python -m hcss_paper.fits"
"""Fits the inputs again and prints them; with ``--write`` it also writes :data:`FITTED_FILE`."""

CLOUD_HEIGHTS_KM = {"stratus": (0.033, 1.0), "cumulus": (0.066, 3.0), "cirrus": (6.0, 10.0), "simulated": (0.333, 6.0)}
"""Base and top according to Table III."""

LEAP_YEAR_MONTHS = 4
"""Table VI prints 2019 throughout; its angles of January to April are those of 2024."""


def published() -> dict[str, Any]:
    """Return the numbers of Tables I to IX and of the baseline geometry (data/tables.json)."""
    tables: dict[str, Any] = json.loads((DATA / "tables.json").read_text(encoding="utf-8"))
    return tables


def printed_row(table: str, row: str, column: str = "Ours") -> Array:
    """Return one row of Table II or IV over the view zenith angles, (8,).

    Parameters
    ----------
    table : {"table_2", "table_4"}
    row : str
        ``"Scenario3"``, ``"3.0-5.0"``.
    column : {"Ours", "Modtran", "RE", "Ours/Modtran"}
    """
    return np.array(published()[table][row][column], dtype=np.float64)


@dataclass(frozen=True)
class AssumedInput:
    """An input or interpretation that the paper does not state, and the value used for it.

    Attributes
    ----------
    text : str
        One line for a report, with the value.
    name : str or None
        Name of a fitted input; None for a choice described in words.
    value : float or None
    unit : str or None
        ``"1"`` for pure numbers.
    """

    text: str
    name: str | None = None
    value: float | None = None
    unit: str | None = None


def in_words(*texts: str) -> tuple[AssumedInput, ...]:
    """Return choices that have no numerical value."""
    return tuple(map(AssumedInput, texts))


@dataclass(frozen=True)
class FittedInput:
    """An input that was fitted to the printed numbers: its unit, its meaning, and how it was fitted."""

    name: str
    value: float
    unit: str
    meaning: str
    how: str

    @property
    def assumed(self) -> AssumedInput:
        """The corresponding line of a report."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        return AssumedInput(f"{self.meaning}: {self.value:g}{unit}", self.name, self.value, self.unit)


def fitted_inputs() -> dict[str, FittedInput]:
    """Return all fitted inputs by name."""
    entries = json.loads(FITTED_FILE.read_text(encoding="utf-8"))["inputs"]
    return {name: FittedInput(name, **entry) for name, entry in entries.items()}


def fitted(name: str) -> float:
    """Return the value of a fitted input; raises CatalogError if the name is unknown."""
    known = fitted_inputs()
    if name not in known:
        raise CatalogError(f"no fitted input '{name}'; {choose_from(name, known)}")
    return known[name].value


COVERAGE = {"Scenario3": 0.30, "Scenario4": 0.47, "Scenario5": 0.30, "Scenario6": 0.47}
"""Coverages of the rows of Table II, from Table I."""

UNPRINTED_COVERAGE = 0.30
"""Of the cubes of Tables IV to VI, which print none: that of Scenario3, whose radiance at nadir is VI's of April."""

MIXED_BY_COVERAGE = {"Scenario3": 0.30, "Scenario4": 0.47, "Table VI": 0.30}
"""Rows of the mixture that have no effective cover of their own, and their coverage."""


def coverage_of(row: str) -> float:
    """Return the coverage of the cubes of a row: ``"Scenario3"``, ``"Table IV, 8-14 um"``, ``"Table VI"``."""
    return COVERAGE.get(row, UNPRINTED_COVERAGE)


def effective_cover(row: str, values: Mapping[str, float] | None = None, coverage: float | None = None) -> float:
    """Return the effective cover of opaque cloud in a row of the mixture.

    Parameters
    ----------
    row : str
        ``"Scenario3"``, ``"Table IV, 8-14 um"``, ``"Table VI"``, ...
    values : mapping, optional
        Inputs by name; by default the fitted ones.
    coverage : float, optional
        Coverage, 0 to 1, for rows of Table VII; by default that of :data:`MIXED_BY_COVERAGE`. Other rows have a
        fitted cover of their own.
    """
    given = {name: fitted.value for name, fitted in fitted_inputs().items()} if values is None else values
    coverage = MIXED_BY_COVERAGE.get(row) if coverage is None else coverage
    if coverage is None:
        return given[f"cover of {row}"]
    return given["cover at no coverage"] + given["cover per coverage"] * coverage


def assumed(names: Iterable[str]) -> tuple[AssumedInput, ...]:
    """Return the fitted inputs of these names, for a reproduction."""
    known = fitted_inputs()
    return tuple(known[name].assumed for name in names)


def origin(names: Iterable[str]) -> str:
    """Return how inputs were fitted, for the notes of a report."""
    known = fitted_inputs()
    ways = dict.fromkeys(known[name].how for name in names)
    return f"Inputs fitted: {'; '.join(ways)}. To repeat the fits: {FIT_COMMAND}"


@dataclass(frozen=True)
class Moment:
    """A time with its zone, and a place, of a row of Table V or VI."""

    time: datetime
    latitude_deg: float
    longitude_deg: float

    @property
    def sun(self) -> Sun:
        """Position and distance of the sun."""
        zenith, azimuth, distance = sun_position([self.time], self.latitude_deg, self.longitude_deg)
        return Sun(float(zenith[0]), float(azimuth[0]), float(distance[0]))


def moments_of_table_5() -> tuple[Moment, ...]:
    """Return scenarios 19 to 38: 20 April 2019, 12:30 in the time zone of round(longitude / 15) hours."""
    return tuple(
        _moment(datetime(2019, 4, 20, 12, 30), round(longitude / 15), latitude, longitude)
        for _, latitude, longitude, *_ in published()["table_5"]["rows"]
    )


def moments_of_table_6() -> tuple[Moment, ...]:
    """Return scenarios 7 to 18: 12:30 at UTC+10 over 35 N, 150 E."""
    dates = [[int(part) for part in row[1].split(".")[1:]] for row in published()["table_6"]["rows"]]
    return tuple(moment_at_baseline(2024 if month <= LEAP_YEAR_MONTHS else 2019, month, day) for month, day in dates)


def suns_of_table_5() -> tuple[Sun, ...]:
    """Return the suns of :func:`moments_of_table_5`."""
    return tuple(moment.sun for moment in moments_of_table_5())


def suns_of_table_6() -> tuple[Sun, ...]:
    """Return the suns of :func:`moments_of_table_6`."""
    return tuple(moment.sun for moment in moments_of_table_6())


def moment_at_baseline(year: int, month: int, day: int) -> Moment:
    """Return 12:30 at UTC+10 at the place of the baseline scene."""
    geometry = published()["baseline_geometry"]
    return _moment(datetime(year, month, day, 12, 30), 10, geometry["latitude"], geometry["longitude"])


def sun_at_baseline(year: int, month: int, day: int) -> Sun:
    """Return the sun of :func:`moment_at_baseline`."""
    return moment_at_baseline(year, month, day).sun


def _moment(clock: datetime, hours: int, latitude_deg: float, longitude_deg: float) -> Moment:
    # A longitude of 225 deg east is written as 135 deg west.
    east = (longitude_deg + 180.0) % 360.0 - 180.0
    return Moment(clock.replace(tzinfo=timezone(timedelta(hours=hours))), latitude_deg, east)
