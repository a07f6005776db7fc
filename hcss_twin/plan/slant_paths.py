"""Intersection of slant paths with clouds: displacements along the line of sight and along the sun's path.

A pixel is a point of the sea. The straight line from it at zenith angle theta and azimuth phi passes the height h
above the point h tan(theta) away, toward phi; x points east and y north. For the line of sight each layer has one
height, that of its flat side: the base of layers anchored at the base and the top of others. The sun's path is traced
through the layer (:mod:`hcss_twin.engine.stages.shadows`). Displacements are rounded to whole points. Toward a sensor
at a known altitude each point has a line of sight of its own, whether or not radiance needs several views.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.physics.geometry import displacement_m
from hcss_twin.physics.viewing import LinesOfSight
from hcss_twin.plan.combinations import Excluded, NotComputed, why_not
from hcss_twin.plan.point_shifts import PointShifts
from hcss_twin.providers import CloudLayer, Grid, RadianceModel, View
from hcss_twin.providers.declarations import Note
from hcss_twin.scenario.models import Slant


def sea_sun_terms(model: RadianceModel) -> tuple[str, ...]:
    """Return the terms of sea-reflected direct sunlight that a radiance model declares; empty if it declares none."""
    named: frozenset[str] = getattr(model, "sea_sun_terms", frozenset())
    return tuple(name for name in model.terms if name in named)


def excluded_beside_shadows(model: RadianceModel, own_suns: bool) -> tuple[Excluded, ...]:
    """Return what shadows cannot be computed with, of the radiance model and of places with suns of their own."""
    disk = "a full disk, over which the sun's direction changes by more than shadows from one sun allow,"
    terms = "a radiance model without sea_sun_terms, which does not say which terms a shadow weakens,"
    others = "a model that does ('as-printed' and 'physical' do)"
    return (
        Excluded("radiance.model", not sea_sun_terms(model), terms, others),
        Excluded("image", own_suns, disk, "a part of the Earth with one sun"),
    )


LARGEST_SUN_DEG = 85.0
"""Zenith of the lowest sun for shadows; the view has the same limit."""

MAX_POINTS_WITHIN = 4096
"""Maximum displacement of the sun's path within a layer, in points along either axis; windows are widened by it."""

_CLOSE_M, _ITERATIONS = 1e-3, 100

_ROUNDING = 1e-9
"""Relative tolerance for positions of the sun computed individually or together."""


def whole_points(displacement: Array, point_m: float) -> tuple[int, int]:
    """Round a displacement (2,) in metres to whole points: rows and columns."""
    rows, columns = np.rint(displacement / point_m)
    return int(rows), int(columns)


@dataclass(frozen=True)
class GridSight:
    """Lines of sight of the points of an image.

    Attributes
    ----------
    image : Grid
        In pixels.
    """

    lines: LinesOfSight
    image: Grid

    def shifts(self, height_m: float, point_m: float) -> PointShifts:
        """Return the displacement of a layer that is met at a height, in points of some size."""
        samples = round(self.image.pixel_size_m / point_m)
        points = Grid(self.image.rows * samples, self.image.columns * samples, point_m)
        return PointShifts(self.lines, points, height_m)

    @property
    def corners_deg(self) -> Array:
        """Zenith angles (4,) of the sensor at the corners of the image."""
        x_m, y_m = (0.5 * self.image.pixel_size_m * count for count in (self.image.columns, self.image.rows))
        return self.lines.from_points(np.array([x_m, x_m, -x_m, -x_m]), np.array([y_m, -y_m, y_m, -y_m])).zenith_deg

    def seen_m(self, x_m: Array, y_m: Array, altitude_m: Array) -> tuple[Array, Array]:
        """Return how far north and east of the sea behind them points are seen, by their own lines of sight.

        Where the line of sight from the sea passes a point follows by iteration: each step leaves the share of the
        error that the altitude is of the sensor's.
        """
        north, east = np.zeros_like(x_m), np.zeros_like(x_m)
        for _ in range(_ITERATIONS):
            seen = self.lines.from_points(x_m - east, y_m - north)
            away = displacement_m(altitude_m, seen.zenith_deg, seen.plane_azimuth_deg)
            error = np.max(np.abs(away - (north, east)), initial=0.0)
            north, east = away
            if error < _CLOSE_M:
                break
        return north, east


