"""States of the surfaces of a scene: the classes and temperatures for which there are tables.

The radiance of a column is smooth in the temperature of its surface, so that a field of temperature needs few states:
it is interpolated between few points by a polynomial in the black-body radiance of each band, in which it is nearly a
straight line. The number of points follows from the error between them, measured for a few columns.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.physics.planck import planck
from hcss_twin.plan.accuracy import SHARES, RequestedAccuracy
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.axis import Axis, PlacedAxis, place
from hcss_twin.plan.combinations import Excluded
from hcss_twin.plan.effects import Effect
from hcss_twin.plan.few_columns import SAFETY_FACTOR, Omission, few_columns
from hcss_twin.plan.scene_analysis import SceneAnalysis, strictest
from hcss_twin.plan.sunlight import COMPUTED
from hcss_twin.plan.surface_classes import SEA, SceneClass, SceneSurfaces, SurfaceState
from hcss_twin.plan.waves import WAVES
from hcss_twin.providers import Grid
from hcss_twin.scenario.scenario import Scenario

SHARE = SHARES["faint_sunlight"]
"""Share of the accuracy for the interpolation in temperature; a scene with a field of it omits no faint sunlight."""

_ORDERS = (1, 2, 4, 8, 16)
_WAVENUMBERS = 24
"""Number of wavenumbers of each band for the error."""

_TABLE = 513
"""Temperatures at which the black-body radiance of the bands is tabulated: exact to 1e-5 over 50 K."""

_POINTS = 2**20
"""Largest number of points of the first frame that are looked up for the shares of the classes."""


def temperature_axis(grid: SpectralGrid, low_K: float, high_K: float) -> Axis:
    """Return the range of a temperature, whose coordinate (B, N) is the black-body radiance of each band."""
    kelvin = np.linspace(low_K, high_K, _TABLE)
    black = _black_body(grid, kelvin)
    share = (black - black[:, :1]) / (black[:, -1:] - black[:, :1])

    def coordinate(temperature_K: Array) -> Array:
        return np.stack([np.interp(temperature_K, kelvin, of_band) for of_band in share])

    return Axis(low_K, high_K, coordinate=coordinate)


def _black_body(grid: SpectralGrid, temperature_K: Array) -> Array:
    """Black-body radiance (B, N) of the bands; without BLAS, whose last bits may depend on the number of threads."""
    return np.stack(
        [
            np.sum(weights[lit] * planck(grid.wavenumber_cm1[lit], temperature_K[:, None]), axis=1)
            for weights in grid.weights_cm1
            for lit in [np.flatnonzero(weights)]
        ]
    )


@dataclass(frozen=True)
class PlannedSurfaces(Effect):
    """States of a scene's surfaces.

    Attributes
    ----------
    classes : tuple of SceneClass
    axes : tuple of PlacedAxis
        Temperatures of each class with tables, ascending; one if it has the same temperature everywhere.
    shares : tuple of float
        Share of each class in the image at the start.
    estimated_error : float
        Largest error of the interpolation in temperature, relative to the total, measured between the nodes.
    """

    kind = "surfaces"

    classes: tuple[SceneClass, ...]
    axes: tuple[PlacedAxis, ...]
    shares: tuple[float, ...]
    estimated_error: float

    def described(self) -> Mapping[str, Any]:
        """Return classes with their shares and temperatures."""
        classes = zip(self.classes, self.axes, self.shares, strict=True)
        return {
            "surfaces": [
                {
                    "name": of.name,
                    "share": share,
                    "lowest_K": of.low_K,
                    "highest_K": of.high_K,
                    "nodes_K": axis.nodes.tolist(),
                }
                for of, axis, share in classes
            ]
        }

    @property
    def states(self) -> tuple[tuple[SurfaceState, ...], ...]:
        """States of each class."""
        return tuple(
            tuple(class_.at(kelvin) for kelvin in axis.nodes.tolist())
            for class_, axis in zip(self.classes, self.axes, strict=True)
        )


def plan_surfaces(
    scenario: Scenario, assembly: Assembly, surfaces: SceneSurfaces, accuracy: RequestedAccuracy | None
) -> PlannedSurfaces:
    """Choose the states of a scene.

    Parameters
    ----------
    accuracy : RequestedAccuracy or None
        None if no radiance is requested.

    Raises
    ------
    ScenarioError
        If a field of temperature needs too many states at this accuracy.
    """
    axes, worst = list[PlacedAxis](), 0.0
    for class_ in surfaces.classes:
        if class_.low_K == class_.high_K or accuracy is None:
            axes.append(PlacedAxis(Axis(class_.low_K, class_.low_K), (np.array([class_.low_K]),)))
            continue
        placed = _placed(assembly, class_, SHARE * accuracy.relative)
        error = SAFETY_FACTOR * placed.error
        if error > SHARE * accuracy.relative:
            message = (
                f"{scenario.accuracy}: between {placed.nodes.size} temperatures of '{class_.name}' from "
                f"{class_.low_K:g} to {class_.high_K:g} K an error of {error:.1e} remains; allowed: "
                f"{SHARE * accuracy.relative:.1e}, with a lower accuracy or a smaller range of temperature"
            )
            raise ScenarioError([Problem("accuracy", message)])
        axes.append(placed)
        worst = max(worst, error)
    return PlannedSurfaces(surfaces.classes, tuple(axes), _shares(scenario, assembly.grid, surfaces), worst)


def _placed(assembly: Assembly, class_: SceneClass, tolerance: float) -> PlacedAxis:
    """Return the temperatures of a class."""
    columns = few_columns(assembly, _WAVENUMBERS)

    def at(temperature_K: Array) -> Array:
        # Sunlight does not depend on the temperature and would only make the error relatively smaller.
        totals = [columns.total(assembly.over(class_.at(kelvin)), None) for kelvin in temperature_K.tolist()]
        return np.stack(totals)[:, :, None]

    axis = temperature_axis(assembly.spectral_grid, class_.low_K, class_.high_K)
    return place(axis, at, tolerance / SAFETY_FACTOR, orders=_ORDERS, cut="never", fewest=True)


def _shares(scenario: Scenario, grid: Grid, surfaces: SceneSurfaces) -> tuple[float, ...]:
    """Share of each class in the image at the start, from all points or evenly spaced rows of them."""
    samples = scenario.image.samples_per_pixel
    rows, columns = grid.rows * samples, grid.columns * samples
    some = np.unique(np.linspace(0, rows - 1, min(rows, max(1, _POINTS // columns))).round().astype(int)).tolist()
    time_s = scenario.frames.first * float(scenario.frames.interval)
    count = np.zeros(len(surfaces.classes))
    windows = [slice(0, rows)] if len(some) == rows else [slice(row, row + 1) for row in some]
    for window in windows:
        number = surfaces.provider.surface(time_s, window, slice(0, columns)).number
        count += np.bincount(number.ravel(), minlength=count.size)
    return tuple((count / count.sum()).tolist())


def extreme_states(surfaces: SceneSurfaces) -> list[SurfaceState]:
    """Return each class of a scene at its lowest and highest temperature."""
    return [class_.at(kelvin) for class_ in surfaces.classes for kelvin in dict.fromkeys((class_.low_K, class_.high_K))]


def merged(
    scenario: Scenario,
    assembly: Assembly,
    surfaces: SceneSurfaces,
    of_sea: SceneAnalysis,
    of_states: Sequence[SceneAnalysis],
) -> SceneAnalysis:
    """Return the analysis of a scene from those of its sea and of each extreme state alone.

    The accuracy is the strictest, views are those of the state that needs most, and bounds are the largest.

    Raises
    ------
    ScenarioError
        If waves are to be resolved on a sea with a temperature of its own.
    """
    field = any(class_.low_K < class_.high_K for class_ in surfaces.classes)
    omissions: dict[str, Omission] = {}
    for item in (item for analysis in (of_sea, *of_states) for item in analysis.omissions):
        if item.what == "changes of air and sea over image and frames":
            item = Omission("changes of air over image and frames", "the scenario has one profile and one wind", 0.0)
        before = omissions.get(item.what, item)
        unknown = item.bound is None or before.bound is None
        bound = None if unknown else max(item.bound or 0.0, before.bound or 0.0)
        estimates = [omission.estimate for omission in (item, before) if omission.estimate is not None]
        omissions[item.what] = replace(before, bound=bound, estimate=max(estimates, default=None))
    if len(surfaces.classes) > 1 and assembly.samples_per_pixel == 1:
        why = "one point for each pixel: a pixel has the surface at its centre"
        omissions["surfaces within the footprint of a pixel"] = Omission(
            "surfaces within the footprint of a pixel", why, None
        )
    waves = of_sea.resolves_waves
    sea_K = assembly.sea_temperature_K
    if waves and not any(class_.name == SEA and class_.low_K == class_.high_K == sea_K for class_ in surfaces.classes):
        why = "the surface has no class 'sea' at sea.temperature, for which waves are drawn"
        if scenario.sea.waves == "on":
            sealess = Excluded("surfaces", True, f"a map of the ground ({why})", "one with sea")
            Excluded.require_none("sea.waves = 'on'", [sealess], "sea.waves = 'off'")
        waves, omissions[WAVES] = False, Omission(WAVES, why, None)
    strict = strictest(of_sea, of_states)
    return replace(
        strict,
        sunlight=COMPUTED if field else strict.sunlight,
        resolves_waves=waves,
        omissions=tuple(omissions.values()),
    )
