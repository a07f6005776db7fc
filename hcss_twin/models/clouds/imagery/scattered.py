"""Single clouds of a database entry, scattered over an unbounded sky to match a coverage."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.models.clouds.database import read_entry
from hcss_twin.models.clouds.imagery.parameters import ImageryParameters
from hcss_twin.models.clouds.imagery.sky import FARTHEST_PIXEL, Sky, single_clouds
from hcss_twin.models.clouds.imagery.whole_scene import pixels_per_second, size_notes, size_problem, whole_pixels
from hcss_twin.providers import CloudDeclaration, CloudInputs, Grid

# Each layer covers half of the clear sky: after this many, 2**-40 of the sky is clear.
_MAX_LAYERS = 40

# Above this share of the cloudy pixels, copies of one cloud become conspicuous.
_CONSPICUOUS = 0.2

MAX_FRAME_PIXELS = 2**26
"""Largest frame (8192 x 8192) whose coverage can be matched, because this needs all its pixels at once."""


class ScatteredClouds:
    """Clouds of an entry at random places and orientations; where clouds overlap, the thickest counts.

    With ``coverage_mode`` "field", coverage c and mean area A give -ln(1 - c) / A clouds per pixel, so that c is
    exactly the mean over the plane (:mod:`hcss_twin.models.clouds.imagery.sky`). With "frame", the density is that for
    which the coverage of the first frame is closest to c; because only whole clouds are added, it may differ from c by
    half the area of one cloud.

    Raises
    ------
    CatalogError
        If the entry (``path``) is not usable or has no whole cloud.
    ScenarioError
        If the pixel sizes differ, or the frame is too large to match its coverage.
    """

    image_coverage = None

    def __init__(self, inputs: CloudInputs, parameters: ImageryParameters, path: Path) -> None:
        entry = read_entry(path)
        grid, layer = inputs.grid, inputs.layer
        problems = size_problem(entry.facts.pixel_size_m, grid, parameters.reinterpret_pixel_size)
        if problems:
            raise ScenarioError(problems, origin="imagery clouds")
        clouds = single_clouds(entry, layer.thickness_min_m, layer.thickness_max_m, parameters.cloud_pixels)
        self._grid = grid
        self._sky = Sky(clouds, inputs.seed, parameters.turned)
        self._speed = pixels_per_second(inputs.motion, grid)
        self._thickest = float(clouds.thickness_m.max())
        self._overcast = layer.coverage == 1.0
        notes = [
            f"{clouds.areas.size} clouds of {clouds.areas.min()} to {clouds.areas.max()} pixels "
            f"({clouds.mean_area:.4g} on average) are placed at random, each as often as any other; "
            f"{clouds.left_out} clouds of the entry are left out: the border of its image or missing pixels cut them, "
            "or cloud_pixels excludes them. Where clouds overlap, the thickest counts. Shapes do not change."
        ]
        share = float(clouds.areas.max()) / float(clouds.areas.sum())
        if share > _CONSPICUOUS:
            notes.append(f"One cloud makes up {share:.0%} of all cloudy pixels and will be seen again and again.")
        if self._overcast:
            self._density = math.inf
            notes.append("Coverage 1 is the limit of infinitely many clouds: one sheet of their greatest thickness.")
        elif layer.coverage_mode == "frame":
            _refuse_large_frames(grid)
            self._density, coverage = self._frame_density(layer.coverage)
            notes.append(
                f"{coverage:.4g} of the first frame's pixels are cloudy ({layer.coverage:g} was requested; clouds are "
                "whole); later frames show other parts of the sky."
            )
        else:
            self._density = self._sky.density(layer.coverage)
            notes.append(f"Coverage is {layer.coverage:g} in the mean over the unbounded sky, not in each frame.")
        self.declares = CloudDeclaration(
            depends_on=frozenset({"time"}) if any(self._speed) else frozenset(),
            evolves=False,
            tileable=True,
            notes=(*notes, *size_notes(entry.facts.pixel_size_m, entry.facts.pixel_size_is_nominal, inputs)),
        )

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the thickness (y, x) within a window of the scene."""
        shift_y, shift_x = (whole_pixels(speed, time_s) for speed in self._speed)
        farthest = max(abs(shift_y), abs(shift_x)) + max(self._grid.rows, self._grid.columns)
        if farthest > FARTHEST_PIXEL:
            problem = Problem("motion", f"at {time_s:g} s the scene is {farthest} pixels away; allowed: 2**60")
            raise ScenarioError([problem], origin="imagery clouds")
        return self.field(
            slice(rows.start + shift_y, rows.stop + shift_y), slice(columns.start + shift_x, columns.stop + shift_x)
        )

    def field(self, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return thickness (rows, columns) of a window of the unbounded sky, in pixels of any sign.

        Raises
        ------
        ValueError
            If the window is more than 2**60 pixels from the origin.
        """
        if self._overcast:
            shape = (rows.stop - rows.start, columns.stop - columns.start)
            return np.full(shape, self._thickest, dtype=np.float32)
        return self._sky.thickness_m(rows, columns, self._density)

    def _frame_density(self, coverage: float) -> tuple[float, float]:
        """Return the density at which the coverage of the first frame is closest, and that coverage."""
        frame = slice(0, self._grid.rows), slice(0, self._grid.columns)
        pixels = self._grid.rows * self._grid.columns
        wanted = coverage * pixels
        layers = max(1, math.ceil(-math.log2(1.0 - coverage)))
        while True:
            arrivals = np.sort(self._sky.arrivals(*frame, layers), axis=None)
            arrived = arrivals[np.isfinite(arrivals)]
            if arrived.size >= wanted or layers >= _MAX_LAYERS:
                break
            layers += 1
        # Possible numbers of cloudy pixels: none, and for each arrival the number of pixels covered up to it.
        last = np.flatnonzero(np.append(arrived[1:] != arrived[:-1], True)) if arrived.size else np.zeros(0, int)
        counts = np.append(0, last + 1)
        best = int(np.argmin(np.abs(counts - wanted)))
        if best == 0:
            return 0.0, 0.0
        # A cloud exists at densities greater than its arrival.
        density = float(np.nextafter(arrived[counts[best] - 1], np.inf))
        return density, float(counts[best]) / pixels


def _refuse_large_frames(grid: Grid) -> None:
    pixels = grid.rows * grid.columns
    if pixels > MAX_FRAME_PIXELS:
        message = (
            f'"frame" matches the coverage of the first frame, all {pixels} pixels of it at once; allowed: '
            f'{MAX_FRAME_PIXELS} pixels, or "field"'
        )
        raise ScenarioError([Problem("clouds.coverage_mode", message)], origin="imagery clouds")
