"""Profiles from files or the catalog: check levels, and complete them from the sea to space."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import datetime
from functools import lru_cache

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.moist_air import (
    MAX_RELATIVE_HUMIDITY,
    altitude_of_pressure,
    from_dewpoint,
    from_mixing_ratio,
    from_relative_humidity,
    from_specific_humidity,
    geometric_altitude,
    pressure_beyond,
    relative_humidity,
)
from hcss_twin.models.atmosphere.profile_field import ProfileField, SoundingGrid
from hcss_twin.models.atmosphere.sounding import NETCDF_SUFFIXES, Sounding, read_sounding
from hcss_twin.models.atmosphere.thinning import thinned
from hcss_twin.physics.profile import GASES, Profile

__all__ = ["load_profile"]

Columns = dict[str, Array]

COMPLETE_M = 100_000.0
"""Profiles that end below this altitude are completed from a model."""

CLEARANCE_M = 1000.0
"""Distance between the last level of the profile and the first model level above it."""

LOWEST_LEVEL_M = 450.0
"""A profile that begins below this altitude is extended down to the sea."""

LAPSE_RATE_K_M = 0.0065
"""Lapse rate of the 1976 US Standard Atmosphere, for that extension."""

DENSE_BELOW_M = 15_000.0
WIDEST_GAP_M = 5_000.0
SURFACE_PRESSURE_PA = (85_000.0, 110_000.0)
HYDROSTATIC_ABOVE_PA = 1.0
"""Below this pressure (80 km) air is not well mixed, and altitudes cannot be computed from pressure."""

HEIGHT_TOLERANCE = (200.0, 0.03)
"""Tolerance of altitudes relative to hydrostatic balance: metres, and fraction of the altitude."""


def build_profile(sounding: Sounding, model: Callable[[], Profile]) -> Profile:
    """Check and complete a sounding.

    Parameters
    ----------
    sounding : Sounding
    model : callable
        Returns the model profile for missing gases and the air above; called only if needed.

    Returns
    -------
    Profile
        Profile from altitude 0 upward; its notes list what was computed or taken from the model.

    Raises
    ------
    CatalogError
        If the levels are not sorted, have a gap of more than 5 km below 15 km, are supersaturated, or contradict each
        other; the message names the line or level in the file.
    """
    columns, notes = dict(sounding.columns), list(sounding.notes)
    _require_positive_pressure(sounding, columns["pressure"])
    columns["h2o"] = _mole_fraction(columns)
    _require_unsaturated(sounding, columns)
    columns["altitude"] = _altitude(sounding, columns, notes)
    _require_dense(sounding, columns["altitude"])
    columns = {name: columns[name] for name in ("altitude", "pressure", "temperature", *GASES) if name in columns}
    columns = _down_to_the_sea(sounding, columns, notes)
    columns = thinned(columns, sounding.name, notes)
    model_gases = set(GASES) - set(columns)
    columns = _with_gases(sounding, columns, model, notes)
    columns = _up_to_space(sounding, columns, model, notes)
    return Profile(
        sounding.name,
        columns["altitude"],
        columns["pressure"],
        columns["temperature"],
        {gas: columns[gas] for gas in GASES if gas in columns},
        tuple(notes),
        frozenset(model_gases & set(columns)),
    )


def _require_positive_pressure(sounding: Sounding, pressure: Array) -> None:
    if np.any(pressure <= 0):
        level = int(np.flatnonzero(pressure <= 0)[0])
        raise CatalogError(f"{sounding.name}, {sounding.where[level]}: pressure is 0; allowed: above 0")


def _mole_fraction(columns: Mapping[str, Array]) -> Array:
    pressure, temperature = columns["pressure"], columns["temperature"]
    if "h2o" in columns:
        return columns["h2o"]
    if "mixing_ratio" in columns:
        return from_mixing_ratio(columns["mixing_ratio"])
    if "specific_humidity" in columns:
        return from_specific_humidity(columns["specific_humidity"])
    if "dewpoint" in columns:
        return from_dewpoint(columns["dewpoint"], pressure)
    return from_relative_humidity(columns["relative_humidity"], pressure, temperature)


def _require_unsaturated(sounding: Sounding, columns: Mapping[str, Array]) -> None:
    humidity = relative_humidity(columns["h2o"], columns["pressure"], columns["temperature"])
    worst = int(np.argmax(humidity))
    if humidity[worst] > MAX_RELATIVE_HUMIDITY + 1e-9:
        raise CatalogError(
            f"{sounding.name}, {sounding.where[worst]}: relative humidity {100 * humidity[worst]:.1f} % over water at "
            f"{columns['pressure'][worst] / 100:g} hPa and {columns['temperature'][worst]:g} K; allowed: up to "
            f"{100 * MAX_RELATIVE_HUMIDITY:g} %"
        )
    if np.any(columns["h2o"] >= 1):
        level = int(np.argmax(columns["h2o"]))
        raise CatalogError(f"{sounding.name}, {sounding.where[level]}: more water vapour than air")


def _altitude(sounding: Sounding, columns: Mapping[str, Array], notes: list[str]) -> Array:
    pressure, temperature, h2o = columns["pressure"], columns["temperature"], columns["h2o"]
    mixed = pressure >= HYDROSTATIC_ABOVE_PA
    if "altitude" not in columns and "geopotential_height" not in columns:
        if not mixed.all():
            level = int(np.argmin(mixed))
            raise CatalogError(
                f"{sounding.name}, {sounding.where[level]}: altitudes are not computed below "
                f"{HYDROSTATIC_ABOVE_PA:g} Pa; give a column of altitude, or end the profile below this level"
            )
        low, high = SURFACE_PRESSURE_PA
        if not low <= pressure[0] <= high:
            raise CatalogError(
                f"{sounding.name}, {sounding.where[0]}: without altitudes the first level is the sea surface; its "
                f"pressure is {pressure[0] / 100:g} hPa, allowed {low / 100:g} to {high / 100:g} hPa"
            )
        notes.append(
            f"profile '{sounding.name}': altitudes computed from pressure, temperature and humidity, the first level "
            "at the sea"
        )
        return altitude_of_pressure(pressure, temperature, h2o)
    given = "altitude" if "altitude" in columns else "geopotential_height"
    altitude = columns[given] if given == "altitude" else geometric_altitude(columns[given])
    rises = np.diff(altitude) > 0
    if not rises.all():
        level = int(np.argmin(rises)) + 1
        raise CatalogError(
            f"{sounding.name}, {sounding.where[level]}: {given} {altitude[level]:g} m does not exceed the "
            f"{altitude[level - 1]:g} m of {sounding.where[level - 1]}"
        )
    if altitude[0] > LOWEST_LEVEL_M:
        raise CatalogError(
            f"{sounding.name}, {sounding.where[0]}: the lowest level is at {altitude[0]:g} m; allowed: up to "
            f"{LOWEST_LEVEL_M:g} m above the sea"
        )
    balanced = altitude_of_pressure(pressure[mixed], temperature[mixed], h2o[mixed], float(altitude[0]))
    away = np.abs(balanced - altitude[mixed])
    excess = away - HEIGHT_TOLERANCE[0] - HEIGHT_TOLERANCE[1] * altitude[mixed]
    if np.any(excess > 0):
        level = int(np.argmax(excess > 0))
        raise CatalogError(
            f"{sounding.name}, {sounding.where[level]}: {given} {altitude[level]:.0f} m, but pressures and "
            f"temperatures up to there reach {balanced[level]:.0f} m; check the units"
        )
    return altitude


def _require_dense(sounding: Sounding, altitude: Array) -> None:
    gap = np.diff(altitude)
    wide = np.flatnonzero((gap > WIDEST_GAP_M) & (altitude[:-1] < DENSE_BELOW_M))
    if wide.size:
        level = int(wide[0])
        raise CatalogError(
            f"{sounding.name}, {sounding.where[level + 1]}: {gap[level] / 1e3:.1f} km above {sounding.where[level]}; "
            f"allowed: gaps of up to {WIDEST_GAP_M / 1e3:g} km below {DENSE_BELOW_M / 1e3:g} km"
        )


def _down_to_the_sea(sounding: Sounding, columns: Columns, notes: list[str]) -> Columns:
    lowest = float(columns["altitude"][0])
    if lowest == 0.0:
        return columns
    temperature = columns["temperature"][0] + LAPSE_RATE_K_M * lowest
    pressure = pressure_beyond(
        float(columns["pressure"][0]), float(columns["temperature"][0]), lowest, float(temperature), 0.0
    )
    notes.append(
        f"profile '{sounding.name}': continued from {lowest:g} m down to the sea with 6.5 K per km and constant mixing "
        "ratios"
    )
    surface = {"altitude": 0.0, "pressure": pressure, "temperature": float(temperature)}
    return {name: np.concatenate(([surface.get(name, float(values[0]))], values)) for name, values in columns.items()}


def _with_gases(sounding: Sounding, columns: Columns, model: Callable[[], Profile], notes: list[str]) -> Columns:
    missing = [gas for gas in GASES if gas not in columns]
    if not missing:
        return columns
    base = model()
    missing = [gas for gas in missing if gas in base.mixing_ratio]
    notes.append(f"profile '{sounding.name}': {', '.join(missing)} from '{base.name}'")
    altitude = np.minimum(columns["altitude"], base.altitude_m[-1])
    return columns | {gas: _log_interpolated(altitude, base.altitude_m, base.mixing_ratio[gas]) for gas in missing}


def _up_to_space(sounding: Sounding, columns: Columns, model: Callable[[], Profile], notes: list[str]) -> Columns:
    top = float(columns["altitude"][-1])
    if top >= COMPLETE_M:
        return columns
    base = model()
    if base.altitude_m[-1] < COMPLETE_M:
        raise CatalogError(
            f"'{base.name}' ends at {base.altitude_m[-1] / 1e3:g} km and cannot complete '{sounding.name}'; "
            f"allowed: profiles of {COMPLETE_M / 1e3:g} km or more"
        )
    above = base.altitude_m >= top + CLEARANCE_M
    altitude, temperature = base.altitude_m[above], base.temperature_K[above]
    first = pressure_beyond(
        float(columns["pressure"][-1]), float(columns["temperature"][-1]), top, temperature[0], altitude[0]
    )
    pressure = base.pressure_Pa[above] * (first / base.pressure_Pa[above][0])
    step = float(base.temperature_at(top)) - float(columns["temperature"][-1])
    notes.append(
        f"profile '{sounding.name}': above {top / 1e3:.4g} km from '{base.name}', which is {abs(step):.1f} K "
        f"{'warmer' if step >= 0 else 'colder'} there; pressures continued"
    )
    added = {"altitude": altitude, "pressure": pressure, "temperature": temperature}
    added |= {gas: base.mixing_ratio[gas][above] for gas in GASES if gas in base.mixing_ratio}
    return {name: np.concatenate((values, added[name])) for name, values in columns.items() if name in added}


def _log_interpolated(at: Array, altitude: Array, ratio: Array) -> Array:
    if np.any(ratio <= 0):
        return np.interp(at, altitude, ratio)
    return np.exp(np.interp(at, altitude, np.log(ratio)))


MAX_PROFILES = 1024
"""Number of profiles of one file that are kept in memory."""

STANDARD = "us-standard-1976"
"""Model that completes profiles by default."""


def load_profile(name: str, catalog: Catalog, above: str = STANDARD, time: datetime | None = None) -> Profile:
    """Read a profile by catalog name or from a user's CSV, IGRA 2 or NetCDF file (docs/how-to/atmospheres.md).

    Parameters
    ----------
    name : str
        Catalog name or path.
    catalog : Catalog
    above : str
        Name or path of the profile that provides gases missing from a file and the air above its last level; it must
        reach 100 km.
    time : datetime, optional
        Of several times in a file, the nearest to this one is read.

    Raises
    ------
    CatalogError
        If a file is missing or malformed, or its levels are not physical; the message names the line or level.
    """
    path = catalog.find(name, "atmospheres", ".csv")
    profile = build_profile(read_sounding(path, name, time), _model(name, catalog, above))
    if path.is_relative_to(catalog.root):
        return replace(profile, model_gases=frozenset(profile.mixing_ratio))
    return profile


def load_profiles(
    name: str, catalog: Catalog, above: str = STANDARD, time: datetime | None = None
) -> Profile | ProfileField:
    """Read a profile like :func:`load_profile`, or the profiles of a NetCDF file with several latitudes or longitudes.

    Raises
    ------
    CatalogError
        As :func:`load_profile`; each of several profiles is checked when it is first used.
    """
    path = catalog.find(name, "atmospheres", ".csv")
    if path.suffix.lower() in NETCDF_SUFFIXES:
        grid = SoundingGrid.read(path, name, time)
        if grid is not None:
            model = _model(name, catalog, above)
            return ProfileField(grid, lru_cache(MAX_PROFILES)(lambda *node: build_profile(grid.node(*node), model)))
    return load_profile(name, catalog, above, time)


def _model(name: str, catalog: Catalog, above: str) -> Callable[[], Profile]:
    """Return a function that reads the profile used to complete another."""

    def incomplete() -> Profile:
        raise CatalogError(f"'{above}' cannot complete '{name}': it has gaps itself; allowed: complete profiles")

    return lambda: build_profile(read_sounding(catalog.find(above, "atmospheres", ".csv"), above), incomplete)
