"""Read a satellite image: one plane of numbers, its pixel size, and whether cloud is bright in it."""

from __future__ import annotations

import warnings
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import CatalogError, choose_from

Array = NDArray[np.float64]

_METRES = {"m": 1.0, "metre": 1.0, "meter": 1.0, "km": 1e3, "kilometre": 1e3, "kilometer": 1e3}
_RADIANS = {"rad", "radian"}

# Relative scatter of coordinate steps, and difference of the two steps, that still counts as square.
_SQUARE = 0.01

# Beyond this wavelength an image is taken to show what the scene emits, and high cloud is the cold part.
# Near 4 um in daylight that is not so: there the user has to say which it is.
_THERMAL_UM = 3.0

# ITU-R BT.601, section 2.5.1: luminance from the colour components.
_LUMINANCE = np.array([0.299, 0.587, 0.114])

_USABLE = ("good", "conditionally_usable")


@dataclass(frozen=True)
class Image:
    """One plane of an image.

    Attributes
    ----------
    values : ndarray of float64 (rows, columns)
        As stored, in physical units where the file gives them; NaN where missing.
    pixel_size_m : float or None
        Side of a pixel on the ground; None where the file does not say.
    bright_is_cloud : bool
        Whether cloud has the larger values.
    units, long_name : str
        What the values are; empty where the file does not say.
    source : str
        Name of the file.
    pixel_size_is_nominal : bool
        True for a geostationary image: its pixel size is that below the satellite, and pixels
        elsewhere are larger.
    north_first, east_first : bool
        Whether the first row is the northernmost, and the first column the easternmost. Files
        without coordinates are taken to have the north in the first row, the west in the first column.
    """

    values: Array
    pixel_size_m: float | None
    bright_is_cloud: bool
    units: str
    long_name: str
    source: str
    pixel_size_is_nominal: bool = False
    north_first: bool = True
    east_first: bool = False


def read_image(path: Path, variable: str | None = None) -> Image:
    """Read an image; the kind of file is known from its first bytes, not from its name.

    Parameters
    ----------
    path : Path
        NetCDF (GOES ABI L1b and L2 among them), a picture that Pillow reads (colour becomes
        luminance, transparent pixels are missing), ``.npy`` or ``.npz``.
    variable : str, optional
        Variable of a NetCDF or ``.npz`` file; needed where there are several planes.

    Raises
    ------
    CatalogError
        If there is no such file, it is not an image, holds several planes or none with two
        dimensions, its pixels are not square, or its values are all missing or all the same.
    """
    if not path.is_file():
        raise CatalogError(f"no image '{path}'")
    with path.open("rb") as file:
        magic = file.read(8)
    if magic.startswith((b"\x89HDF", b"CDF")):
        image = _read_netcdf(path, variable)
    elif magic.startswith((b"\x93NUMPY", b"PK\x03\x04", b"PK\x05\x06")):
        image = _read_numpy(path, variable)
    else:
        if variable is not None:
            raise CatalogError(f"{path}: a picture has no variable '{variable}'; allowed: leave it out")
        image = _read_picture(path)
    values = np.where(np.isfinite(image.values), image.values, np.nan)
    finite = values[np.isfinite(values)]
    if finite.size == 0:
        raise CatalogError(f"{path}: all {values.size} pixels are missing")
    if finite.min() == finite.max():
        raise CatalogError(f"{path}: all pixels have the value {finite[0]:g}; clouds need a contrast")
    return replace(image, values=values)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep the warnings of file libraries about odd attributes of other people's files to ourselves."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def _read_picture(path: Path) -> Image:
    from PIL import Image as Picture

    try:
        with _quiet(), Picture.open(path) as picture:
            frames = getattr(picture, "n_frames", 1)
            if frames != 1:
                raise CatalogError(f"{path}: {frames} pictures in one file; allowed: 1")
            if picture.mode in ("1", "L", "F") or picture.mode.startswith("I"):
                values = np.asarray(picture, dtype=np.float64)
            else:
                colours = np.asarray(picture.convert("RGBA"), dtype=np.float64)
                values = np.where(colours[..., 3] > 0.0, colours[..., :3] @ _LUMINANCE, np.nan)
    except (OSError, SyntaxError, ValueError, Picture.DecompressionBombError) as error:
        raise CatalogError(f"{path}: not an image that can be read: {error}") from error
    return Image(values, None, True, "", "grey level", path.name)


