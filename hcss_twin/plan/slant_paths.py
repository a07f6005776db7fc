"""Intersection of slant paths with clouds: displacements along the line of sight and along the sun's path.

A pixel is a point of the sea. The straight line from it at zenith angle theta and azimuth phi passes the height h
above the point h tan(theta) away, toward phi; x points east and y north. For the line of sight each layer has one
height, that of its flat side: the base of layers anchored at the base and the top of others. The sun's path is traced
through the layer (:mod:`hcss_twin.engine.stages.shadows`). Displacements are rounded to whole points.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.plan.combinations import Excluded, NotComputed, why_not
from hcss_twin.providers import CloudLayer, Grid, RadianceModel, View
from hcss_twin.providers.declarations import Note
from hcss_twin.scenario.models import Slant


def sea_sun_terms(model: RadianceModel) -> tuple[str, ...]:
    """Return the terms of sea-reflected direct sunlight that a radiance model declares; empty if it declares none."""
    named: frozenset[str] = getattr(model, "sea_sun_terms", frozenset())
    return tuple(name for name in model.terms if name in named)


def excluded_beside_shadows(model: RadianceModel) -> tuple[Excluded, ...]:
    """Return what shadows cannot be computed with, of the radiance model."""
    terms = "a radiance model without sea_sun_terms, which does not say which terms a shadow weakens,"
    others = "a model that does ('as-printed' and 'physical' do)"
    return (Excluded("radiance.model", not sea_sun_terms(model), terms, others),)


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
    options : Slant
        What the scenario says of shadows and parallax.
    sun_zenith_deg, sun_azimuth_deg : ndarray (F,)
        Angles at the frames with the sun above the horizon.
    why_not : mapping of str to NotComputed
        Why ``shadows`` or ``parallax`` are not computed, whichever are not.
    """

    options: Slant
    view: View
    sun_zenith_deg: Array
    sun_azimuth_deg: Array
    why_not: Mapping[str, NotComputed] = field(default_factory=dict)

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


def slant_paths(
    options: Slant, view: View, sun_zenith_deg: Array, sun_azimuth_deg: Array, on_grid: bool = True
) -> SlantPaths:
    """Return the slant paths of a scene from its options and the sun at its frames (F,).

    Parameters
    ----------
    on_grid : bool
        Whether pixels are a grid on the ground; others have parallax by themselves, and no shadows yet.

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
    geometry = Excluded("image", not on_grid, "an image that is no grid on the ground", "a grid on the ground")
    paths = SlantPaths(options, view, sun_zenith_deg[up], sun_azimuth_deg[up])
    return paths.beside("shadows", [Excluded("time", bool(low.size), sun, high), geometry]).beside(
        "parallax", [geometry]
    )


def enlarged(grid: Grid, margin: tuple[int, int]) -> Grid:
    """Return a plane with a margin of rows and columns on each side."""
    return Grid(grid.rows + 2 * margin[0], grid.columns + 2 * margin[1], grid.pixel_size_m)
