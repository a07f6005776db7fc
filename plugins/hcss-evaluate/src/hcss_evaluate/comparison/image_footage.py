"""Open the files of a comparison: an image, several images of one scene, or a cube."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path

import numpy as np

from hcss_evaluate.comparison.footage import EvaluationChoice, Footage, Method, is_kelvin
from hcss_evaluate.errors import ImageOptionError
from hcss_twin.core.reading import Reading
from hcss_twin.models.clouds.imagery.image import SatelliteImage
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.providers import Array, CatalogError, CubeError, ImageError, NetcdfFile

_WAVELENGTH = re.compile(r"([0-9.]+) um")


def open_images(paths: Sequence[Path], choice: EvaluationChoice) -> Footage:
    """Read one image, or the images of a sequence in the given order.

    Raises
    ------
    CatalogError
        If a file is not a usable image.
    ImageError
        If an option applies to cubes only, or images differ in shape, unit or pixel size.
    """
    for name, given in (("band", choice.band), ("frames", choice.frames)):
        if given:
            raise ImageOptionError(
                f"{name}: applies to cubes only, and {paths[0].name} is an image; leave it out"
                + ("; planes of a file are chosen with variable" if name == "band" else "")
            )
    if choice.method == "truth":
        raise ImageOptionError(f"method 'truth': {paths[0].name} is an image and has no mask; allowed: another method")
    images = [read_image(path, choice.variable) for path in paths]
    first = images[0]
    for path, image in zip(paths[1:], images[1:], strict=True):
        _require_alike(paths[0], first, path, image)
    notes = list(first.described(choice.cloud_is))
    notes += [f"{path.name}: {note}" for path, image in zip(paths[1:], images[1:], strict=True) for note in image.notes]
    size = choice.pixel_size_m or first.pixel_size_m
    if choice.pixel_size_m and first.pixel_size_m and choice.pixel_size_m != first.pixel_size_m:
        notes.append(f"Pixels of {first.pixel_size_m:.6g} m are treated as pixels of {choice.pixel_size_m:g} m.")
    elif size is not None and first.pixel_size_is_nominal and choice.pixel_size_m is None:
        notes.append("The pixel size is that at the sub-satellite point; pixels elsewhere are larger.")
    elif size is None:
        notes.append(f"The file gives no pixel size{': ' + first.pixel_size_note if first.pixel_size_note else ''}.")
    coefficients = first.planck
    kelvin: Callable[[Array], Array] | None = coefficients.kelvin if coefficients is not None else None
    if is_kelvin(first.units):
        kelvin = np.asarray
    match = _WAVELENGTH.search(first.band)
    turned = [_northward(image) for image in images]
    return Footage(
        name=paths[0].name if len(paths) == 1 else f"{paths[0].name} and {len(paths) - 1} more",
        kind="image" if len(paths) == 1 else "images",
        quantity=first.long_name.replace("_", " ") or "grey level",
        units=first.units,
        band=first.band,
        wavelength_um=float(match[1]) if match else None,
        shape=(first.values.shape[0], first.values.shape[1]),
        pixel_size_m=size,
        is_nominal=first.pixel_size_is_nominal and choice.pixel_size_m is None,
        labels=tuple(image.date or path.name for path, image in zip(paths, images, strict=True)),
        seconds=_seconds(images),
        bright_is_cloud=first.cloud_is_bright(choice.cloud_is),
        method=_method(choice, first),
        notes=tuple(notes),
        values=lambda number: turned[number],
        truth=None,
        kelvin=kelvin,
    )


def _method(choice: EvaluationChoice, image: SatelliteImage) -> Method:
    if choice.method != "auto":
        return choice.method
    return "valid" if image.has_values_in_cloud_only else "otsu"


def _northward(image: SatelliteImage) -> Array:
    return np.ascontiguousarray(image.north_and_east_last)


def _require_alike(first_path: Path, first: SatelliteImage, path: Path, image: SatelliteImage) -> None:
    """Reject a sequence whose images differ in shape, unit or pixel size."""
    for what, one, other in (
        ("shape", first.values.shape, image.values.shape),
        ("unit", first.units, image.units),
        ("band", first.band, image.band),
        ("pixel size", first.pixel_size_m, image.pixel_size_m),
    ):
        if one != other:
            raise ImageError(
                f"{path}: {what} {other!r}, while {first_path.name} has {one!r}; allowed: images of one sequence"
            )


def _seconds(images: Sequence[SatelliteImage]) -> tuple[float, ...] | None:
    """Return times relative to the first image; None if a file has no time or the times do not ascend."""
    try:
        times = [datetime.fromisoformat(image.date) for image in images]
    except ValueError:
        return None
    aware = [time if time.tzinfo else time.replace(tzinfo=UTC) for time in times]
    seconds = [(time - aware[0]).total_seconds() for time in aware]
    return tuple(seconds) if all(b > a for a, b in pairwise(seconds)) else None


def open_footage(
    title: str,
    source: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    choice: EvaluationChoice,
    stack: ExitStack,
    like: Footage | None,
) -> Footage:
    """Open an image, several images or a cube; ``stack`` closes the cube.

    ``title`` (REAL or SIM) is used in messages; ``like`` is the other side. Raises CatalogError if the file does not
    exist or is not a usable image, CubeError if a cube cannot be read or lacks the requested data, and ImageError if an
    option does not apply to the file.
    """
    choice.check()
    paths = [Path(source)] if isinstance(source, str | os.PathLike) else [Path(path) for path in source]
    if not paths:
        raise ImageError(f"{title}: no file given, allowed: one or more")
    cubes = [path for path in paths if is_cube(path)]
    if cubes and len(paths) > 1:
        raise ImageError(f"{title}: {cubes[0]} is a cube; allowed: one cube, or several images")
    if not cubes:
        for path in paths:
            if path.is_dir():
                raise CatalogError(f"{title}: {path} is a folder; allowed: an image, or a cube")
        try:
            return open_images(paths, choice)
        except SatelliteImage.SeveralImagesError as error:
            raise error.chosen_with(f"variable (--{title.lower()}-variable)") from error
    from hcss_evaluate.comparison.cube_footage import cube_footage
    from hcss_twin import open_cube

    with Reading(paths[0], CubeError):
        return cube_footage(title, stack.enter_context(open_cube(paths[0])), paths[0], choice, like)


def is_cube(path: Path) -> bool:
    """Whether a file is a cube of this package, complete or not."""
    if path.suffix.lower() == ".zarr" and path.is_dir():
        return True
    if not path.is_file() or not Reading(path, CatalogError).is_netcdf:
        return False
    with suppress(Exception), Reading.quiet(), NetcdfFile(path) as dataset:  # a damaged file of any kind
        return "hcss_cube_format" in dataset.ncattrs()
    return False
