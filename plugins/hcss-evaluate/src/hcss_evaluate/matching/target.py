"""The image to match: the clouds that the imagery generator would make from a file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.matching.structure import LEVELS, STILL, CloudImage, grey_inputs
from hcss_twin.core.arguments import checked
from hcss_twin.core.errors import CatalogError, CubeError, ImageError, ScenarioError
from hcss_twin.core.images import SMALLEST_SIDE
from hcss_twin.core.netcdf import NETCDF
from hcss_twin.core.plugins import FAILURES, describe, installed
from hcss_twin.core.reading import first_bytes
from hcss_twin.cube.reader import open_cube
from hcss_twin.models.clouds.database import read_facts
from hcss_twin.models.clouds.imagery.cloudiness import (
    CloudIs,
    cloudiness_level,
    described,
    has_values_in_cloud_only,
    relative_grey,
    thickness_of,
)
from hcss_twin.models.clouds.imagery.generator import ImageryClouds
from hcss_twin.models.clouds.imagery.image import SatelliteImage
from hcss_twin.models.clouds.imagery.parameters import ImageryParameters
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.models.clouds.imagery.whole_scene import MovingWindow, position_problems
from hcss_twin.providers import Grid

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
    variable, window_pixels, cloud_is, missing, row_origin, column_origin
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
    method: Method = "auto"
    window_pixels: int | None = None
    cloud_is: CloudIs = "auto"
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
    source = _open(path, choice)
    shape = source.shape
    size = choice.pixel_size_m or source.pixel_size_m
    if size is None:
        raise ImageError(f"pixel_size: not in {path}{source.why}; allowed: a length, for example --pixel-size '1 km'")
    part = (choice.rows or min(shape[0], LARGEST_SIDE), choice.columns or min(shape[1], LARGEST_SIDE))
    if min(part) < SMALLEST_SIDE:
        raise ImageError(f"image: {part[0]} rows x {part[1]} columns, allowed: {SMALLEST_SIDE} or more along each axis")
    grid = Grid(*part, size)
    method = _method(choice, source)
    if source.image is not None and method == "valid":
        level = _valid_level(source.image, choice, grid)
        how = source.cube_note or "every pixel with a value"
    else:
        level, how = _imagery_level(path, choice, grid, method, source.image is None)
    cloudy = np.count_nonzero(level)
    if cloudy == 0 or (cloudy == level.size and method != "coverage"):
        what = "no pixel" if cloudy == 0 else "every pixel"
        raise ImageError(
            f"image: {what} of the part is cloudy by the method '{method}'; allowed: another method or part"
        )
    which = "the whole image" if part == shape else f"a part of {shape[0]} x {shape[1]}"
    if part != shape and choice.row_origin is None and choice.column_origin is None:
        which = f"the centre of {shape[0]} x {shape[1]}"
    notes = [f"{part[0]} rows x {part[1]} columns of {size:g} m: {which}.", f"Cloud is {how}."]
    if choice.pixel_size_m is None and source.is_nominal:
        notes.append("The pixel size is that at the sub-satellite point; pixels elsewhere are larger.")
    if source.pixel_size_m is not None and size != source.pixel_size_m:
        notes.append(f"Pixels of {source.pixel_size_m:.6g} m are treated as pixels of {size:g} m.")
    if source.image is not None and not source.cube_note:
        notes += described(source.image, choice.cloud_is)
    of_plugins = () if source.cube_note else _notes_of_plugins(path, choice.variable)
    return Target(CloudImage(level, size), path.name, (*notes, *of_plugins))


def _notes_of_plugins(path: Path, variable: str | None) -> Iterator[str]:
    """Yield what functions of the entry point group note on an image; a match does not need them."""
    for origin, entry_point in installed("hcss_twin.image_notes"):
        try:
            if isinstance(entry_point, BaseException):
                raise entry_point
            yield from entry_point.load()(path, variable)
        except FAILURES as error:
            yield f"{origin} has no notes: {describe(error)}"


@dataclass(frozen=True)
class _ImageFacts:
    """Metadata of a file; ``image`` is None for an entry, ``why`` is the reason for a missing pixel size.

    ``cube_note`` says which variables of a cube are used; empty for other images.
    """

    shape: tuple[int, ...]
    pixel_size_m: float | None
    is_nominal: bool
    why: str
    image: SatelliteImage | None
    cube_note: str = ""


def _open(path: Path, choice: ImageChoice) -> _ImageFacts:
    try:
        facts, shape = read_facts(path)
    except CatalogError:
        if choice.method == "auto" and choice.variable in (None, _THICKNESS):
            cube = _cube_clouds(path)
            if cube is not None:
                if choice.cloud_is != "auto":
                    raise ImageError(
                        "cloud_is: has no meaning for a cube, whose own cloud is used; leave it out"
                    ) from None
                return cube
        # Any other image. If it is an invalid entry, the reader reports what is wrong.
        image = read_image(path, choice.variable)
        why = f" ({image.pixel_size_note})" if image.pixel_size_note else ""
        return _ImageFacts(image.values.shape, image.pixel_size_m, image.pixel_size_is_nominal, why, image)
    usual = ImageChoice()
    given = [name for name in _OF_AN_IMAGE if getattr(choice, name) != getattr(usual, name)]
    if given:
        raise ImageError(f"{', '.join(given)}: has no meaning for an entry of the database; leave it out")
    return _ImageFacts(shape, facts.pixel_size_m, facts.pixel_size_is_nominal, "", None)


_MASK, _THICKNESS = "cloud_mask", "cloud_thickness"


def _cube_clouds(path: Path) -> _ImageFacts | None:
    """Return the first frame of a cube's thickness where its mask has cloud; None if the file is no cube."""
    if not first_bytes(path, CatalogError).startswith(NETCDF):
        return None
    try:
        dataset = open_cube(path)
    except CubeError:
        return None
    with dataset:
        if _THICKNESS not in dataset:
            raise ImageError(
                f"{path}: the cube has no {_THICKNESS}; allowed: a cube with it (hcss run --set "
                f'\'output.variables=["{_MASK}", "{_THICKNESS}"]\'), or one of its images by --variable'
            )
        thickness = dataset[_THICKNESS].isel(time=0).transpose("y", "x")
        values = thickness.to_numpy().astype(np.float64)
        cloudy, said = values > 0.0, f"its {_THICKNESS} is greater than 0"
        if _MASK in dataset:
            cloudy, said = dataset[_MASK].isel(time=0).transpose("y", "x").to_numpy() == 1, f"its {_MASK} is 1"
        steps = [
            float(dataset[axis][1] - dataset[axis][0]) if axis in dataset.coords and dataset.sizes[axis] > 1 else None
            for axis in ("y", "x")
        ]
        frames = dataset.sizes["time"]
    if not cloudy.any():
        raise ImageError(f"{path}: no pixel of the cube's first frame is cloudy; allowed: a cube with cloud")
    which = f"the first of the cube's {frames} frames" if frames > 1 else "the cube"
    image = SatelliteImage(
        np.where(cloudy, values, np.nan),
        None if steps[1] is None else abs(steps[1]),
        True,
        "m",
        "geometric thickness of the cloud",
        path.name,
        north_first=steps[0] is None or steps[0] < 0.0,
        east_first=steps[1] is not None and steps[1] < 0.0,
        variable=_THICKNESS,
    )
    note = f"every pixel of {which} where {said}, with grey levels from its {_THICKNESS}"
    return _ImageFacts(values.shape, image.pixel_size_m, False, "", image, note)


