"""Clouds from a satellite image (section III.A.1 of the HCSS paper).

Adaptive threshold, mask, and grey levels that become thickness: the static scenes.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hcss_twin.clouds.imagery.parameters import ImageryParameters
from hcss_twin.clouds.imagery.reader import Image, read_image
from hcss_twin.clouds.imagery.threshold import coverage_threshold, local_threshold, otsu_threshold
from hcss_twin.clouds.windows import window_inside
from hcss_twin.errors import Problem, ScenarioError
from hcss_twin.providers import CloudInputs, Declares, Grid

# Of the cloudy pixels, this percentile of the grey levels and all above it get the greatest
# thickness: a few glinting or noisy pixels would otherwise make all the other clouds thin.
TOP_PERCENTILE = 99.9

# Relative difference of pixel sizes that counts as none.
_SAME_SIZE = 0.01


class ImageryClouds:
    """Clouds cut out of a satellite image; their shapes never change.

    A pixel is cloudy where its grey level exceeds an adaptive threshold (see
    :mod:`hcss_twin.clouds.imagery.threshold`). Its thickness is linear in the grey level (eq 7 of
    the HCSS paper),

    Th = Th_min + (Th_max - Th_min) (C - C_min) / (C_max - C_min),

    with C_min the (lowest) threshold and C_max the 99.9th percentile of the cloudy pixels; what is
    brighter has Th_max. Both belong to the whole image, so that all frames agree.

    The scene starts at ``row_origin``, ``column_origin``, or in the middle of the image. From then
    on it moves over the image by whole pixels, (v_platform - v_x) t to the east and -v_y t to the
    north. Rows of the image are turned so that y grows northward with the row, as in every scene.

    The image should show nothing but clouds and sea: bright land is taken for cloud.

    Parameters
    ----------
    inputs : CloudInputs
        Layer, image plane, motion and the catalog that records the file. The seed is not used.
    parameters : ImageryParameters
        The image and how it is read.

    Attributes
    ----------
    image : Image
        What was read.
    image_coverage : float
        Fraction of cloudy pixels of the scene at time 0.

    Raises
    ------
    CatalogError
        If the file is missing or not a usable image.
    ScenarioError
        If scene and image do not fit: size, pixel size, origin, missing pixels, coverage.
    """

    declares: Declares

    def __init__(self, inputs: CloudInputs, parameters: ImageryParameters) -> None:
        grid, motion = inputs.grid, inputs.motion
        self.image = read_image(inputs.catalog.file(parameters.image), parameters.variable)
        self._grid = grid
        self._missing_is_clear = parameters.missing == "clear"
        problems = _misfits(self.image, grid, parameters)
        if problems:
            raise ScenarioError(problems, origin="imagery clouds")
        shape = self.image.values.shape
        self._origin = (
            _origin(parameters.row_origin, shape[0], grid.rows, self.image.north_first),
            _origin(parameters.column_origin, shape[1], grid.columns, self.image.east_first),
        )
        wind_x, wind_y = motion.cloud_velocity_m_s
        # Pixels of the scene per second along rows (y) and columns (x).
        self._speed = (
            -wind_y / grid.pixel_size_m,
            (motion.platform_speed_m_s - wind_x) / grid.pixel_size_m,
        )
        level = _level(self.image, parameters.cloud_is)
        self._missing = np.isnan(level)
        scene = self._frame(0.0)
        self._refuse_missing(self._missing[scene], 0.0)
        threshold, lowest = _threshold(level, level[scene], parameters, inputs.layer.coverage)
        cloudy = level > threshold
        self._thickness = _thickness(
            level, cloudy, lowest, inputs.layer.thickness_min_m, inputs.layer.thickness_max_m
        )
        self.image_coverage = float(np.count_nonzero(cloudy[scene])) / (grid.rows * grid.columns)
        self.declares = Declares(
            depends_on=frozenset({"time"}) if any(self._speed) else frozenset(),
            evolves=False,
            tileable=True,
            notes=self._notes(parameters, inputs.layer.coverage, int(np.count_nonzero(self._missing[scene]))),
        )

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return geometric thickness (y, x) in metres of a window at ``time_s``; 0 is clear sky.

        Raises
        ------
        ScenarioError
            If the footprint has left the image, or missing pixels came into it.
        ValueError
            If the time is not finite or the window is not inside the scene.
        """
        if not math.isfinite(time_s):
            raise ValueError(f"time_s: {time_s} given, allowed: any finite time")
        window = (
            window_inside("rows", rows, self._grid.rows),
            window_inside("columns", columns, self._grid.columns),
        )
        frame = self._frame(time_s)
        self._refuse_missing(self._missing[frame], time_s)
        return self._thickness[frame][window].copy()

    def _frame(self, time_s: float) -> tuple[slice, slice]:
        """Return the rows and columns of the image (south and west first) seen at ``time_s``."""
        slices = []
        sizes = (self._grid.rows, self._grid.columns)
        for name, origin, speed, size, whole in zip(
            ("rows", "columns"), self._origin, self._speed, sizes, self.image.values.shape, strict=True
        ):
            start = origin + math.floor(speed * time_s + 0.5)
            if not 0 <= start <= whole - size:
                room = whole - size - origin if speed * time_s > 0.0 else origin
                last = math.copysign((room + 0.5) / abs(speed), time_s)
                outside = max(-start, start + size - whole)
                problem = Problem(
                    "motion",
                    f"at {time_s:g} s the footprint has left the image by {outside} of its {size} {name}; "
                    f"allowed: less than {last:.6g} s, a larger image, or another {name[:-1]}_origin",
                )
                raise ScenarioError([problem], origin="imagery clouds")
            slices.append(slice(start, start + size))
        return slices[0], slices[1]

    def _refuse_missing(self, missing: NDArray[np.bool_], time_s: float) -> None:
        count = 0 if self._missing_is_clear else int(np.count_nonzero(missing))
        if count:
            problem = Problem(
                "clouds.parameters.missing",
                f"{count} of the {missing.size} pixels of the scene at {time_s:g} s are missing in the image"
                '; allowed: another row_origin and column_origin, or missing = "clear"',
            )
            raise ScenarioError([problem], origin="imagery clouds")

    def _notes(self, parameters: ImageryParameters, coverage: float, missing: int) -> tuple[str, ...]:
        found = f"{self.image_coverage:.4g} of the scene's pixels are cloudy at the start"
        if parameters.method == "coverage":
            notes = [f"{found}; {coverage:g} was asked for. Later frames have what is in their place."]
        else:
            notes = [
                f"{found}, as found in the image by the method '{parameters.method}'; "
                f"the scenario's coverage, {coverage:g}, is not used."
            ]
        notes.append(
            f"Thickness is linear in the grey level up to the {TOP_PERCENTILE:g}th percentile of the "
            "cloudy pixels of the whole image; what is brighter has the greatest thickness. Shapes do not "
            "change."
        )
        notes += pixel_size_notes(self.image, self._grid)
        if missing:
            notes.append(f"{missing} pixels of the scene are missing in the image and taken for clear sky.")
        return tuple(notes)


