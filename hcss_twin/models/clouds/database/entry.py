"""One entry of the cloud database in memory.

The file of a database entry: format ``hcss-cloud-entry``, NetCDF-4 after CF-1.11.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CatalogError
from hcss_twin.core.files import atomic_write, open_format

NOT_STATED = "not stated"
"""What stands where neither the image nor the user says anything."""


@dataclass(frozen=True)
class EntryFacts:
    """Where an entry comes from and how it was made; each is an attribute of its file.

    Attributes
    ----------
    source_file, source_sha256 : str
        Name and hash of the image file.
    variable, band, observed, source, licence : str
        Plane of the file, spectral band, time of observation, origin, and terms of use.
    pixel_size_m : float
        Side of a pixel on the ground.
    pixel_size_is_nominal : bool
        Whether it is that below a geostationary satellite; elsewhere pixels are larger.
    pixel_size_from : str
        ``file`` or ``user``.
    units, cloud_is : str
        Units of the image's values, and whether ``bright`` or ``dark`` ones are cloud.
    method : str
        Threshold method.
    window_pixels : int
        Side of the surroundings of method ``local``; 0 for the others.
    threshold_lowest, threshold_highest : float
        Thresholds in the image's units; they differ for method ``local`` only. Lowest means least cloudy.
    closing, opening, largest_hole, min_area : int
        Sizes of the cleaning in pixels (:class:`hcss_twin.models.clouds.database.segmentation.Cleaning`).
    holes_filled, hole_pixels, clouds_dropped : int
        What the cleaning did.
    coverage : float
        Fraction of cloudy pixels.
    clouds : int
        Number of single clouds.
    missing_pixels : int
        Pixels without a value.
    fractal_dimension, fractal_dimension_error : float
        Of the image's values in the cloudy pixels, and its standard error; NaN where not known.
    fractal_dimension_method : str
        How it was estimated, or why it was not.
    box_counting_dimension, box_counting_error : float
        Of the grey levels of the whole scene, clear sky being 0.
    box_counting_method : str
        How it was estimated, or why it was not.
    created, created_with : str
        Time of the import, and version of this package.
    """

    source_file: str
    source_sha256: str
    variable: str
    band: str
    observed: str
    source: str
    licence: str
    pixel_size_m: float
    pixel_size_is_nominal: bool
    pixel_size_from: str
    units: str
    cloud_is: str
    method: str
    window_pixels: int
    threshold_lowest: float
    threshold_highest: float
    closing: int
    opening: int
    largest_hole: int
    min_area: int
    holes_filled: int
    hole_pixels: int
    clouds_dropped: int
    coverage: float
    clouds: int
    missing_pixels: int
    fractal_dimension: float = math.nan
    fractal_dimension_error: float = math.nan
    fractal_dimension_method: str = NOT_STATED
    box_counting_dimension: float = math.nan
    box_counting_error: float = math.nan
    box_counting_method: str = NOT_STATED
    created: str = NOT_STATED
    created_with: str = NOT_STATED


@dataclass(frozen=True)
class CloudEntry:
    """Clouds of one image, north in the first row and west in the first column.

    Attributes
    ----------
    grey : ndarray of uint8 (rows, columns)
        0 clear, 1 to 255 from the threshold to the brightest cloud.
    labels : ndarray of int32 (rows, columns)
        0 clear, else the number of the single cloud, from 1.
    missing : ndarray of bool (rows, columns)
        Where the image has no value.
    image : ndarray of uint8 (rows, columns)
        The whole image for people to look at, cloud bright; 0 where missing.
    facts : EntryFacts
        Everything else.
    """

    grey: NDArray[np.uint8]
    labels: NDArray[np.int32]
    missing: NDArray[np.bool_]
    image: NDArray[np.uint8]
    facts: EntryFacts

    @property
    def mask(self) -> NDArray[np.bool_]:
        """Cloudy pixels (rows, columns)."""
        return self.labels > 0


FORMAT = "hcss-cloud-entry"
FORMAT_VERSION = 1

_CLEAR, _CLOUD, _MISSING = 0, 1, 2

_YES_NO = {"yes": True, "no": False}

_MEANINGS = {
    "image": "image, cloud bright, 0 where missing: for people to look at",
    "grey": "grey level of cloud: 0 clear, 1 to 255 from the threshold to the brightest cloud",
    "mask": "cloud mask",
    "label": "number of the single cloud; 0 is clear",
}


def write_entry(path: Path, entry: CloudEntry) -> None:
    """Write an entry; whatever happens, ``path`` holds a whole file or what it held before.

    Raises
    ------
    CatalogError
        If the file cannot be written.
    """
    import netCDF4

    mask = np.where(entry.mask, _CLOUD, np.where(entry.missing, _MISSING, _CLEAR)).astype(np.int8)
    planes: dict[str, NDArray[Any]] = {"image": entry.image, "grey": entry.grey, "mask": mask, "label": entry.labels}
    create: Callable[..., Any] = netCDF4.Dataset
    with atomic_write(path, CatalogError) as draft, create(draft, "w", format="NETCDF4") as file:
        file.setncatts({"Conventions": "CF-1.11", "format": FORMAT, "format_version": np.int32(FORMAT_VERSION)})
        file.setncatts({name: _stored(value) for name, value in dataclasses.asdict(entry.facts).items()})
        rows, columns = entry.grey.shape
        size = entry.facts.pixel_size_m
        for axis, count, positions, where in (
            ("y", rows, (rows - 0.5 - np.arange(rows)) * size, "north"),
            ("x", columns, (np.arange(columns) + 0.5) * size, "east"),
        ):
            file.createDimension(axis, count)
            coordinate = file.createVariable(axis, "f8", (axis,))
            coordinate.setncatts(
                {"standard_name": f"projection_{axis}_coordinate", "long_name": f"distance to the {where}"}
            )
            coordinate.setncatts({"units": "m", "axis": axis.upper()})
            coordinate[:] = positions
        for name, values in planes.items():
            variable = file.createVariable(
                name, values.dtype, ("y", "x"), compression="zlib", shuffle=True, fill_value=False
            )
            variable.setncatts({"long_name": _MEANINGS[name], "units": "1"})
            if name == "mask":
                flags = np.array([_CLEAR, _CLOUD, _MISSING], dtype=np.int8)
                variable.setncatts({"flag_values": flags, "flag_meanings": "clear cloud missing"})
                del variable.units
            variable[:] = values


def read_entry(path: Path) -> CloudEntry:
    """Read an entry and check that its parts agree.

    Raises
    ------
    CatalogError
        If the file is not of this format, or its content contradicts itself.
    """
    with open_format(path, FORMAT, FORMAT_VERSION) as file:
        facts = _facts(path, file)
        try:
            planes = {name: np.ma.getdata(file.variables[name][...]) for name in _MEANINGS}
        except (KeyError, OSError, RuntimeError) as error:
            raise CatalogError(f"{path}: damaged or incomplete entry: {error}") from error
    mask = planes["mask"]
    entry = CloudEntry(
        grey=_typed(path, "grey", planes["grey"], np.uint8),
        labels=_typed(path, "label", planes["label"], np.int32),
        missing=np.asarray(mask == _MISSING),
        image=_typed(path, "image", planes["image"], np.uint8),
        facts=facts,
    )
    _check(path, entry, mask)
    return entry


def read_facts(path: Path) -> tuple[EntryFacts, tuple[int, int]]:
    """Return what an entry says about itself, and its (rows, columns), without reading its planes.

    Raises
    ------
    CatalogError
        If the file is not of this format.
    """
    with open_format(path, FORMAT, FORMAT_VERSION) as file:
        facts = _facts(path, file)
        try:
            return facts, (file.dimensions["y"].size, file.dimensions["x"].size)
        except KeyError as error:
            raise CatalogError(f"{path}: damaged or incomplete entry: no dimension {error}") from error


def _stored(value: Any) -> Any:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return np.int32(value) if isinstance(value, int) else value


def _facts(path: Path, file: Any) -> EntryFacts:
    kinds: dict[str, Callable[[Any], Any]] = {"str": str, "float": float, "int": int, "bool": _YES_NO.__getitem__}
    values: dict[str, Any] = {}
    for field in dataclasses.fields(EntryFacts):
        try:
            values[field.name] = kinds[str(field.type)](getattr(file, field.name))
        except (AttributeError, ValueError, TypeError, KeyError) as error:
            raise CatalogError(f"{path}: attribute '{field.name}' is missing or malformed: {error}") from error
    facts = EntryFacts(**values)
    if not 0.0 < facts.pixel_size_m < np.inf:
        raise CatalogError(f"{path}: pixel_size_m: {facts.pixel_size_m} given, allowed: greater than 0")
    return facts


def _typed(path: Path, name: str, values: NDArray[Any], dtype: type[Any]) -> NDArray[Any]:
    if values.dtype != dtype or values.ndim != 2:
        raise CatalogError(
            f"{path}: '{name}' is {values.dtype} with shape {values.shape}; allowed: {np.dtype(dtype)}, (rows, columns)"
        )
    return values


def _check(path: Path, entry: CloudEntry, mask: NDArray[Any]) -> None:
    """Refuse an entry whose variables contradict each other."""
    shapes = {plane.shape for plane in (entry.grey, entry.labels, entry.image, mask)}
    if len(shapes) != 1:
        raise CatalogError(f"{path}: variables of different shapes: {sorted(shapes)}")
    found = np.unique(entry.labels)
    if not np.array_equal(found[found != 0], np.arange(1, entry.facts.clouds + 1)):
        raise CatalogError(
            f"{path}: label: {np.count_nonzero(found)} clouds from {found.min()} to {found.max()}; allowed: "
            f"each number from 1 to {entry.facts.clouds}"
        )
    for name, cloudy in (("grey", entry.grey > 0), ("mask", mask == _CLOUD)):
        if not np.array_equal(cloudy, entry.mask):
            count = int(np.count_nonzero(cloudy != entry.mask))
            raise CatalogError(f"{path}: {name} and label disagree about cloud in {count} pixels")
