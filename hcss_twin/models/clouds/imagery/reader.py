"""Reader for satellite images: one plane of numbers, its pixel size, and whether cloud is bright."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CatalogError
from hcss_twin.core.netcdf import NETCDF
from hcss_twin.core.reading import MAX_IMAGE_PIXELS, Reading, require_no_stream, require_size
from hcss_twin.models.clouds.imagery.geotiff import read_tiff
from hcss_twin.models.clouds.imagery.image import SatelliteImage
from hcss_twin.models.clouds.imagery.netcdf_image import read_netcdf
from hcss_twin.models.clouds.imagery.planes import ORIENTATION, choose_plane, luminance, require_upright

__all__ = ["read_image"]

# First bytes of TIFF and BigTIFF in both byte orders.
_TIFF = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")

# Suffixes of NetCDF files, for a helpful message about damaged ones.
_NETCDF = (".nc", ".nc4", ".cdf", ".netcdf")


def read_image(path: Path, variable: str | None = None, at: Mapping[str, int] | None = None) -> SatelliteImage:
    """Read an image; the first bytes of the file, not its name, determine the format.

    Parameters
    ----------
    path : Path
        NetCDF (including GOES ABI L1b and L2), GeoTIFF, a picture that Pillow reads (colour is converted to luminance,
        transparent pixels are missing), ``.npy`` or ``.npz``.
    variable : str, optional
        Variable of a NetCDF or ``.npz`` file, or TIFF band number, from 1; needed if there are several planes.
    at : mapping of str to int, optional
        Index along each further dimension of a NetCDF variable of several images.

    Raises
    ------
    CatalogError
        If the file does not exist, is not an image, has several planes or none with two dimensions, has pixels that are
        not square, or has values that are all missing, all the same, or no temperatures although the unit is K.
    """
    if not path.is_file():
        require_no_stream(path, CatalogError)
        raise CatalogError(f"no image '{path}'")
    magic = Reading(path, CatalogError).first_bytes()
    if at and not magic.startswith(NETCDF):
        raise CatalogError(f"{path}: at {next(iter(at))}: allowed for NetCDF variables of several images only")
    if magic.startswith(NETCDF):
        image = read_netcdf(path, variable, at or {})
    elif magic.startswith(_TIFF):
        image = read_tiff(path, variable)
    elif magic.startswith((b"\x93NUMPY", b"PK\x03\x04", b"PK\x05\x06")):
        image = _read_numpy(path, variable)
    else:
        if variable is not None:
            raise CatalogError(f"{path}: a picture has no variable '{variable}'; allowed: leave it out")
        image = _read_picture(path)
    return image.examined(path)


def _read_picture(path: Path) -> SatelliteImage:
    from PIL import Image as Picture
    from PIL import UnidentifiedImageError

    with Reading(path, CatalogError, "not an image that can be read"), Reading.quiet():
        try:
            picture = Picture.open(path)
        except UnidentifiedImageError as error:
            if path.stat().st_size == 0:
                why = "it is empty"
            elif path.suffix.lower() in _NETCDF:
                why = "it is not a NetCDF file, or its header is damaged"
            else:
                why = "not a readable image: unknown format"
            raise CatalogError(f"{path}: {why}; allowed: NetCDF, TIFF, PNG, JPEG, .npy, .npz") from error
        with picture:
            frames = getattr(picture, "n_frames", 1)
            if frames != 1:
                raise CatalogError(f"{path}: {frames} pictures in one file; allowed: 1")
            require_size(path, picture.size[::-1], CatalogError, MAX_IMAGE_PIXELS, "pixels")
            require_upright(path, picture.getexif().get(ORIENTATION))
            if picture.mode in ("1", "L", "F") or picture.mode.startswith("I"):
                values = np.asarray(picture).astype(np.float64)
                values[values == picture.info.get("transparency")] = np.nan
            else:
                values = luminance(np.asarray(picture.convert("RGBA"), dtype=np.float64))
    return SatelliteImage(values, None, True, "", "grey level", path.name)


def _read_numpy(path: Path, variable: str | None) -> SatelliteImage:
    # The file is opened here, because numpy would leave that of a damaged archive open.
    with Reading(path, CatalogError, "not an array that can be read"), path.open("rb") as file:
        if file.read(2) == b"PK":
            with zipfile.ZipFile(file) as archive:
                names = [name.removesuffix(".npy") for name in archive.namelist()]
                with archive.open(f"{choose_plane(path, variable, names, names)}.npy") as member:
                    array = _array(path, member)
        elif variable is not None:
            raise CatalogError(f"{path}: a single array has no variable; allowed: leave it out")
        else:
            array = _array(path, file)
    if array.ndim != 2 or array.dtype.kind not in "biuf":
        raise CatalogError(
            f"{path}: an array of {array.dtype} with shape {array.shape}; allowed: real numbers, (rows, columns)"
        )
    name = variable or "array"
    return SatelliteImage(array.astype(np.float64), None, True, "", name, path.name, variable=variable or "")


def _array(path: Path, file: IO[bytes]) -> NDArray[Any]:
    """Read an array in numpy's format after checking its declared shape."""
    file.seek(0)
    version = np.lib.format.read_magic(file)
    header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    require_size(path, header(file)[0], CatalogError, MAX_IMAGE_PIXELS, "pixels")
    file.seek(0)
    array: NDArray[Any] = np.lib.format.read_array(file, allow_pickle=False)
    return array