def pixel_size_notes(image: Image, grid: Grid) -> tuple[str, ...]:
    """Say where the pixel size of the scene is not, or not safely, that of the image."""
    size = image.pixel_size_m
    if size is None:
        return (f"The image gives no pixel size; {grid.pixel_size_m:g} m is the scenario's.",)
    notes = []
    if image.pixel_size_is_nominal:
        notes.append(
            f"The image's pixel size, {size:.5g} m, is nominal: that below the geostationary satellite; "
            "pixels elsewhere are larger."
        )
    if not _same_size(size, grid):
        notes.append(f"Pixels of {size:.5g} m are taken for pixels of {grid.pixel_size_m:g} m.")
    return tuple(notes)


def _misfits(image: Image, grid: Grid, parameters: ImageryParameters) -> list[Problem]:
    """List where the scene does not fit the image."""
    rows, columns = image.values.shape
    problems = []
    for name, size, whole in (("rows", grid.rows, rows), ("columns", grid.columns, columns)):
        if size > whole:
            problems.append(
                Problem(
                    f"image.{name}",
                    f"{size} is more than the image has ({rows} rows, {columns} columns); closest is {whole}",
                )
            )
            continue
        axis = name[:-1]
        origin = getattr(parameters, f"{axis}_origin")
        if origin is not None and origin + size > whole:
            problems.append(
                Problem(
                    f"clouds.parameters.{axis}_origin",
                    f"{origin} puts {size} {name} beyond the image's {whole}; allowed: 0 to {whole - size}, "
                    f"closest is {whole - size}",
                )
            )
    native = image.pixel_size_m
    if native is not None and not parameters.reinterpret_pixel_size and not _same_size(native, grid):
        problems.append(
            Problem(
                "image.pixel_size",
                f"{grid.pixel_size_m:g} m differs by more than 1 % from the image's {native:.6g} m; set "
                f"image.pixel_size = {native:.6g} or parameters.reinterpret_pixel_size = true",
            )
        )
    return problems


