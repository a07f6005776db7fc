"""The image that is to be matched."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from hcss_twin.clouds.database.entry import EntryFacts
from hcss_twin.clouds.database.entry_file import read_facts
from hcss_twin.clouds.imagery.generator import ImageryClouds
from hcss_twin.clouds.imagery.parameters import ImageryParameters
from hcss_twin.clouds.imagery.reader import read_image
from hcss_twin.errors import CatalogError, ImageError
from hcss_twin.evaluation.checks import SMALLEST_SIDE
from hcss_twin.matching.cloud_image import CloudImage, grey_inputs

# Larger images are cut to this many rows and columns unless told otherwise: the paper's frame.
LARGEST_SIDE = 800


@dataclass(frozen=True)
class ImageChoice:
    """Which part of an image is matched, and what in it is cloud.

    Attributes
    ----------
    variable, method, window_pixels, cloud_is, missing, row_origin, column_origin
        As the parameters of the imagery generator
        (:class:`hcss_twin.clouds.imagery.parameters.ImageryParameters`).
    coverage : float or None
        Fraction of cloudy pixels, for method ``coverage``.
    pixel_size_m : float or None
        Side of a pixel; needed where the file does not say.
    rows, columns : int or None
        Size of the part; default: the image's, at most 800.
    """

    variable: str | None = None
    method: str = "otsu"
    window_pixels: int | None = None
    cloud_is: str = "auto"
    missing: Literal["error", "clear"] = "error"
    row_origin: int | None = None
    column_origin: int | None = None
    coverage: float | None = None
    pixel_size_m: float | None = None
    rows: int | None = None
    columns: int | None = None


@dataclass(frozen=True)
class Target:
    """A cloud image and what was done to get it.

    Attributes
    ----------
    image : CloudImage
        The part that is matched.
    source : str
        Name of the file.
    notes : tuple of str
        Which part it is, how clouds were found, what is nominal or missing.
    """

    image: CloudImage
    source: str
    notes: tuple[str, ...]


def read_target(path: Path, choice: ImageChoice | None = None) -> Target:
    """Read an image with the generator of static scenes: its clouds are what would be simulated from it.

    Parameters
    ----------
    path : Path
        NetCDF (GOES ABI among them), GeoTIFF, picture, ``.npy`` or ``.npz``; or an entry of the cloud
        database, whose mask has been cleaned.
    choice : ImageChoice, optional
        Part and threshold.

    Raises
    ------
    CatalogError
        If the file is not a usable image.
    ImageError
        If it gives no pixel size and none is given, is too small, or has no cloud or no clear pixel
        where a threshold was to find some; or a threshold is given for an entry.
    ScenarioError
        If part and image do not fit, or pixels are missing.
    """
    choice = choice or ImageChoice()
    if (choice.coverage is None) is (choice.method == "coverage"):
        raise ImageError("coverage: goes with the method 'coverage', and only with it")
    shape, native_m, why, source = _about(path, choice)
    size = choice.pixel_size_m or native_m
    if size is None:
        raise ImageError(
            f"pixel_size: {path} does not give it{why}; allowed: a length, as --pixel-size '1 km'"
        )
    part = (choice.rows or min(shape[0], LARGEST_SIDE), choice.columns or min(shape[1], LARGEST_SIDE))
    if min(part) < SMALLEST_SIDE:
        raise ImageError(
            f"image: {part[0]} rows x {part[1]} columns, allowed: {SMALLEST_SIDE} or more along each axis"
        )
    parameters = ImageryParameters(
        **source,
        missing=choice.missing,
        row_origin=choice.row_origin,
        column_origin=choice.column_origin,
        reinterpret_pixel_size=choice.pixel_size_m is not None,
    )
    coverage = 0.5 if choice.coverage is None else choice.coverage
    clouds = ImageryClouds(grey_inputs(coverage, *part, size), parameters)
    level = clouds.thickness_m(0.0, slice(0, part[0]), slice(0, part[1]))
    cloudy = np.count_nonzero(level)
    if cloudy == 0 or (cloudy == level.size and choice.method != "coverage"):
        what = "no pixel" if cloudy == 0 else "every pixel"
        raise ImageError(
            f"image: {what} of the part is cloudy by the method '{choice.method}'; allowed: another method or part"
        )
    which = "the whole image" if part == shape else f"a part of {shape[0]} x {shape[1]}"
    if part != shape and choice.row_origin is None and choice.column_origin is None:
        which = f"the centre of {shape[0]} x {shape[1]}"
    notes = [f"{part[0]} rows x {part[1]} columns of {size:g} m: {which}."]
    # What the generator says about coverage and motion is about a scene and not about a picture.
    notes += [
        note
        for note in clouds.declares.notes
        if "nominal" in note or "taken for" in note or "missing" in note
    ]
    return Target(CloudImage(level, size), path.name, tuple(notes))


def _about(path: Path, choice: ImageChoice) -> tuple[tuple[int, int], float | None, str, dict[str, Any]]:
    """Return a file's size, pixel size, why that is unknown, and the parameters by which it is read."""
    usual = ImageChoice()
    how = {name: getattr(choice, name) for name in ("variable", "method", "window_pixels", "cloud_is")}
    entry = _entry_facts(path)
    if entry is not None:
        given = [name for name, value in how.items() if value != getattr(usual, name)]
        if given:
            raise ImageError(f"{', '.join(given)}: has no meaning for an entry of the database; leave it out")
        return entry[1], entry[0].pixel_size_m, "", {"entry": str(path.resolve())}
    image = read_image(path, choice.variable)
    rows, columns = image.values.shape
    why = f" ({image.pixel_size_note})" if image.pixel_size_note else ""
    return (rows, columns), image.pixel_size_m, why, {"image": str(path.resolve()), **how}


def _entry_facts(path: Path) -> tuple[EntryFacts, tuple[int, int]] | None:
    """Return what an entry of the cloud database says about itself; None for any other file."""
    try:
        return read_facts(path)
    except CatalogError:
        return None
