"""Elements of a scene: attenuation, addition to the radiance of the frames, and what they hide.

The radiance of a pixel with a body of radiance L, share c and altitude z becomes

    L_pixel + c t [T L + A - L_behind]

with the direct transmission t of the clouds above z, transmittance T and emission A of the air above z, and the
radiance L_behind of what it hides without these clouds, which is L_pixel if there are none. Light that clouds scatter
into the line of sight remains. A plume of intensity I adds t T I / (a cos(view zenith)), with the area a of the pixel
on the ground, and hides nothing.

Small elements have the air and clouds of their own place, and the column of that place behind them; a body larger than
a pixel has those of its pieces. They hide parts of each other as squares; extended ones, which only say their share of
each pixel, hide this share of all below them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import cached_method
from hcss_twin.cube.variables import (
    ELEMENT,
    ELEMENT_PLACE,
    ELEMENT_POINT_RADIANCE,
    ELEMENT_RADIANCE,
    ELEMENT_RATE,
    ELEMENT_SHARE,
    ELEMENT_TRANSMITTANCE,
)
from hcss_twin.engine.clouds import FrameClouds
from hcss_twin.engine.stages.element_paths import ElementPaths
from hcss_twin.engine.stages.placed_points import (
    LARGEST_DRAWN,
    Piece,
    Place,
    PlacedPoint,
    Share,
    WindowPieces,
    higher_than,
    merged,
    placed_point,
    point_of,
)
from hcss_twin.engine.stages.stage import WITH_ELEMENTS, Frame, FramePart, PartWindow, Stage
from hcss_twin.engine.tables.point_axis import PointAxis
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, length
from hcss_twin.providers import ElementPixels, ElementPoint, SightPath, Sun

if TYPE_CHECKING:
    from hcss_twin.engine.tables.frame_look_up import FrameLookUp

Thickness = NDArray[np.float32]

_PLACES = 64
"""Places in memory, if what is before elements differs from place to place."""

_SEED_KEY = 2**18
"""Distinguishes the seeds of elements from those of clouds, waves and the certificate."""


class ElementStage(Stage):
    """Elements of a scene.

    Parameters
    ----------
    effects : sequence of PointAxis
        Effects of points, behind which elements lie, too.
    """

    title = "elements"
    reads = ("truth", "columns", "light between columns", "texture", "sunlight", "waves")
    writes = ("elements",)

    def __init__(self, plan: Plan, effects: Sequence[PointAxis[Any]] = ()) -> None:
        self._plan, self._effects = plan, effects
        self._paths = cached_method(self._paths_in, _PLACES)

    def begin(self, part: FramePart) -> None:
        """Make room for what elements add."""
        self._of_part = self._elements(part)
        part.drawn = self._of_part.drawn
        wanted = {spec.name for spec in self._plan.computed} & {ELEMENT_RADIANCE, ELEMENT_POINT_RADIANCE}
        shape = len(self._plan.bands), *part.radiance.shape[1:]
        part.added = {name: np.zeros(shape, dtype=np.float32) for name in wanted}

    def apply(self, part: FramePart, window: PartWindow) -> None:
        """Add the elements of a window."""
        before = part.shown[:, *window.inside].copy() if part.shown is not part.radiance else None
        added = self._of_part.add(window.window, window.thickness_m, part.shown, part.added, part.truth, window.inside)
        if before is not None:  # light between columns, which elements are added to, remains the difference of both
            part.radiance[:, *window.inside] += part.shown[:, *window.inside] - before
        window.left_out[WITH_ELEMENTS] = added

    def finish(self, part: FramePart, frame: Frame) -> None:
        """Add what elements added to the radiance, of those variables that are wanted."""
        frame |= part.added

    def windows(self, part: FramePart, area: Window) -> list[Window]:
        """Return windows of an area of the image that hold all small elements that sensors draw."""
        return self._elements(part).windows(area)

    def _elements(self, part: FramePart) -> InstantElements:
        clouds = seen = part.clouds
        if self._plan.rays.instants > 1:  # what small elements have before them is that of the middle
            clouds = FrameClouds(self._plan, part.time_s, rays=self._plan.rays.still())
        return InstantElements(self._plan, self._paths_at, part.index, part.time_s, clouds, part.look_up, seen)

    def _paths_at(self, time_s: float, row: int, column: int) -> ElementPaths:
        """Return the paths to a pixel, in the state of the point in its middle."""
        points = self._plan.samples_per_pixel**2
        no_cloud = np.zeros((points, len(self._plan.layers)))
        return self._paths(*(effect.of_pixel(time_s, row, column, no_cloud)[points // 2] for effect in self._effects))

    def _paths_in(self, *states: Any) -> ElementPaths:
        plan = self._plan
        for effect, state in zip(self._effects, states, strict=True):
            plan = effect.plan_in(plan, state)
        return ElementPaths(plan)


class InstantElements:
    """Elements of a part of one frame, and the scene around them (:class:`hcss_twin.providers.ElementScene`).

    Attributes
    ----------
    drawn : dict of (int, int) to list of Piece
        What small elements add to each pixel of the windows so far, which sensors draw.
    """

    sun: Sun | None
    random: np.random.Generator

    def __init__(
        self,
        plan: Plan,
        paths_at: Callable[[float, int, int], ElementPaths],
        index: int,
        time_s: float,
        clouds: FrameClouds,
        look_up: FrameLookUp | None,
        seen: FrameClouds,
    ) -> None:
        self._plan, self._paths_at = plan, paths_at
        self._clouds, self._look_up, self._seen = clouds, look_up, seen
        self._time_s, self._number = time_s, plan.scenario.frames.first + index
        self.drawn: dict[tuple[int, int], list[Piece]] = {}
        self._points_of_places: dict[Place, list[Thickness]] = {}

    def add(
        self,
        window: Window,
        thickness_m: Sequence[Thickness],
        radiance: NDArray[np.float32],
        added: Mapping[str, NDArray[np.float32]],
        truth: Mapping[str, NDArray[Any]],
        in_part: Window,
    ) -> NDArray[np.bool_]:
        """Add the elements to a window.

        Parameters
        ----------
        window, in_part : (slice, slice)
            Rows and columns of the window in the image, and in the part.
        thickness_m : sequence of ndarray (window rows x samples, window columns x samples)
            Of each layer.
        radiance : ndarray of float32 (C, y, x)
            Radiance of the part; its first B channels are the totals of the bands.
        added : mapping of str to ndarray of float32 (B, y, x)
            Those of ``element_radiance`` and ``element_point_radiance`` that are wanted; get what elements add.
        truth : mapping of str to ndarray (..., y, x)
            Truth variables of the part.

        Returns
        -------
        ndarray of bool (window rows, window columns)
            Pixels with an element.
        """
        parts = self._given(window)
        points = [element for _, element in parts if isinstance(element, PlacedPoint)]
        present = np.zeros((length(window[0]), length(window[1])), dtype=np.bool_)
        small = WindowPieces(window, in_part, thickness_m, radiance)
        for number, element in parts:
            if isinstance(element, PlacedPoint):
                higher, samples = higher_than(element, points), self._plan.samples_per_pixel
                for pixel, pieces in element.pieces(window, higher, samples).items():
                    element_truth = self._add_point(element, pixel, pieces, small)
                    present[pixel[0] - window[0].start, pixel[1] - window[1].start] = True
                    _tell(truth, element_truth, *small.at(pixel))
                continue
            element_truth = {ELEMENT: number, ELEMENT_SHARE: element.share}
            element_truth |= {f"{ELEMENT}_{name}": values for name, values in element.truth.items()}
            y, x = element.rows - window[0].start, element.columns - window[1].start
            present[y, x] = True
            _tell(truth, element_truth, y + in_part[0].start, x + in_part[1].start)
            for n, pixel in enumerate(zip(element.rows.tolist(), element.columns.tolist(), strict=True)):
                self._add_pixel(element, n, pixel, small, added)
        self._draw(small, added, truth)
        return present

    def windows(self, area: Window) -> list[Window]:
        """Return windows of an area of the image that hold all small elements that sensors draw."""
        placed = (element for _, element in self._given(area) if isinstance(element, PlacedPoint))
        windows = [element.window(area) for element in placed if element.side <= LARGEST_DRAWN]
        return [window for window in windows if length(window[0]) > 0 and length(window[1]) > 0]

    def _given(self, window: Window) -> list[tuple[int, ElementPixels | PlacedPoint]]:
        """Return what the providers give for a window, with the numbers of their sections, from the lowest on."""
        plan, time_s, parts = self._plan, self._time_s, list[tuple[float, int, ElementPixels | PlacedPoint]]()
        for number, provider in enumerate(plan.assembly.elements, start=1):
            seed = np.random.SeedSequence(plan.scenario.seed, spawn_key=(_SEED_KEY, number, self._number))
            self.sun, self.random = plan.sun_at(time_s), np.random.Generator(np.random.PCG64(seed))
            for element in provider.pixels(time_s, *window, self):
                placed = placed_point(plan, number, element, time_s) if isinstance(element, ElementPoint) else element
                if placed is not None:
                    parts.append((element.altitude_m, number, placed))
        parts.sort(key=lambda part: part[0])
        return [(number, element) for _, number, element in parts]

    def project(self, x_m: Array, y_m: Array, altitude_m: Array) -> tuple[Array, Array]:
        """Return where points appear in the image, as :meth:`hcss_twin.providers.ElementScene.project`."""
        return self._plan.rays.project(x_m, y_m, altitude_m, self._time_s)

    def path(self, x_m: float, y_m: float, altitude_m: float) -> SightPath:
        """Return what is between a point and the sensor, as :meth:`hcss_twin.providers.ElementScene.path`."""
        at = self.project(*(np.array([coordinate]) for coordinate in (x_m, y_m, altitude_m)))
        place = float(at[0][0]), float(at[1][0])
        paths = self._paths(place)
        zenith = self._zenith_of(place)
        above = paths.heights_above(self._own_points(place), altitude_m, self._own_tops(place))
        cloud = paths.through_cloud(above, zenith)
        return SightPath(
            paths.band_mean(paths.air(altitude_m, zenith)),
            paths.air_emission(altitude_m, zenith).copy(),
            paths.band_mean(cloud),
        )

    def _own_points(self, place: Place, small: WindowPieces | None = None) -> list[Thickness]:
        """Return the thickness (1, 1) of each layer at the point of the scene that a place in the image is in.

        A window that holds the place knows it, if the cube shows an instant.
        """
        if place not in self._points_of_places:
            pixel, (i, j) = self._known(place)
            if small is not None and small.holds(pixel) and self._clouds is self._seen:
                thickness = small.points_of(pixel, self._plan.samples_per_pixel)
            else:
                thickness = self._clouds.thickness_m(_of_pixel(pixel))
            self._points_of_places[place] = [layer[i : i + 1, j : j + 1] for layer in thickness]
        return self._points_of_places[place]

    def _own_tops(self, place: Place) -> list[Thickness | None]:
        """Return the tops (1, 1) there of layers whose tops vary, None for others."""
        pixel, (i, j) = self._known(place)
        tops = self._tops_of(self._clouds, pixel)
        return [None if layer is None else layer[i : i + 1, j : j + 1] for layer in tops]

    def _known(self, place: Place) -> tuple[tuple[int, int], tuple[int, int]]:
        """Return the pixel of a place in the image, and the point of it; beyond the known clouds, the nearest one."""
        plan, (row, column) = self._plan, place
        if plan.is_grid and not all(hasattr(generator, "thickness_around_m") for generator in plan.assembly.generators):
            row, column = min(max(row, 0.0), plan.grid.rows - 1e-6), min(max(column, 0.0), plan.grid.columns - 1e-6)
        pixel = math.floor(row), math.floor(column)
        return pixel, point_of((row, column), pixel, plan.samples_per_pixel)

    def _tops_of(self, clouds: FrameClouds, pixel: tuple[int, int]) -> list[Thickness | None]:
        """Return the tops at the points of a pixel, as :meth:`_own_tops`."""
        varying = self._plan.assembly.hanging_layers
        return [
            clouds.tops_m(layer, _of_pixel(pixel)) if layer in varying else None
            for layer in range(len(self._plan.layers))
        ]

    def _add_point(
        self, placed: PlacedPoint, pixel: tuple[int, int], pieces: Sequence[Share], small: WindowPieces
    ) -> dict[str, Any]:
        """Add the pieces of a small element in one pixel, and return their truth."""
        point, covers = placed.point, placed.area or 1.0
        element_truth: dict[str, Any] = {
            ELEMENT: placed.number,
            ELEMENT_SHARE: covers * sum(piece.share for piece in pieces),
        }
        element_truth |= {f"{ELEMENT}_{name}": value for name, value in point.truth.items()}
        changes = dict[tuple[float, ...], Array]()
        of_place = [] if placed.is_resolved else self._own_points(placed.place, small)
        target = small.large if placed.side > LARGEST_DRAWN else small.drawn
        samples = self._plan.samples_per_pixel
        points, tops = small.points_of(pixel, samples), self._tops_of(self._seen, pixel)
        for piece in pieces:
            i, j = point_of((piece.row, piece.column), pixel, samples)
            behind = [layer[i : i + 1, j : j + 1] for layer in points]
            own = [None if layer is None else layer[i : i + 1, j : j + 1] for layer in tops]
            key = tuple(float(layer[0, 0]) for layer in (*behind, *own) if layer is not None)
            if key not in changes:
                place, above, highest = (piece.row, piece.column), behind, own
                if not placed.is_resolved:
                    place, above, highest = placed.place, of_place, self._own_tops(placed.place)
                heights = self._paths(place).heights_above(above, point.altitude_m, highest)
                element_truth[ELEMENT_TRANSMITTANCE], changes[key] = self._change(
                    point, place, pixel, heights, behind, small
                )
            target.setdefault(pixel, []).append((placed, piece, changes[key] * covers * piece.share))
        return element_truth

    def _change(
        self,
        point: ElementPoint,
        place: Place,
        pixel: tuple[int, int],
        heights: Array,
        behind: Sequence[Thickness],
        small: WindowPieces,
    ) -> tuple[Array, Array]:
        """Return the transmittance (B,) before a small element, and what it adds (B,) to a pixel that it fills.

        Parameters
        ----------
        heights : ndarray (L, 1)
            Of the clouds above it, which weaken it.
        behind : sequence of ndarray (1, 1)
            Thickness at the point that it hides.
        """
        paths, altitude_m, zenith = self._paths(place), point.altitude_m, self._zenith_of(place)
        cloud, air = paths.through_cloud(heights, zenith), paths.air(altitude_m, zenith)
        reach = paths.band_mean(air * cloud, point.temperature_K)
        if self._look_up is None:
            return reach, np.zeros_like(reach)
        if point.intensity is not None:
            return reach, reach * point.intensity / self._area_m2(*place, point)
        assert point.radiance is not None
        alone = paths.band_mean(air, point.temperature_K)
        direct = np.divide(reach, alone, out=np.zeros_like(reach), where=alone > 0.0)
        reaching = reach * point.radiance
        if point.reflectance:
            reaching = reaching + point.reflectance * paths.reflected(
                altitude_m, zenith, self._plan.sun_at(self._time_s), heights
            )
        hidden = self._behind(pixel, heights, behind, small)
        return reach, reaching + direct * (paths.air_emission(altitude_m, zenith) - hidden)

    def _behind(
        self, pixel: tuple[int, int], heights: Array, thickness_m: Sequence[Thickness], small: WindowPieces
    ) -> Array:
        """Return the radiance (B,) of the column that a body hides in a pixel, without the layers above the body."""
        y, x = small.at(pixel)
        channels, all_points = small.radiance.shape[0], small.points_of(pixel, self._plan.samples_per_pixel)
        whole = [
            np.full(point.shape, thickness[0, 0]) for point, thickness in zip(all_points, thickness_m, strict=True)
        ]
        if np.any(heights):
            return self._looked_up(_below(whole, heights), channels, (y, x))
        before = small.radiance[: len(self._plan.bands), y, x].astype(np.float64)
        if all(np.array_equal(one, other) for one, other in zip(whole, all_points, strict=True)):
            return before
        # What waves, shadows and lower elements change stays.
        hidden, mean = (self._looked_up(clouds, channels, (y, x)) for clouds in (whole, all_points))
        return np.maximum(before + hidden - mean, 0.0)

    def _draw(
        self, small: WindowPieces, added: Mapping[str, NDArray[np.float32]], truth: Mapping[str, NDArray[Any]]
    ) -> None:
        """Add the small elements of a window to its pixels, which have all else by now."""
        bands = len(self._plan.bands)
        for pixel in {**small.large, **small.drawn}:
            y, x = small.at(pixel)
            pieces = small.drawn.get(pixel, [])
            behind = small.radiance[:bands, y, x].copy()
            if self._look_up is not None:
                for _, _, change in small.large.get(pixel, []):
                    behind = np.maximum(behind + change, 0.0).astype(np.float32)
                total = behind.astype(np.float64)
                for _, _, change in pieces:
                    total = total + change
                before, after = small.radiance[:bands, y, x].astype(np.float64), np.maximum(total, 0.0)
                small.radiance[:bands, y, x] = after
                for name, since in ((ELEMENT_RADIANCE, before), (ELEMENT_POINT_RADIANCE, behind.astype(np.float64))):
                    if name in added:
                        added[name][:, y, x] += small.radiance[:bands, y, x] - since
            if not pieces:
                continue
            found = [Piece(at.row, at.column, of.rate, change, pixel, behind) for of, at, change in pieces]
            self.drawn.setdefault(pixel, []).extend(found)
            weights = np.array([np.sum(np.abs(piece.radiance)) for piece in found])
            if not np.any(weights):
                weights = np.array([at.share for _, at, _ in pieces])
            rates = weights @ np.array([piece.rate for piece in found]) / weights.sum()
            motion = dict(zip((*ELEMENT_PLACE, *ELEMENT_RATE), (*merged(found, weights), *rates), strict=True))
            for name in motion.keys() & truth.keys():
                truth[name][y, x] = motion[name]

    def _add_pixel(
        self,
        pixels: ElementPixels,
        n: int,
        pixel: tuple[int, int],
        small: WindowPieces,
        added: Mapping[str, NDArray[np.float32]],
    ) -> None:
        """Add the n-th pixel of an extended element."""
        if self._look_up is None:
            return
        plan, paths, altitude_m = self._plan, self._paths(pixel), pixels.altitude_m
        radiance, at = small.radiance, small.at(pixel)
        thickness_m = small.points_of(pixel, plan.samples_per_pixel)
        zenith = self._zenith_deg(*pixel)
        heights = paths.heights_above(thickness_m, altitude_m, self._tops_of(self._seen, pixel))
        cloud = paths.through_cloud(heights, zenith)
        air = paths.air(altitude_m, zenith)
        reach = paths.band_mean(air * cloud, pixels.temperature_K)
        bands = slice(0, len(plan.bands)), *at
        before = radiance[bands].astype(np.float64)
        if pixels.intensity is not None:
            change = reach * pixels.intensity / self._area_m2(pixel[0] + 0.5, pixel[1] + 0.5)
        else:
            assert pixels.radiance is not None
            element_radiance = pixels.radiance if pixels.radiance.ndim == 1 else pixels.radiance[n]
            behind = before
            if np.any(heights):
                behind = self._looked_up(_below(thickness_m, heights), radiance.shape[0], at)
            alone = paths.band_mean(air, pixels.temperature_K)
            direct = np.divide(reach, alone, out=np.zeros_like(reach), where=alone > 0.0)
            change = reach * element_radiance + direct * (paths.air_emission(altitude_m, zenith) - behind)
            for found in (small.large, small.drawn):
                if pixel in found:
                    found[pixel] = [
                        (of, piece, (1.0 - pixels.share[n] * direct) * light) for of, piece, light in found[pixel]
                    ]
        radiance[bands] = np.maximum(before + pixels.share[n] * change, 0.0)
        if ELEMENT_RADIANCE in added:
            added[ELEMENT_RADIANCE][:, *at] += radiance[bands] - before

    def _looked_up(self, thickness_m: Sequence[Thickness], channels: int, at: tuple[int, int]) -> Array:
        """Return the radiance (B,) of one pixel of the part with other clouds."""
        look_up, pixel = self._look_up, np.empty((channels, 1, 1), dtype=np.float32)
        assert look_up is not None
        of_pixel = look_up.of_part((slice(at[0], at[0] + 1), slice(at[1], at[1] + 1)))
        of_pixel.fill(pixel, thickness_m, self._plan.samples_per_pixel)
        return pixel[: len(self._plan.bands), 0, 0].astype(np.float64)

    def _area_m2(self, row: float, column: float, point: ElementPoint | None = None) -> float:
        """Area of a pixel across the line of sight, at the distance of a point or else of the ground."""
        at_m = None if point is None else (point.x_m, point.y_m, point.altitude_m)
        return self._plan.rays.pixel_area_m2(row, column, self._time_s, at_m)

    def _paths(self, place: Place) -> ElementPaths:
        """Return the paths of the pixel that holds a place."""
        return self._paths_at(self._time_s, math.floor(place[0]), math.floor(place[1]))

    def _zenith_of(self, place: Place) -> float:
        """View zenith angle of the pixel that holds a place."""
        return self._zenith_deg(math.floor(place[0]), math.floor(place[1]))

    def _zenith_deg(self, row: int, column: int) -> float:
        """View zenith angle of a pixel, which may lie outside the image."""
        (view,) = self._plan.views_of_pixels([row], [column], self._time_s)
        return view.zenith_deg


def _of_pixel(pixel: tuple[int, int]) -> Window:
    row, column = pixel
    return slice(row, row + 1), slice(column, column + 1)


def _below(thickness_m: Sequence[Thickness], heights: Array) -> list[Thickness]:
    """Return the clouds of the layers that have none above the altitude of these heights."""
    return [
        np.zeros_like(thickness) if np.any(above) else thickness
        for above, thickness in zip(heights, thickness_m, strict=True)
    ]


def _tell(truth: Mapping[str, NDArray[Any]], element_truth: Mapping[str, Any], y: Any, x: Any) -> None:
    """Write the truth of the highest element so far in pixels of a part."""
    for name, array in truth.items():
        if name.startswith(ELEMENT):
            array[..., y, x] = element_truth.get(name, np.nan)
