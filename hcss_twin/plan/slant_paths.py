"""Intersection of slant paths with clouds: displacements along the line of sight and along the sun's path.

A pixel is a point of the sea. The straight line from it at zenith angle theta and azimuth phi passes the height h
above the point h tan(theta) away, toward phi; x points east and y north. For the line of sight each layer has one
height, that of its flat side: the base of layers anchored at the base and the top of others. The sun's path is traced
through the layer (:mod:`hcss_twin.engine.stages.shadows`). Displacements are rounded to whole points.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.providers import CloudLayer, Grid, RadianceModel, View
from hcss_twin.providers.declarations import Note
from hcss_twin.scenario.models import Slant


def sea_sun_terms(model: RadianceModel) -> tuple[str, ...]:
    """Return the terms of sea-reflected direct sunlight that a radiance model declares; empty if it declares none."""
    named: frozenset[str] = getattr(model, "sea_sun_terms", frozenset())
    return tuple(name for name in model.terms if name in named)


def require_sea_sun_terms(model: RadianceModel) -> None:
    """Reject a radiance model that does not declare the terms that shadows reduce.

    Raises
    ------
    ScenarioError
        Names ``slant.shadows``.
    """
    if not sea_sun_terms(model):
        message = (
            "the radiance model has no attribute sea_sun_terms and so does not say which terms a shadow weakens; "
            "allowed: false, or a radiance model that does ('as-printed' and 'physical' do)"
        )
        raise ScenarioError([Problem("slant.shadows", message)])


LARGEST_SUN_DEG = 85.0
"""Zenith of the lowest sun for shadows; the view has the same limit."""

MAX_POINTS_WITHIN = 4096
"""Maximum displacement of the sun's path within a layer, in points along either axis; windows are widened by it."""

_ROUNDING = 1e-9
"""Relative tolerance for positions of the sun computed individually or together."""


def reference_height_m(layer: CloudLayer) -> float:
    """Return the height at which a layer is seen: its base, or its top if it is anchored at the top."""
    return layer.base_m if layer.anchor == "base" else layer.top_m


def displacement_m(height_m: Array | float, zenith_deg: Array | float, azimuth_deg: Array | float) -> Array:
    """Return how far north and east, (2, ...), a straight line toward a direction passes a height.

    Parameters
    ----------
    height_m, zenith_deg, azimuth_deg : float or ndarray (...)
        Height; direction to the sensor or sun from the sea point; zenith below 90.
    """
    distance = height_m * np.tan(np.radians(zenith_deg))
    azimuth = np.radians(azimuth_deg)
    return np.stack((distance * np.cos(azimuth), distance * np.sin(azimuth)))


def whole_points(displacement: Array, point_m: float) -> tuple[int, int]:
    """Round a displacement (2,) in metres to whole points: rows and columns."""
    rows, columns = np.rint(displacement / point_m)
    return int(rows), int(columns)


@dataclass(frozen=True)
class SlantPaths:
    """Displacements of the clouds of a scene.

    Attributes
    ----------
    shadows, parallax : bool
        Whether sun paths, and lines of sight, are slant.
    sun_zenith_deg, sun_azimuth_deg : ndarray (F,)
        Angles at the frames with the sun above the horizon.
    """

    shadows: bool
    parallax: bool
    view: View
    sun_zenith_deg: Array
    sun_azimuth_deg: Array

    def of_view(self, layer: CloudLayer, point_m: float) -> tuple[int, int]:
        """Return the displacement (rows, columns) of a layer's cloud seen from a pixel; zero without parallax."""
        if not self.parallax:
            return 0, 0
        away = displacement_m(reference_height_m(layer), self.view.zenith_deg, self.view.azimuth_deg)
        return whole_points(away, point_m)

    def margin(self, layer: CloudLayer, point_m: float) -> tuple[int, int]:
        """Return how many rows and columns beyond the image the paths of all frames intersect a layer.

        The margin is equal on opposite sides, because cloud fields are centred on the image.
        """
        rows, columns = (abs(points) for points in self.of_view(layer, point_m))
        if self.shadows and self.sun_zenith_deg.size:
            away = displacement_m(layer.top_m, self.sun_zenith_deg, self.sun_azimuth_deg)
            farthest = np.max(np.abs(away), axis=1) * (1.0 + _ROUNDING)
            sun_rows, sun_columns = whole_points(farthest, point_m)
            rows, columns = max(rows, sun_rows), max(columns, sun_columns)
        return rows, columns

    def require_short(self, layer: CloudLayer, point_m: float, samples: int) -> None:
        """Reject points so small that the sun's path crosses too many of them within a layer.

        Raises
        ------
        ScenarioError
            Names the pixel size.
        """
        if not self.shadows or not self.sun_zenith_deg.size:
            return
        within = displacement_m(layer.thickness_max_m, self.sun_zenith_deg, self.sun_azimuth_deg)
        longest = float(np.max(np.abs(within)))
        if longest > MAX_POINTS_WITHIN * point_m:
            closest = math.ceil(longest / MAX_POINTS_WITHIN * samples * 100.0) / 100.0
            message = (
                f"{point_m * samples:g} m with {samples} points along it: the sun's path runs {longest:.0f} m within "
                f"'{layer.name}', over {longest / point_m:.0f} points; allowed for shadows: {MAX_POINTS_WITHIN}; "
                f"closest valid choice is {closest:g}, or slant.shadows = false"
            )
            raise ScenarioError([Problem("image.pixel_size", message)])

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the selected options."""
        notes = []
        if self.parallax:
            notes.append(
                "parallax: each layer is displaced as a whole, at the height of its flat side and by whole points; "
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


def slant_paths(options: Slant, view: View, sun_zenith_deg: Array, sun_azimuth_deg: Array) -> SlantPaths:
    """Return the slant paths of a scene from its options and the sun at its frames (F,).

    Raises
    ------
    ScenarioError
        If shadows are requested with the sun too close to the horizon.
    """
    up = sun_zenith_deg < 90.0
    low = np.flatnonzero(up & (sun_zenith_deg > LARGEST_SUN_DEG))
    if options.shadows and low.size:
        frame = int(low[0])
        message = (
            f"the sun is at zenith {sun_zenith_deg[frame]:.2f} deg in frame {frame}, where shadows are "
            f"{math.tan(math.radians(float(sun_zenith_deg[frame]))):.3g} times as long as clouds are high; allowed: "
            f"frames with the sun up to {LARGEST_SUN_DEG:g} deg or below the horizon; or shadows = false"
        )
        raise ScenarioError([Problem("slant.shadows", message)])
    return SlantPaths(options.shadows, options.parallax, view, sun_zenith_deg[up], sun_azimuth_deg[up])


def enlarged(grid: Grid, margin: tuple[int, int]) -> Grid:
    """Return a plane with a margin of rows and columns on each side."""
    return Grid(grid.rows + 2 * margin[0], grid.columns + 2 * margin[1], grid.pixel_size_m)
