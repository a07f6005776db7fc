"""Rays: which points of the scene, and which views, belong to the pixels of an image.

Clouds, surfaces and elements are defined in the plane of the scene, ``plan.grid``. The cube has the rows and columns of
``plan.rays``, which say where each pixel looks: at the same plane (:class:`GridRays`, the default), or through a camera
in orbit or another instrument of a plugin, which is one class derived from :class:`Rays`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ProviderError
from hcss_twin.cube.geometry import pixel_centres_m
from hcss_twin.cube.header import ImageLayout
from hcss_twin.cube.variables import VariableSpec
from hcss_twin.physics.geodesy import to_geographic
from hcss_twin.plan.air_over_field import Climate
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.combinations import Excluded
from hcss_twin.plan.directions import Directions, Views
from hcss_twin.plan.windows import Window, length, pixel_sums, points_of
from hcss_twin.providers import Grid, View
from hcss_twin.scenario.scenario import Scenario

__all__ = ["Rays"]

Range: TypeAlias = tuple[float, float]


class Rays(ABC):
    """Which points of the scene, and which views, belong to the pixels of an image.

    Attributes
    ----------
    image : Grid
        Rows, columns, and typical size of a pixel on the ground.
    samples_per_pixel : int
        Points along each side of a pixel, which is their mean.
    view : View
        Typical direction to the sensor.
    directions : Directions or None
        Rectangle of all directions to the sensor, between whose edges tables are made; None if the plan finds out
        whether the view varies over a grid on the ground, and then ``views_of_pixels`` has to be given, too.
    climate : Climate or None
        Air and sea of places; None for those of the scenario.
    notes : tuple of str
        For the plan.
    filled_in : tuple of (str, str, str)
        Keys that the scenario omits, with the values that are used instead, and why.
    integration_s : float
        Time during which a frame sees the scene.
    instants : int
        Instants of that time which the points of a pixel stand for.
    may_miss_ground : bool
        Whether some pixels may not see the ground, so that they are not computed.
    NOWHERE : float
        Row and column of what is hidden.
    """

    NOWHERE: ClassVar[float] = -1e9

    image: Grid
    samples_per_pixel: int
    view: View
    directions: Directions | None
    climate: Climate | None = None
    notes: tuple[str, ...] = ()
    filled_in: tuple[tuple[str, str, str], ...] = ()
    integration_s: float = 0.0
    instants: int = 1
    may_miss_ground: bool = False

    @abstractmethod
    def points_m(self, window: Window, time_s: float, height_m: float) -> tuple[Array, Array]:
        """Return where the lines of sight of a window meet a height, in the plane of the scene.

        Parameters
        ----------
        window : (slice, slice)
            Rows and columns of the image, or around it.
        time_s : float
            Time of the frame after the scenario's start.
        height_m : float
            Above the sea.

        Returns
        -------
        x_m, y_m : ndarray (rows x samples, columns x samples)
            Eastward and northward from the centre of the scene; NaN where a line of sight misses.
        """

    @abstractmethod
    def positions(self, window: Window, time_s: float) -> tuple[Array, Array]:
        """Return the positions (rows, columns) of the pixels of a window in ``directions``, -1 to 1 along x and y.

        NaN where a pixel does not see the ground.
        """

    def views_of_pixels(self, rows: Sequence[int], columns: Sequence[int], time_s: float) -> list[View]:
        """Return the exact view of some pixels, for the certificate; by default those of their positions."""
        assert self.directions is not None
        windows = ((slice(row, row + 1), slice(column, column + 1)) for row, column in zip(rows, columns, strict=True))
        places = (self.positions(window, time_s) for window in windows)
        return self.directions.at((float(x[0, 0]), float(y[0, 0])) for x, y in places)

    def bounds(self, time_s: float) -> tuple[Range, Range] | None:
        """Return what part of ``directions`` along x and y a frame sees, in which fewer tables do; None: any."""
        return None

    def reach_m(self, *times_s: float) -> tuple[float, float] | None:
        """Return how far the corners of some frames are from the centre of the scene along x and y; None: unknown."""
        ends = (slice(row, row + 1) for row in (0, self.image.rows - 1))
        corners = [(row, slice(at, at + 1)) for row in ends for at in (0, self.image.columns - 1)]
        seen = [self.points_m(corner, time_s, 0.0) for time_s in times_s for corner in corners]
        x_m, y_m = (np.abs(np.concatenate([np.ravel(part) for part in axis])) for axis in zip(*seen, strict=True))
        return None if np.any(np.isnan(x_m)) else (float(x_m.max()), float(y_m.max()))

    def frame_key(self, time_s: float) -> Hashable:
        """Return what tells the rays of a frame from those of others; by default its time, which decides over them."""
        return time_s

    def still(self) -> Rays:
        """Return the same rays at the middle of the integration time alone."""
        return self

    def unseen(self, window: Window, time_s: float) -> NDArray[np.bool_] | None:
        """Return a mask (rows, columns) of the pixels that do not see the ground; None if all do."""
        return None

    def project(
        self, x_m: Array, y_m: Array, altitude_m: Array, time_s: float, later_s: float = 0.0
    ) -> tuple[Array, Array]:
        """Return row and column (N,) in which points of the scene (N,) appear; ``NOWHERE`` where they are hidden.

        Pixel n extends from n to n + 1. The image is that of a time ``later_s`` after that of the frame. Scenes with
        elements need it.
        """
        raise ProviderError(f"{type(self).__name__}: it does not say where elements appear; allowed: no [[elements]]")

    def pixel_area_m2(
        self, row: float, column: float, time_s: float, point_m: tuple[float, float, float] | None = None
    ) -> float:
        """Return the area of a pixel across its line of sight, at the distance of a point or else of the ground.

        Scenes with elements need it.
        """
        raise ProviderError(f"{type(self).__name__}: pixels have no area; allowed: no [[elements]]")

    def locations_deg(self, window: Window, time_s: float, scenario: Scenario) -> tuple[Array, Array]:
        """Return latitude and longitude (rows, columns) of the pixels of a window, or any where they see no ground.

        By default it is that of the middle of their points.
        """
        points_m, samples = self.points_m(window, time_s, 0.0), self.samples_per_pixel
        x_m, y_m = (np.nan_to_num(pixel_sums(of_points, samples) / samples**2) for of_points in points_m)
        return to_geographic(x_m, y_m, scenario.place.latitude, scenario.place.longitude)

    def angles_deg(self, window: Window, time_s: float) -> tuple[Array, Array]:
        """Return zenith and azimuth (clockwise from north) of the sensor at the pixels of a window, as locations.

        Scenes with derived variables may need it.
        """
        raise ProviderError(f"{type(self).__name__}: pixels have no angles; allowed: no [[output.derived]] of them")

    def variables(self, requested: tuple[VariableSpec, ...]) -> tuple[VariableSpec, ...]:
        """Return the variables of the cube: those that are requested, and coordinates of pixels."""
        kept = tuple(spec for spec in requested if spec.kind != "geometry")
        if not self.may_miss_ground:
            return kept
        return tuple(
            replace(spec, may_be_missing=True)
            if np.dtype(spec.dtype).kind == "f" and (spec.needs_radiance or spec.kind == "own")
            else spec
            for spec in kept
        )

    def prepare(self, scenario: Scenario, assembly: Assembly, radiance: bool) -> None:
        """Take note of the scene that will be seen; raise a :class:`ScenarioError` for what cannot be shown."""
        Excluded.require_none("an image that is no grid on the ground", excluded_beside_rays(self, scenario, assembly))

    def layout(self, scenario: Scenario) -> ImageLayout | None:
        """Return the coordinates of the cube and its extent; None for a grid on the ground, whose plane has them."""
        return ImageLayout(self.coordinates(), *self.extent_deg(scenario))

    def coordinates(self) -> tuple[tuple[VariableSpec, NDArray[Any]], ...]:
        """Return the coordinate variables of the cube with their values: rows and columns, and others of your own."""
        return tuple(
            (
                VariableSpec(name, "1", f"{name} of the image", "coordinate", "From 0.", (name,), "int32"),
                np.arange(size, dtype=np.int32),
            )
            for name, size in (("row", self.image.rows), ("column", self.image.columns))
        )

    def extent_deg(self, scenario: Scenario) -> tuple[float, float, float, float]:
        """Return south, north, west and east of what the first and the last frame see at sea level."""
        rows, columns = self.image.rows, self.image.columns
        frames, place = scenario.frames, scenario.place
        ends_s = (float(number * frames.interval) for number in (frames.first, frames.first + frames.count - 1))
        seen = [self.points_m((slice(0, rows), slice(0, columns)), time_s, 0.0) for time_s in ends_s]
        x_m, y_m = (np.concatenate([np.ravel(coordinates) for coordinates in axis]) for axis in zip(*seen, strict=True))
        met = ~np.isnan(x_m)
        latitude, longitude = to_geographic(x_m[met], y_m[met], place.latitude, place.longitude)
        south, north, west, east = (float(end(angles)) for angles in (latitude, longitude) for end in (np.min, np.max))
        return south, north, west, east

    def complete(self, frame: dict[str, NDArray[Any]], time_s: float, extent: Window) -> None:
        """Set what pixels without ground show to missing in a part of a frame, and add the coordinates of pixels."""
        unseen = self.unseen(extent, time_s)
        if unseen is not None:
            for values in frame.values():
                if values.dtype.kind == "f":
                    values[..., unseen] = np.nan


def excluded_beside_rays(rays: Rays, scenario: Scenario, assembly: Assembly) -> tuple[Excluded, ...]:
    """Return what cannot be computed with an image that is no grid on the ground."""
    modes = (
        Excluded(
            scenario.field_as_typed(f"clouds.layers[{number}].coverage_mode"),
            0.0 < layer.coverage < 1.0 and layer.coverage_mode == "frame" and not from_image,
            "'frame', one coverage of every image,",
            "'field'",
        )
        for number, (layer, from_image) in enumerate(zip(assembly.layers, assembly.from_images, strict=True))
    )
    of_sun = any(name.startswith("sun_") for provider in assembly.derived for name in provider.needs)
    return (
        *modes,
        Excluded(
            "output.derived",
            of_sun and assembly.own_suns,
            "a variable of the sun's angles, which differ from place to place,",
            "others",
        ),
    )


def require_one_view(scenario: Scenario) -> None:
    """Refuse keys of another view beside rays of a section; raises a :class:`ScenarioError`."""
    view, platform, leave = scenario.view, scenario.platform, "to leave it out"
    table = (
        Excluded("view.zenith", view.zenith != 0.0, "another view", leave),
        Excluded("view.azimuth", view.azimuth != 0.0, "another view", leave),
        *(
            Excluded(f"platform.{name}", getattr(platform, name) is not None, "another view", leave)
            for name in type(platform).model_fields
        ),
        Excluded("motion.platform_speed", scenario.motion.platform_speed != 0.0, "motion of another platform", "0"),
        Excluded("image.window", scenario.image.window is not None, _WINDOW, leave),
    )
    Excluded.require_none("a camera or scanner, which has its own view", table)


_WINDOW = "a part of the grid of [image], which is the sky's (keys of the camera or scanner say which pixels are read),"


@dataclass(frozen=True, eq=False)
class GridRays(Rays):
    """Pixels that form a grid on the ground, seen from one direction or toward a sensor at a known altitude.

    Parameters
    ----------
    assembly : Assembly
        Plane of the scene, view and motion.
    views : Views
        Those over the image.
    """

    assembly: Assembly
    samples_per_pixel: int
    views: Views
    directions: None = None

    @property
    def image(self) -> Grid:  # type: ignore[override]
        """The plane of the scene."""
        return self.assembly.grid

    @property
    def view(self) -> View:  # type: ignore[override]
        """View of the image centre."""
        return self.assembly.view

    def points_m(self, window: Window, time_s: float, height_m: float) -> tuple[Array, Array]:
        """Return the points of the plane itself: generators know how far layers are displaced."""
        point_m = self.image.pixel_size_m / self.samples_per_pixel
        y_m, x_m = (
            (np.arange(points.start, points.stop) + 0.5) * point_m - 0.5 * count * self.image.pixel_size_m
            for points, count in zip(
                (points_of(pixels, self.samples_per_pixel) for pixels in window),
                (self.image.rows, self.image.columns),
                strict=True,
            )
        )
        return np.broadcast_arrays(x_m[None, :], y_m[:, None])  # type: ignore[return-value]

    def positions(self, window: Window, time_s: float) -> tuple[Array, Array]:
        """Return the positions in the image."""
        y, x = (
            (2.0 * np.arange(pixels.start, pixels.stop) + 1.0 - count) / count
            for pixels, count in zip(window, (self.image.rows, self.image.columns), strict=True)
        )
        return np.broadcast_arrays(x[None, :], y[:, None])  # type: ignore[return-value]

    def views_of_pixels(self, rows: Sequence[int], columns: Sequence[int], time_s: float) -> list[View]:
        """Return the view from the centres of pixels, which may lie outside the image."""
        image = self.image
        return self.views.at(
            ((2.0 * column + 1.0 - image.columns) / image.columns, (2.0 * row + 1.0 - image.rows) / image.rows)
            for row, column in zip(rows, columns, strict=True)
        )

    def locations_deg(self, window: Window, time_s: float, scenario: Scenario) -> tuple[Array, Array]:
        """Return where the centres of the pixels are at a time."""
        x_m, y_m = self._centres_m(window)
        place = scenario.place
        return to_geographic(
            x_m + self.assembly.motion.platform_speed_m_s * time_s, y_m, place.latitude, place.longitude
        )

    def angles_deg(self, window: Window, time_s: float) -> tuple[Array, Array]:
        """Return the angles toward the sensor at the centres of the pixels, or those of the one view."""
        x_m, y_m = self._centres_m(window)
        lines = self.assembly.lines_of_sight
        if lines is None:
            return np.full(x_m.shape, self.view.zenith_deg), np.full(x_m.shape, self.view.azimuth_deg)
        sight = lines.from_points(x_m, y_m)
        return sight.zenith_deg, sight.azimuth_deg

    def _centres_m(self, window: Window) -> tuple[Array, Array]:
        """Place of the centres of pixels in the plane."""
        x_m, y_m = np.meshgrid(
            *(
                pixel_centres_m(pixels.start, length(pixels), size, self.image.pixel_size_m)
                for pixels, size in zip(window[::-1], (self.image.columns, self.image.rows), strict=True)
            )
        )
        return x_m, y_m

    def project(
        self, x_m: Array, y_m: Array, altitude_m: Array, time_s: float, later_s: float = 0.0
    ) -> tuple[Array, Array]:
        """Return where points appear: displaced by their parallax, if the scene has it."""
        grid, speed_m_s = self.image, self.assembly.motion.platform_speed_m_s
        north, east = self.assembly.slant.seen_m(x_m - speed_m_s * (time_s + later_s), y_m, altitude_m)
        row = (y_m - north) / grid.pixel_size_m + 0.5 * grid.rows
        column = (x_m - east - speed_m_s * time_s) / grid.pixel_size_m + 0.5 * grid.columns
        return row, column - speed_m_s * later_s / grid.pixel_size_m

    def pixel_area_m2(
        self, row: float, column: float, time_s: float, point_m: tuple[float, float, float] | None = None
    ) -> float:
        """Return the area of a pixel across its line of sight, the same at all distances."""
        (view,) = self.views_of_pixels([math.floor(row)], [math.floor(column)], time_s)
        return self.image.pixel_size_m**2 * math.cos(math.radians(view.zenith_deg))

    def variables(self, requested: tuple[VariableSpec, ...]) -> tuple[VariableSpec, ...]:
        """Return the requested variables; those of the geometry are the same in all frames."""
        return requested

    def prepare(self, scenario: Scenario, assembly: Assembly, radiance: bool) -> None:
        """Accept all scenes."""
        return

    def layout(self, scenario: Scenario) -> None:
        """Return None: the coordinates are those of the plane."""
        return


def instants_s(integration_s: float, count: int) -> list[float]:
    """Return evenly spaced instants around 0 with the variance of an integration time T, T^2 / 12.

    In the middles of equal parts, N instants would have 1 - 1 / N^2 of it.
    """
    if count == 1:
        return [0.0]
    step = integration_s / math.sqrt(count**2 - 1.0)
    return [(number - 0.5 * (count - 1)) * step for number in range(count)]


def planned_rays(scenario: Scenario, catalog: Catalog) -> Rays | None:
    """Return the rays of a scenario's sections; None if its image is the grid on the ground."""
    if not scenario.sections:
        return None
    from hcss_twin.core.sections import plugin_sections  # not for scenarios without such sections

    owners = [owner for name, owner in plugin_sections().items() if name in scenario.sections]
    makers = {owner.spec.rays: owner for owner in owners if owner.spec.rays is not None}
    if len(makers) > 1:
        raise ProviderError(f"several image geometries: {', '.join(map(str, makers))}; allowed: one")
    return next((owner.make(str(target), scenario, catalog) for target, owner in makers.items()), None)
