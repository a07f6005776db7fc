"""Whole image scenes (section III.A.1 of the HCSS paper): a window that moves over the image.

The window moves by whole pixels, so that thickness is never interpolated and every frame shows original image pixels.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.models.clouds.database import CloudEntry
from hcss_twin.models.clouds.imagery.cloudiness import Cloudiness
from hcss_twin.models.clouds.imagery.image import same_size, size_notes
from hcss_twin.models.clouds.imagery.image_thickness import method_of, thickness_by_temperature, thickness_by_threshold
from hcss_twin.models.clouds.imagery.moving_window import MovingWindow
from hcss_twin.models.clouds.imagery.parameters import ImageryParameters
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.providers import CloudDeclaration, CloudInputs, Grid


def size_problem(native_m: float | None, grid: Grid, reinterpret: bool) -> list[Problem]:
    """Report a pixel size that differs from the image's, unless the user accepts it."""
    if native_m is None or reinterpret or same_size(native_m, grid):
        return []
    return [
        Problem(
            "image.pixel_size",
            f"{grid.pixel_size_m:g} m differs by more than 1 % from the image's {native_m:.6g} m; set "
            f"image.pixel_size = {native_m:.6g} or parameters.reinterpret_pixel_size = true",
        )
    ]


class _Plane(NamedTuple):
    """Clouds of an image, rows northward and columns eastward.

    ``thickness_m`` is float32 (rows, columns), 0 where clear; ``missing`` is bool, True where the image has no value;
    ``notes`` describe the origin of the clouds, ``by_temperature`` is False where a threshold told them from the sea.
    """

    thickness_m: NDArray[np.float32]
    missing: NDArray[np.bool_]
    notes: tuple[str, ...]
    by_temperature: bool