def _read_numpy(path: Path, variable: str | None) -> Image:
    try:
        # Opened here, because a damaged archive would leave the file open.
        with path.open("rb") as file:
            loaded = np.load(file, allow_pickle=False)
            if isinstance(loaded, np.ndarray):
                if variable is not None:
                    raise CatalogError(f"{path}: a single array has no variable; allowed: leave it out")
                array = loaded
            else:
                array = loaded[_choose(path, variable, list(loaded.files), list(loaded.files))]
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise CatalogError(f"{path}: not an array that can be read: {error}") from error
    if array.ndim != 2 or array.dtype.kind not in "biuf":
        raise CatalogError(
            f"{path}: an array of {array.dtype} with shape {array.shape}; "
            "allowed: real numbers, (rows, columns)"
        )
    return Image(array.astype(np.float64), None, True, "", variable or "array", path.name)


def _choose(path: Path, variable: str | None, planes: list[str], known: list[str]) -> str:
    """Return the variable to read: the one asked for, or the only one there is."""
    if variable is not None:
        if variable not in known:
            raise CatalogError(f"{path}: no variable '{variable}'; {choose_from(variable, planes)}")
        return variable
    if len(planes) == 1:
        return planes[0]
    if not planes:
        raise CatalogError(f"{path}: no image: none of its variables has two dimensions")
    listed = ", ".join(sorted(planes))
    raise CatalogError(f"{path}: several images; set parameters.variable to one of: {listed}")


def _read_netcdf(path: Path, variable: str | None) -> Image:
    import netCDF4

    try:
        with _quiet(), netCDF4.Dataset(path) as dataset:
            name = _choose(path, variable, _planes(dataset), list(dataset.variables))
            return _netcdf_plane(path, dataset, dataset.variables[name])
    except (OSError, RuntimeError, ValueError, TypeError) as error:
        raise CatalogError(f"{path}: not a NetCDF image that can be read: {error}") from error


def _text(item: Any, name: str) -> str:
    return str(getattr(item, name, ""))


def _long_dimensions(variable: Any) -> list[str]:
    return [name for name, size in zip(variable.dimensions, variable.shape, strict=True) if size > 1]


def _is_plane(variable: Any) -> bool:
    return len(_long_dimensions(variable)) == 2 and getattr(variable.dtype, "kind", "") in "iuf"


def _planes(dataset: Any) -> list[str]:
    """List the variables with two dimensions that are measurements: no coordinates, bounds or flags."""
    helpers = {"latitude", "longitude", "status_flag"}
    named: set[str] = set()
    for variable in dataset.variables.values():
        for attribute in ("coordinates", "ancillary_variables", "bounds"):
            named.update(_text(variable, attribute).split())
    return [
        name
        for name, variable in dataset.variables.items()
        if _is_plane(variable) and name not in named and _text(variable, "standard_name") not in helpers
    ]


def _netcdf_plane(path: Path, dataset: Any, variable: Any) -> Image:
    if not _is_plane(variable):
        raise CatalogError(
            f"{path}: '{variable.name}' of type {variable.dtype} has the shape {tuple(variable.shape)}; "
            "allowed: numbers with two dimensions longer than 1; "
            f"{choose_from(variable.name, _planes(dataset))}"
        )
    values = _numbers(variable)
    for flag_name in _text(variable, "ancillary_variables").split():
        flags = dataset.variables.get(flag_name)
        if flags is not None and flags.shape == variable.shape:
            values[_unusable(flags)] = np.nan
    y_name, x_name = _long_dimensions(variable)
    values = values.squeeze()
    if _is_eastward(dataset.variables.get(y_name)):
        values, y_name, x_name = values.T, x_name, y_name
    step_y, step_x = (_step(path, dataset.variables.get(name)) for name in (y_name, x_name))
    size, nominal = _pixel_size(path, dataset, variable, (y_name, x_name), (step_y, step_x))
    return Image(
        values=values,
        pixel_size_m=size,
        bright_is_cloud=not _is_thermal(dataset, variable),
        units=_text(variable, "units"),
        long_name=_text(variable, "long_name") or variable.name,
        source=path.name,
        pixel_size_is_nominal=nominal,
        north_first=step_y is None or step_y < 0.0,
        east_first=step_x is not None and step_x < 0.0,
    )


