"""Cloud generators: fields of cloud thickness."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.providers.declarations import Declaration, among

_EPSILON = float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class Grid:
    """The image plane: ``rows`` x ``columns`` square pixels of ``pixel_size_m``; x along columns.

    For n x n points per pixel of the image, a cloud generator gets n times the rows and columns of 1/n of the size;
    each point is the centre of its square.
    """

    rows: int
    columns: int
    pixel_size_m: float

    def inside(self, rows: slice, columns: slice) -> tuple[slice, slice]:
        """Return a window with its open ends filled in.

        Raises
        ------
        ValueError
            If it has a step or reaches outside the grid.
        """
        windows = []
        for name, window, size in (("rows", rows, self.rows), ("columns", columns, self.columns)):
            start = 0 if window.start is None else window.start
            stop = size if window.stop is None else window.stop
            if window.step not in (None, 1) or not 0 <= start <= stop <= size:
                raise ValueError(f"{name}: {window} given, allowed: a window without step inside 0 to {size}")
            windows.append(slice(start, stop))
        return windows[0], windows[1]

    def displacement_pixels(self, speed_m_s: float, time_s: float) -> float:
        """Return how far something moves, in pixels (v t of eq 4), without rounding errors where it is a round number.

        A distance within a few units in the last place of a multiple of 1/1024 pixel is rounded to that multiple.
        Otherwise a platform that moves by whole pixels per frame would not reproduce the same bits at times such as
        3 x 0.1 s.
        """
        distance = speed_m_s * time_s / self.pixel_size_m
        rounded = round(distance * 1024.0) / 1024.0
        return rounded if abs(distance - rounded) <= 8.0 * _EPSILON * abs(distance) else distance


@dataclass(frozen=True)
class Motion:
    """Motion of platform and clouds, and evolution of cloud shapes.

    Attributes
    ----------
    platform_speed_m_s : float
        Speed of the image's ground footprint in +x (columns).
    cloud_velocity_m_s : (float, float)
        Velocity (x, y) of the cloud field over the ground.
    evolution_time_s : float
        Time in which the largest structures change; infinity: frozen shapes.
    frame_interval_s : float
        Time between frames.
    lifetime_s_per_m : float, optional
        Time in which structures of 8 km wavelength and more change, per size of a lattice cell, half their
        wavelength; replaces ``evolution_time_s`` in generators that can. None: not by size.
    """

    platform_speed_m_s: float
    cloud_velocity_m_s: tuple[float, float]
    evolution_time_s: float
    frame_interval_s: float
    lifetime_s_per_m: float | None = None


@dataclass(frozen=True)
class Microphysics:
    """Particles of one cloud layer: n(r) = a r^alpha exp(-b r^nu), the modified gamma distribution.

    Attributes
    ----------
    material : str
        What they are made of: ``water``, ``ice``, or another material that the layer's optics provider handles.
    alpha, b, nu : float
        Shape, scale (um^-nu) and exponent for a radius in micrometres.
    number_density_m3 : float
        Particles per cubic metre, from which ``a`` follows.
    radius_range_um : (float, float)
        Limits of integration r1, r2.
    density_kg_m3 : float or None
        Of the material; None for water and ice.
    """

    material: str
    alpha: float
    b: float
    nu: float
    number_density_m3: float
    radius_range_um: tuple[float, float]
    density_kg_m3: float | None = None


@dataclass(frozen=True)
class CloudLayer:
    """One cloud layer: altitudes, coverage and particles.

    Attributes
    ----------
    name : str
        Cloud type.
    base_m, top_m : float
        Altitudes of the layer's base and of its highest top.
    anchor : {"base", "top"}
        The boundary that stays fixed if the cloud is thinner than ``top_m - base_m``.
    thickness_min_m : float
        Thickness of the thinnest cloudy pixel.
    coverage : float
        Fraction of cloudy pixels, 0 to 1.
    temperature_K : float or None
        Cloud temperature; None: that of the air at the cloud top.
    microphysics : Microphysics
        Particles.
    coverage_mode : {"frame", "field"}
        ``frame``: exactly ``coverage`` in every frame. ``field``: one threshold for the unbounded field, exact in the
        mean, so that all windows and sensors see the same clouds.
    edge_taper : float
        Part of the cloudy area, 0 to 1 from the edge inward, over which thickness rises smoothly; 0 is eq 7 as printed.
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

    @property
    def reference_height_m(self) -> float:
        """Height at which the layer is seen: its base, or its top if it is anchored at the top."""
        return self.base_m if self.anchor == "base" else self.top_m

    def cloud_top_m(self, thickness_m: Array) -> Array:
        """Altitude of the cloud top, same shape as ``thickness_m``."""
        if self.anchor == "base":
            return self.base_m + thickness_m
        return np.full_like(thickness_m, self.top_m)

    def hanging_from(self, top_m: float) -> CloudLayer:
        """Return the layer with another top, from which clouds of any thickness hang; it does not reach below 0 m."""
        return replace(self, base_m=max(top_m - self.thickness_max_m, 0.0), top_m=top_m, anchor="top")


