"""The contract between providers and the engine.

Four kinds can be swapped by any installed package (cloud generators, sea models, optics,
transmittance providers), and a fifth, the radiance model, assembles what they return. A
provider is a class that is called as ``Class(inputs, parameters)``: ``inputs`` is the
dataclass of its kind below, ``parameters`` an instance of the parameter model its spec
names. Principles:

* Providers return dimensionless or geometric properties; only the engine multiplies by
  Planck's function or the sun (a file that brings its own path radiance is the exception).
* A transmittance is asked for a *whole composite path*. Legs are summed, never multiplied,
  because band-model and k-distributed transmittances do not multiply.
* Providers declare what they depend on, so that the plan can skip. This version uses the ranges of
  wavenumber and view zenith, the native grid, ``tileable`` and ``notes``; the rest is for the plans
  to come, and the conformance kit checks it already.
* Outside a declared range is an error, never a clamp.

Axes: ``wavenumber_cm1`` (V,) ascending and last; altitudes above the sea in metres; angles
as cosines ``mu`` or radians. Azimuths are bearings from the surface point toward sensor or
sun, clockwise from north; ``relative_azimuth`` in [0, pi] is 0 with the sensor on the sun's
side and pi toward the glint. View zenith angles are those at the surface point.

The provider API is version 0: it may change until it is frozen as version 1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hcss_twin.catalog import Catalog
from hcss_twin.physics.paths import Path
from hcss_twin.physics.profile import Profile

API_VERSION = 0

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Declares:
    """What a provider says about itself; it only removes work or places nodes.

    Beside it a cloud generator may have ``skipped`` (pairs of what it left out and why, for the plan)
    and ``image_coverage`` (a number where the coverage follows from an image and not from the
    scenario), and a sea model ``significant_wave_height_m`` (written into the cube).

    Attributes
    ----------
    depends_on : frozenset of str
        Among ``view_zenith``, ``sun_zenith``, ``relative_azimuth``, ``thickness``, ``time``.
    valid : mapping of str to (low, high)
        Ranges of validity, for example ``{"wavenumber_cm1": (500, 10000)}``; outside is an error.
    native_grid_cm1 : ndarray (N,), optional
        Spectral nodes to which calls are restricted between band edges.
    resolution_cm1 : float
        Spectral resolution; 0 where the provider is pointwise.
    evolves : bool
        Whether a cloud field changes other than by translation.
    tileable : bool
        Whether a cloud generator can give any window of a frame alone.
    notes : tuple of str
        What a user should know; copied into plan and cube.
    legs : {"any", "to_space"}
        Paths a transmittance provider knows: any legs, or only such as reach from one target to space. For the
        latter the radiance model fits a law that serves other paths.
    """

    depends_on: frozenset[str] = frozenset()
    valid: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    native_grid_cm1: Array | None = None
    resolution_cm1: float = 0.0
    evolves: bool = False
    tileable: bool = True
    notes: tuple[str, ...] = ()
    legs: Literal["any", "to_space"] = "any"


# --- clouds -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Grid:
    """The image plane: ``rows`` x ``columns`` square pixels of ``pixel_size_m``; x along columns.

    A cloud generator gets the plane of the points it is asked for: with n x n points per pixel of the image there
    are n times the rows and columns, of an n-th of the size, and each point is the centre of its square.
    """

    rows: int
    columns: int
    pixel_size_m: float


@dataclass(frozen=True)
class Motion:
    """What moves: the platform's ground speed along +x, the wind that carries the clouds, and evolution.

    Attributes
    ----------
    platform_speed_m_s : float
        Speed of the image's ground footprint in +x (columns).
    cloud_velocity_m_s : (float, float)
        Velocity (x, y) of the cloud field over the ground.
    evolution_time_s : float
        Lattice cell of the time dimension at the coarsest octave; infinity freezes the shapes.
    frame_interval_s : float
        Time between frames.
    """

    platform_speed_m_s: float
    cloud_velocity_m_s: tuple[float, float]
    evolution_time_s: float
    frame_interval_s: float


@dataclass(frozen=True)
class Microphysics:
    """Particles of one cloud layer: n(r) = a r^alpha exp(-b r^nu), the modified gamma distribution.

    Attributes
    ----------
    phase : {"water", "ice"}
        Thermodynamic phase, which selects the refractive index.
    alpha, b, nu : float
        Shape, scale (um^-nu) and exponent for a radius in micrometres.
    number_density_m3 : float
        Particles per cubic metre; fixes ``a`` by normalisation.
    radius_range_um : (float, float)
        Limits of integration r1, r2.
    """

    phase: Literal["water", "ice"]
    alpha: float
    b: float
    nu: float
    number_density_m3: float
    radius_range_um: tuple[float, float]


@dataclass(frozen=True)
class CloudLayer:
    """One cloud layer: where it is and what it is made of.

    Attributes
    ----------
    name : str
        Cloud type, for people.
    base_m, top_m : float
        Altitudes of the layer's base and of its highest possible top.
    anchor : {"base", "top"}
        Which of the two stays where it is when the cloud is thinner than ``top_m - base_m``.
    thickness_min_m : float
        Thickness of the thinnest cloudy pixel.
    coverage : float
        Fraction of cloudy pixels, 0 to 1.
    temperature_K : float or None
        Cloud temperature; None takes the profile's at the cloud top.
    microphysics : Microphysics
        Particles.
    coverage_mode : {"frame", "field"}
        ``frame``: exactly ``coverage`` in every frame. ``field``: one threshold for the unbounded field,
        exact in the mean, so that every window and every sensor sees the same clouds.
    edge_taper : float
        0 to 1: part of the cloudy area, from the edge inward, over which thickness rises smoothly from
        its minimum; 0 is eq 7 as printed.
    """

    name: str
    base_m: float
    top_m: float
    anchor: Literal["base", "top"]
    thickness_min_m: float
    coverage: float
    temperature_K: float | None
    microphysics: Microphysics
    coverage_mode: Literal["frame", "field"] = "frame"
    edge_taper: float = 0.0

    @property
    def thickness_max_m(self) -> float:
        """Greatest geometric thickness."""
        return self.top_m - self.base_m

    def cloud_top_m(self, thickness_m: Array) -> Array:
        """Altitude of the cloud top, same shape as ``thickness_m``."""
        if self.anchor == "base":
            return self.base_m + thickness_m
        return np.full_like(thickness_m, self.top_m)


@dataclass(frozen=True)
class CloudInputs:
    """What a cloud generator is built from; ``type_parameters`` are the catalog's for this cloud type."""

    layer: CloudLayer
    grid: Grid
    motion: Motion
    seed: int
    catalog: Catalog
    type_parameters: Mapping[str, Any] = field(default_factory=dict)


