"""Sunlight scattered once toward the sensor by molecules and aerosol (LOWTRAN7's SSGEO and SSRAD).

Along the line of sight, the scattering transmittance decreases layer by layer. Each decrease is weighted with the phase
function and with the transmittance of the whole path sun -> point -> sensor, whose absorber amounts add.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError
from hcss_twin.models.atmosphere.band_model.absorption import CONTINUA, Absorption, BandModelCoefficients
from hcss_twin.models.atmosphere.band_model.aerosol import (
    REGION_TOPS_M,
    AerosolTables,
    boundary_optics,
    wavelength_weights,
)
from hcss_twin.models.atmosphere.band_model.layers import LayeredAir
from hcss_twin.physics.paths import Leg

Nodes = NDArray[np.intp]

_DEPOLARIZATION = 0.0279
_MAX_SUN_ZENITH_DEG = 88.0


@dataclass(frozen=True)
class Illumination:
    """Solar zenith angle and azimuth relative to the sensor at the surface point, radians."""

    sun_zenith: float
    relative_azimuth: float


class ScatteredSunlight:
    """Computes singly scattered sunlight for one profile.

    Parameters
    ----------
    air : LayeredAir
    absorption : Absorption
    coefficients : BandModelCoefficients
    aerosol : str
        Boundary-layer model, or ``none``.
    """

    def __init__(
        self, air: LayeredAir, absorption: Absorption, coefficients: BandModelCoefficients, aerosol: str
    ) -> None:
        self._air = air
        self._absorption = absorption
        self._aerosol = aerosol
        self._tables: AerosolTables = coefficients.aerosol
        self._rayleigh_column = coefficients.exponent.size + CONTINUA.index("rayleigh")
        self._rayleigh = coefficients.absorption[self._rayleigh_column]
        self._weights = wavelength_weights(self._tables, coefficients.wavenumber_cm1)

    def radiance(self, leg: Leg, sun: Illumination, nodes: Nodes, asymmetry: float | None) -> Array:
        """Return the radiance per unit solar irradiance (N,), sr-1, at native wavenumbers."""
        layers = self._air.between(leg.lower_m, leg.upper_m)
        if not layers.temperature_K.size:
            return np.zeros(nodes.size)
        slant = self._air.slant(layers, leg.lower_m, np.array([leg.zenith_deg]))[0]
        by_layer = np.add.reduceat(slant[:, None] * layers.amount, layers.first_cell, axis=0)
        view = np.concatenate((np.zeros((1, by_layer.shape[1])), np.cumsum(by_layer[::-1], axis=0)))
        altitude = self._air.boundaries_m(layers)[::-1]
        # Local zenith of the straight line of sight, and the angle it subtends at the Earth's centre.
        zenith = math.radians(leg.zenith_deg)
        radius = self._air.earth_radius_m
        local = np.arcsin(math.sin(zenith) * radius / (radius + altitude))
        sun_angle = _sun_along(zenith - local, sun)
        if np.max(sun_angle) > math.radians(_MAX_SUN_ZENITH_DEG):
            raise ProviderError(
                f"band model: the sun is {math.degrees(float(np.max(sun_angle))):.1f} deg from the zenith of a "
                f"point on the path; allowed {_MAX_SUN_ZENITH_DEG:g} deg"
            )
        # Unscattered light travels opposite to the direction of the sun.
        scattering_cosine = -(
            math.cos(zenith) * math.cos(sun.sun_zenith)
            + math.sin(zenith) * math.sin(sun.sun_zenith) * math.cos(sun.relative_azimuth)
        )
        total = view + np.stack(
            [
                self._air.amounts_upwards(float(height), float(np.sin(angle)))
                for height, angle in zip(altitude, sun_angle, strict=True)
            ]
        )
        humidity = np.repeat(self._absorption.humidity_percent(view[-1:]), total.shape[0])
        both = self._absorption.transmittance(total, humidity, nodes)
        molecular = np.exp(-view[:, self._rayleigh_column, None] * self._rayleigh[nodes])
        result = _layer_sum(molecular, both, np.full((1, 1), _rayleigh_phase(scattering_cosine)))
        if self._aerosol != "none":
            particles, phase = self._aerosol_part(view, altitude, humidity[:1], scattering_cosine, asymmetry)
            result += _layer_sum(particles[:, nodes], both, phase[:, nodes])
        return result

    def _aerosol_part(
        self, view: Array, altitude: Array, humidity: Array, cosine: float, asymmetry: float | None
    ) -> tuple[Array, Array]:
        """Return scattering transmittance to each boundary (B, V), and phase function of each layer (L, V).

        LOWTRAN7 defines phase functions at boundaries, so that they jump for targets where a height region begins.
        """
        quantity = {
            name: np.concatenate(
                (boundary_optics(self._tables, self._aerosol, name, humidity), self._tables.upper[name])
            )
            @ self._weights
            for name in ("extinction", "absorption", "asymmetry")
        }
        first = self._absorption.aerosol_column
        depth = view[:, first : first + 4] @ (quantity["extinction"] - quantity["absorption"])
        region = np.searchsorted(REGION_TOPS_M, 0.5 * (altitude[:-1] + altitude[1:]))
        shape = quantity["asymmetry"][region]
        if asymmetry is not None:
            shape = np.full_like(shape, asymmetry)
        phase = (1.0 - shape**2) / (4.0 * np.pi * (1.0 + shape**2 - 2.0 * shape * cosine) ** 1.5)
        return np.exp(-depth), phase


def _sun_along(subtended: Array, sun: Illumination) -> Array:
    """Return the solar zenith angle at points along the line of sight, given their angle at the Earth's centre."""
    cosine = np.cos(subtended) * math.cos(sun.sun_zenith) + np.sin(subtended) * math.sin(sun.sun_zenith) * math.cos(
        sun.relative_azimuth
    )
    result: Array = np.arccos(np.clip(cosine, -1.0, 1.0))
    return result


def _layer_sum(scatterers: Array, total: Array, phase: Array) -> Array:
    """Sum over layers (t_n-1 - t_n) times phase function times the mean of total / t at both ends (SSRAD).

    Parameters
    ----------
    scatterers : ndarray (B, V)
        Scattering transmittance t from the sensor to each boundary.
    total : ndarray (B, V)
        Transmittance of the path from the sun through each boundary to the sensor.
    phase : ndarray (L, V)
        Of each layer, sr-1.
    """
    source = total / np.maximum(scatterers, 1e-300)
    weight = (scatterers[:-1] - scatterers[1:]) * 0.5 * (source[:-1] + source[1:])
    result: Array = np.sum(weight * phase, axis=0)
    return result


def _rayleigh_phase(cosine: float) -> float:
    """Return the phase function of molecules, sr-1, with depolarization."""
    share = (1.0 + _DEPOLARIZATION) + (1.0 - _DEPOLARIZATION) * cosine**2
    return 3.0 / (16.0 * math.pi) * share * 2.0 / (2.0 + _DEPOLARIZATION)
