"""Names and units of the columns of a profile file."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from hcss_twin.core.errors import Problem
from hcss_twin.physics.profile import GASES

Unit = tuple[float, float]
"""(factor, offset) with SI value = factor * value + offset."""


@dataclass(frozen=True)
class ProfileQuantity:
    """One quantity of a profile.

    Attributes
    ----------
    name : str
        Internal name and first spelling.
    spellings : tuple of str
        Accepted names, lower case; a hyphen or blank is equivalent to an underscore.
    units : mapping of str to (factor, offset)
        Accepted units, normalised by :func:`folded`; the first is the SI unit.
    low, high : float
        Physical limits in SI units, inclusive.
    needs_unit : bool
        Whether a column without a unit is rejected.
    """

    name: str
    spellings: tuple[str, ...]
    units: Mapping[str, Unit]
    low: float
    high: float
    needs_unit: bool = True

    @property
    def si_unit(self) -> str:
        """SI unit."""
        return next(iter(self.units))


_M, _HPA, _CELSIUS = (1.0, 0.0), (100.0, 0.0), (1.0, 273.15)
_LENGTH = {"m": _M, "km": (1e3, 0.0), "ft": (0.3048, 0.0), "metre": _M, "meter": _M, "metres": _M, "meters": _M}
_PRESSURE = {"pa": (1.0, 0.0), **dict.fromkeys(("hpa", "mb", "mbar", "millibar", "millibars"), _HPA), "kpa": (1e3, 0.0)}
_TEMPERATURE = {
    **dict.fromkeys(("k", "kelvin"), (1.0, 0.0)),
    **dict.fromkeys(("c", "degc", "°c", "celsius", "deg_c", "degree_celsius", "degrees_celsius"), _CELSIUS),
}
_RELATIVE = {**dict.fromkeys(("1", "fraction"), (1.0, 0.0)), **dict.fromkeys(("percent", "%", "pct"), (0.01, 0.0))}
_MASS_RATIO = {
    **dict.fromkeys(("kg_kg", "kg_kg-1", "kg_kg**-1", "1"), (1.0, 0.0)),
    **dict.fromkeys(("g_kg", "g_kg-1", "g_kg**-1"), (1e-3, 0.0)),
}
_MOLE_FRACTION = {
    **dict.fromkeys(("1", "mol_mol", "mol_mol-1"), (1.0, 0.0)),
    **dict.fromkeys(("ppmv", "ppm", "1e-6"), (1e-6, 0.0)),
    **dict.fromkeys(("ppbv", "ppb", "1e-9"), (1e-9, 0.0)),
}
_GEOPOTENTIAL = dict.fromkeys(
    ("m2_s-2", "m2_s2", "m**2_s**-2", "m2_s**-2", "m^2_s^-2", "m^2_s^2", "j_kg-1", "j_kg"), _M
)
_GAS_NAMES = {
    "h2o": "water_vapour",
    "co2": "carbon_dioxide",
    "o3": "ozone",
    "n2o": "nitrous_oxide",
    "co": "carbon_monoxide",
    "ch4": "methane",
    "o2": "oxygen",
}

HUMIDITIES = ("h2o", "mixing_ratio", "specific_humidity", "dewpoint", "relative_humidity")
"""Quantities that specify water vapour; the first one present is used."""

QUANTITIES: Mapping[str, ProfileQuantity] = MappingProxyType(
    {
        quantity.name: quantity
        for quantity in (
            ProfileQuantity("altitude", ("altitude", "height", "geometric_altitude", "z"), _LENGTH, -1e3, 1e6),
            ProfileQuantity("geopotential", ("geopotential",), _GEOPOTENTIAL, -1e4, 1e7),
            ProfileQuantity(
                "geopotential_height",
                ("geopotential_height", "geopotential_altitude", "gph"),
                {**_LENGTH, "gpm": (1.0, 0.0)},
                -1e3,
                1e6,
            ),
            ProfileQuantity("pressure", ("pressure", "air_pressure", "pressure_level", "p"), _PRESSURE, 0.0, 1.1e5),
            ProfileQuantity("temperature", ("temperature", "air_temperature", "ta", "t"), _TEMPERATURE, 100.0, 1500.0),
            ProfileQuantity("relative_humidity", ("relative_humidity", "rh", "hur"), _RELATIVE, 0.0, 2.0),
            ProfileQuantity(
                "dewpoint",
                ("dewpoint", "dew_point", "dewpoint_temperature", "dew_point_temperature", "td"),
                _TEMPERATURE,
                123.0,
                332.0,
            ),
            ProfileQuantity("specific_humidity", ("specific_humidity", "hus", "q"), _MASS_RATIO, 0.0, 0.2),
            ProfileQuantity(
                "mixing_ratio",
                ("mixing_ratio", "humidity_mixing_ratio", "water_vapour_mixing_ratio"),
                _MASS_RATIO,
                0.0,
                0.2,
            ),
            *(
                ProfileQuantity(
                    gas,
                    (gas, _GAS_NAMES[gas], f"mole_fraction_of_{_GAS_NAMES[gas]}_in_air"),
                    _MOLE_FRACTION,
                    0.0,
                    1.0,
                    needs_unit=False,
                )
                for gas in GASES
            ),
        )
    }
)

PASSED_OVER = (
    "air_number_density", "time", "latitude", "longitude", "lat", "lon", "level", "wind_speed", "wind_direction",
    "wind_from_direction", "wind_from", "u_wind", "v_wind", "eastward_wind", "northward_wind", "ascent_rate",
    "frost_point", "ice_point", "humidity_wrt_ice", "potential_temperature",
)  # fmt: skip
"""Sounding columns that a profile does not need, in any unit."""

_BRACKETS = re.compile(r"(?P<name>.*?)[\s_]*[\[(](?P<unit>[^\])]*)[\])]")


def folded(unit: str) -> str:
    """Normalise a unit for these tables: lower case, with underscores for blanks and slashes."""
    return re.sub(r"[\s/·_]+", "_", unit.strip().lower())


def recognised(header: str) -> tuple[ProfileQuantity, Unit] | None:
    """Return the quantity and unit of a CSV column from its name.

    Parameters
    ----------
    header : str
        ``name_unit``, ``name [unit]`` or ``name (unit)``.

    Returns
    -------
    tuple or None
        The quantity and its unit; None for an ignored column.

    Raises
    ------
    ValueError
        If the name or the unit is unknown, or the unit is missing.
    """
    bracket = _BRACKETS.fullmatch(header.strip())
    text = folded(header).replace("-", "_") if bracket is None else _folded_name(bracket["name"])
    for spelling, quantity in _by_length():
        if bracket is not None and text == spelling:
            return quantity, unit_of(quantity, bracket["unit"], header)
        if bracket is None and (text == spelling or text.startswith(f"{spelling}_")):
            # The unit is read before hyphens are replaced by underscores: in a unit, a hyphen is a minus sign.
            return quantity, unit_of(quantity, folded(header)[len(spelling) + 1 :], header)
    if any(text == passed_over or text.startswith(f"{passed_over}_") for passed_over in PASSED_OVER):
        return None
    spellings = [spelling for spelling, _ in _by_length()]
    guess = Problem.closest(text, spellings) or Problem.closest(text.rpartition("_")[0], spellings)
    hint = f"; closest is '{guess}'" if guess else ""
    raise ValueError(f"column '{header}' is not known; allowed: {', '.join(QUANTITIES)}{hint}")


def named(names: Iterable[str], unit: str = "") -> ProfileQuantity | None:
    """Return the ProfileQuantity that matches a name of a NetCDF variable, or None.

    Reanalyses call geopotential z, and the pressure of their levels level, which their units tell.
    """
    for name in names:
        label = _folded_name(name)
        if label in _BY_UNIT and folded(unit) in QUANTITIES[_BY_UNIT[label]].units:
            return QUANTITIES[_BY_UNIT[label]]
        for quantity in QUANTITIES.values():
            if label in quantity.spellings:
                return quantity
    return None


_BY_UNIT = {"z": "geopotential", "level": "pressure", "lev": "pressure", "isobaricinhpa": "pressure"}


def unit_of(quantity: ProfileQuantity, unit: str, label: str) -> Unit:
    """Return the conversion of a unit.

    Raises
    ------
    ValueError
        If it is missing or not a unit of the quantity.
    """
    allowed = ", ".join(quantity.units)
    if not unit.strip():
        if quantity.needs_unit:
            raise ValueError(
                f"'{label}' has no unit; allowed: {allowed}; for example '{quantity.name}_{quantity.si_unit}'"
            )
        return quantity.units[quantity.si_unit]
    try:
        return quantity.units[folded(unit)]
    except KeyError:
        guess = Problem.closest(folded(unit), quantity.units)
        hint = f"; closest is '{guess}'" if guess else ""
        raise ValueError(f"'{label}': unknown unit '{unit.strip()}'; allowed: {allowed}{hint}") from None


def _folded_name(name: str) -> str:
    return folded(name).replace("-", "_")


def _by_length() -> list[tuple[str, ProfileQuantity]]:
    """Return all spellings, the longest first, so that 'temperature_K' is not taken for 't'."""
    pairs = [(spelling, quantity) for quantity in QUANTITIES.values() for spelling in quantity.spellings]
    return sorted(pairs, key=lambda pair: -len(pair[0]))