@runtime_checkable
class CloudGenerator(Protocol):
    """Fields of cloud thickness."""

    declares: Declares

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return geometric thickness (y, x) of a window of the image at ``time_s``; 0 is clear sky.

        ``time_s`` counts from the scenario's start. A pixel's value must not depend on the window
        (unless ``declares.tileable`` is False, when only whole frames are asked for), on earlier
        calls, or on the number of threads.
        """
        ...


# --- sea --------------------------------------------------------------------------------


@dataclass(frozen=True)
class SeaInputs:
    """What a sea model is built from."""

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

    A model whose attribute ``anisotropic`` is true also takes ``wind_azimuth`` (M,) as the last argument of
    both methods: bearing of the sensor minus the bearing the wind comes from, in radians and counted in the
    sense in which the source lies at ``wind_azimuth + relative_azimuth``
    (:func:`hcss_twin.physics.geometry.wind_azimuths` gives both). Without it the model returns the mean over all
    bearings.

    A model may have ``reflection_weights(wavenumber_cm1, mu, mu_nodes, basis, wind_azimuth) -> (M, N, V)``: the
    share of the light seen that came from the sky, folded onto the zenith cosines at which the sky is known.
    The weights of each view sum to 1 minus its emissivity.

    A model may say how steep the waves are that pixels see: ``mean_square_slope`` (of the whole sea) and
    ``wave_slope_rms(pixel_size_m) -> (upwind, crosswind)``, the deviations of slope of the waves that such pixels
    resolve. From both the plan makes the bound on what averaging over waves leaves out. To have its waves drawn it
    also needs:

    * ``wave_field(grid, motion, seed) -> WaveShapes``: slopes with these deviations, Gaussian and independent along
      and across the wind, that travel with the waves and with the platform;
    * ``tilted(upwind, crosswind, pixel_size_m) -> SeaModel``: the same sea where a resolved wave has this slope along
      the bearing the wind comes from and at right angles to it, in the sense in which ``wind_azimuth`` is counted; its
      facets have the slopes that are left below the pixel, about this one. It is ``anisotropic``.
    """

    declares: Declares

    def emissivity(self, wavenumber_cm1: Array, mu: Array) -> Array:
        """Return directional emissivity (M, V) in [0, 1] for cosines ``mu`` (M,) of the view zenith."""
        ...

    def brdf(self, wavenumber_cm1: Array, mu_out: Array, mu_in: Array, relative_azimuth: Array) -> Array:
        """Return BRDF (M, V) in sr-1 for directions given as arrays (M,); reciprocal, not negative."""
        ...


