"""Sea model ``cox-munk`` (Fresnel reflection by facets with Cox-Munk slopes), and geometry of all sea models."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.models.model_errors import from_table
from hcss_twin.models.parameters import CoxMunkParameters
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.models.sea import pierson_moskowitz
from hcss_twin.models.sea.facets import facet_weights, incidence_nodes
from hcss_twin.models.sea.slope_statistics import (
    MEASURED_WIND_M_S,
    mean_square_slope,
    resolved_variances,
    slope_density,
)
from hcss_twin.models.sea.wave_spectrum import WaveSpectrum
from hcss_twin.physics.fresnel import unpolarised_reflectance
from hcss_twin.providers import SeaDeclaration, SeaInputs


def directions(field: str, cosines: Array) -> Array:
    """Return cosines (M,) as float64; raise ValueError unless they are in (0, 1]."""
    values = np.asarray(cosines, dtype=np.float64)
    if values.ndim != 1:
        raise ValueError(f"{field} of shape {values.shape}: needs one axis (M,)")
    if not np.all((values > 0.0) & (values <= 1.0)):
        raise ValueError(f"{field} between {np.min(values)} and {np.max(values)}: allowed 0 < {field} <= 1")
    return values


def bearings(wind_azimuth: Array | None, count: int) -> Array | None:
    """Return wind azimuths (count,) as float64, or None; raise ValueError for another shape or infinite values."""
    if wind_azimuth is None:
        return None
    values = np.asarray(wind_azimuth, dtype=np.float64)
    if values.shape != (count,) or not np.all(np.isfinite(values)):
        raise ValueError(f"wind_azimuth of shape {values.shape}: needs ({count},), finite radians")
    return values


def relative_azimuths(relative_azimuth: Array) -> Array:
    """Return relative azimuths of sensor and source (M,) as float64; raise ValueError unless in [0, pi]."""
    values = np.asarray(relative_azimuth, dtype=np.float64)
    if not np.all((values >= 0.0) & (values <= np.pi)):
        raise ValueError(f"relative_azimuth between {np.min(values)} and {np.max(values)}: allowed 0 to pi rad")
    return values


TERMS = 32

MAX_TAIL = 1e-12
"""Maximum last terms of a Chebyshev series relative to its largest one; those of water are below 1e-13."""


def reflectance_at(index: NDArray[np.complex128], cos_incidence: Array) -> Array:
    """Return the reflectance for unpolarised light at M angles and V wavenumbers, (M, V).

    Reflectance is analytic in the cosine, so that a polynomial through about thirty Chebyshev points is exact to
    rounding and costs one matrix product. If there are few angles, or the last terms are not small (metals), every
    angle is computed separately.

    Parameters
    ----------
    index : ndarray (V,)
        Refractive index n + i k.
    cos_incidence : ndarray (M,)
        In (0, 1].

    Raises
    ------
    ValueError
        If a cosine is outside (0, 1].
    """
    few = cos_incidence.size <= 2 * TERMS
    if few or not (
        np.min(cos_incidence) > 0.0 and np.max(cos_incidence) <= 1.0
    ):  # unpolarised_reflectance also rejects NaN
        return unpolarised_reflectance(index, cos_incidence[:, None])
    nodes = incidence_nodes(TERMS)
    at_nodes = unpolarised_reflectance(index, nodes[:, None])
    # Chebyshev polynomials are orthogonal over their points.
    terms = (2.0 / TERMS) * chebyshev.chebvander(2.0 * nodes - 1.0, TERMS - 1).T @ at_nodes
    terms[0] *= 0.5
    if np.any(np.max(np.abs(terms[-2:]), axis=0) > MAX_TAIL * np.max(np.abs(terms), axis=0)):
        return unpolarised_reflectance(index, cos_incidence[:, None])
    return np.asarray(chebyshev.chebvander(2.0 * cos_incidence - 1.0, TERMS - 1) @ terms)


class CoxMunkSea:
    """Directional emissivity and BRDF of a wind-roughened sea, isotropic, first reflection only.

    Facets do not hide one another. Light reflected toward other facets is missing from the BRDF and counts as reflected
    in the emissivity, which is therefore too low at grazing views. Wind direction and water temperature have no effect:
    slopes are isotropic, and the index is tabulated at one temperature.

    Parameters
    ----------
    inputs : SeaInputs
        Wind speed 0 to 60 m/s; ValueError outside.
    parameters : CoxMunkParameters
        Which refractive index to use; CatalogError if it cannot be read.
    """

    model_errors = from_table(__file__, "cox-munk")

    def __init__(self, inputs: SeaInputs, parameters: CoxMunkParameters) -> None:
        self._mean_square_slope = mean_square_slope(inputs.wind_speed_m_s)
        self._wind_speed_m_s = inputs.wind_speed_m_s
        self._index = load_refractive_index(inputs.catalog, parameters.water_index)
        self.declares = SeaDeclaration(
            depends_on=frozenset({"view_zenith", "sun_zenith", "relative_azimuth"}),
            valid={"wavenumber_cm1": self._index.valid_cm1},
            notes=_notes(inputs.wind_speed_m_s),
        )

    @property
    def mean_square_slope(self) -> float:
        """Total mean-square slope of the surface."""
        return self._mean_square_slope

    @property
    def significant_wave_height_m(self) -> float:
        """Significant wave height of the Pierson-Moskowitz spectrum at this wind."""
        return pierson_moskowitz.significant_wave_height_m(self._wind_speed_m_s)

    def wave_slope_rms(self, pixel_size_m: float) -> tuple[float, float]:
        """Return the slope standard deviations (upwind, crosswind) of the waves resolved at a pixel size."""
        spectrum = WaveSpectrum("pierson-moskowitz", self._wind_speed_m_s)
        upwind, crosswind = resolved_variances(spectrum, pixel_size_m)
        return upwind**0.5, crosswind**0.5

    def emissivity(self, wavenumber_cm1: Array, mu: Array) -> Array:
        """Return directional emissivity (M, V): 1 minus the reflectance averaged over the visible facets.

        Eq 17 of the HCSS paper; Masuda et al. 1988, see :mod:`hcss_twin.models.sea.facets`. Raises ValueError if a
        wavenumber or cosine is out of range.
        """
        cosines = directions("mu", mu)
        index = self._index.at(wavenumber_cm1)
        weights = facet_weights(cosines, self._mean_square_slope)
        reflectance = unpolarised_reflectance(index, incidence_nodes(weights.shape[1])[:, None])
        return np.asarray(1.0 - weights @ reflectance, dtype=np.float64)

    def brdf(self, wavenumber_cm1: Array, mu_out: Array, mu_in: Array, relative_azimuth: Array) -> Array:
        """Return BRDF (M, V) in sr-1: rho(chi) P(slope) / (4 mu_out mu_in mu_n^4) (HCSS paper, eq 18).

        Cox and Munk 1954 for P. The facet that reflects the source into the sensor has the bisector of the two
        directions as normal; mu_n is the cosine of its tilt, and chi is half the angle between the directions.
        ``relative_azimuth`` (M,) is in [0, pi], pi toward the glint. Raises ValueError if a wavenumber, cosine or
        azimuth is out of range.
        """
        out, into = directions("mu_out", mu_out), directions("mu_in", mu_in)
        azimuth = relative_azimuths(relative_azimuth)
        index = self._index.at(wavenumber_cm1)
        slope_squared, cos_incidence = mirror_facet(out, into, azimuth)
        density = slope_density(slope_squared, self._mean_square_slope)
        # 1 / mu_n^2 = 1 + slope^2
        geometry = density * (1.0 + slope_squared) ** 2 / (4.0 * out * into)
        return np.asarray(geometry[:, None] * reflectance_at(index, cos_incidence), dtype=np.float64)


def mirror_facet(mu_out: Array, mu_in: Array, relative_azimuth: Array) -> tuple[Array, Array]:
    """Return the squared slope (M,) of the facet that mirrors one direction into the other, and cos(chi) (M,) on it.

    Both follow from the sum of the two unit vectors, whose length is 2 cos(chi). This is symmetric in the directions
    and avoids cancellation near the specular direction, unlike 1 + cos(2 chi).

    Parameters
    ----------
    mu_out, mu_in : ndarray (M,)
        Cosines of the zenith angles, in (0, 1].
    relative_azimuth : ndarray (M,)
        Angle between the two directions in the horizontal plane, in radians.
    """
    sin_out = np.sqrt((1.0 - mu_out) * (1.0 + mu_out))
    sin_in = np.sqrt((1.0 - mu_in) * (1.0 + mu_in))
    opening = 4.0 * np.cos(0.5 * relative_azimuth) ** 2
    horizontal_squared = (sin_out - sin_in) ** 2 + opening * (sin_out * sin_in)
    vertical = mu_out + mu_in
    cos_incidence = np.minimum(0.5 * np.sqrt(vertical**2 + horizontal_squared), 1.0)
    return horizontal_squared / vertical**2, cos_incidence


def _notes(wind_speed_m_s: float) -> tuple[str, ...]:
    notes = ["sea: first reflection only, no shadowing; emissivity is too low toward grazing views"]
    low, high = MEASURED_WIND_M_S
    if not low <= wind_speed_m_s <= high:
        notes.append(
            f"sea: wind {wind_speed_m_s:g} m/s is outside {low:g} to {high:g} m/s, where Cox and Munk "
            "measured slopes; their linear law is extrapolated"
        )
    return tuple(notes)
