"""Sea model ``rough-sea``: facets with shadowing, second reflection, sea water and foam."""

from __future__ import annotations

import copy
from functools import lru_cache, partial
from typing import Self, TypeVar

import numpy as np

from hcss_twin.core.cached_method import cached_by_spectrum
from hcss_twin.models.model_errors import from_table
from hcss_twin.models.parameters import RoughSeaParameters
from hcss_twin.models.sea.cox_munk import bearings, directions, mirror_facet, reflectance_at, relative_azimuths
from hcss_twin.models.sea.facets import both_seen, incidence_nodes, smith_lambda
from hcss_twin.models.sea.reflection import (
    INCIDENCE_COUNT,
    Basis,
    FirstHit,
    Reflection,
    basis_values,
    checked_nodes,
    reflected,
)
from hcss_twin.models.sea.sea_water import OWN_ERRORS, SeaWater, foam_coverage, foam_reflectance, load_sea_water, notes
from hcss_twin.models.sea.slope_statistics import Tilt, resolved_variances, slope_density, slope_statistics, unresolved
from hcss_twin.models.sea.wave_field import ResolvedWaves
from hcss_twin.models.sea.wave_spectrum import WaveSpectrum
from hcss_twin.physics.fresnel import unpolarised_reflectance
from hcss_twin.physics.quadrature import gauss_legendre
from hcss_twin.providers import Array, Grid, Motion, SeaDeclaration, SeaInputs

_Key = TypeVar("_Key")
_Value = TypeVar("_Value")
_WIND_AZIMUTHS = 16
_MAX_VIEWS = 64
"""Reflections held in memory, by view and node set; a column needs one view and its streams, with two sets."""
_SPECTRA = 2
"""Sets of wavenumbers whose reflectance at the nodes of incidence is held in memory."""