# --- optics -----------------------------------------------------------------------------


@dataclass(frozen=True)
class SingleScattering:
    """Bulk single-scattering properties of a cloud volume.

    Attributes
    ----------
    extinction_m1 : ndarray (V,)
        Volume extinction coefficient.
    albedo : ndarray (V,)
        Single-scattering albedo in [0, 1].
    moments : ndarray (K, V)
        Legendre moments of the phase function: ``moments[0]`` = 1, ``moments[1]`` = asymmetry
        parameter. K = 2 means Henyey-Greenstein.
    """

    extinction_m1: Array
    albedo: Array
    moments: Array


@dataclass(frozen=True)
class OpticsInputs:
    """What an optics provider is built from."""

    catalog: Catalog


@runtime_checkable
class Optics(Protocol):
    """Bulk optical properties of cloud particles."""

    declares: Declares

    def single_scattering(self, cloud: Microphysics, wavenumber_cm1: Array) -> SingleScattering:
        """Return bulk properties at ``wavenumber_cm1`` (V,)."""
        ...


# --- atmosphere -------------------------------------------------------------------------


@dataclass(frozen=True)
class AtmosphereInputs:
    """What a transmittance provider is built from."""

    profile: Profile
    catalog: Catalog


@runtime_checkable
class TransmittanceProvider(Protocol):
    """Gas (and aerosol) transmittance of composite paths.

    A provider may also have ``path_radiance(wavenumber_cm1, paths) -> (P, V)`` in
    W m-2 sr-1 (cm-1)-1: its own thermal emission of single upward legs to space. Without it the
    engine derives path radiance from transmittances and the profile's temperatures.

    A class whose data belong to one profile may also have the static method
    ``bound_profile(parameters, catalog) -> Profile``. It is asked before the provider is made: a scenario
    that names no profile gets this one, and one that scales its water vapour is refused. Without it the
    provider accepts any profile.
    """

    declares: Declares

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return transmittance (P, V) in [0, 1] of each composite path; 1 for a path without legs."""
        ...


# --- radiance ---------------------------------------------------------------------------


@dataclass(frozen=True)
class View:
    """Direction from the surface point to the sensor."""

    zenith_deg: float
    azimuth_deg: float


@dataclass(frozen=True)
class Sun:
    """The sun seen from the surface point.

    Attributes
    ----------
    zenith_deg, azimuth_deg : float
        Apparent (refracted) zenith and bearing.
    distance_au : float
        Earth-Sun distance.
    """

    zenith_deg: float
    azimuth_deg: float
    distance_au: float

    @property
    def is_up(self) -> bool:
        """Whether the sun is above the horizon of the surface point."""
        return self.zenith_deg < 90.0


@dataclass(frozen=True)
class RadianceInputs:
    """What a radiance model is built from: the scene's providers and states.

    ``layers`` run from the lowest to the highest and do not overlap; there may be none.
    ``solar_irradiance`` maps wavenumbers (V,) to W m-2 (cm-1)-1 at 1 au.
    """

    profile: Profile
    transmittance: TransmittanceProvider
    sea: SeaModel
    optics: Optics
    layers: tuple[CloudLayer, ...]
    sea_temperature_K: float
    view: View
    solar_irradiance: SolarIrradiance
    wind_from_deg: float = 0.0


class SolarIrradiance(Protocol):
    """Extraterrestrial spectral irradiance at 1 au."""

    def __call__(self, wavenumber_cm1: Array) -> Array:
        """Return W m-2 (cm-1)-1 at ``wavenumber_cm1`` (V,)."""
        ...


@runtime_checkable
class RadianceModel(Protocol):
    """Assembly of the spectral radiance of one column of sea, cloud and air.

    ``terms`` maps the name of each part to its description; their sum is the radiance at the
    sensor. ``solar_terms`` names those that are exactly 0 without a sun.
    """

    declares: Declares
    terms: Mapping[str, str]
    solar_terms: frozenset[str]

    def clear(self, wavenumber_cm1: Array, sun: Sun | None) -> Mapping[str, Array]:
        """Return each term (V,) of a cloud-free column, W m-2 sr-1 (cm-1)-1; ``sun`` None: no sun."""
        ...

    def cloudy(self, wavenumber_cm1: Array, thickness_m: Array, sun: Sun | None) -> Mapping[str, Array]:
        """Return each term (N, V) of cloudy columns.

        ``thickness_m`` (N, L) has one column per layer, in the order of ``inputs.layers``; 0 means that the
        layer has no cloud there, and no row is all 0.
        """
        ...
