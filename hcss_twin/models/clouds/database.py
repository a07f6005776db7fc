"""The cloud database: clouds extracted from images, one NetCDF file per image.

An entry is a file of the format ``hcss-cloud-entry`` (NetCDF-4, CF-1.11): grey levels, mask and labels of the single
clouds, and their origin. A folder of such files is the database. ``hcss import`` writes entries, so that you can
inspect the clouds before a scenario uses them.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CatalogError
from hcss_twin.core.files import Writing, open_format
from hcss_twin.core.netcdf import NetcdfFile
from hcss_twin.core.reading import Reading

__all__ = ["CloudEntry"]

FORMAT, FORMAT_VERSION = "hcss-cloud-entry", 1

_CLEAR, _CLOUD, _MISSING = 0, 1, 2

_NOT_STATED = "not stated"

_YES_NO = {"yes": True, "no": False}

_LONG_NAMES = {
    "image": "image, cloud bright, 0 where missing: for display",
    "grey": "grey level of cloud: 0 clear, 1 to 255 from the threshold to the brightest cloud",
    "mask": "cloud mask",
    "label": "number of the single cloud; 0 is clear",
}


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
        The whole image for visual inspection, cloud bright; 0 where missing.
    facts : CloudEntry.Facts
        Source and processing.
    notes : tuple of str
        What the user should know when it is made; not in the file.
    FOLDER, SUFFIX : str
        Name of the folder of entries in the catalog, next to a scenario, and in the output of ``hcss import``; suffix
        of their files.
    NOT_STATED : str
        Text for facts that neither the image nor the user gives.
    """

    FOLDER: ClassVar = "clouds"
    SUFFIX: ClassVar = ".nc"
    NOT_STATED: ClassVar = _NOT_STATED

    @dataclass(frozen=True)
    class Facts:
        """Source and processing of an entry; each fact is an attribute of its file.

        Attributes
        ----------
        source_file, source_sha256 : str
            Name of the image file, with the part of it that was imported, and hash of the file.
        variable, band, observed, source, licence : str
            Plane of the file, spectral band, time of observation, origin, and terms of use.
        pixel_size_m : float
            Side of a pixel on the ground.
        pixel_size_is_nominal : bool
            True if it applies only at the sub-satellite point of a geostationary satellite; others are larger.
        pixel_size_from : str
            ``file``, ``user``, or ``sample``: the catalog's description of a measured sample.
        units, cloud_is : str
            Units of the image's values, and whether ``bright`` or ``dark`` ones are cloud.
        method : str
            Threshold method.
        window_pixels : int
            Side of the averaging window of method ``local``; 0 for the others.
        threshold_lowest, threshold_highest : float
            Thresholds in image units; they differ only for method ``local``. Lowest means least cloudy.
        closing, opening, largest_hole, min_area : int
            Parameters of the mask cleaning in pixels (:class:`hcss_evaluate.database.segmentation.Cleaning`).
        holes_filled, hole_pixels, clouds_dropped : int
            Number of changes made by the cleaning.
        coverage : float
            Fraction of cloudy pixels.
        clouds : int
            Number of single clouds.
        missing_pixels : int
            Pixels without a value.
        fractal_dimension, fractal_dimension_error : float
            Of the image values in the cloudy pixels, and its standard error; NaN if unknown.
        box_counting_dimension, box_counting_error : float
            Of the grey levels of the whole scene, with clear sky as 0.
        fractal_dimension_method, box_counting_method : str
            Method of each estimate, or why there is none.
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
        fractal_dimension_method: str = _NOT_STATED
        box_counting_dimension: float = math.nan
        box_counting_error: float = math.nan
        box_counting_method: str = _NOT_STATED
        created: str = _NOT_STATED
        created_with: str = _NOT_STATED

    grey: NDArray[np.uint8]
    labels: NDArray[np.int32]
    missing: NDArray[np.bool_]
    image: NDArray[np.uint8]
    facts: CloudEntry.Facts
    notes: tuple[str, ...] = ()

    @property
    def mask(self) -> NDArray[np.bool_]:
        """Cloudy pixels (rows, columns)."""
        return self.labels > 0

    def write(self, path: Path) -> None:
        """Write the entry; an interrupted write leaves ``path`` unchanged.

        Raises
        ------
        CatalogError
            If the file cannot be written.
        """
        mask = np.where(self.mask, _CLOUD, np.where(self.missing, _MISSING, _CLEAR)).astype(np.int8)
        planes: dict[str, NDArray[Any]] = {"image": self.image, "grey": self.grey, "mask": mask, "label": self.labels}
        with Writing(path, CatalogError, "NetCDF") as draft, NetcdfFile(draft, "w") as file:
            file.setncatts({"Conventions": "CF-1.11", "format": FORMAT, "format_version": np.int32(FORMAT_VERSION)})
            file.setncatts({name: _attribute(value) for name, value in dataclasses.asdict(self.facts).items()})
            rows, columns = self.grey.shape
            size = self.facts.pixel_size_m
            for axis, count, positions, direction in (
                ("y", rows, (rows - 0.5 - np.arange(rows)) * size, "north"),
                ("x", columns, (np.arange(columns) + 0.5) * size, "east"),
            ):
                file.createDimension(axis, count)
                coordinate = file.createVariable(axis, "f8", (axis,))
                coordinate.setncatts(
                    {"standard_name": f"projection_{axis}_coordinate", "long_name": f"distance to the {direction}"}
                )
                coordinate.setncatts({"units": "m", "axis": axis.upper()})
                coordinate[:] = positions
            for name, values in planes.items():
                variable = file.createVariable(
                    name, values.dtype, ("y", "x"), compression="zlib", shuffle=True, fill_value=False
                )
                variable.setncatts({"long_name": _LONG_NAMES[name], "units": "1"})
                if name == "mask":
                    flags = np.array([_CLEAR, _CLOUD, _MISSING], dtype=np.int8)
                    variable.setncatts({"flag_values": flags, "flag_meanings": "clear cloud missing"})
                    del variable.units
                variable[:] = values

    @staticmethod
    @Reading.argument(CatalogError)
    def read(path: Path) -> CloudEntry:
        """Read an entry and check that its variables agree with each other.

        Raises
        ------
        CatalogError
            If the file is not in this format, or its variables contradict each other.
        """
        with open_format(path, FORMAT, FORMAT_VERSION) as file:
            facts = _facts(path, file)
            with Reading(path, CatalogError, "damaged or incomplete entry"):
                planes = {name: np.ma.getdata(file.variables[name][...]) for name in _LONG_NAMES}
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

    @staticmethod
    @Reading.argument(CatalogError)
    def read_facts(path: Path) -> tuple[CloudEntry.Facts, tuple[int, int]]:
        """Return the facts of an entry and its (rows, columns), without reading its planes.

        Raises
        ------
        CatalogError
            If the file is not in this format.
        """
        with open_format(path, FORMAT, FORMAT_VERSION) as file:
            facts = _facts(path, file)
            with Reading(path, CatalogError, "damaged or incomplete entry"):
                return facts, (file.dimensions["y"].size, file.dimensions["x"].size)


def _attribute(value: Any) -> Any:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return np.int32(value) if isinstance(value, int) else value


def _facts(path: Path, file: Any) -> CloudEntry.Facts:
    parse: dict[str, Callable[[Any], Any]] = {"str": str, "float": float, "int": int, "bool": _YES_NO.__getitem__}
    values: dict[str, Any] = {}
    for field in dataclasses.fields(CloudEntry.Facts):
        try:
            values[field.name] = parse[str(field.type)](getattr(file, field.name))
        except (AttributeError, ValueError, TypeError, KeyError) as error:
            raise CatalogError(f"{path}: attribute '{field.name}' is missing or malformed: {error}") from error
    facts = CloudEntry.Facts(**values)
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
    shapes = {plane.shape for plane in (entry.grey, entry.labels, entry.image, mask)}
    if len(shapes) != 1:
        raise CatalogError(f"{path}: variables of different shapes: {sorted(shapes)}")
    numbers = np.unique(entry.labels)
    if not np.array_equal(numbers[numbers != 0], np.arange(1, entry.facts.clouds + 1)):
        raise CatalogError(
            f"{path}: label: {np.count_nonzero(numbers)} clouds from {numbers.min()} to {numbers.max()}; allowed: "
            f"each number from 1 to {entry.facts.clouds}"
        )
    for name, cloudy in (("grey", entry.grey > 0), ("mask", mask == _CLOUD)):
        if not np.array_equal(cloudy, entry.mask):
            count = int(np.count_nonzero(cloudy != entry.mask))
            raise CatalogError(f"{path}: {name} and label disagree about cloud in {count} pixels")