def _numbers(variable: Any) -> Array:
    """Return a variable, unpacked, with NaN for fill values and values outside its valid range."""
    return np.ma.filled(np.ma.asarray(variable[...]).astype(np.float64), np.nan)


def _unusable(flags: Any) -> NDArray[np.bool_]:
    """Return where a quality flag says neither good nor conditionally usable; all False for other flags."""
    meanings = _text(flags, "flag_meanings").split()
    usable = [index for index, meaning in enumerate(meanings) if meaning.startswith(_USABLE)]
    codes = np.atleast_1d(getattr(flags, "flag_values", []))
    if not usable or codes.size != len(meanings):
        return np.zeros(flags.shape, dtype=np.bool_)
    return ~np.isin(_numbers(flags), codes[usable].astype(np.float64))


def _is_eastward(coordinate: Any) -> bool:
    """Whether a coordinate variable runs along x."""
    return coordinate is not None and (
        _text(coordinate, "axis") == "X"
        or _text(coordinate, "standard_name") in ("projection_x_coordinate", "longitude")
    )


def _is_thermal(dataset: Any, variable: Any) -> bool:
    """Whether an image shows temperature or thermal radiance, where high cloud is cold: small values."""
    units = _text(variable, "units").casefold()
    name = f"{_text(variable, 'standard_name')} {_text(variable, 'long_name')}".casefold().replace(" ", "_")
    if units in ("k", "kelvin") or "brightness_temperature" in name:
        return True
    wavelength = dataset.variables.get("band_wavelength")
    if "sr-1" not in units or wavelength is None or _text(wavelength, "units") != "um":
        return False
    return bool(np.all(_numbers(wavelength) > _THERMAL_UM))


def _step(path: Path, coordinate: Any) -> float | None:
    """Return the step of a coordinate in its own units; None where there is no coordinate."""
    if coordinate is None or coordinate.ndim != 1 or coordinate.shape[0] < 2:
        return None
    positions = _numbers(coordinate)
    step = float(positions[-1] - positions[0]) / (positions.size - 1)
    if not np.all(np.abs(np.diff(positions) - step) <= _SQUARE * abs(step)) or step == 0.0:
        raise CatalogError(f"{path}: coordinate '{coordinate.name}' is not evenly spaced; resample the image")
    return step


def _pixel_size(
    path: Path,
    dataset: Any,
    variable: Any,
    names: tuple[str, str],
    steps: tuple[float | None, float | None],
) -> tuple[float | None, bool]:
    """Return the side of a pixel in metres (None where unknown) and whether it is nominal.

    On the fixed grid of a geostationary imager (GOES-R Product Definition and Users' Guide, vol. 3,
    section 5.1.2) x and y are scan angles; times the height of the satellite they are lengths below it.
    """
    mapping = dataset.variables.get(_text(variable, "grid_mapping").split(":")[0].strip())
    geostationary = _text(mapping, "grid_mapping_name") == "geostationary"
    height = float(getattr(mapping, "perspective_point_height", np.nan))
    sides = []
    for name, step in zip(names, steps, strict=True):
        units = _text(dataset.variables.get(name), "units").casefold().removesuffix("s")
        metres = height if units in _RADIANS else _METRES.get(units, np.nan)
        if step is None or not np.isfinite(metres):
            return None, False
        sides.append(abs(step) * metres)
    if abs(sides[0] - sides[1]) > _SQUARE * max(sides):
        raise CatalogError(
            f"{path}: pixels of {sides[1]:g} m x {sides[0]:g} m are not square; allowed: sides that differ "
            "by at most 1 %; resample the image"
        )
    return float(np.sqrt(sides[0] * sides[1])), geostationary
