"""The image to match: the clouds that the imagery generator would make from a file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.matching.structure import LEVELS, STILL, CloudImage, grey_inputs
from hcss_evaluate.measures.images import SMALLEST_SIDE
from hcss_twin import open_cube
from hcss_twin.core.arguments import checked
from hcss_twin.core.reading import Reading
from hcss_twin.cube.frame_selection import FrameSelection
from hcss_twin.models.clouds.database import CloudEntry
from hcss_twin.models.clouds.imagery.image import SatelliteImage
from hcss_twin.models.clouds.imagery.parameters import ImageReading
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.providers import Array, CatalogError, CubeError, Grid, ImageError, Kind, ScenarioError
from hcss_twin.providers.registry.registry import Registry

# Larger images are cropped to this many rows and columns by default, the frame size of the paper.
LARGEST_SIDE = 800
Method = Literal["auto", "otsu", "local", "coverage", "valid"]

# Options that do not apply to an entry, whose clouds have been extracted already.
_OF_AN_IMAGE = ("variable", "method", "window_pixels", "cloud_is")


@checked
@dataclass(frozen=True)
class ImageChoice:
    """Selection of the matched part of an image and of the cloud detection.

    Attributes
    ----------
    variable, at, window_pixels, cloud_is, missing, row_origin, column_origin
        As :class:`hcss_twin.models.clouds.imagery.parameters.ImageryParameters`.
    method : {"auto", "otsu", "local", "coverage", "valid"}
        Cloud detection method. ``valid``, for products with values in cloud only, selects every pixel with a value;
        ``auto`` is a cube's own mask, ``valid`` for cloud-top variables with missing pixels, ``otsu`` for all others.
    coverage : float or None
        Fraction of cloudy pixels for method ``coverage``.
    pixel_size_m : float or None
        Pixel size; required if the file has none.
    rows, columns : int or None
        Size of the part; default: that of the image, at most 800.
    """

    variable: str | None = None
    at: Mapping[str, int] = field(default_factory=dict)
    method: Method = "auto"
    window_pixels: int | None = None
    cloud_is: SatelliteImage.CloudIs = "auto"
    missing: Literal["error", "clear"] = "error"
    row_origin: int | None = None
    column_origin: int | None = None
    coverage: float | None = None
    pixel_size_m: float | None = None
    rows: int | None = None
    columns: int | None = None


@dataclass(frozen=True)
class Target:
    """The matched part of an image, its file name, and notes.

    The notes describe the part, the cloud detection, and nominal or missing metadata.
    """

    image: CloudImage
    source: str
    notes: tuple[str, ...]


def read_target(path: Path, choice: ImageChoice | None = None) -> Target:
    """Read an image with the imagery generator, so that its clouds are those that a scenario would simulate.

    The file is NetCDF (including GOES ABI), GeoTIFF, picture, ``.npy`` or ``.npz``, an entry of the cloud database with
    its cleaned mask, or a cube with its own mask and thickness.

    Raises
    ------
    CatalogError
        If the file is not a usable image.
    ImageError
        If the pixel size is unknown, the image is too small, thresholding finds no cloud or no clear pixel, or options
        contradict each other or the file.
    ScenarioError
        If the part lies outside the image, or pixels are missing.
    """
    choice = choice or ImageChoice()
    _check(choice)
    try:
        return _read(path, choice)
    except ScenarioError as error:
        raise ScenarioError(error.problems, origin=str(path)) from error


def _read(path: Path, choice: ImageChoice) -> Target:
    source = _entry(path, choice) or _cube(path, choice) or _image(path, choice)
    shape = source.shape
    size = choice.pixel_size_m or source.pixel_size_m
    if size is None:
        raise ImageError(f"pixel_size: not in {path}{source.why}; allowed: a length, for example --pixel-size '1 km'")
    part = (choice.rows or min(shape[0], LARGEST_SIDE), choice.columns or min(shape[1], LARGEST_SIDE))
    if min(part) < SMALLEST_SIDE:
        raise ImageError(f"image: {part[0]} rows x {part[1]} columns, allowed: {SMALLEST_SIDE} or more along each axis")
    level, cloud = source.clouds(Grid(*part, size))
    cloudy = np.count_nonzero(level)
    if cloudy == 0 or (cloudy == level.size and choice.method != "coverage"):
        what = "no pixel" if cloudy == 0 else "every pixel"
        raise ImageError(f"image: {what} of the part is cloud, which is {cloud}; allowed: another method or part")
    which = "the whole image" if part == shape else f"a part of {shape[0]} x {shape[1]}"
    if part != shape and choice.row_origin is None and choice.column_origin is None:
        which = f"the centre of {shape[0]} x {shape[1]}"
    notes = [f"{part[0]} rows x {part[1]} columns of {size:g} m: {which}.", f"Cloud is {cloud}."]
    if choice.pixel_size_m is None and source.is_nominal:
        notes.append("The pixel size is that at the sub-satellite point; pixels elsewhere are larger.")
    if source.pixel_size_m is not None and size != source.pixel_size_m:
        notes.append(f"Pixels of {source.pixel_size_m:.6g} m are treated as pixels of {size:g} m.")
    return Target(CloudImage(level, size), path.name, (*notes, *source.notes()))


@dataclass(frozen=True)
class _Source:
    """An image with its cloud mask, as one of the readers below finds it.

    Attributes
    ----------
    shape : tuple of int
        Rows and columns of the image.
    pixel_size_m : float or None
        None if the file states none; ``why`` is the reason.
    is_nominal : bool
        Whether the pixel size holds at the sub-satellite point only.
    clouds : callable
        Returns the grey levels of the chosen part, 0 where clear, and what the mask is.
    notes : callable
        Returns what the user should know of the image.
    """

    shape: tuple[int, ...]
    pixel_size_m: float | None
    is_nominal: bool
    clouds: Callable[[Grid], tuple[NDArray[np.float32], str]]
    notes: Callable[[], Iterable[str]]
    why: str = ""


def _entry(path: Path, choice: ImageChoice) -> _Source | None:
    """Read an entry of the cloud database with its cleaned mask; None if the file is none, or is damaged."""
    try:
        facts, shape = CloudEntry.read_facts(path)
    except CatalogError:
        return None
    usual = ImageChoice()
    given = [name for name in _OF_AN_IMAGE if getattr(choice, name) != getattr(usual, name)]
    if given:
        raise ImageError(f"{', '.join(given)}: has no meaning for an entry of the database; leave it out")
    clouds = partial(_generated, path, choice, "what the entry's mask has", {"entry": str(path.resolve())})
    notes = partial(_notes_of_plugins, path, choice.variable)
    return _Source(shape, facts.pixel_size_m, facts.pixel_size_is_nominal, clouds, notes)


_MASK, _THICKNESS = "cloud_mask", "cloud_thickness"


def _cube(path: Path, choice: ImageChoice) -> _Source | None:
    """Read the first frame of a cube's thickness with its mask; None if the file or the choice is another image."""
    if choice.method != "auto" or choice.variable not in (None, _THICKNESS):
        return None
    if path.suffix.lower() != ".zarr" and not Reading(path, CatalogError).is_netcdf:
        return None
    try:
        opened = open_cube(path)
    except CubeError:
        return None
    with opened:
        dataset = FrameSelection.as_seen(opened)
        if choice.cloud_is != "auto":
            raise ImageError("cloud_is: has no meaning for a cube, whose own cloud is used; leave it out")
        if _THICKNESS not in dataset:
            raise ImageError(
                f"{path}: the cube has no {_THICKNESS}; allowed: a cube with it (hcss run --set "
                f'\'output.variables=["{_MASK}", "{_THICKNESS}"]\'), or one of its images by --variable'
            )
        planes = {
            name: dataset[name].isel(time=0).transpose("y", "x").to_numpy()
            for name in (_THICKNESS, _MASK)
            if name in dataset
        }
        step_y, step_x = (
            float(dataset[axis][1] - dataset[axis][0])
            if dataset[axis].attrs.get("units") == "m" and dataset.sizes[axis] > 1
            else None
            for axis in ("y", "x")
        )
        frames = dataset.sizes["time"]
    thickness = planes[_THICKNESS].astype(np.float64)
    cloudy, stated = thickness > 0.0, f"its {_THICKNESS} is greater than 0"
    if _MASK in planes:
        cloudy, stated = planes[_MASK] == 1, f"its {_MASK} is 1"
    if not cloudy.any():
        raise ImageError(f"{path}: no pixel of the cube's first frame is cloudy; allowed: a cube with cloud")
    which = f"the first of the cube's {frames} frames" if frames > 1 else "the cube"
    cloud = f"every pixel of {which} where {stated}, with grey levels from its {_THICKNESS}"
    north_first, east_first = step_y is None or step_y < 0.0, step_x is not None and step_x < 0.0
    turn = slice(None, None, -1 if north_first else 1), slice(None, None, -1 if east_first else 1)
    level = np.where(cloudy, thickness, np.nan)[turn]
    clouds = partial(_masked, choice, level, (north_first, east_first), cloud)
    why = "" if "row" not in opened.dims else ", as pixels of a camera differ in size on the ground"
    return _Source(thickness.shape, None if step_x is None else abs(step_x), False, clouds, tuple, why)


