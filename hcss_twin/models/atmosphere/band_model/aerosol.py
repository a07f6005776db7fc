"""LOWTRAN7 aerosol: four height regions, each with relative extinction and a profile at 0.55 um.

E. P. Shettle and R. W. Fenn, *Models for the Aerosols of the Lower Atmosphere and the Effects of Humidity Variations on
Their Optical Properties*, AFGL-TR-79-0214 (1979). As in LOWTRAN7 (subroutines AERPRF, EXABIN, AEREXT), only the aerosol
of the lowest 2 km depends on humidity, as one path mean.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array

MODELS = ("maritime", "rural", "urban")
REGION_TOPS_M = (2_000.0, 10_000.0, 30_000.0)
"""Tops of the boundary layer, the troposphere and the stratosphere of the aerosol model."""

QUANTITIES = ("extinction", "absorption", "asymmetry")
UPPER_REGIONS = ("troposphere", "stratosphere", "upper")
_MAX_HUMIDITY = 99.0
_NO_HAZE_M1 = 1e-30


@dataclass(frozen=True)
class AerosolTables:
    """Tables of the aerosol models.

    Attributes
    ----------
    wavelength_um : ndarray (A,)
    ln_dryness : ndarray (4,)
        ln(100 - relative humidity in percent) of the tabulated humidities.
    boundary : mapping of (str, str) to ndarray (A, 4)
        ln of ``extinction`` and ``absorption`` relative to extinction at 0.55 um, and of ``asymmetry``, by
        boundary-layer model and quantity.
    upper : mapping of str to ndarray (3, A)
        The same quantities (not their logarithms) in the three upper regions.
    haze_altitude_m : ndarray (H,)
    visibility_km : ndarray (5,)
        Descending.
    boundary_haze_m1 : ndarray (H, 5)
        Extinction at 0.55 um up to 2 km.
    upper_haze_m1 : mapping of str to ndarray (2, H)
        Extinction at 0.55 um above 2 km for each season, at visibilities of 50 and 23 km.
    """

    wavelength_um: Array
    ln_dryness: Array
    boundary: Mapping[tuple[str, str], Array]
    upper: Mapping[str, Array]
    haze_altitude_m: Array
    visibility_km: Array
    boundary_haze_m1: Array
    upper_haze_m1: Mapping[str, Array]


def read_aerosol(values: Callable[[str], Array]) -> AerosolTables:
    """Read the aerosol tables; ``values`` returns a variable of the coefficient file."""
    return AerosolTables(
        wavelength_um=values("aerosol_wavelength_um"),
        ln_dryness=np.log(100.0 - values("humidity_percent")),
        boundary={(name, quantity): np.log(values(f"{name}_{quantity}")) for name in MODELS for quantity in QUANTITIES},
        upper={quantity: np.stack([values(f"{name}_{quantity}") for name in UPPER_REGIONS]) for quantity in QUANTITIES},
        haze_altitude_m=values("haze_altitude_km") * 1e3,
        visibility_km=values("visibility_km"),
        boundary_haze_m1=values("haze_boundary_layer") * 1e-3,
        upper_haze_m1={
            season: np.stack([values(f"haze_{season.replace('-', '_')}_{km}km") for km in (50, 23)]) * 1e-3
            for season in ("spring-summer", "fall-winter")
        },
    )


def haze_m1(tables: AerosolTables, altitude_m: Array, visibility_km: float, season: str) -> Array:
    """Return the extinction at 0.55 um by region (LOWTRAN7's AERPRF).

    Interpolation is linear in 1 / visibility, also beyond 50 km, and exponential in altitude.

    Returns
    -------
    ndarray (L, 4)
        m-1; each altitude belongs to one region only.
    """
    inverse = 1.0 / visibility_km
    weight = min((inverse - 1.0 / 50.0) / (1.0 / 23.0 - 1.0 / 50.0), 1.0)
    low = np.array([np.interp(inverse, 1.0 / tables.visibility_km, row) for row in tables.boundary_haze_m1])
    low += min(weight, 0.0) * (tables.boundary_haze_m1[:, 1] - tables.boundary_haze_m1[:, 0])
    clear, hazy = tables.upper_haze_m1[season]
    above = clear + weight * (hazy - clear)
    profile = np.where(tables.haze_altitude_m <= REGION_TOPS_M[0], low, above)
    profile = np.maximum(profile, _NO_HAZE_M1)
    haze = np.exp(np.interp(altitude_m, tables.haze_altitude_m, np.log(profile)))
    haze[altitude_m > tables.haze_altitude_m[-1]] = 0.0
    region = np.searchsorted(REGION_TOPS_M, altitude_m, side="left")
    result: Array = np.where(region[:, None] == np.arange(4), haze[:, None], 0.0)
    return result


def boundary_optics(
    tables: AerosolTables,
    model: str,
    quantity: str,
    humidity_percent: Array,
    wavelengths: NDArray[np.intp] | slice = slice(None),
) -> Array:
    """Return an optical quantity of a boundary-layer aerosol at relative humidities (P,) (LOWTRAN7's EXABIN).

    The logarithm is interpolated linearly in ln(100 - humidity).

    Parameters
    ----------
    tables : AerosolTables
    model, quantity : str
    humidity_percent : ndarray (P,)
    wavelengths : ndarray (A,) or slice
        Indices of tabulated wavelengths; a narrow band needs few of them.

    Returns
    -------
    ndarray (P, A)
    """
    ln_dryness = np.log(100.0 - np.clip(humidity_percent, 0.0, _MAX_HUMIDITY))
    nodes = tables.ln_dryness  # descending
    upper = np.clip(np.searchsorted(-nodes, -ln_dryness, side="right"), 1, nodes.size - 1)
    fraction = (ln_dryness - nodes[upper - 1]) / (nodes[upper] - nodes[upper - 1])
    table = tables.boundary[model, quantity][wavelengths].T
    result: Array = np.exp(table[upper - 1] + fraction[:, None] * (table[upper] - table[upper - 1]))
    return result


def wavelength_weights(tables: AerosolTables, wavenumber_cm1: Array) -> Array:
    """Return the matrix (A, V) of linear interpolation in wavelength."""
    wavelength = 1e4 / wavenumber_cm1
    upper = np.clip(np.searchsorted(tables.wavelength_um, wavelength, side="right"), 1, tables.wavelength_um.size - 1)
    span = tables.wavelength_um[upper] - tables.wavelength_um[upper - 1]
    fraction = (wavelength - tables.wavelength_um[upper - 1]) / span
    weights = np.zeros((tables.wavelength_um.size, wavenumber_cm1.size))
    column = np.arange(wavenumber_cm1.size)
    weights[upper - 1, column] = 1.0 - fraction
    weights[upper, column] = fraction
    return weights
