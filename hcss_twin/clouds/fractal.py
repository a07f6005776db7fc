"""Fractal clouds: a sum of interpolated lattices of random numbers (eqs 2-5 and 7 of the HCSS paper)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from hcss_twin.clouds.coverage import cloud_fraction_value, cloudy_pixels
from hcss_twin.clouds.interpolation import apply, cubic_axis, cubic_weights, nearest_axis, split
from hcss_twin.clouds.lattice import lattice_normals, unit_offset
from hcss_twin.clouds.parameters import FractalParameters
from hcss_twin.clouds.thickness import map_thickness
from hcss_twin.clouds.windows import window_inside
from hcss_twin.errors import Problem, ScenarioError
from hcss_twin.providers import CloudInputs, Declares, Grid, Motion

# The length that L divides: 800 pixels of 20 m, the paper's image.
REFERENCE_LENGTH_M = 16_000.0

# From this many cells per step on the nearest node, one random number, replaces the interpolation.
# What is neglected is the correlation of neighbours: -.11 at worst and -.05 on average at 2 cells,
# within .007 of 0 from 3 cells on, none from 4. Octaves this fine have a small share of the variance.
NEAREST_FROM = 2.5

# Such steps are cut to this many cells, or fine octaves would overflow the integer node indices.
_LONGEST_STEP = 2.0**20

_X, _Y, _T = 0, 1, 2
_EPSILON = float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class AxisScale:
    """How one axis of one octave is sampled.

    Attributes
    ----------
    step : float
        Lattice cells per pixel, or per second on the time axis; 0 on a frozen time axis.
    nearest : bool
        Whether the nearest node replaces the interpolation.
    """

    step: float
    nearest: bool


@dataclass(frozen=True)
class Octave:
    """One term of eq 2: its number k, its share of the (unit) variance, and its axes."""

    k: int
    variance: float
    x: AxisScale
    y: AxisScale
    t: AxisScale

    @property
    def is_white(self) -> bool:
        """Whether all pixels of all frames are independent (or of one frame that never changes)."""
        return self.x.nearest and self.y.nearest and (self.t.nearest or self.t.step == 0.0)


def _scale(cells_per_unit: float, unit_step: float) -> AxisScale:
    nearest = cells_per_unit * unit_step >= NEAREST_FROM
    return AxisScale(min(cells_per_unit, _LONGEST_STEP / unit_step) if nearest else cells_per_unit, nearest)


def separate_octaves(shape: FractalParameters, grid: Grid, motion: Motion) -> tuple[Octave, ...]:
    """List the terms of eq 2, scaled to unit total variance; ``shape`` must be complete."""
    gamma, hurst, cells, limits = shape.gamma, shape.H, shape.L, shape.k
    if gamma is None or hurst is None or cells is None or limits is None:
        raise ValueError("shape: gamma, H, L and k must all be given")
    numbers = range(limits[0], limits[1] + 1)
    # Relative to the first octave: the ratio is the same, and nothing underflows.
    powers = [gamma ** (-2.0 * hurst * (k - limits[0])) for k in numbers]
    total = math.fsum(powers)
    octaves = []
    for k, power in zip(numbers, powers, strict=True):
        per_pixel = gamma**k * grid.pixel_size_m / REFERENCE_LENGTH_M
        per_second = gamma**k / motion.evolution_time_s
        # Without an interval there is no neighbouring frame to be independent of.
        time_axis = (
            _scale(per_second, motion.frame_interval_s)
            if motion.frame_interval_s > 0.0
            else AxisScale(per_second, False)
        )
        octaves.append(
            Octave(
                k,
                power / total,
                _scale(cells[0] * per_pixel, 1.0),
                _scale(cells[1] * per_pixel, 1.0),
                time_axis,
            )
        )
    return tuple(octaves)


def merge_white(octaves: tuple[Octave, ...]) -> tuple[Octave, ...]:
    """Replace all white octaves by one with the sum of their variances.

    A sum of independent white noises is a white noise: exact in law. The coarsest of them lends
    its number and its scales, because it is the one that changes least when clouds drift by less
    than a pixel between frames.
    """
    white = [octave for octave in octaves if octave.is_white]
    if len(white) < 2:
        return octaves
    coarsest = white[0]
    merged = Octave(
        coarsest.k, math.fsum(octave.variance for octave in white), coarsest.x, coarsest.y, coarsest.t
    )
    return (*(octave for octave in octaves if not octave.is_white), merged)


def describe_skipped(octaves: tuple[Octave, ...]) -> tuple[tuple[str, str], ...]:
    """List what is not computed as eqs 2-4 are written, as pairs (what, why)."""
    skipped = [("axis z of the 4-D field", "a fixed z slice has the same law as the 3-D field: exact")]
    if all(octave.t.step == 0.0 for octave in octaves):
        skipped.append(("time axis", "evolution_time is infinite: shapes are frozen, one time plane: exact"))
    for octave in octaves:
        axes = [name for name, axis in (("x", octave.x), ("y", octave.y), ("t", octave.t)) if axis.nearest]
        if axes:
            units = [unit for unit, names in (("pixels", "xy"), ("frames", "t")) if set(axes) & set(names)]
            skipped.append(
                (
                    f"interpolation of octave {octave.k} along {', '.join(axes)}",
                    f"{' and '.join(units)} are {NEAREST_FROM:g} or more cells apart, taken as independent: "
                    f"neglects correlations of -.11 to .01 in {octave.variance:.1e} of the variance",
                )
            )
    white = [octave for octave in octaves if octave.is_white]
    if len(white) > 1:
        skipped.append(
            (
                f"octaves {', '.join(str(octave.k) for octave in white[1:])} as separate terms",
                f"white in every axis, as octave {white[0].k}, which carries their variance "
                f"({math.fsum(octave.variance for octave in white):.3g} in all): exact within a frame",
            )
        )
    return tuple(skipped)


def displacement_pixels(speed_m_s: float, time_s: float, pixel_size_m: float) -> float:
    """Return the distance covered in pixels, free of rounding where it is meant to be a round number.

    A distance within a few units in the last place of a multiple of 1/1024 pixel is that multiple.
    Otherwise a platform that moves by whole pixels per frame would not, at times such as
    3 x 0.1 s, see the same bits again.
    """
    distance = speed_m_s * time_s / pixel_size_m
    rounded = round(distance * 1024.0) / 1024.0
    return rounded if abs(distance - rounded) <= 8.0 * _EPSILON * abs(distance) else distance


def complete_parameters(parameters: FractalParameters, defaults: Mapping[str, Any]) -> FractalParameters:
    """Fill what ``parameters`` leaves open from the cloud type's ``defaults``.

    Raises
    ------
    ScenarioError
        With one problem for each parameter that neither gives, or that the cloud type gives wrongly.
    """
    values: dict[str, Any] = {}
    problems = []
    for name in FractalParameters.model_fields:
        value = getattr(parameters, name)
        values[name] = defaults.get(name) if value is None else value
        if values[name] is None:
            what = FractalParameters.model_fields[name].description
            problems.append(
                Problem(f"clouds.parameters.{name}", f"neither given nor part of the cloud type; {what}")
            )
    try:
        complete = FractalParameters(**values)
    except ValidationError as error:
        for detail in error.errors():
            path = ".".join(str(part) for part in detail["loc"])
            problems.append(
                Problem(f"cloud type, fractal.{path}", f"{detail['msg']}; {detail['input']!r} given")
            )
    if problems:
        raise ScenarioError(problems, origin="fractal clouds")
    return complete


def _check_motion(motion: Motion, grid: Grid) -> None:
    problems = []
    for name, value, allowed in (
        ("evolution_time_s", motion.evolution_time_s, motion.evolution_time_s > 0.0),
        ("frame_interval_s", motion.frame_interval_s, 0.0 <= motion.frame_interval_s < math.inf),
        ("pixel_size_m", grid.pixel_size_m, 0.0 < grid.pixel_size_m < math.inf),
    ):
        if not allowed:
            limit = "0 or more and finite" if name == "frame_interval_s" else "greater than 0"
            problems.append(Problem(name, f"{value} given, allowed: {limit}"))
    if problems:
        raise ScenarioError(problems, origin="fractal clouds")


class FractalClouds:
    """Clouds from the fractal field of eqs 2-4, with exact coverage and a linear map to thickness.

    V(x, y, t) = sum_k gamma^(-k H) S_k(gamma^k X / L) / sqrt(sum_k gamma^(-2 k H)),

    where S_k interpolates a lattice of independent normals with unit variance everywhere, so that
    V is N(0, 1) at every point and eq 5 gives a uniform p. The lattice cells are 16 km / L along x
    and y and ``evolution_time_s`` in time, all divided by gamma^k. Each octave has its own lattice
    and a random offset of it. The z axis of the 4-D field is collapsed: a slice at fixed z of a
    field with independent nodes and unit-variance weights has the law of the 3-D field exactly.

    Pixel (i, j) at time t lies at x = (j + 1/2) a + (v_platform - v_x) t and y = (i + 1/2) a - v_y t,
    with a the pixel size: the platform moves along +x over clouds that the wind carries.

    Parameters
    ----------
    inputs : CloudInputs
        Layer, image plane, motion, seed, and the cloud type's defaults.
    parameters : FractalParameters
        Shape; what is None comes from ``inputs.type_parameters``.

    Raises
    ------
    ScenarioError
        If a parameter is given nowhere, or an input is out of its range.
    """

    declares: Declares

    def __init__(self, inputs: CloudInputs, parameters: FractalParameters) -> None:
        self._grid = inputs.grid
        self._layer = inputs.layer
        self._seed = inputs.seed
        motion = inputs.motion
        _check_motion(motion, inputs.grid)
        self.parameters = complete_parameters(parameters, inputs.type_parameters)
        separate = separate_octaves(self.parameters, inputs.grid, motion)
        self.octaves = merge_white(separate)
        self.skipped = describe_skipped(separate)
        wind_x, wind_y = motion.cloud_velocity_m_s
        self._speed_x, self._speed_y = motion.platform_speed_m_s - wind_x, -wind_y
        evolves = math.isfinite(motion.evolution_time_s)
        changes = evolves or self._speed_x != 0.0 or self._speed_y != 0.0
        self.declares = Declares(
            depends_on=frozenset({"time"}) if changes else frozenset(),
            evolves=evolves,
            tileable=False,
            notes=(
                "Coverage is exact in each frame and thickness spans its whole range in each frame, so that "
                "a pixel depends on the rest of its frame.",
            ),
        )

    def field(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float64]:
        """Return the normal field V (rows, columns) of any window of the plane, inside the image or not.

        A pixel has the same bits in every window, whatever was asked before.

        Parameters
        ----------
        time_s : float
            Time since the scenario's start.
        rows, columns : slice
            With start and stop (of any sign) and without step, in pixels of the image at ``time_s``.

        Raises
        ------
        ValueError
            If a slice has no ends or a step, if the time is not finite, or if the window lies so far
            out that its nodes cannot be counted in 64 bits.
        """
        if not math.isfinite(time_s):
            raise ValueError(f"time_s: {time_s} given, allowed: any finite time")
        x = self._positions("columns", columns, self._speed_x, time_s)
        y = self._positions("rows", rows, self._speed_y, time_s)
        total = np.zeros((y.size, x.size))
        if total.size:
            for octave in self.octaves:
                total += self._octave(octave, time_s, y, x)
        return total

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return geometric thickness (y, x) in metres at ``time_s``; 0 is clear sky.

        The whole frame is computed, because its coverage is exact, and the window cut from it.

        Raises
        ------
        ValueError
            If the window is not inside the image.
        """
        window = (
            window_inside("rows", rows, self._grid.rows),
            window_inside("columns", columns, self._grid.columns),
        )
        field = self.field(time_s, slice(0, self._grid.rows), slice(0, self._grid.columns))
        cloudy = cloudy_pixels(field, self._layer.coverage)
        values = cloud_fraction_value(field[cloudy])
        frame = map_thickness(values, cloudy, self._layer.thickness_min_m, self._layer.thickness_max_m)
        return frame[window]

    def _positions(self, name: str, window: slice, speed_m_s: float, time_s: float) -> NDArray[np.float64]:
        """Return the pixel centres (N,) of a window in pixels from the origin of the cloud field."""
        if window.start is None or window.stop is None or window.step not in (None, 1):
            raise ValueError(f"{name}: {window} given, allowed: a slice with start and stop and no step")
        shift = displacement_pixels(speed_m_s, time_s, self._grid.pixel_size_m)
        # Half-integers: exact, so that moving the window and moving the platform give the same sum.
        return (np.arange(window.start, window.stop, dtype=np.int64) + 0.5) + shift

    def _octave(
        self, octave: Octave, time_s: float, y: NDArray[np.float64], x: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return one term of the sum at pixel positions ``y`` (M,) and ``x`` (N,)."""
        axes = []
        for positions, scale, axis in ((y, octave.y, _Y), (x, octave.x, _X)):
            coordinate = positions * scale.step + unit_offset(self._seed, octave.k, axis)
            axes.append(nearest_axis(coordinate) if scale.nearest else cubic_axis(coordinate))
        along_y, along_x = axes
        plane = np.zeros((along_y.nodes.size, along_x.nodes.size))
        # The time planes are blended on the lattice, which for most octaves is coarser than the image.
        for t, weight in self._time_weights(octave, time_s):
            normals = lattice_normals(self._seed, octave.k, t, along_y.nodes, along_x.nodes)
            normals *= weight
            plane += normals
        return apply(along_y, along_x, plane)

    def _time_weights(self, octave: Octave, time_s: float) -> list[tuple[int, float]]:
        """Return time planes and their weights, which include the amplitude of the octave."""
        amplitude = math.sqrt(octave.variance)
        if octave.t.step == 0.0:
            return [(0, amplitude)]
        coordinate = np.full(1, time_s * octave.t.step + unit_offset(self._seed, octave.k, _T))
        cell, fraction = split(coordinate)
        if octave.t.nearest:
            return [(int(cell[0]), amplitude)]
        weights = cubic_weights(fraction)[0]
        return [(int(cell[0]) + tap - 1, amplitude * float(weights[tap])) for tap in range(4)]
