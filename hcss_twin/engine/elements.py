"""Elements of a scene: attenuation, addition to the radiance of the frames, and what they hide.

The radiance of a pixel with an element of radiance L, share c and altitude z becomes

    L_pixel + c t [T L + A - L_behind]

with the direct transmission t of the clouds above z, transmittance T and emission A of the air above z, and the
radiance L_behind of the pixel without these clouds, which is L_pixel if there are none. Light that clouds scatter into
the line of sight remains. An unresolved source of intensity I adds c t T I / (a cos(view zenith)), with the area a of
the pixel on the ground, and hides nothing. Lower elements come first, so that higher ones hide them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.cube.variables import ELEMENT, ELEMENT_SHARE
from hcss_twin.engine.element_paths import ElementPaths
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.over_views import image_views
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.slant_paths import displacement_m
from hcss_twin.plan.views import ImageViews
from hcss_twin.plan.windows import Window, length, points_of
from hcss_twin.providers import ElementPixels, SightPath, Sun

if TYPE_CHECKING:
    from hcss_twin.engine.tables.over_points import AnyLookUp

Thickness = NDArray[np.float32]

_SEED_KEY = 2**18
"""Distinguishes the seeds of elements from those of clouds, waves and the certificate."""


class Clouds(Protocol):
    """Clouds of one instant, as :class:`hcss_twin.engine.stream.FrameClouds`."""

    def thickness_m(self, window: Window) -> list[Thickness]:
        """Thickness of each layer at the points of a window."""


class ElementStage:
    """Elements of a scene."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._paths = ElementPaths(plan)
        self._views = None if plan.views is None or plan.imager is not None else image_views(plan)

    def at(self, index: int, time_s: float, clouds: Clouds, look_up: AnyLookUp | None) -> InstantElements:
        """Return the elements of a part of a frame.

        Parameters
        ----------
        index : int
            Number of the frame.
        time_s : float
            Time after the start.
        look_up : LookUp, ViewedLookUp, SurfaceLookUp or None
            Look-up of the part; None without radiance.
        """
        return InstantElements(self._plan, self._paths, self._views, index, time_s, clouds, look_up)


