"""Clouds from satellite images (section III.A.1 of the HCSS paper): static scenes.

A threshold gives the cloud mask, and grey levels are converted to thickness (eq 7). The clouds are those of the image
scene, or single clouds scattered over an unbounded sky.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.models.clouds.database import CloudEntry
from hcss_twin.models.clouds.imagery.image import size_notes
from hcss_twin.models.clouds.imagery.moving_window import pixels_per_second, whole_pixels
from hcss_twin.models.clouds.imagery.parameters import ImageryParameters
from hcss_twin.models.clouds.imagery.sky import FARTHEST_PIXEL, Sky, single_clouds
from hcss_twin.models.clouds.imagery.whole_scene import WholeScene, size_problem
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
    clear_sky_varies = False

    def __init__(self, inputs: CloudInputs, parameters: ImageryParameters, path: Path) -> None:
        entry = CloudEntry.read(path)
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
            notes=(*notes, *size_notes(entry.facts.pixel_size_m, entry.facts.pixel_size_is_nominal, inputs.grid)),
        )

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the thickness (y, x) within a window of the scene."""
        return self.thickness_around_m(time_s, rows, columns)

    def thickness_around_m(
        self, time_s: float, rows: slice, columns: slice, summary: None = None
    ) -> NDArray[np.float32]:
        """Return the thickness (y, x) of a window of the sky, within the scene or around it."""
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


class ImageryClouds:
    """Clouds of a satellite image, with constant shapes.

    They come from an image or from an entry of the cloud database, whose clouds were extracted and inspected
    beforehand. In an image, a pixel is cloudy if its grey level exceeds a threshold
    (:mod:`hcss_twin.models.clouds.imagery.cloudiness`). Thickness is linear in the grey level (eq 7 of the HCSS paper),

    Th = Th_min + (Th_max - Th_min) (C - C_min) / (C_max - C_min),

    with C_min the (lowest) threshold and C_max the 99.9th percentile of the cloudy pixels; brighter pixels have Th_max.
    Both refer to the whole image, so that all frames agree.

    A whole scene starts at ``row_origin``, ``column_origin``, or at the image centre. It moves over the image by whole
    pixels, (v_platform - v_x) t to the east and -v_y t to the north, up to the image border. Scattered clouds move in
    the same way without a border. Rows of the image are flipped so that y grows northward with the row. Around a whole
    scene is the rest of the image, and beyond the image what the parameter ``beyond`` says; around scattered clouds are
    others.

    The image should show only clouds and sea: bright land is classified as cloud.

    Parameters
    ----------
    inputs : CloudInputs
        Layer, image plane, motion and the catalog that records the file. The seed is used only for scattered clouds.
    parameters : ImageryParameters
        The image or entry and how it is used.

    Attributes
    ----------
    image_coverage : float or None
        Fraction of cloudy pixels of a whole scene at time 0; None for scattered clouds.

    Raises
    ------
    CatalogError
        If the file is missing or not usable.
    ScenarioError
        If scene and image do not match in size, pixel size, origin, missing pixels or coverage.
    """

    declares: CloudDeclaration
    honours = ("coverage_mode",)
    goes_on_with = "clouds.parameters.beyond = 'mirror'"

    def __init__(self, inputs: CloudInputs, parameters: ImageryParameters) -> None:
        if inputs.layer.edge_taper != 0.0:
            problem = Problem(
                "clouds.edge_taper",
                f"{inputs.layer.edge_taper:g} given; clouds of an image have the edges of the image; allowed: 0",
            )
            raise ScenarioError([problem], origin="imagery clouds")
        self._grid = inputs.grid
        self._clouds: WholeScene | ScatteredClouds
        if parameters.entry is not None:
            path = inputs.catalog.find(parameters.entry, CloudEntry.FOLDER, CloudEntry.SUFFIX, beside=True)
        else:
            path = inputs.catalog.file(str(parameters.image))
        kind = ScatteredClouds if parameters.placement == "single-clouds" else WholeScene
        self._clouds = kind(inputs, parameters, path)
        self.declares = self._clouds.declares
        self.image_coverage: float | None = self._clouds.image_coverage
        self.clear_sky_varies = self._clouds.clear_sky_varies

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return geometric thickness (y, x) in metres of a window at ``time_s``; 0 is clear sky.

        Raises
        ------
        ScenarioError
            If the footprint has left the image or contains missing pixels.
        ValueError
            If the time is not finite or the window is not inside the scene.
        """
        if not math.isfinite(time_s):
            raise ValueError(f"time_s: {time_s} given, allowed: any finite time")
        return self._clouds.thickness_m(time_s, *self._grid.inside(rows, columns))

    @property
    def thickness_around_m(self) -> Callable[..., NDArray[np.float32]]:
        """Method that returns the thickness (y, x) of a window in or around the scene, if that is known.

        Raises
        ------
        AttributeError
            With a whole scene and ``beyond = "unknown"``.
        """
        return self._clouds.thickness_around_m