def _image(path: Path, choice: ImageChoice) -> _Source:
    """Read any other image; a damaged entry is reported as such."""
    image = read_image(path, choice.variable, choice.at)
    method = choice.method
    if method == "auto":
        method = "valid" if image.has_values_in_cloud_only else "otsu"
    if method == "valid":
        level, turned = image.level(choice.cloud_is), (image.north_first, image.east_first)
        clouds = partial(_masked, choice, level, turned, "every pixel with a value")
    else:
        how = {
            "image": str(path.resolve()),
            "method": method,
            "variable": choice.variable,
            "at": dict(choice.at),
            "window_pixels": choice.window_pixels,
            "cloud_is": choice.cloud_is,
        }
        clouds = partial(_generated, path, choice, f"what the method '{method}' finds", how)

    def notes() -> Iterator[str]:
        yield from image.described(choice.cloud_is)
        yield from _notes_of_plugins(path, choice.variable)

    why = f" ({image.pixel_size_note})" if image.pixel_size_note else ""
    return _Source(image.values.shape, image.pixel_size_m, image.pixel_size_is_nominal, clouds, notes, why)


def _notes_of_plugins(path: Path, variable: str | None) -> Iterator[str]:
    """Yield what functions of the entry point group note on an image; a match does not need them."""
    for origin, notes, error in Registry.answers("hcss_twin.image_notes", path, variable):
        yield from (f"{origin} has no notes: {error}",) if error else notes


