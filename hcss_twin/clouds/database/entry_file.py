"""The file of a database entry: format ``hcss-cloud-entry``, NetCDF-4 after CF-1.11."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.clouds.database.entry import CloudEntry, EntryFacts
from hcss_twin.drafts import draft_of
from hcss_twin.errors import CatalogError
from hcss_twin.netcdf_format import open_format

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
    planes: dict[str, NDArray[Any]] = {
        "image": entry.image,
        "grey": entry.grey,
        "mask": mask,
        "label": entry.labels,
    }
    create: Callable[..., Any] = netCDF4.Dataset
    with draft_of(path, CatalogError) as draft, create(draft, "w", format="NETCDF4") as file:
        file.setncatts(
            {"Conventions": "CF-1.11", "format": FORMAT, "format_version": np.int32(FORMAT_VERSION)}
        )
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
    kinds: dict[str, Callable[[Any], Any]] = {
        "str": str,
        "float": float,
        "int": int,
        "bool": _YES_NO.__getitem__,
    }
    values: dict[str, Any] = {}
    for field in dataclasses.fields(EntryFacts):
        try:
            values[field.name] = kinds[str(field.type)](getattr(file, field.name))
        except (AttributeError, ValueError, TypeError, KeyError) as error:
            raise CatalogError(
                f"{path}: attribute '{field.name}' is missing or malformed: {error}"
            ) from error
    facts = EntryFacts(**values)
    if not 0.0 < facts.pixel_size_m < np.inf:
        raise CatalogError(f"{path}: pixel_size_m: {facts.pixel_size_m} given, allowed: greater than 0")
    return facts


def _typed(path: Path, name: str, values: NDArray[Any], dtype: type[Any]) -> NDArray[Any]:
    if values.dtype != dtype or values.ndim != 2:
        raise CatalogError(
            f"{path}: '{name}' is {values.dtype} with shape {values.shape}; allowed: "
            f"{np.dtype(dtype)}, (rows, columns)"
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
