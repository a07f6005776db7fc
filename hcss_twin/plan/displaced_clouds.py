"""Clouds beyond the image, which slant paths need, seen from the rows and columns of the image."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import cached_method
from hcss_twin.plan.hanging_levels import Level, Met
from hcss_twin.plan.point_shifts import PointShifts, gathered
from hcss_twin.plan.windows import Window, length, relative, strips_around
from hcss_twin.providers import CloudDeclaration, CloudGenerator

Shift = tuple[int, int] | PointShifts

Thickness = NDArray[np.float32]

SHARED = 0.1
"""Share of a window from which what is known of it is copied."""

NOWHERE: Window = slice(0, 0), slice(0, 0)


class DisplacedClouds:
    """A cloud generator that is addressed by the rows and columns of the image, and knows the clouds around it.

    All other attributes are delegated to the generator. The sky of clouds whose coverage is that of the image has no
    place of its own: it lies so that the image sees it, and displacements count from that of the line of sight.

    Parameters
    ----------
    generator : CloudGenerator
        Of a larger plane of which it can compute windows, or of the image, with ``thickness_around_m``.
    margin : (int, int)
        Rows and columns of the plane before and after those of the image.
    view_shift : (int, int) or PointShifts
        Displacement of the cloud seen from each point, within the margin of a larger plane.
    of_image : bool
        Whether the clouds are those that the image sees, made for its plane.
    levels : sequence of (Level, (int, int) or PointShifts)
        Of clouds whose tops vary, seen along slant lines of sight: slices of height from the highest down, and the
        displacement of what is seen there.
    thickness_range_m : (float, float)
        Thickness of the thinnest and of the thickest of these clouds.
    """

    def __init__(
        self,
        generator: CloudGenerator,
        margin: tuple[int, int],
        view_shift: Shift,
        of_image: bool = False,
        levels: Sequence[tuple[Level, Shift]] = (),
        thickness_range_m: tuple[float, float] = (0.0, math.inf),
    ) -> None:
        self._generator = generator
        self._margin = margin
        self._view_shift = view_shift
        self._origin = (0, 0)
        if of_image:
            self._origin = view_shift if isinstance(view_shift, tuple) else view_shift.middle
        self._of_image, self._levels, self._thickness_range_m = of_image, levels, thickness_range_m
        self._summary = cached_method(self._summary_at, 1)
        self._known: tuple[float, Window, NDArray[np.float32]] = math.nan, NOWHERE, np.empty((0, 0), np.float32)
        # The engine asks for the thickness of a window, and then for its tops.
        self._met = cached_method(self._met_in, 1)

    @property
    def declares(self) -> CloudDeclaration:
        """Declaration of the generator."""
        return self._generator.declares

    def __getattr__(self, name: str) -> Any:
        # attributes of copies and unpickled objects are looked up before the generator is set
        if name.startswith("__") or name == "_generator":
            raise AttributeError(name)
        attribute = getattr(self._generator, name)
        # looked up here, so that hasattr() reflects the generator
        own = {
            "thickness_around_m": self._thickness_around_m,
            "thickness_in_frame_m": self._thickness_around_m,
            "cloud_top_m": self._cloud_top_m,
            "cloud_depth_m": self._cloud_depth_m,
            "height_shares": self._height_shares,
        }
        return own.get(name, attribute)

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the thickness (y, x) seen from a window of the image."""
        return self._seen_m(time_s, rows, columns, self._generator.thickness_m)

    def _seen_m(
        self, time_s: float, rows: slice, columns: slice, of_image: Callable[..., NDArray[np.float32]]
    ) -> NDArray[np.float32]:
        """Return the thickness (y, x) seen from a window; ``of_image`` gives that of clouds that the image sees."""
        if self._levels:
            return self._met(time_s, rows.start, rows.stop, columns.start, columns.stop).thickness_m.copy()
        if isinstance(self._view_shift, tuple):
            if self._of_image:
                return of_image(time_s, rows, columns)
            return self.displaced_m(time_s, rows, columns, self._view_shift)
        shifts, wide, first = self._around(rows, columns, self._view_shift)
        return gathered(self.displaced_m(time_s, *wide, first), shifts, first)

    @staticmethod
    def _around(rows: slice, columns: slice, view_shift: PointShifts) -> tuple[NDArray[Any], Window, tuple[int, int]]:
        """Return the displacements of the points of a window, and the window that they need with its own."""
        shifts = view_shift.at(rows, columns)
        (down, right), (far_down, far_right) = shifts.min(axis=(1, 2)).tolist(), shifts.max(axis=(1, 2)).tolist()
        wide = slice(rows.start, rows.stop + far_down - down), slice(columns.start, columns.stop + far_right - right)
        return shifts, wide, (down, right)

    def _thickness_around_m(self, time_s: float, rows: slice, columns: slice, summary: Any) -> NDArray[np.float32]:
        """Return the thickness (y, x) seen from a window that may reach outside the image."""

        def around(*window: Any) -> NDArray[np.float32]:
            sky: NDArray[np.float32] = self._generator.thickness_around_m(*window, summary)  # type: ignore[attr-defined]
            return sky

        return self._seen_m(time_s, rows, columns, around)

    def _cloud_top_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the altitude of the cloud top (y, x) that is seen from a window in or around the image."""
        if self._levels:
            return self._met(time_s, rows.start, rows.stop, columns.start, columns.stop).top_m.copy()
        assert isinstance(self._view_shift, tuple)
        return self.displaced_top_m(time_s, rows, columns, self._view_shift)

    def _cloud_depth_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the height (y, x) of the clouds of a window, for rays that cross them."""
        assert isinstance(self._view_shift, tuple)
        return self.displaced_ends_m(time_s, rows, columns, self._view_shift)[1]

    def _height_shares(
        self, time_s: float, rows: slice, columns: slice, thickness_m: NDArray[np.float32], edges_m: Array
    ) -> NDArray[np.float32]:
        """Return the shares of height (Z, y, x) of the columns that are seen from a window in or around the image."""
        shares: Any = self._generator.height_shares  # type: ignore[attr-defined]
        if isinstance(self._view_shift, tuple):
            of_window: NDArray[np.float32] = shares(
                time_s, *self._moved(rows, columns, self._view_shift), thickness_m, edges_m
            )
            return of_window
        shifts, wide, first = self._around(rows, columns, self._view_shift)
        around = shares(time_s, *self._moved(*wide, first), self.displaced_m(time_s, *wide, first), edges_m)
        return np.stack([gathered(level, shifts, first) for level in around])

    def _met_in(self, time_s: float, top: int, bottom: int, left: int, right: int) -> Met:
        """Return the clouds that lines of sight of a window cross."""
        rows, columns = slice(top, bottom), slice(left, right)
        tops_m = self._generator.cloud_top_range_m  # type: ignore[attr-defined]
        met = Met((bottom - top, right - left), self._thickness_range_m, tops_m)
        of_levels = [
            (level, np.reshape(shift, (2, 1, 1)) if isinstance(shift, tuple) else shift.at(rows, columns))
            for level, shift in self._levels
        ]
        near = np.min([shifts.min(axis=(1, 2)) for _, shifts in of_levels], axis=0)
        far = np.max([shifts.max(axis=(1, 2)) for _, shifts in of_levels], axis=0)
        first = int(near[0]), int(near[1])
        wide = slice(top, bottom + int(far[0]) - first[0]), slice(left, right + int(far[1]) - first[1])
        clouds = self.displaced_m(time_s, *wide, first), *self.displaced_ends_m(time_s, *wide, first)
        y, x = np.arange(bottom - top)[:, None], np.arange(right - left)[None, :]
        for level, shifts in of_levels:
            met.look(*clouds, (y + shifts[0] - first[0], x + shifts[1] - first[1]), level)
        return met

    def displaced_m(self, time_s: float, rows: slice, columns: slice, shift: tuple[int, int]) -> NDArray[np.float32]:
        """Return the thickness (y, x) displaced by ``shift`` rows north and columns east of a window of the image.

        Raises
        ------
        ValueError
            If the displacement exceeds the margin.
        """
        moved = self._moved(rows, columns, shift)
        before_s, before, known = self._known
        shared = _overlap(moved, before)
        if before_s != time_s or _points(shared) < max(1.0, SHARED * _points(moved)):
            sky = self._sky_m(time_s, moved)
        else:
            # The sun sees most of the clouds that the sensor sees: the rest is computed.
            sky = np.empty([length(pixels) for pixels in moved], np.float32)
            sky[relative(shared, moved)] = known[relative(shared, before)]
            for strip in strips_around(shared, moved):
                sky[relative(strip, moved)] = self._sky_m(time_s, strip)
        if self._generator.declares.tileable:
            self._known = time_s, moved, sky
        return sky

    def _sky_m(self, time_s: float, window: Window) -> NDArray[np.float32]:
        """Return the thickness (y, x) in a window of the generator's plane, beyond which its sky may continue."""
        around = getattr(self._generator, "thickness_around_m", None)
        if around is not None:
            sky: NDArray[np.float32] = around(time_s, *window, self._summary(time_s))
            return sky
        return self._generator.thickness_m(time_s, *window)

    def displaced_ends_m(
        self, time_s: float, rows: slice, columns: slice, shift: tuple[int, int]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return the altitude of tops that vary, and the height over which their clouds are spread."""
        top = self.displaced_top_m(time_s, rows, columns, shift)
        if not hasattr(self._generator, "cloud_depth_m"):
            return top, self.displaced_m(time_s, rows, columns, shift)
        return top, self._generator.cloud_depth_m(time_s, *self._moved(rows, columns, shift))

    def displaced_top_m(
        self, time_s: float, rows: slice, columns: slice, shift: tuple[int, int]
    ) -> NDArray[np.float32]:
        """Return the altitude of tops that vary, as :meth:`displaced_m`."""
        tops: NDArray[np.float32] = self._generator.cloud_top_m(  # type: ignore[attr-defined]
            time_s, *self._moved(rows, columns, shift)
        )
        return tops

    def _moved(self, rows: slice, columns: slice, shift: tuple[int, int]) -> tuple[slice, slice]:
        """Return the window of the generator's plane that is displaced from a window of the image."""
        if not self._of_image and any(abs(by) > room for by, room in zip(shift, self._margin, strict=True)):
            raise ValueError(f"shift: {shift} given, allowed: up to {self._margin}")
        y, x = (
            slice(window.start + room + by - seen, window.stop + room + by - seen)
            for window, room, by, seen in zip((rows, columns), self._margin, shift, self._origin, strict=True)
        )
        return y, x

    def _summary_at(self, time_s: float) -> Any:
        """Return what the frame tells of the clouds around it."""
        if self._generator.declares.tileable:
            return None
        return self._generator.frame_summary(time_s)  # type: ignore[attr-defined]


def upright(
    generator: Any, time_s: float, rows: slice, columns: slice, summary: Any = None
) -> tuple[Thickness, Thickness, Thickness]:
    """Return thickness, top, and height (y, x) of clouds whose tops vary, above their points, whatever views see."""
    if isinstance(generator, DisplacedClouds):
        where = time_s, rows, columns, (0, 0)
        ends: tuple[Thickness, Thickness] = generator.displaced_ends_m(*where)
        return generator.displaced_m(*where), *ends
    thickness: Thickness = generator.thickness_around_m(time_s, rows, columns, summary)
    depth = generator.cloud_depth_m(time_s, rows, columns) if hasattr(generator, "cloud_depth_m") else thickness
    return thickness, generator.cloud_top_m(time_s, rows, columns), depth


def _overlap(window: Window, other: Window) -> Window:
    """Return the part of a window that is in another one, of length 0 or less if there is none."""
    rows, columns = (
        slice(max(one.start, two.start), min(one.stop, two.stop)) for one, two in zip(window, other, strict=True)
    )
    return rows, columns


def _points(window: Window) -> int:
    return max(0, length(window[0])) * max(0, length(window[1]))