def _same_size(native_m: float, grid: Grid) -> bool:
    return abs(grid.pixel_size_m - native_m) <= _SAME_SIZE * native_m


def _origin(given: int | None, whole: int, size: int, is_turned: bool) -> int:
    """Return where the scene starts along an axis that grows northward or eastward."""
    if given is None:
        return (whole - size) // 2
    return whole - size - given if is_turned else given


def _level(image: Image, cloud_is: str) -> NDArray[np.float64]:
    """Return the values with cloud the larger ones, rows northward and columns eastward."""
    bright = image.bright_is_cloud if cloud_is == "auto" else cloud_is == "bright"
    values = image.values[:: -1 if image.north_first else 1, :: -1 if image.east_first else 1]
    return values if bright else -values


def _threshold(
    level: NDArray[np.float64], scene: NDArray[np.float64], parameters: ImageryParameters, coverage: float
) -> tuple[float | NDArray[np.float64], float]:
    """Return the threshold, one for all pixels or one for each, and the lowest, where thickness starts."""
    if parameters.method == "otsu":
        otsu = otsu_threshold(level)
        return otsu, otsu
    if parameters.method == "local":
        local = local_threshold(level, parameters.window_pixels or max(3, min(level.shape) // 8))
        return local, float(np.nanmin(local))
    try:
        wanted = coverage_threshold(scene, coverage)
    except ValueError as error:
        raise ScenarioError([Problem("clouds.coverage", str(error))], origin="imagery clouds") from error
    return wanted, max(wanted, float(np.nanmin(level)))


def _thickness(
    level: NDArray[np.float64],
    cloudy: NDArray[np.bool_],
    lowest: float,
    thickness_min_m: float,
    thickness_max_m: float,
) -> NDArray[np.float32]:
    """Map grey levels to thickness (eq 7); same shape as ``level``, 0 in clear pixels."""
    thickness = np.zeros(level.shape, dtype=np.float32)
    grey = level[cloudy]
    if grey.size == 0:
        return thickness
    top = float(np.percentile(grey, TOP_PERCENTILE))
    scaled = np.minimum((grey - lowest) / (top - lowest), 1.0) if top > lowest else np.ones_like(grey)
    values = (thickness_min_m + (thickness_max_m - thickness_min_m) * scaled).astype(np.float32)
    # Rounding to single precision must neither leave the layer nor reach 0, which is clear sky.
    highest = np.float32(thickness_max_m)
    if float(highest) > thickness_max_m:
        highest = np.nextafter(highest, np.float32(0.0))
    thickness[cloudy] = np.maximum(np.minimum(values, highest), np.finfo(np.float32).tiny)
    return thickness
