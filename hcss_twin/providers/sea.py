"""Sea models: directional emissivity and reflection of the sea surface."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.providers.clouds import Grid, Motion
from hcss_twin.providers.declarations import Declaration, among


@dataclass(frozen=True)
class SeaInputs:
    """Inputs of a sea model.

    Attributes
    ----------
    wind_speed_m_s : float
        At 10 m above the sea, 0 or more.
    wind_from_deg : float
        Bearing from which the wind blows.
    temperature_K : float
        Of the water's skin.
    catalog : Catalog
        Reader of data files.
    """

    wind_speed_m_s: float
    wind_from_deg: float
    temperature_K: float
    catalog: Catalog


class WaveShapes(Protocol):
    """One realisation of the waves that an image resolves."""

    def slopes(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return slopes (2, y, x) along x and y in a window of the image, ``time_s`` after the scenario's start.

        A pixel's value does not depend on the window (to rounding).
        """
        ...


@dataclass(frozen=True, kw_only=True)
class SeaDeclaration(Declaration):
    """What a sea model declares, besides notes and its own errors.

    Attributes
    ----------
    depends_on : frozenset of str or None
        Variables that matter, among ``view_zenith``, ``sun_zenith``, ``relative_azimuth``; the conformance kit checks
        it. None: not said.
    valid : mapping of str to (low, high)
        Ranges of validity, ends included: ``wavenumber_cm1``.
    """

    depends_on: frozenset[str] | None = field(
        default=None, metadata=among("view_zenith", "sun_zenith", "relative_azimuth")
    )
    valid: Mapping[str, tuple[float, float]] = field(default_factory=dict, metadata=among("wavenumber_cm1"))


@runtime_checkable
class SeaModel(Protocol):
    """Directional emissivity and bidirectional reflectance of the sea surface.

    Kirchhoff's law: emissivity plus the integral of BRDF times ``mu_in`` over the sky is 1. The integral must not
    exceed 1 - emissivity; without ``reflection_weights`` it may be lower by up to 0.1, and the engine rescales it.
    """

    declares: SeaDeclaration

    def emissivity(self, wavenumber_cm1: Array, mu: Array) -> Array:
        """Return directional emissivity (M, V) in [0, 1] for cosines ``mu`` (M,) of the view zenith."""
        ...

    def brdf(self, wavenumber_cm1: Array, mu_out: Array, mu_in: Array, relative_azimuth: Array) -> Array:
        """Return BRDF (M, V) in sr-1 for directions given as arrays (M,); reciprocal, not negative."""
        ...


class SeaModelOptions(Protocol):
    """Optional members of a sea model.

    Attributes
    ----------
    anisotropic : bool
        Whether results depend on the bearing to the wind. The methods of an anisotropic model, including
        ``reflection_weights``, then have a last, optional argument ``wind_azimuth`` (M,) in radians: bearing of the
        sensor minus the bearing the wind comes from, in the sense in which the source is at
        ``wind_azimuth + relative_azimuth`` (:func:`hcss_twin.physics.geometry.wind_azimuths` computes both). Without it
        they return the mean over all bearings. Reciprocity of the BRDF: exchanged directions have
        ``-(wind_azimuth + relative_azimuth)``.
    significant_wave_height_m : float
        In metres, 0 or more; written into the cube.
    mean_square_slope : float
        Variance of slope of the sea, 0 or more; with ``wave_slope_rms`` the plan bounds the error of a statistical sea.
    """

    anisotropic: bool
    significant_wave_height_m: float
    mean_square_slope: float

    def wave_slope_rms(self, pixel_size_m: float) -> tuple[float, float]:
        """Return the standard deviations of slope, upwind and crosswind, of the waves that such pixels resolve."""
        ...

    def wave_field(self, grid: Grid, motion: Motion, seed: int) -> WaveShapes:
        """Return Gaussian waves with these standard deviations, independent along and across the wind.

        Needed, with ``tilted``, for scenes with resolved waves.
        """
        ...

    def tilted(self, upwind: float, crosswind: float, pixel_size_m: float) -> SeaModel:
        """Return the same sea, ``anisotropic``, where a resolved wave has this slope (dimensionless).

        Upwind: along the bearing the wind comes from; crosswind: at right angles in the sense of ``wind_azimuth``.
        Facets have the slopes of unresolved waves about it.
        """
        ...

    def reflection_weights(
        self,
        wavenumber_cm1: Array,
        mu: Array,
        mu_nodes: Array,
        basis: Literal["lagrange", "linear"] = "lagrange",
        wind_azimuth: Array | None = None,
    ) -> Array:
        """Return dimensionless weights (M, N, V) of the sky's radiance at ``mu_nodes`` (N,) for views ``mu`` (M,).

        Reflected radiance is the sum of weights times sky radiance, for a sky that is the same in all azimuths and is
        interpolated between nodes by the Lagrange polynomial or linearly (``basis``; the engine uses the default). The
        weights of a view sum to 1 - emissivity. With this method the engine does not integrate the BRDF.
        """
        ...