class BrightnessInversion(Protocol):
    """Thickness of a layer from its brightness temperature at 10.8 um, in the scene that the generator is made for.

    For generators that start from images. It is computed at first use, with the scene's own radiance model.
    """

    @property
    def clear_K(self) -> float:
        """Brightness temperature of the clear sky."""
        ...

    @property
    def coldest_K(self) -> float:
        """Lowest brightness temperature that the layer's clouds can have."""
        ...

    def air_temperature_K(self, altitude_m: Array) -> Array:
        """Return the temperature of the air, any shape; below sea level and above the profile that of its ends.

        An opaque cloud with its top at that altitude has about this brightness temperature.
        """
        ...

    def thickness_m(self, brightness_temperature_K: Array) -> NDArray[np.float32]:
        """Return the thickness of the layer, same shape, 0 for the temperature of clear sky and above.

        What is colder than ``coldest_K`` has the greatest thickness. The layer has no cloud thinner than its
        ``thickness_min_m``: what would be thinner gets that thickness or 0, whichever is closer in temperature.
        """
        ...

    def hanging_K(self, top_m: float) -> tuple[Array, Array]:
        """Return thicknesses (N,) in m from 0 on, and the brightness temperature of clouds that hang from an altitude.

        The layer is that of :meth:`CloudLayer.hanging_from`. For generators with ``cloud_top_m``.
        """
        ...

    def in_band(self, limits_um: tuple[float, float]) -> BrightnessInversion:
        """Return the inversion in a band of equal response in wavenumber, without sunlight."""
        ...


@dataclass(frozen=True)
class CloudInputs:
    """Inputs of a cloud generator.

    Attributes
    ----------
    layer : CloudLayer
        Altitudes, thickness and coverage.
    grid : Grid
        Plane of the points.
    motion : Motion
        Motion and evolution.
    seed : int
        0 to below 2^63, different for each layer. All random numbers derive from it.
    catalog : Catalog
        Reader of data files.
    type_parameters : mapping of str to anything
        Parameters of the cloud type's shapes, by the names of the fractal generator; may be empty.
    inversion : BrightnessInversion or None
        None outside a scene, and in one whose other values are rejected.
    """

    layer: CloudLayer
    grid: Grid
    motion: Motion
    seed: int
    catalog: Catalog
    type_parameters: Mapping[str, Any] = field(default_factory=dict)
    inversion: BrightnessInversion | None = None


@dataclass(frozen=True, kw_only=True)
class CloudDeclaration(Declaration):
    """What a cloud generator declares, besides notes and its own errors.

    Attributes
    ----------
    depends_on : frozenset of str or None
        Variables that matter, among ``time``; the conformance kit checks it. None: not said.
    evolves : bool
        Whether the field changes in other ways than by translation.
    tileable : bool
        Whether it can give any window of a frame alone.
    """

    depends_on: frozenset[str] | None = field(default=None, metadata=among("time"))
    evolves: bool = False
    tileable: bool = True


