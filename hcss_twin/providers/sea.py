"""Sea models: directional emissivity and reflection of the sea surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.providers.clouds import Grid, Motion
from hcss_twin.providers.common import Declares


@dataclass(frozen=True)
class SeaInputs:
    """What a sea model is built from.

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
    """One realisation of the waves that the points of an image resolve."""

    def slopes(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return slopes (2, y, x) along x and along y in a window of the image at ``time_s``.

        ``time_s`` counts from the scenario's start. A pixel's value does not depend on the window (to rounding),
        on earlier calls, or on the number of threads.
        """
        ...


@runtime_checkable
class SeaModel(Protocol):
    """Directional emissivity and bidirectional reflectance of the sea surface.

    What is not emitted is reflected (Kirchhoff): emissivity and the BRDF integrated over the sky, weighted with
    ``mu_in``, sum to 1. The integral must not exceed 1 - emissivity by more than rounding and quadrature; models
    without ``reflection_weights`` may miss it by up to 0.1, which the engine closes by scaling.
    """

    declares: Declares

    def emissivity(self, wavenumber_cm1: Array, mu: Array) -> Array:
        """Return directional emissivity (M, V) in [0, 1] for cosines ``mu`` (M,) of the view zenith."""
        ...

    def brdf(self, wavenumber_cm1: Array, mu_out: Array, mu_in: Array, relative_azimuth: Array) -> Array:
        """Return BRDF (M, V) in sr-1 for directions given as arrays (M,); reciprocal, not negative."""
        ...


class SeaModelOptions(Protocol):
    """What a sea model may have beside ``SeaModel``.

    Attributes
    ----------
    anisotropic : bool
        Whether results depend on the bearing to the wind; without the attribute they do not. The methods of an
        anisotropic model, ``reflection_weights`` among them, take one more and last argument ``wind_azimuth`` (M,),
        which may be left out: bearing of the sensor minus the bearing the wind comes from, in radians and counted in
        the sense in which the source lies at ``wind_azimuth + relative_azimuth``
        (:func:`hcss_twin.physics.geometry.wind_azimuths` gives both). Without it they return the mean over all
        bearings. The BRDF is reciprocal where exchanged directions go with ``-(wind_azimuth + relative_azimuth)``.
    significant_wave_height_m : float
        Metres, 0 or more; written into the cube.
    mean_square_slope : float
        Variance of slope of the whole sea, 0 or more; with ``wave_slope_rms`` the plan bounds what averaging over waves
        leaves out.
    """

    anisotropic: bool
    significant_wave_height_m: float
    mean_square_slope: float

    def wave_slope_rms(self, pixel_size_m: float) -> tuple[float, float]:
        """Return the deviations of slope, upwind and crosswind, of the waves that pixels of this size resolve."""
        ...

    def wave_field(self, grid: Grid, motion: Motion, seed: int) -> WaveShapes:
        """Return waves with slopes of these deviations that travel with themselves and with the platform.

        Gaussian, independent along and across the wind. With ``tilted`` it lets a scene draw its waves.
        """
        ...

    def tilted(self, upwind: float, crosswind: float, pixel_size_m: float) -> SeaModel:
        """Return the same sea where a resolved wave has this slope, dimensionless.

        Along the bearing the wind comes from, and at right angles to it in the sense in which ``wind_azimuth`` is
        counted; facets have the slopes that are left below the pixel, about this one. The sea returned is
        ``anisotropic``.
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
        """Return the share (M, N, V) of the light seen at ``mu`` (M,) that came from the sky at ``mu_nodes`` (N,).

        The reflected radiance is the sum over nodes of weight times the sky's radiance there, for a sky known at
        the zenith cosines ``mu_nodes``, the same in all azimuths, and between them continued by the Lagrange
        polynomial through them or linearly (``basis``; the engine leaves it at its default). Dimensionless; the
        weights of each view sum to 1 - emissivity. With it the engine does not integrate the BRDF.
        """
        ...
