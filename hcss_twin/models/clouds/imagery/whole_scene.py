"""Clouds where an image has them: the static scenes of section III.A.1 of the HCSS paper."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.models.clouds.database import read_entry
from hcss_twin.models.clouds.imagery.cloudiness import (
    TOP_PERCENTILE,
    cloudiness_level,
    find_threshold,
    relative_grey,
    thickness_of,
)
from hcss_twin.models.clouds.imagery.moving_window import MovingWindow, position_problems, same_size, size_problem
from hcss_twin.models.clouds.imagery.parameters import ImageryParameters
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.providers import CloudInputs, Declares


@dataclass(frozen=True)
class _Plane:
    """Clouds of an image, rows northward and columns eastward.

    Attributes
    ----------
    thickness_m : ndarray of float32 (rows, columns)
        0 where clear.
    missing : ndarray of bool (rows, columns)
        Where the image has no value.
    notes : tuple of str
        How it was made.
    """

    thickness_m: NDArray[np.float32]
    missing: NDArray[np.bool_]
    notes: tuple[str, ...]


class WholeScene:
    """A window on an image or a database entry, moving over it with platform and wind.

    Parameters
    ----------
    inputs : CloudInputs
        Layer, image plane and motion. The seed is not used.
    parameters : ImageryParameters
        How the file is read.
    path : Path
        Image, or entry where ``parameters.entry`` is given.

    Attributes
    ----------
    image_coverage : float
        Fraction of cloudy pixels of the scene at time 0.

    Raises
    ------
    CatalogError
        If the file cannot be used.
    ScenarioError
        If scene and image do not fit: size, pixel size, origin, missing pixels, coverage.
    """

    def __init__(self, inputs: CloudInputs, parameters: ImageryParameters, path: Path) -> None:
        make = _from_image if parameters.entry is None else _from_entry
        self._window, self._plane = make(inputs, parameters, path)
        self._parameters = parameters
        scene = self._window.at(0.0)
        _refuse_missing(self._plane.missing[scene], parameters, 0.0)
        self.image_coverage = float(np.mean(self._plane.thickness_m[scene] > 0.0))
        missing = int(np.count_nonzero(self._plane.missing[scene]))
        notes = [
            f"{self.image_coverage:.4g} of the scene's pixels are cloudy at the start{self._plane.notes[0]}",
            *self._plane.notes[1:],
        ]
        if missing:
            notes.append(f"{missing} pixels of the scene are missing in the image and taken for clear sky.")
        self.declares = Declares(
            depends_on=frozenset({"time"}) if self._window.moves else frozenset(),
            evolves=False,
            tileable=True,
            notes=tuple(notes),
        )

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return thickness (y, x) of a window inside the scene.

        Raises
        ------
        ScenarioError
            If the footprint has left the image, or missing pixels came into it.
        """
        frame = self._window.at(time_s)
        _refuse_missing(self._plane.missing[frame], self._parameters, time_s)
        return self._plane.thickness_m[frame][rows, columns].copy()


def _refuse_missing(missing: NDArray[np.bool_], parameters: ImageryParameters, time_s: float) -> None:
    """Refuse a frame with missing pixels, unless they are to be taken for clear sky."""
    count = 0 if parameters.missing == "clear" else int(np.count_nonzero(missing))
    if count:
        problem = Problem(
            "clouds.parameters.missing",
            f"{count} of the {missing.size} pixels of the scene at {time_s:g} s are missing in the image"
            '; allowed: another row_origin and column_origin, or missing = "clear"',
        )
        raise ScenarioError([problem], origin="imagery clouds")


def _window(
    inputs: CloudInputs,
    parameters: ImageryParameters,
    shape: tuple[int, int],
    size_m: float | None,
    turned: tuple[bool, bool] = (True, False),
) -> MovingWindow:
    """Return the window of the scene, or raise with everything that does not fit."""
    origins = (parameters.row_origin, parameters.column_origin)
    problems = position_problems(shape, inputs.grid, origins)
    problems += size_problem(size_m, inputs.grid, parameters.reinterpret_pixel_size)
    if problems:
        raise ScenarioError(problems, origin="imagery clouds")
    return MovingWindow(shape, inputs.grid, inputs.motion, origins, turned)