class RoughSea:
    """Directional emissivity and BRDF of a wind-roughened sea with shadowing and second reflections.

    The fraction ``emissivity`` of the light in a view is emitted by the sea (directly, or by a second facet that the
    first one reflects), the rest comes from the sky; :meth:`reflection_weights` returns its distribution over zenith
    angles. The BRDF contains light reflected once, and foam: its hemispherical integral is less than 1 - emissivity by
    the light reflected twice. Methods take arguments and raise errors as :class:`hcss_twin.providers.SeaModel` and
    ``SeaModelOptions``.

    Parameters
    ----------
    inputs : SeaInputs
        Wind speed 0 to 60 m/s (0 to 20 with ``gram-charlier``), temperature 263.15 to 318.15 K (if used).
    parameters : RoughSeaParameters
        Options of the model.

    Raises
    ------
    ScenarioError, ValueError
        If wind speed, temperature or salinity are outside their ranges.
    CatalogError
        If a refractive index cannot be read.
    """

    model_errors = from_table(__file__, "rough-sea")

    def __init__(self, inputs: SeaInputs, parameters: RoughSeaParameters) -> None:
        wind = inputs.wind_speed_m_s
        self._inputs = inputs
        self._slopes = slope_statistics(wind, parameters.slopes)
        self._tilt: Tilt | None = None
        self._whole: Self | None = None
        self._shadowing = parameters.shadowing
        self._water = load_sea_water(
            inputs.catalog,
            parameters.water_index,
            inputs.temperature_K,
            parameters.salinity_psu,
            by_temperature=parameters.water_temperature,
        )
        # Asked for twice at each view; the tilted parts of a sea share it.
        self._reflectance = cached_by_spectrum(partial(_reflectance_at_nodes, self._water), maxsize=_SPECTRA)
        self._foam = foam_coverage(wind, parameters.foam_law) if parameters.foam else 0.0
        self._foam_emissivity = parameters.foam_emissivity
        self._reflection = _reflection(self._slopes, parameters.shadowing, parameters.re_reflection)
        self._spectrum = WaveSpectrum(parameters.spectrum, wind, parameters.fetch_m)
        # Reflected rays do not depend on the water: seas of other temperatures share them.
        self._folds, self._seconds = self._reflection.folds, self._reflection.seconds
        self.anisotropic = not self._slopes.isotropic
        self.declares = SeaDeclaration(
            depends_on=frozenset({"view_zenith", "sun_zenith", "relative_azimuth"}),
            valid={"wavenumber_cm1": self._water.valid_cm1},
            notes=notes(inputs, parameters, self._foam),
            own_errors=OWN_ERRORS if parameters.shadowing != "none" and parameters.re_reflection else (),
        )

    @property
    def mean_square_slope(self) -> float:
        """Total mean-square slope of the surface."""
        return self._slopes.mean_square_slope

    @property
    def foam_coverage(self) -> float:
        """Fraction of the sea under foam."""
        return self._foam

    @property
    def significant_wave_height_m(self) -> float:
        """Significant wave height of the chosen spectrum at this wind."""
        return self._spectrum.significant_wave_height_m

    def wave_slope_rms(self, pixel_size_m: float) -> tuple[float, float]:
        """Return the slope standard deviations (upwind, crosswind) of the waves resolved at a pixel size."""
        upwind, crosswind = resolved_variances(self._spectrum, pixel_size_m)
        return upwind**0.5, crosswind**0.5

    def wave_field(self, grid: Grid, motion: Motion, seed: int) -> ResolvedWaves:
        """Return the waves longer than two pixels of an image; see :class:`ResolvedWaves`."""
        return ResolvedWaves(self._spectrum, self._inputs.wind_from_deg, grid, motion, seed)

    def tilted(self, upwind: float, crosswind: float, pixel_size_m: float) -> Self:
        """Return the part of this sea that resolved waves tilt by a slope (upwind, crosswind).

        Its facets have the subpixel slopes about the tilt. Shadowing and second reflection by other waves are as for
        the whole sea. Calls without a wind azimuth return values for the whole sea, because a tilt depends on azimuth.

        Raises
        ------
        ProviderError
            If slopes are ``gram-charlier``, or the resolved waves alone are rougher than the sea.
        """
        tilted = copy.copy(self)
        tilted._tilt = Tilt(upwind, crosswind, unresolved(self._slopes, self._spectrum, pixel_size_m))
        tilted._whole = self
        tilted._folds = {}
        tilted.anisotropic = True
        return tilted

    def emissivity(self, wavenumber_cm1: Array, mu: Array, wind_azimuth: Array | None = None) -> Array:
        """Return directional emissivity (M, V) (HCSS paper, eq 17, with shadows and second reflections)."""
        cosines = directions("mu", mu)
        return np.asarray(1.0 - self._from_sky(wavenumber_cm1, cosines, np.ones(1), "linear", wind_azimuth)[:, 0])

    def reflection_weights(
        self,
        wavenumber_cm1: Array,
        mu: Array,
        mu_nodes: Array,
        basis: Basis = "lagrange",
        wind_azimuth: Array | None = None,
    ) -> Array:
        """Return the fraction of the light (M, N, V) that comes from the sky, interpolated from nodes (N,).

        ``basis`` selects the sky interpolation between the nodes: the polynomial through all nodes, for a Gauss rule,
        or linear in the cosine, for any nodes and without negative weights. The weights of a view sum to 1 -
        emissivity.
        """
        nodes = checked_nodes(mu_nodes)
        return self._from_sky(wavenumber_cm1, directions("mu", mu), nodes, basis, wind_azimuth)

    def brdf(
        self,
        wavenumber_cm1: Array,
        mu_out: Array,
        mu_in: Array,
        relative_azimuth: Array,
        wind_azimuth: Array | None = None,
    ) -> Array:
        """Return BRDF (M, V) in sr-1: rho(chi) P(slope) S / (4 mu_out mu_in mu_n^4), and foam (HCSS paper, eq 18).

        Cox and Munk 1954 for P, Smith 1967 for the fraction S of facets visible from both directions. Exactly
        reciprocal: exchanged directions are those of the mirror image, wind_azimuth becoming -(wind_azimuth +
        relative_azimuth).
        """
        out, into = directions("mu_out", mu_out), directions("mu_in", mu_in)
        azimuth = relative_azimuths(relative_azimuth)
        bearing = bearings(wind_azimuth, out.size)
        if bearing is None and self._whole is not None:
            return self._whole.brdf(wavenumber_cm1, mu_out, mu_in, relative_azimuth)
        if bearing is not None or not self.anisotropic:
            shape, cosine = self._mirrors(out, into, azimuth, np.zeros(out.size) if bearing is None else bearing)
        else:
            turns = np.arange(_WIND_AZIMUTHS) * (2.0 * np.pi / _WIND_AZIMUTHS)
            # Centred on the middle between the two directions, so that exchanging them changes nothing.
            mirrors = [self._mirrors(out, into, azimuth, turn - 0.5 * azimuth) for turn in turns]
            shape, cosine = np.mean([part for part, _ in mirrors], axis=0), mirrors[0][1]
        index = self._water.at(wavenumber_cm1)
        water = shape[:, None] * reflectance_at(index, cosine)
        if self._foam == 0.0:
            return np.asarray(water, dtype=np.float64)
        foam = foam_reflectance(wavenumber_cm1, self._foam_emissivity) / np.pi
        return np.asarray((1.0 - self._foam) * water + self._foam * foam, dtype=np.float64)

    def _mirrors(self, out: Array, into: Array, azimuth: Array, bearing: Array) -> tuple[Array, Array]:
        """Return P S / (4 mu_out mu_in mu_n^4) (M,) and the cosine of incidence (M,)."""
        sin_out, sin_in = np.sqrt((1.0 - out) * (1.0 + out)), np.sqrt((1.0 - into) * (1.0 + into))
        vertical = out + into
        other = bearing + azimuth
        upwind = sin_out * np.cos(bearing) + sin_in * np.cos(other)
        crosswind = sin_out * np.sin(bearing) + sin_in * np.sin(other)
        slope_squared, cosine = mirror_facet(out, into, azimuth)
        outward = smith_lambda(out, self._slopes.variance_along(bearing))
        if self._tilt is not None:
            up, across = -upwind / vertical - self._tilt.upwind, -crosswind / vertical - self._tilt.crosswind
            # Toward the sensor, the area of the tilted part differs from the mean of the whole sea.
            area = out * (1.0 + outward) / self._tilt.cross_section(out, bearing)
            density = area * self._tilt.rest.density(up, across)
        elif self._slopes.isotropic:
            density = slope_density(slope_squared, self._slopes.mean_square_slope)
        else:
            density = self._slopes.density(-upwind / vertical, -crosswind / vertical)
        seen = both_seen(outward, smith_lambda(into, self._slopes.variance_along(other)), self._shadowing)
        return density * seen * (1.0 + slope_squared) ** 2 / (4.0 * out * into), cosine

    def _from_sky(
        self, wavenumber_cm1: Array, mu: Array, nodes: Array, basis: Basis, wind_azimuth: Array | None
    ) -> Array:
        bearing = bearings(wind_azimuth, mu.size)
        whole = self if bearing is not None or self._whole is None else self._whole
        first, second = whole._folded(mu, nodes, basis, bearing)
        water = reflected(first, second, self._reflectance(np.asarray(wavenumber_cm1, dtype=np.float64)))
        if self._foam == 0.0:
            return water
        x, w = gauss_legendre(64)
        angle = 0.5 * (x + 1.0)
        flux = (angle * w) @ basis_values(angle, nodes, basis)
        foam = flux[:, None] * foam_reflectance(wavenumber_cm1, self._foam_emissivity)[None, :]
        return np.asarray((1.0 - self._foam) * water + self._foam * foam[None], dtype=np.float64)

    def _folded(self, mu: Array, nodes: Array, basis: Basis, bearing: Array | None) -> tuple[list[FirstHit], Array]:
        """Return the reflection of each view at the nodes; cached, because views repeat for every band."""
        nodes_key = (nodes.tobytes(), basis)
        second = self._seconds.get(nodes_key)
        if second is None:
            second = self._reflection.second(nodes, basis)
            _keep(self._seconds, nodes_key, second)
        turns: list[float | None] = [None] * mu.size
        if bearing is not None and self.anisotropic:
            turns = list(bearing.tolist())
        first = []
        for view, turn in zip(mu.tolist(), turns, strict=True):
            key = (view, turn, *nodes_key)
            fold = self._folds.get(key)
            if fold is None:
                known = self._any_fold(view, turn) if nodes.size == 1 else None
                fold = known or self._reflection.first(view, nodes, basis, turn, self._tilt)
                if nodes.size == 1:
                    fold = fold.of_the_whole_sky()
                _keep(self._folds, key, fold)
            first.append(fold)
        return first, second

    def _any_fold(self, view: float, turn: float | None) -> FirstHit | None:
        """Return a cached reflection of a view, for any nodes."""
        for (own_view, own_turn, *_), fold in list(self._folds.items()):
            if (own_view, own_turn) == (view, turn):
                return fold
        return None


_reflection = lru_cache(maxsize=4)(Reflection)


def _reflectance_at_nodes(water: SeaWater, wavenumber_cm1: Array) -> Array:
    """Return Fresnel's reflectance (K, V) at the nodes of incidence."""
    return unpolarised_reflectance(water.at(wavenumber_cm1), incidence_nodes(INCIDENCE_COUNT)[:, None])


def _keep(store: dict[_Key, _Value], key: _Key, value: _Value) -> None:
    """Cache a value; if there are too many, drop all others (in one step, for thread safety)."""
    if len(store) >= _MAX_VIEWS:
        store.clear()
    store[key] = value