class InstantElements:
    """Elements of a part of one frame, and the scene around them (:class:`hcss_twin.providers.ElementScene`)."""

    sun: Sun | None
    random: np.random.Generator

    def __init__(
        self,
        plan: Plan,
        paths: ElementPaths,
        views: ImageViews | None,
        index: int,
        time_s: float,
        clouds: Clouds,
        look_up: AnyLookUp | None,
    ) -> None:
        self._plan, self._paths, self._views = plan, paths, views
        self._clouds, self._look_up = clouds, look_up
        self._time_s, self._number = time_s, plan.scenario.frames.first + index

    def add(
        self,
        window: Window,
        thickness_m: Sequence[Thickness],
        radiance: NDArray[np.float32],
        added: NDArray[np.float32],
        truth: Mapping[str, NDArray[Any]],
        place: Window,
    ) -> NDArray[np.bool_]:
        """Add the elements to a window.

        Parameters
        ----------
        window, place : (slice, slice)
            Rows and columns of the window in the image, and in the part.
        thickness_m : sequence of ndarray (window rows x samples, window columns x samples)
            Of each layer.
        radiance : ndarray of float32 (C, y, x)
            Radiance of the part; its first B channels are the totals of the bands.
        added : ndarray of float32 (B, y, x)
            Gets the difference that elements make; without channels if it is not wanted.
        truth : mapping of str to ndarray (y, x)
            Truth variables of the part.

        Returns
        -------
        ndarray of bool (window rows, window columns)
            Pixels with an element.
        """
        plan, parts = self._plan, list[tuple[int, ElementPixels]]()
        for number, provider in enumerate(plan.assembly.elements, start=1):
            seed = np.random.SeedSequence(plan.scenario.seed, spawn_key=(_SEED_KEY, number, self._number))
            self.sun, self.random = plan.sun_at(self._time_s), np.random.Generator(np.random.PCG64(seed))
            parts += ((number, pixels) for pixels in provider.pixels(self._time_s, *window, self))
        parts.sort(key=lambda part: part[1].altitude_m)
        present = np.zeros((length(window[0]), length(window[1])), dtype=np.bool_)
        for number, pixels in parts:
            own = {ELEMENT: number, ELEMENT_SHARE: pixels.share}
            own |= {f"{ELEMENT}_{name}": values for name, values in pixels.truth.items()}
            y, x = pixels.rows - window[0].start, pixels.columns - window[1].start
            present[y, x] = True
            for name, array in truth.items():
                if name.startswith(ELEMENT):
                    array[place][y, x] = own.get(name, np.nan)
            for n, corner in enumerate(zip(y.tolist(), x.tolist(), strict=True)):
                points = [each[_points(corner, plan.samples_per_pixel)] for each in thickness_m]
                at = corner[0] + place[0].start, corner[1] + place[1].start
                self._add_pixel(pixels, n, points, radiance, added, at)
        return present

    def project(self, x_m: Array, y_m: Array, altitude_m: Array) -> tuple[Array, Array]:
        """Return where points appear in the image, as :meth:`hcss_twin.providers.ElementScene.project`."""
        plan, grid = self._plan, self._plan.grid
        north, east = 0.0 * altitude_m, 0.0 * altitude_m
        if plan.assembly.slant.parallax:
            toward = plan.assembly.slant.view
            north, east = displacement_m(altitude_m, toward.zenith_deg, toward.azimuth_deg)
        centre_m = plan.assembly.motion.platform_speed_m_s * self._time_s
        row = (y_m - north) / grid.pixel_size_m + 0.5 * grid.rows
        return row, (x_m - east - centre_m) / grid.pixel_size_m + 0.5 * grid.columns

    def path(self, x_m: float, y_m: float, altitude_m: float) -> SightPath:
        """Return what is between a point and the sensor, as :meth:`hcss_twin.providers.ElementScene.path`."""
        row, column = (
            math.floor(each[0]) for each in self.project(*(np.array([each]) for each in (x_m, y_m, altitude_m)))
        )
        thickness = self._clouds.thickness_m((slice(row, row + 1), slice(column, column + 1)))
        zenith, paths = self._zenith_deg(row, column), self._paths
        cloud = paths.through_cloud(paths.heights_above(thickness, altitude_m), zenith)
        return SightPath(
            paths.band_mean(paths.air(altitude_m, zenith)),
            paths.air_emission(altitude_m, zenith).copy(),
            paths.band_mean(cloud),
        )

    def _add_pixel(
        self,
        pixels: ElementPixels,
        n: int,
        thickness_m: Sequence[Thickness],
        radiance: NDArray[np.float32],
        added: NDArray[np.float32],
        at: tuple[int, int],
    ) -> None:
        """Add the n-th pixel of an element, with clouds of this thickness at its points, at a place in the part."""
        if self._look_up is None:
            return
        plan, paths, altitude_m = self._plan, self._paths, pixels.altitude_m
        zenith = self._zenith_deg(int(pixels.rows[n]), int(pixels.columns[n]))
        heights = paths.heights_above(thickness_m, altitude_m)
        cloud = paths.through_cloud(heights, zenith)
        air = paths.air(altitude_m, zenith)
        reach = paths.band_mean(air * cloud, pixels.temperature_K)
        bands = slice(0, len(plan.bands)), *at
        before = radiance[bands].astype(np.float64)
        if pixels.intensity is not None:
            change = reach * pixels.intensity / self._area_m2(int(pixels.rows[n]), int(pixels.columns[n]))
        else:
            assert pixels.radiance is not None
            own = pixels.radiance if pixels.radiance.ndim == 1 else pixels.radiance[n]
            behind = before
            if np.any(heights):
                lower = [
                    np.zeros_like(each) if np.any(above) else each
                    for above, each in zip(heights, thickness_m, strict=True)
                ]
                behind = self._looked_up(lower, radiance.shape[0], at)
            alone = paths.band_mean(air, pixels.temperature_K)
            direct = np.divide(reach, alone, out=np.zeros_like(reach), where=alone > 0.0)
            change = reach * own + direct * (paths.air_emission(altitude_m, zenith) - behind)
        radiance[bands] = np.maximum(before + pixels.share[n] * change, 0.0)
        if added.size:
            added[bands] += radiance[bands] - before

    def _looked_up(self, thickness_m: Sequence[Thickness], channels: int, at: tuple[int, int]) -> Array:
        """Return the radiance (B,) of one pixel of the part with other clouds."""
        look_up, pixel = self._look_up, np.empty((channels, 1, 1), dtype=np.float32)
        assert look_up is not None
        if not isinstance(look_up, LookUp):
            look_up = look_up.of_part((slice(at[0], at[0] + 1), slice(at[1], at[1] + 1)))
        look_up.fill(pixel, thickness_m, self._plan.samples_per_pixel)
        return pixel[: len(self._plan.bands), 0, 0].astype(np.float64)

    def _area_m2(self, row: int, column: int) -> float:
        """Area of a pixel across the line of sight."""
        return self._plan.grid.pixel_size_m**2 * math.cos(math.radians(self._zenith_deg(row, column)))

    def _zenith_deg(self, row: int, column: int) -> float:
        """View zenith angle of a pixel, which may lie outside the image."""
        if self._views is None:
            return self._plan.view.zenith_deg
        grid = self._plan.grid
        place = (2.0 * column + 1.0 - grid.columns) / grid.columns, (2.0 * row + 1.0 - grid.rows) / grid.rows
        return self._views.at([place])[0].zenith_deg


def _points(corner: tuple[int, int], samples: int) -> Window:
    """Points of one pixel of a window."""
    row, column = (points_of(slice(each, each + 1), samples) for each in corner)
    return row, column