@runtime_checkable
class CloudGenerator(Protocol):
    """Fields of cloud thickness."""

    declares: CloudDeclaration

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return geometric thickness (y, x) of a window of the image, ``time_s`` after the start; 0: clear sky.

        Both slices have start and stop, and no step. A pixel's value must not depend on the window (unless
        ``declares.tileable`` is False; then all windows are whole frames).
        """
        ...


class CloudGeneratorOptions(Protocol):
    """Optional members of a cloud generator.

    Attributes
    ----------
    skipped : sequence of (str, str)
        Omitted physics and why, each a few words; listed in the plan.
    image_coverage : float or None
        Cloudy fraction, 0 to 1, from an image; it replaces ``layer.coverage``, even 0. None: the layer's.
    honours : collection of str
        Fields of the layer, of ``coverage_mode`` and ``edge_taper``, that the generator uses. Plan and cube warn about
        others that a scenario sets.
    cloud_top_range_m : (float, float) or None
        Lowest and highest altitude of ``cloud_top_m``. None: tops are those of the layer.
    clear_sky_varies : bool
        Whether thin cloud gives the clear sky the texture of an image, so that the scene adds none by default. Without
        it: no.
    goes_on_with : str
        Of clouds that end with their image: key and value of the scenario with which they go on, for messages.
    """

    skipped: Sequence[tuple[str, str]]
    image_coverage: float | None
    honours: Collection[str]
    cloud_top_range_m: tuple[float, float] | None
    clear_sky_varies: bool
    goes_on_with: str

    def cloud_top_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the altitude of the cloud top (y, x) of a window; where it is clear any within the range.

        The range is ``cloud_top_range_m``. Where that is None, generators with ``cloud_depth_m`` have tops within the
        layer: the sun's paths alone then cross clouds of these heights.

        The cloud of a point is that of :meth:`CloudLayer.hanging_from`: the generator keeps it no thicker than that
        layer. A pixel's value must not depend on the window, which may reach outside the image if the generator has
        ``thickness_around_m``. Only tileable generators may have it.
        """
        ...

    def cloud_depth_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the height (y, x) over which the cloud of a point is spread, from ``cloud_top_m`` down.

        Slant paths cross clouds of this height, which have their thickness in all; without it height and thickness are
        the same. Above 0, and no more than ``thickness_max_m`` of the layer. Only with ``cloud_top_m``, for the same
        windows.
        """
        ...

    def frame_summary(self, time_s: float) -> Any:
        """Return what windows of the frame at ``time_s`` need of the whole frame.

        For generators of whole frames (``declares.tileable`` is False), with ``thickness_in_frame_m``: frames of more
        than 4096 x 4096 points are then computed by windows. It must not grow with the frame; it can be pickled.
        """
        ...

    def thickness_in_frame_m(self, time_s: float, rows: slice, columns: slice, summary: Any) -> NDArray[np.float32]:
        """Return the thickness (y, x) of a window, equal to the bit to ``thickness_m`` of the whole frame."""
        ...

    def thickness_around_m(self, time_s: float, rows: slice, columns: slice, summary: Any) -> NDArray[np.float32]:
        """Return the thickness (y, x) of a window that may reach outside the image, also to negative indices.

        For generators of unbounded skies: blurring optics see clouds beyond the image. Inside the image the result
        equals ``thickness_m`` to the bit. ``summary`` is that of ``frame_summary``, or None without one.
        """
        ...

    def height_shares(
        self, time_s: float, rows: slice, columns: slice, thickness_m: NDArray[np.float32], edges_m: Array
    ) -> NDArray[np.float32]:
        """Return how the cloud of each point is spread over heights: shares (Z, y, x) between altitudes (Z + 1,).

        For light between columns: any top, base, profile or voxels. Edges ascend through the layer. Shares of a point
        sum to 1 where the thickness (y, x) of the window is above 0, else to 0. Windows may leave the image.
        """
        ...