@dataclass(frozen=True)
class SlantPaths:
    """Displacements of the clouds of a scene.

    Attributes
    ----------
    options : Slant
        What the scenario says of shadows and parallax.
    sun_zenith_deg, sun_azimuth_deg : ndarray (F,)
        Angles at the frames with the sun above the horizon.
    why_not : mapping of str to NotComputed
        Why ``shadows`` or ``parallax`` are not computed, whichever are not.
    sight : GridSight or None
        Lines of sight of the points of the image; None if all are parallel to the view.
    """

    options: Slant
    view: View
    sun_zenith_deg: Array
    sun_azimuth_deg: Array
    why_not: Mapping[str, NotComputed] = field(default_factory=dict)
    sight: GridSight | None = None

    @property
    def shadows(self) -> bool:
        """Whether paths of sunlight are slant."""
        return "shadows" not in self.why_not

    @property
    def parallax(self) -> bool:
        """Whether lines of sight are slant."""
        return "parallax" not in self.why_not

    def beside(self, effect: str, table: Iterable[Excluded]) -> SlantPaths:
        """Return the paths without ``shadows`` or ``parallax`` if something of a table excludes it.

        Raises
        ------
        ScenarioError
            If the scenario switches it on.
        """
        return self.without(effect, why_not(f"slant.{effect}", getattr(self.options, effect), table))

    def without(self, effect: str, why: NotComputed | None) -> SlantPaths:
        """Return the paths without ``shadows`` or ``parallax`` if there is a reason."""
        if why is None or effect in self.why_not:
            return self
        return replace(self, why_not={**self.why_not, effect: why})

    def of_view(self, layer: CloudLayer, point_m: float) -> tuple[int, int] | PointShifts:
        """Return the displacement (rows, columns) of a layer's cloud seen from a point; zero without parallax.

        Returns
        -------
        (int, int) or PointShifts
            The latter if points of the image differ.
        """
        return self.at_height(layer.reference_height_m, point_m)

    def at_height(self, height_m: float, point_m: float) -> tuple[int, int] | PointShifts:
        """Return the displacement of what is met at a height, as :meth:`of_view`."""
        if not self.parallax:
            return 0, 0
        if self.sight is None:
            return whole_points(displacement_m(height_m, self.view.zenith_deg, self.view.azimuth_deg), point_m)
        shifts = self.sight.shifts(height_m, point_m)
        lowest, highest = shifts.range
        return lowest if lowest == highest else shifts

    def farthest_m(self, height_m: float) -> float:
        """Return how far from the sea seen behind it a height is met, at most: at a corner of the image."""
        zenith_deg = np.array(self.view.zenith_deg) if self.sight is None else self.sight.corners_deg
        return float(np.max(displacement_m(height_m, zenith_deg, 0.0)))

    def differs(self, layers: Iterable[CloudLayer], point_m: float) -> bool:
        """Whether points of the image see a layer displaced differently."""
        return any(isinstance(self.of_view(layer, point_m), PointShifts) for layer in layers)

    def toward(self, view: View) -> SlantPaths:
        """Return the slant paths of the same scene in orthographic view from another direction."""
        return replace(self, view=view, sight=None)

    def seen_m(self, x_m: Array, y_m: Array, altitude_m: Array) -> tuple[Array, Array]:
        """Return how far north and east (...) of the sea seen behind them points (...) of the image's plane are."""
        if not self.parallax:
            return 0.0 * altitude_m, 0.0 * altitude_m
        if self.sight is None:
            north, east = displacement_m(altitude_m, self.view.zenith_deg, self.view.azimuth_deg)
        else:
            north, east = self.sight.seen_m(x_m, y_m, altitude_m)
        return north, east

    def margin(self, layer: CloudLayer, point_m: float) -> tuple[int, int]:
        """Return how many rows and columns beyond the image the paths of all frames intersect a layer.

        The margin is equal on opposite sides, because cloud fields are centred on the image.
        """
        shift = self.of_view(layer, point_m)
        ends = shift.range if isinstance(shift, PointShifts) else (shift, shift)
        rows, columns = (max(abs(low), abs(high)) for low, high in zip(*ends, strict=True))
        if self.shadows and self.sun_zenith_deg.size:
            away = displacement_m(layer.top_m, self.sun_zenith_deg, self.sun_azimuth_deg)
            farthest = np.max(np.abs(away), axis=1) * (1.0 + _ROUNDING)
            sun_rows, sun_columns = whole_points(farthest, point_m)
            rows, columns = max(rows, sun_rows), max(columns, sun_columns)
        return rows, columns

    def longest_m(self, layer: CloudLayer) -> float:
        """Return how far the sun's path runs within a layer, along x or y; 0 without shadows."""
        if not self.shadows or not self.sun_zenith_deg.size:
            return 0.0
        within = displacement_m(layer.thickness_max_m, self.sun_zenith_deg, self.sun_azimuth_deg)
        return float(np.max(np.abs(within)))

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the selected options."""
        notes = []
        if self.parallax and self.farthest_m(1.0) > 0.0:
            how = "as a whole" if self.sight is None else "along the line of sight of each point"
            notes.append(
                f"parallax: each layer is displaced {how}, at the height of its flat side and by whole points; "
                "sides of clouds and the relief of their other side are not displaced"
            )
        if self.shadows:
            notes.append(
                Note(
                    "shadows: clear points lose the direct sunlight that the sea reflects, to clouds on the sun's "
                    "path; light that clouds scatter forward or sideways, sunlight in shaded air and shadows on or "
                    "under other clouds are left out",
                    sunlight=True,
                )
            )
        return tuple(notes)


def slant_paths(
    options: Slant, view: View, sun_zenith_deg: Array, sun_azimuth_deg: Array, on_grid: bool = True
) -> SlantPaths:
    """Return the slant paths of a scene from its options and the sun at its frames (F,).

    Parameters
    ----------
    on_grid : bool
        Whether pixels are a grid on the ground; others have parallax by themselves.

    Raises
    ------
    ScenarioError
        If shadows are on with the sun too close to the horizon.
    """
    up = sun_zenith_deg < 90.0
    low = np.flatnonzero(up & (sun_zenith_deg > LARGEST_SUN_DEG))
    sun = ""
    if low.size:
        zenith = float(sun_zenith_deg[low[0]])
        times = math.tan(math.radians(zenith))
        sun = (
            f"the sun at zenith {zenith:.2f} deg in frame {low[0]}, where shadows are {times:.3g} times as long as "
            "clouds are high,"
        )
    high = f"frames with the sun up to {LARGEST_SUN_DEG:g} deg or below the horizon"
    paths = SlantPaths(options, view, sun_zenith_deg[up], sun_azimuth_deg[up]).beside("parallax", [])
    if not on_grid:  # clouds are not displaced: pixels look where their own lines of sight meet them
        paths = paths.without(
            "parallax", NotComputed("each pixel has a line of sight of its own, which meets each layer")
        )
    return paths.beside("shadows", [Excluded("time", bool(low.size), sun, high)])


def enlarged(grid: Grid, margin: tuple[int, int]) -> Grid:
    """Return a plane with a margin of rows and columns on each side."""
    return Grid(grid.rows + 2 * margin[0], grid.columns + 2 * margin[1], grid.pixel_size_m)
