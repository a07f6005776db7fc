"""Reader for satellite images: one plane of numbers, its pixel size, and whether cloud is bright."""

from __future__ import annotations

import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from hcss_twin.core.errors import CatalogError
from hcss_twin.models.clouds.imagery.geotiff import read_tiff
from hcss_twin.models.clouds.imagery.image import SatelliteImage, choose_plane, luminance
from hcss_twin.models.clouds.imagery.netcdf_image import quiet, read_netcdf

# First bytes of TIFF and BigTIFF in both byte orders.
_TIFF = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")

# Suffixes of NetCDF files, for a helpful message about damaged ones.
_NETCDF = (".nc", ".nc4", ".cdf", ".netcdf")


def read_image(path: Path, variable: str | None = None) -> SatelliteImage:
    """Read an image; the first bytes of the file, not its name, determine the format.

    Parameters
    ----------
    path : Path
        NetCDF (including GOES ABI L1b and L2), GeoTIFF, a picture that Pillow reads (colour is converted to luminance,
        transparent pixels are missing), ``.npy`` or ``.npz``.
    variable : str, optional
        Variable of a NetCDF or ``.npz`` file, or TIFF band number, from 1; needed if there are several planes.

    Raises
    ------
    CatalogError
        If the file does not exist, is not an image, has several planes or none with two dimensions, has pixels that are
        not square, or has values that are all missing or all the same.
    """
    if not path.is_file():
        raise CatalogError(f"no image '{path}'")
    with path.open("rb") as file:
        magic = file.read(8)
    if magic.startswith((b"\x89HDF", b"CDF")):
        image = read_netcdf(path, variable)
    elif magic.startswith(_TIFF):
        image = read_tiff(path, variable)
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


def _read_picture(path: Path) -> SatelliteImage:
    from PIL import Image as Picture
    from PIL import UnidentifiedImageError

    try:
        with quiet(), Picture.open(path) as picture:
            frames = getattr(picture, "n_frames", 1)
            if frames != 1:
                raise CatalogError(f"{path}: {frames} pictures in one file; allowed: 1")
            if picture.mode in ("1", "L", "F") or picture.mode.startswith("I"):
                values = np.asarray(picture, dtype=np.float64)
            else:
                values = luminance(np.asarray(picture.convert("RGBA"), dtype=np.float64))
    except UnidentifiedImageError as error:
        if path.stat().st_size == 0:
            why = "it is empty"
        elif path.suffix.lower() in _NETCDF:
            why = "it is not a NetCDF file, or its header is damaged"
        else:
            why = "not a readable image: unknown format"
        raise CatalogError(f"{path}: {why}; allowed: NetCDF, TIFF, PNG, JPEG, .npy, .npz") from error
    except (OSError, SyntaxError, ValueError, Picture.DecompressionBombError) as error:
        raise CatalogError(f"{path}: not an image that can be read: {error}") from error
    return SatelliteImage(values, None, True, "", "grey level", path.name)


def _read_numpy(path: Path, variable: str | None) -> SatelliteImage:
    try:
        # Opened here, because a damaged archive would leave the file open.
        with path.open("rb") as file:
            loaded = np.load(file, allow_pickle=False)
            if isinstance(loaded, np.ndarray):
                if variable is not None:
                    raise CatalogError(f"{path}: a single array has no variable; allowed: leave it out")
                array = loaded
            else:
                array = loaded[choose_plane(path, variable, list(loaded.files), list(loaded.files))]
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise CatalogError(f"{path}: not an array that can be read: {error}") from error
    if array.ndim != 2 or array.dtype.kind not in "biuf":
        raise CatalogError(
            f"{path}: an array of {array.dtype} with shape {array.shape}; allowed: real numbers, (rows, columns)"
        )
    name = variable or "array"
    return SatelliteImage(array.astype(np.float64), None, True, "", name, path.name, variable=variable or "")