def _from_image(inputs: CloudInputs, parameters: ImageryParameters, path: Path) -> tuple[MovingWindow, _Plane]:
    image = read_image(path, parameters.variable)
    rows, columns = image.values.shape
    turned = (image.north_first, image.east_first)
    window = _window(inputs, parameters, (rows, columns), image.pixel_size_m, turned)
    level = cloudiness_level(image, parameters.cloud_is)
    _refuse_missing(np.isnan(level[window.at(0.0)]), parameters, 0.0)
    layer = inputs.layer
    # In the unbounded sky, coverage is a matter of the image and not of the part that one sensor sees.
    scope = level if layer.coverage_mode == "field" else level[window.at(0.0)]
    try:
        threshold, lowest = find_threshold(level, parameters.method, parameters.window_pixels, layer.coverage, scope)
    except ValueError as error:
        raise ScenarioError([Problem("clouds.coverage", str(error))], origin="imagery clouds") from error
    cloudy = level > threshold
    thickness = np.zeros(level.shape, dtype=np.float32)
    thickness[cloudy] = thickness_of(relative_grey(level[cloudy], lowest), layer.thickness_min_m, layer.thickness_max_m)
    if parameters.method == "coverage":
        where = "over the whole image" if layer.coverage_mode == "field" else "there"
        found = f"; {layer.coverage:g} was asked for {where}. Later frames have what is in their place."
    else:
        found = (
            f", as found in the image by the method '{parameters.method}'; "
            f"the scenario's coverage, {layer.coverage:g}, is not used."
        )
    notes = [
        found,
        f"Thickness is linear in the grey level up to the {TOP_PERCENTILE:g}th percentile of the "
        "cloudy pixels of the whole image; what is brighter has the greatest thickness. Shapes do not "
        "change.",
        *size_notes(image.pixel_size_m, image.pixel_size_is_nominal, inputs),
    ]
    return window, _Plane(thickness, np.isnan(level), tuple(notes))


def _from_entry(inputs: CloudInputs, parameters: ImageryParameters, path: Path) -> tuple[MovingWindow, _Plane]:
    entry = read_entry(path)
    rows, columns = entry.grey.shape
    window = _window(inputs, parameters, (rows, columns), entry.facts.pixel_size_m)
    layer = inputs.layer
    grey = entry.grey[::-1]
    thickness = np.zeros(grey.shape, dtype=np.float32)
    relative = (grey[grey > 0].astype(np.float64) - 1.0) / 254.0
    thickness[grey > 0] = thickness_of(relative, layer.thickness_min_m, layer.thickness_max_m)
    notes = (
        f", as in the entry; the scenario's coverage, {layer.coverage:g}, is not used.",
        "Thickness is linear in the 255 grey levels of the entry. Shapes do not change.",
        *size_notes(entry.facts.pixel_size_m, entry.facts.pixel_size_is_nominal, inputs),
    )
    return window, _Plane(thickness, entry.missing[::-1], notes)


def size_notes(size_m: float | None, is_nominal: bool, inputs: CloudInputs) -> list[str]:
    """Tell how the pixels of an image and those of the scene go together."""
    notes = []
    if size_m is None:
        return [f"The image gives no pixel size; {inputs.grid.pixel_size_m:g} m is the scenario's."]
    if is_nominal:
        notes.append(
            f"The image's pixel size, {size_m:.5g} m, is nominal: that below the geostationary satellite; "
            "pixels elsewhere are larger."
        )
    if not same_size(size_m, inputs.grid):
        notes.append(f"Pixels of {size_m:.5g} m are taken for pixels of {inputs.grid.pixel_size_m:g} m.")
    return notes
