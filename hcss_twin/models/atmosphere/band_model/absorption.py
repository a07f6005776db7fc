"""Optical depth from absorber amounts: double-exponential functions, continua and aerosol in one matrix product."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import cached_method
from hcss_twin.core.errors import CatalogError
from hcss_twin.core.files import open_format
from hcss_twin.models.atmosphere.band_model.aerosol import (
    AerosolTables,
    boundary_optics,
    read_aerosol,
    wavelength_weights,
)

FORMAT = "hcss-band-model"
FORMAT_VERSIONS = (1, 2)
"""1: LOWTRAN7's numbers, one channel of a gas at a wavenumber; 2: optical depth per amount^a of every channel."""

CONTINUA = (
    "nitrogen",
    "water_self",
    "water_self_260",
    "water_foreign",
    "rayleigh",
    "ozone_visible",
    "nitric_acid",
    "oxygen",
    "oxygen_linear",
    "oxygen_quadratic",
)
DEFAULT_MODEL = "us-standard-1976"
MAIN_GASES = ("h2o", "co2", "o3", "n2o", "co", "ch4", "o2")
TRACE_GASES = ("no", "so2", "no2", "nh3", "hno3")


@dataclass(frozen=True)
class BandModelCoefficients:
    """Band-model coefficients that do not depend on the profile.

    A *channel* scales the amount of one gas with pressure and temperature; each gas has one per group of bands.

    Attributes
    ----------
    wavenumber_cm1 : ndarray (V,)
        Native grid, steps of 5 cm-1.
    channel_gas : tuple of str (C,)
        Gas of each channel.
    pressure_exponent, temperature_exponent : ndarray (C,)
        Exponents of p / 1013.25 mb and of 273.15 K / T.
    exponent : ndarray (C,)
        Exponent a of the double exponential function.
    absorption : ndarray (C + 10, V)
        Optical depth per amount^a (channels), then per amount (continua, in the order of ``CONTINUA``).
    default_altitude_m : ndarray (D,)
    default_mixing_ratio : mapping of str to ndarray (D,)
        1976 US Standard volume mixing ratios, for gases that a profile lacks.
    resolution_cm1 : float
    source : str
    aerosol : AerosolTables
    """

    wavenumber_cm1: Array
    channel_gas: tuple[str, ...]
    pressure_exponent: Array
    temperature_exponent: Array
    exponent: Array
    absorption: Array
    default_altitude_m: Array
    default_mixing_ratio: Mapping[str, Array]
    resolution_cm1: float
    source: str
    aerosol: AerosolTables


def read_coefficients(path: Path) -> BandModelCoefficients:
    """Read the coefficients of the band model.

    Raises
    ------
    CatalogError
        If the file is not in this format, a variable is missing, or a number is missing or not finite.
    """
    with open_format(path, FORMAT, *FORMAT_VERSIONS) as dataset:
        try:
            return _from_dataset(path, dataset)
        except (KeyError, AttributeError, IndexError) as error:
            raise CatalogError(f"{path}: variable or attribute missing: {error}") from error


def _from_dataset(path: Path, dataset: Any) -> BandModelCoefficients:
    def sparse(name: str, needed: NDArray[np.bool_] | bool = True) -> Array:
        """Return a variable whose missing values, where it is not needed, are NaN."""
        filled: Array = np.ma.filled(dataset.variables[name][:].astype(np.float64), np.nan)
        if np.any(needed & ~np.isfinite(filled)):
            raise CatalogError(f"{path}: {name} has missing or infinite values")
        return filled

    def values(name: str) -> Array:
        return sparse(name)

    wavenumber = values("wavenumber_cm1")
    if not (wavenumber[0] > 0.0 and np.all(np.diff(wavenumber) > 0.0)):
        raise CatalogError(f"{path}: wavenumber_cm1 must be above 0 and ascend")
    gases = tuple(dataset.channel_gas.split())
    if dataset.format_version == 1:
        channel = np.ma.filled(dataset.variables["band_channel"][:], 0)
        # Channels that no wavenumber uses have no exponent; their matrix rows are zero.
        used = np.isin(np.arange(1, len(gases) + 1), channel)
        exponent = np.where(used, sparse("channel_exponent", used), 1.0)
        bands = _band_absorption(sparse("band_strength", channel > 0), channel, exponent)
    else:
        exponent, bands = values("channel_exponent"), values("channel_absorption")
    continua = np.stack([values(f"continuum_{name}") for name in CONTINUA])
    model = dataset.models.split().index(DEFAULT_MODEL)
    defaults = {gas: values(f"{gas}_ppmv")[model] * 1e-6 for gas in MAIN_GASES}
    defaults |= {gas: values(f"{gas}_ppmv") * 1e-6 for gas in TRACE_GASES}
    return BandModelCoefficients(
        wavenumber_cm1=wavenumber,
        channel_gas=gases,
        pressure_exponent=values("channel_pressure_exponent"),
        temperature_exponent=values("channel_temperature_exponent"),
        exponent=exponent,
        absorption=np.concatenate((bands, continua)),
        default_altitude_m=values("altitude_km") * 1e3,
        default_mixing_ratio=defaults,
        resolution_cm1=float(dataset.resolution_cm1),
        source=str(dataset.source),
        aerosol=read_aerosol(values),
    )