class WholeScene:
    """Window on an image or database entry (``path``) that moves over it with platform and wind.

    ``image_coverage`` is the fraction of cloudy pixels of the scene at time 0. Errors are as for ``ImageryClouds``.
    """

    def __init__(self, inputs: CloudInputs, parameters: ImageryParameters, path: Path) -> None:
        read = _from_image if parameters.entry is None else _from_entry
        self._window, self._plane = read(inputs, parameters, path)
        self._parameters = parameters
        self.clear_sky_varies = self._plane.by_temperature
        scene = self._window.at(0.0)
        _refuse_missing(self._plane.missing[scene], parameters, 0.0)
        self.image_coverage = float(np.mean(self._plane.thickness_m[scene] > 0.0))
        missing = int(np.count_nonzero(self._plane.missing[scene]))
        visible = self.image_coverage / max(1.0 - missing / self._plane.missing[scene].size, 1e-9)
        notes = [
            f"{visible:.4g} of the scene's visible pixels are cloudy at the start{self._plane.notes[0]}",
            *self._plane.notes[1:],
        ]
        if missing:
            notes.append(f"{missing} pixels of the scene are missing in the image and taken for clear sky.")
        self.declares = CloudDeclaration(
            depends_on=frozenset({"time"}) if self._window.moves else frozenset(),
            evolves=False,
            tileable=True,
            notes=tuple(notes),
        )

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the thickness (y, x) within a window of the scene.

        Raises
        ------
        ScenarioError
            If the footprint has left the image or contains missing pixels.
        """
        frame = self._window.at(time_s)
        _refuse_missing(self._plane.missing[frame], self._parameters, time_s)
        return self._plane.thickness_m[frame][rows, columns].copy()

    @property
    def thickness_around_m(self) -> Callable[..., NDArray[np.float32]]:
        """The optional member of generators; only where the parameter ``beyond`` says how clouds go on.

        Raises
        ------
        AttributeError
            With ``beyond = "unknown"``.
        """
        if self._parameters.beyond == "unknown":
            raise AttributeError("thickness_around_m")
        return self._thickness_around_m

    def _thickness_around_m(
        self, time_s: float, rows: slice, columns: slice, summary: None = None
    ) -> NDArray[np.float32]:
        """Return the thickness (y, x) of a window that may reach outside the scene, and outside the image."""
        places, outside = [], []
        for frame, given, size in zip(self._window.at(time_s), (rows, columns), self._plane.missing.shape, strict=True):
            at = np.arange(frame.start + given.start, frame.start + given.stop)
            outside.append((at < 0) | (at >= size))
            turn = at % (2 * size)
            places.append(np.minimum(turn, 2 * size - 1 - turn))
        near = np.ix_(*places)
        _refuse_missing(self._plane.missing[near], self._parameters, time_s)
        thickness = self._plane.thickness_m[near]
        if self._parameters.beyond == "clear":
            thickness[outside[0]], thickness[:, outside[1]] = 0.0, 0.0
        return thickness


def _refuse_missing(
    missing: NDArray[np.bool_], parameters: ImageryParameters, time_s: float, notes: tuple[str, ...] = ()
) -> None:
    count = 0 if parameters.missing == "clear" else int(np.count_nonzero(missing))
    if count:
        problem = Problem(
            "clouds.parameters.missing",
            f"{count} of the {missing.size} pixels of the scene at {time_s:g} s are missing in the image"
            f"{''.join(f' ({note})' for note in notes)}; allowed: another row_origin and column_origin, or "
            'missing = "clear"',
        )
        raise ScenarioError([problem], origin="imagery clouds")


def _window(
    inputs: CloudInputs,
    parameters: ImageryParameters,
    shape: tuple[int, int],
    size_m: float | None,
    turned: tuple[bool, bool] = (True, False),
) -> MovingWindow:
    origins = (parameters.row_origin, parameters.column_origin)
    problems = MovingWindow.problems(shape, inputs.grid, origins)
    problems += size_problem(size_m, inputs.grid, parameters.reinterpret_pixel_size)
    if problems:
        raise ScenarioError(problems, origin="imagery clouds")
    return MovingWindow(shape, inputs.grid, inputs.motion, origins, turned)


def _from_image(inputs: CloudInputs, parameters: ImageryParameters, path: Path) -> tuple[MovingWindow, _Plane]:
    image = read_image(path, parameters.variable, parameters.at)
    rows, columns = image.values.shape
    turned = (image.north_first, image.east_first)
    window = _window(inputs, parameters, (rows, columns), image.pixel_size_m, turned)
    level = image.level(parameters.cloud_is)
    _refuse_missing(np.isnan(level[window.at(0.0)]), parameters, 0.0, image.notes)
    if parameters.method == "auto":
        parameters = parameters.model_copy(update={"method": method_of(image, parameters.cloud_is)})
    by_temperature = parameters.method == "temperature"
    method = thickness_by_temperature if by_temperature else thickness_by_threshold
    thickness, notes = method(image, level, window.at(0.0), inputs, parameters)
    size = image.size_notes(inputs.grid)
    notes = (*notes, *image.described(parameters.cloud_is), *size)
    return window, _Plane(thickness, np.isnan(level), notes, by_temperature)


def _from_entry(inputs: CloudInputs, parameters: ImageryParameters, path: Path) -> tuple[MovingWindow, _Plane]:
    entry = CloudEntry.read(path)
    rows, columns = entry.grey.shape
    window = _window(inputs, parameters, (rows, columns), entry.facts.pixel_size_m)
    layer = inputs.layer
    grey = entry.grey[::-1]
    thickness = np.zeros(grey.shape, dtype=np.float32)
    relative = (grey[grey > 0].astype(np.float64) - 1.0) / 254.0
    thickness[grey > 0] = Cloudiness.thickness_of(relative, layer.thickness_min_m, layer.thickness_max_m)
    notes = (
        f", as in the entry; the scenario's coverage, {layer.coverage:g}, is not used.",
        "Thickness is linear in the 255 grey levels of the entry. Shapes do not change.",
        *size_notes(entry.facts.pixel_size_m, entry.facts.pixel_size_is_nominal, inputs.grid),
    )
    return window, _Plane(thickness, entry.missing[::-1], notes, False)