def _check(choice: ImageChoice) -> None:
    """Refuse options that contradict each other: none is ignored."""
    if (choice.coverage is None) is (choice.method == "coverage"):
        raise ImageError("coverage: needed with the method 'coverage', not allowed with others")
    if choice.window_pixels is not None and choice.method != "local":
        raise ImageError("window_pixels: allowed with the method 'local' only")


def _method(choice: ImageChoice, source: _ImageFacts) -> Literal["otsu", "local", "coverage", "valid"]:
    if choice.method != "auto":
        return choice.method
    image = source.image
    return "valid" if image is not None and (source.cube_note or has_values_in_cloud_only(image)) else "otsu"


def _imagery_level(
    path: Path, choice: ImageChoice, grid: Grid, method: str, is_entry: bool
) -> tuple[NDArray[np.float32], str]:
    """Return grey levels and a description of the cloud mask from the imagery generator."""
    how: dict[str, Any] = {"entry": str(path.resolve())}
    said = "what the entry's mask has"
    if not is_entry:
        how = {
            "image": str(path.resolve()),
            "method": method,
            "variable": choice.variable,
            "window_pixels": choice.window_pixels,
            "cloud_is": choice.cloud_is,
        }
        said = f"what the method '{method}' finds"
    parameters = ImageryParameters(
        **how,
        missing=choice.missing,
        row_origin=choice.row_origin,
        column_origin=choice.column_origin,
        reinterpret_pixel_size=choice.pixel_size_m is not None,
    )
    coverage = 0.5 if choice.coverage is None else choice.coverage
    clouds = ImageryClouds(
        grey_inputs(coverage, grid.rows, grid.columns, grid.pixel_size_m, base=path.parent), parameters
    )
    # Other attributes of the generator, coverage and motion, concern a scene and not a single image.
    said += "".join(f"; {note}" for note in clouds.declares.notes if "missing" in note).rstrip(".")
    return clouds.thickness_m(0.0, slice(0, grid.rows), slice(0, grid.columns)), said


def _valid_level(image: SatelliteImage, choice: ImageChoice, grid: Grid) -> NDArray[np.float32]:
    """Return grey levels of an image in which every pixel with a value is cloud."""
    origins = (choice.row_origin, choice.column_origin)
    rows, columns = image.values.shape
    problems = position_problems((rows, columns), grid, origins)
    if problems:
        raise ScenarioError(problems, origin="image")
    turned = (image.north_first, image.east_first)
    window = MovingWindow((rows, columns), grid, STILL, origins, turned)
    level = cloudiness_level(image, choice.cloud_is)
    relative = relative_grey(level[~np.isnan(level)], float(np.nanmin(level)))
    grey = np.zeros(level.shape, dtype=np.float32)
    grey[~np.isnan(level)] = thickness_of(relative, *LEVELS)
    return grey[window.at(0.0)].copy()
