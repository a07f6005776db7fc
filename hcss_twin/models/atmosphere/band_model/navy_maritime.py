"""The Navy maritime aerosol, whose sea salt depends on wind.

S. G. Gathman, *Optical properties of the marine aerosol as predicted by the Navy aerosol model*, Optical Engineering
22, 57 (1983), as in LOWTRAN7 (subroutine MARINE). Three lognormal size modes of .03, .24 and 2 um (at 80 % humidity)
represent continental aerosol, salt raised by the mean wind of the last day, and fresh salt; they grow with the humidity
at the sea. The same spectrum applies to the whole boundary layer; the asymmetry is that of the maritime aerosol.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError
from hcss_twin.core.files import open_format
from hcss_twin.models.atmosphere.band_model.aerosol import AerosolTables
from hcss_twin.models.parameters import NAVY_MARITIME

FILE = "navy-maritime"
FORMAT = ("hcss-navy-maritime", 1)

MAX_WIND_M_S = 20.0
MIN_VISIBILITY_KM = 2.0
DEFAULT_CHARACTER = 3
"""LOWTRAN7's default air mass character: close to open ocean (1) on the scale to 10."""

_VISIBLE_UM = 0.55
_KOSCHMIEDER, _MOLECULES_KM1 = 3.912, 0.01159
"""Visibility times extinction at 0.55 um (Koschmieder), and the extinction of molecules there."""


@dataclass(frozen=True)
class NavyTables:
    """Tables of the three size modes.

    Attributes
    ----------
    wavelength_um : ndarray (A,)
    humidity_percent : ndarray (4,)
    log10 : mapping of str to ndarray (3, A, 4)
        log10 of ``extinction`` and ``absorption`` of modes of unit amplitude, in units of 0.001 pi km-1.
    """

    wavelength_um: Array
    humidity_percent: Array
    log10: Mapping[str, Array]


@dataclass(frozen=True)
class SeaAir:
    """Inputs of the aerosol model: winds, humidity at the sea, air mass character."""

    wind_m_s: float
    wind_24h_m_s: float
    humidity_percent: float
    character: int


def read_navy_maritime(path: Path) -> NavyTables:
    """Read the tables of the size modes.

    Raises
    ------
    CatalogError
        If the file is not in this format.
    """
    with open_format(path, *FORMAT) as dataset:
        values = {name: np.asarray(variable[:], dtype=np.float64) for name, variable in dataset.variables.items()}
    log10 = {quantity: values[f"log10_{quantity}"] for quantity in ("extinction", "absorption")}
    return NavyTables(values["wavelength_um"], values["humidity_percent"], log10)


def coefficients_km1(tables: NavyTables, air: SeaAir) -> dict[str, Array]:
    """Return ``extinction`` and ``absorption`` at the sea, (A,) each, in km-1.

    Humidity is limited to the tables' 50 to 98 %, as in LOWTRAN7.

    Raises
    ------
    ProviderError
        If a wind exceeds 20 m/s.
    """
    for field, wind in (("sea.wind_speed", air.wind_m_s), ("wind_24h_m_s", air.wind_24h_m_s)):
        if not 0.0 <= wind <= MAX_WIND_M_S:
            raise ProviderError(
                f"band model: {field} is {wind:g} m/s; aerosol '{NAVY_MARITIME}' allows 0 to {MAX_WIND_M_S:g} m/s; "
                "closest choice: 'maritime'"
            )
    nodes = tables.humidity_percent
    humidity = float(np.clip(air.humidity_percent, nodes[0], nodes[-1]))
    growth = ((2.0 - humidity / 100.0) / (6.0 * (1.0 - humidity / 100.0))) ** (1.0 / 3.0)
    amplitude = np.array(
        [2000.0 * air.character**2, max(5.866 * (air.wind_24h_m_s - 2.2), 0.5), 10.0 ** (0.06 * air.wind_m_s - 2.8)]
    )
    upper = int(np.clip(np.searchsorted(nodes, humidity), 1, nodes.size - 1))
    share = (humidity - nodes[upper - 1]) / (nodes[upper] - nodes[upper - 1])

    def total(log10: Array) -> Array:
        modes = 10.0 ** (log10[..., upper - 1] + share * (log10[..., upper] - log10[..., upper - 1]))
        result: Array = 1e-3 * np.pi / growth * (amplitude @ modes)
        return result

    return {quantity: total(log10) for quantity, log10 in tables.log10.items()}


def with_navy_maritime(
    aerosol: AerosolTables, tables: NavyTables, air: SeaAir, visibility_km: float | None
) -> tuple[AerosolTables, float]:
    """Return the aerosol tables with this model added, and the visibility, which by default follows from the aerosol.

    Raises
    ------
    ProviderError
        If a wind is outside the model's range, or the visibility is below 2 km, the least of the height profiles.
    """
    of_sea = coefficients_km1(tables, air)
    visible = float(of_sea["extinction"][np.flatnonzero(tables.wavelength_um == _VISIBLE_UM)[0]])
    if visibility_km is None:
        visibility_km = _KOSCHMIEDER / (visible + _MOLECULES_KM1)
        if visibility_km < MIN_VISIBILITY_KM:
            raise ProviderError(
                f"band model: aerosol '{NAVY_MARITIME}' with wind {air.wind_m_s:g} m/s, air mass character "
                f"{air.character} and {air.humidity_percent:.0f} % humidity has a visibility of {visibility_km:.2g} "
                f"km; allowed: {MIN_VISIBILITY_KM:g} km or more; give visibility_km"
            )
    # The tables end at 40 um, beyond the band model.
    spectra = {
        quantity: np.log(np.interp(aerosol.wavelength_um, tables.wavelength_um, values / visible))
        for quantity, values in of_sea.items()
    }
    humidities = aerosol.ln_dryness.size
    boundary = {(NAVY_MARITIME, name): np.tile(spectrum[:, None], humidities) for name, spectrum in spectra.items()}
    boundary[NAVY_MARITIME, "asymmetry"] = aerosol.boundary["maritime", "asymmetry"]
    return replace(aerosol, boundary={**aerosol.boundary, **boundary}), visibility_km