def _check(choice: ImageChoice) -> None:
    """Refuse options that contradict each other: none is ignored."""
    if (choice.coverage is None) is (choice.method == "coverage"):
        raise ImageError("coverage: needed with the method 'coverage', not allowed with others")
    if choice.window_pixels is not None and choice.method != "local":
        raise ImageError("window_pixels: allowed with the method 'local' only")


def _generated(
    path: Path, choice: ImageChoice, cloud: str, how: dict[str, Any], grid: Grid
) -> tuple[NDArray[np.float32], str]:
    """Return grey levels from the imagery generator, and the cloud with its note on missing pixels."""
    parameters = dict(
        **how,
        missing=choice.missing,
        row_origin=choice.row_origin,
        column_origin=choice.column_origin,
        reinterpret_pixel_size=choice.pixel_size_m is not None,
    )
    coverage = 0.5 if choice.coverage is None else choice.coverage
    registry = Registry.defaults_only()
    inputs = grey_inputs(coverage, grid.rows, grid.columns, grid.pixel_size_m, base=path.parent)
    clouds = registry.create(registry.resolve(Kind.CLOUDS, "imagery"), inputs, parameters)
    # Other attributes of the generator, coverage and motion, concern a scene and not a single image.
    cloud += "".join(f"; {note}" for note in clouds.declares.notes if "missing" in note).rstrip(".")
    return clouds.thickness_m(0.0, slice(0, grid.rows), slice(0, grid.columns)), cloud


def _masked(
    choice: ImageChoice, level: Array, turned: tuple[bool, bool], cloud: str, grid: Grid
) -> tuple[NDArray[np.float32], str]:
    """Return grey levels of cloudiness levels (rows northward, columns eastward) that are NaN where clear."""
    origins = (choice.row_origin, choice.column_origin)
    rows, columns = level.shape
    problems = ImageReading.Window.problems((rows, columns), grid, origins)
    if problems:
        raise ScenarioError(problems, origin="image")
    window = ImageReading.Window((rows, columns), grid, STILL, origins, turned)
    cloudy = ~np.isnan(level)
    grey = np.zeros(level.shape, dtype=np.float32)
    grey[cloudy] = SatelliteImage.Cloudy.thickness_of(
        SatelliteImage.Cloudy.relative_grey(level[cloudy], float(np.nanmin(level))), *LEVELS
    )
    return grey[window.at(0.0)].copy(), cloud