def _band_absorption(strength: Array, channel: NDArray[np.int8], exponent: Array) -> Array:
    """Return the coefficients 10^(a C') by channel, (C, V)."""
    result = np.zeros((exponent.size, strength.shape[1]))
    species, column = np.nonzero(np.asarray(channel) > 0)
    row = np.asarray(channel)[species, column].astype(np.intp) - 1
    result[row, column] = 10.0 ** (exponent[row] * strength[species, column])
    return result


class Absorption:
    """Computes optical depth at the native wavenumbers.

    Parameters
    ----------
    coefficients : BandModelCoefficients
    aerosol : str
        Boundary-layer model, or ``none``.
    """

    def __init__(self, coefficients: BandModelCoefficients, aerosol: str) -> None:
        self._tables = coefficients.aerosol
        self._aerosol = aerosol
        self._wavenumber = coefficients.wavenumber_cm1
        self._exponent = coefficients.exponent
        self._gas_columns: int = coefficients.absorption.shape[0]
        self._matrix = coefficients.absorption
        if aerosol != "none":
            weights = wavelength_weights(self._tables, coefficients.wavenumber_cm1)
            upper = self._tables.upper["extinction"] @ weights
            self._matrix = np.concatenate((self._matrix, upper, weights))
        self._window = cached_method(self._make_window, 4)
        self._weights = cached_method(self._make_weights, 4)

    @property
    def aerosol_column(self) -> int:
        """Index of the first aerosol column in the amounts: four height regions, then the humidity weight."""
        return self._gas_columns

    def humidity_percent(self, amount: Array) -> Array:
        """Return the aerosol-weighted mean relative humidity (P,) below 2 km for amounts (P, K)."""
        haze, weighted = amount[:, self._gas_columns], amount[:, -1]
        crossed = haze > 0.0
        result: Array = np.where(crossed, 100.0 - np.exp(weighted / np.where(crossed, haze, 1.0)), 0.0)
        return result

    def transmittance(self, amount: Array, humidity_percent: Array, nodes: NDArray[np.intp]) -> Array:
        """Return the transmittance (P, N) of amounts (P, K) at native wavenumbers, given by their indices.

        Factors of the optical depth are band amounts to their powers, continua and aerosol.
        """
        used, matrix = self._window(nodes.tobytes())
        first, powers = self._gas_columns, used[used < self._exponent.size]
        parts = [
            amount[:, powers] ** self._exponent[powers],
            amount[:, used[(used >= self._exponent.size) & (used < first)]],
        ]
        if self._aerosol != "none":
            above, boundary = used[(used >= first) & (used < first + 3)], used[used >= first + 3] - (first + 3)
            parts.append(amount[:, above + 1])
            # Of the tabulated wavelengths only those that the nodes lie between: a narrow band has few.
            extinction = boundary_optics(self._tables, self._aerosol, "extinction", humidity_percent, boundary)
            parts.append(amount[:, first : first + 1] * extinction)
        depth = np.concatenate(parts, axis=1) @ matrix
        result: Array = np.exp(np.negative(depth, out=depth), out=depth)
        return result

    def scattering(self, amount: Array, humidity_percent: Array, nodes: NDArray[np.intp]) -> tuple[Array, Array]:
        """Return the aerosol's optical depth of scattering of amounts (P, K), and the same times asymmetry, (P, N)."""
        used, weights = self._weights(nodes.tobytes())
        first = self._gas_columns
        upper = {name: values[:, used] for name, values in self._tables.upper.items()}
        boundary = {
            name: boundary_optics(self._tables, self._aerosol, name, humidity_percent, used)
            for name in ("extinction", "absorption", "asymmetry")
        }
        low = amount[:, first : first + 1] * (boundary["extinction"] - boundary["absorption"])
        above = amount[:, first + 1 : first + 4, None] * (upper["extinction"] - upper["absorption"])
        depth, forward = np.zeros((2, len(amount), len(weights)))
        depth[:, used] = low + above.sum(axis=1)
        forward[:, used] = low * boundary["asymmetry"] + (above * upper["asymmetry"]).sum(axis=1)
        return depth @ weights, forward @ weights

    def _make_weights(self, nodes: bytes) -> tuple[NDArray[np.intp], Array]:
        """Return the tabulated wavelengths that given nodes lie between, and the weights (A, N) of all."""
        weights = wavelength_weights(self._tables, self._wavenumber[np.frombuffer(nodes, dtype=np.intp)])
        return np.flatnonzero(weights.any(axis=1)), weights

    def _make_window(self, nodes: bytes) -> tuple[NDArray[np.intp], Array]:
        """Return the channels that absorb at given wavenumbers, and their coefficients; most absorb in few bands."""
        matrix = self._matrix[:, np.frombuffer(nodes, dtype=np.intp)]
        used = np.flatnonzero(matrix.any(axis=1))
        return used, matrix[used]
