"""Fractal clouds: a sum of interpolated lattices of random numbers (eqs 2-5 and 7 of the HCSS paper)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.models.clouds.coverage import FrameSummary, summarise
from hcss_twin.models.clouds.fractal.field import FractalField
from hcss_twin.models.clouds.fractal.octaves import Octave, describe_skipped
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.models.clouds.thickness import field_thickness, frame_thickness, thickness_in_frame
from hcss_twin.providers import CloudDeclaration, CloudInputs, CloudLayer, Grid, Motion

__all__ = ["FractalClouds"]

STRIP_PIXELS = 2**21
"""Largest strip used to summarise a frame; bounds the memory for large frames."""


_NOISY = 0.5
"""Variance fraction of subpixel cells above which a warning is issued."""

_FRAME_NOTE = (
    "Coverage is exact in each frame and thickness spans its whole range in each frame, so that "
    "a pixel depends on the rest of its frame."
)
_FIELD_NOTE = (
    "Coverage is exact in the mean over the unbounded sky; that of one frame scatters around it, the more "
    "the fewer clouds it holds."
)


def complete_parameters(parameters: FractalParameters, defaults: Mapping[str, Any]) -> FractalParameters:
    """Fill missing ``parameters`` from the cloud type's ``defaults``.

    Raises
    ------
    ScenarioError
        With one problem for each parameter that is missing from both or has an invalid default.
    """
    values: dict[str, Any] = {}
    problems = []
    for name in FractalParameters.model_fields:
        value, usual = getattr(parameters, name), defaults.get(name)
        values[name] = value if usual is None or (name in parameters.model_fields_set and value is not None) else usual
        if values[name] is None:
            what = FractalParameters.model_fields[name].description
            problems.append(Problem(f"clouds.parameters.{name}", f"neither given nor part of the cloud type; {what}"))
    try:
        complete = FractalParameters(**values)
    except ValidationError as error:
        for detail in error.errors():
            path = ".".join(str(part) for part in detail["loc"])
            problems.append(Problem(f"cloud type, fractal.{path}", f"{detail['msg']}; {detail['input']!r} given"))
    if problems:
        raise ScenarioError(problems, origin="fractal clouds")
    return complete


def _check_motion(motion: Motion, grid: Grid) -> None:
    problems = []
    if not motion.evolution_time_s > 0.0:
        problems.append(Problem("evolution_time_s", f"{motion.evolution_time_s} given, allowed: greater than 0"))
    if not 0.0 <= motion.frame_interval_s < math.inf:
        problems.append(Problem("frame_interval_s", f"{motion.frame_interval_s} given, allowed: 0 or more and finite"))
    if not 0.0 < grid.pixel_size_m < math.inf:
        problems.append(Problem("pixel_size_m", f"{grid.pixel_size_m} given, allowed: greater than 0"))
    if problems:
        raise ScenarioError(problems, origin="fractal clouds")


class FractalClouds:
    """Clouds from the fractal field of eqs 2-4, with exact coverage (eq 5) and a linear map to thickness (eq 7).

    V(x, y, t) = sum_k gamma^(-k H) S_k(gamma^k X / L) / sqrt(sum_k gamma^(-2 k H)),

    where S_k interpolates a lattice of independent normals with unit variance everywhere, so that V is N(0, 1) at every
    point and eq 5 gives a uniform p. The lattice cells are 16 km / L along x and y and ``evolution_time_s`` in time,
    all divided by gamma^k. Each octave has its own lattice with a random offset. The z axis of the 4-D field of eq 3 is
    omitted: for independent nodes and unit-variance weights, a slice at fixed z has exactly the distribution of the 3-D
    field. The field therefore does not shape clouds in height: each column is one slab from its base to its top.

    The origin of the sky is the image centre at time 0. Pixel (i, j) at time t lies at
    x = (j + 1/2 - columns/2) a + (v_platform - v_x) t and y = (i + 1/2 - rows/2) a - v_y t (eq 4), with a the pixel
    size: the platform moves along +x over clouds that the wind carries.

    Parameters
    ----------
    inputs : CloudInputs
        Layer, image plane, motion, seed, and the cloud type's defaults.
    parameters : FractalParameters
        Shape; None selects the value in ``inputs.type_parameters``.
    threads : int, optional
        Default: all processors, at most 8. Results do not depend on the number.

    Raises
    ------
    ScenarioError
        If a parameter is missing from both, or an input is out of range.
    """

    declares: CloudDeclaration
    honours = ("coverage_mode", "edge_taper")

    @staticmethod
    def field_thickness(
        field: NDArray[np.float32], layer: CloudLayer, exponent: float = 1.0, in_place: bool = False
    ) -> NDArray[np.float32]:
        """Return the thickness in m where V exceeds a fixed threshold, the normal quantile of the coverage (eqs 5, 7).

        The coverage is exact on average over an unbounded field, and a pixel does not depend on others. ``exponent`` is
        that of the parameters; with ``in_place`` the result replaces the field (any shape).
        """
        return field_thickness(field, layer, exponent, in_place)

    def __init__(self, inputs: CloudInputs, parameters: FractalParameters, threads: int | None = None) -> None:
        self._grid = inputs.grid
        self._layer = inputs.layer
        motion = inputs.motion
        _check_motion(motion, inputs.grid)
        self.parameters = complete_parameters(parameters, inputs.type_parameters)
        is_one_sky = inputs.layer.coverage_mode == "field"
        separate = Octave.separate(self.parameters, inputs.grid, motion, noise=not is_one_sky)
        self.octaves = Octave.merge_noise(separate)
        self.skipped = describe_skipped(separate, self.octaves)
        self._field = FractalField(inputs.seed, self.octaves, threads)
        wind_x, wind_y = motion.cloud_velocity_m_s
        self._speed_x, self._speed_y = motion.platform_speed_m_s - wind_x, -wind_y
        evolves = math.isfinite(motion.evolution_time_s)
        changes = evolves or self._speed_x != 0.0 or self._speed_y != 0.0
        self.declares = CloudDeclaration(
            depends_on=frozenset({"time"}) if changes else frozenset(),
            evolves=evolves,
            tileable=is_one_sky,
            notes=(_FIELD_NOTE if is_one_sky else _FRAME_NOTE, *_noise_notes(separate)),
        )

    def field(
        self, time_s: float, rows: slice, columns: slice, out: NDArray[np.float32] | None = None
    ) -> NDArray[np.float32]:
        """Return the normal field V (rows, columns) of any window of the plane, inside or outside the image (eqs 2-4).

        A pixel has the same bits in every window, whatever the order in which windows are computed.

        Parameters
        ----------
        time_s : float
            Time since the scenario's start.
        rows, columns : slice
            With start and stop (of any sign) and without step, in pixels of the image at ``time_s``.
        out : ndarray of float32 (rows, columns), optional
            Output array, to avoid allocating a new one for every frame.

        Raises
        ------
        ValueError
            If a slice has open ends or a step, the time is not finite, or node indices exceed 64 bits.
        """
        if not math.isfinite(time_s):
            raise ValueError(f"time_s: {time_s} given, allowed: any finite time")
        x = self._pixels("columns", columns, self._grid.columns, self._speed_x, time_s)
        y = self._pixels("rows", rows, self._grid.rows, self._speed_y, time_s)
        return self._field.window(time_s, y, x, out)

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return geometric thickness (y, x) in metres at ``time_s``; 0 is clear sky.

        With ``coverage_mode`` "frame", the whole frame is computed and the window is extracted from it.

        Raises
        ------
        ValueError
            If the window is not inside the image.
        """
        inside = self._grid.inside(rows, columns)
        layer, exponent = self._layer, self.parameters.brightness_exponent
        if layer.coverage_mode == "field":
            return field_thickness(self.field(time_s, *inside), layer, exponent, in_place=True)
        whole = self.field(time_s, slice(0, self._grid.rows), slice(0, self._grid.columns))
        return frame_thickness(whole, layer, exponent)[inside]

    def frame_summary(self, time_s: float) -> FrameSummary:
        """Return the threshold and the highest value of the frame at ``time_s``, for :meth:`thickness_in_frame_m`.

        The field of the frame is computed two or three times, strip by strip.
        """
        rows, columns = self._grid.rows, self._grid.columns
        step = max(1, STRIP_PIXELS // columns)

        def strips() -> Iterator[NDArray[np.float32]]:
            buffer = np.empty((min(step, rows), columns), dtype=np.float32)
            for row in range(0, rows, step):
                stop = min(row + step, rows)
                yield self.field(time_s, slice(row, stop), slice(0, columns), buffer[: stop - row])

        return summarise(strips, rows * columns, self._layer.coverage)

    def thickness_in_frame_m(
        self, time_s: float, rows: slice, columns: slice, summary: FrameSummary
    ) -> NDArray[np.float32]:
        """Return the same bits as :meth:`thickness_m`, without computing the whole frame.

        ``summary`` is that of the frame at ``time_s``. Raises ValueError if the window is not inside the image.
        """
        inside = self._grid.inside(rows, columns)
        first, width = inside[0].start * self._grid.columns + inside[1].start, self._grid.columns
        exponent = self.parameters.brightness_exponent
        return thickness_in_frame(self.field(time_s, *inside), first, width, summary, self._layer, exponent)

    def thickness_around_m(
        self, time_s: float, rows: slice, columns: slice, summary: FrameSummary | None
    ) -> NDArray[np.float32]:
        """Return geometric thickness (y, x) in metres of a window that may reach outside the image.

        ``summary`` is that of the frame at ``time_s``; None with ``coverage_mode`` "field". The threshold and thickness
        scale of a frame also apply outside it: values above the frame's highest get the maximum thickness, and with
        coverage 1 the sky is overcast outside, too.
        """
        layer, exponent = self._layer, self.parameters.brightness_exponent
        field = self.field(time_s, rows, columns)
        if summary is None:
            return field_thickness(field, layer, exponent, in_place=True)
        first, width = rows.start * self._grid.columns + columns.start, self._grid.columns
        if layer.coverage == 1.0 and summary.lowest is not None:
            np.maximum(field, np.float32(summary.lowest), out=field)
            summary = replace(summary, last=first + field.shape[0] * width + field.shape[1])
        return thickness_in_frame(field, first, width, summary, layer, exponent)

    def _pixels(self, name: str, window: slice, size: int, speed_m_s: float, time_s: float) -> FractalField.PixelWindow:
        if window.start is None or window.stop is None or window.step not in (None, 1):
            raise ValueError(f"{name}: {window} given, allowed: a slice with start and stop and no step")
        shift = self._grid.displacement_pixels(speed_m_s, time_s)
        return FractalField.PixelWindow(window.start, max(0, window.stop - window.start), (0.5 - 0.5 * size) + shift)


def _noise_notes(octaves: Sequence[Octave]) -> tuple[str, ...]:
    """Return a warning if neighbouring pixels are mostly independent."""
    white = sum(octave.variance for octave in octaves if octave.is_white)
    if white <= _NOISY:
        return ()
    return (
        f"Cells that hold {white:.0%} of the variance are smaller than pixels, whose clouds are therefore almost "
        "independent of each other: the picture looks like noise. Smaller pixels, or fewer cells L, show shapes.",
    )
