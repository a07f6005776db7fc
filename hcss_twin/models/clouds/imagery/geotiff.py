"""Planes of TIFF files, and the pixel size from GeoTIFF tags.

tifffile reads the structure (bands, tiles, overviews, number types) and the tags. Pillow decodes compressions that
tifffile cannot (LZW, JPEG and others) if the file has one band or is a plain picture; other such files need the package
imagecodecs.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CatalogError
from hcss_twin.core.reading import MAX_IMAGE_PIXELS, Reading, require_size
from hcss_twin.models.clouds.imagery.image import SatelliteImage
from hcss_twin.models.clouds.imagery.planes import (
    ORIENTATION,
    SQUARE,
    choose_plane,
    luminance,
    require_upright,
    square_side,
)
from hcss_twin.physics.geodesy import MEAN_EARTH_RADIUS_M

_DATE_TIME = 306

_ALPHA = ((1,), (2,))
"""Last of the extra samples: opacity, with which the others are multiplied or not (TIFF 6.0, section 18)."""

# Keys and codes of OGC GeoTIFF 1.1 (19-008r4), sections 7.4 and 7.5 and annex C.
_PROJECTED, _GEOGRAPHIC = 1, 2
_METRES = {9001: 1.0, 9002: 0.3048, 9003: 1200.0 / 3937.0, 9036: 1000.0}
_DEGREE = 9102


def read_tiff(path: Path, variable: str | None) -> SatelliteImage:
    """Read one band of a TIFF or GeoTIFF file; see :func:`hcss_twin.models.clouds.imagery.reader.read_image`.

    A picture with three or four 8-bit samples is converted to luminance unless a band is chosen. Pixels are missing
    that have the no-data value of GDAL's tag, that are transparent, or that the file's own mask hides. Scale, offset
    and unit of GDAL's metadata are applied. Overviews are ignored.

    Raises
    ------
    CatalogError
        If the file is damaged, has several pages, has several bands without a choice, or has an unknown compression, or
        if its grid is rotated or its pixels are not square.
    """
    import tifffile

    tifffile.logger().setLevel("CRITICAL")  # damage is reported below, by one error
    with Reading(path, CatalogError, "not an image that can be read"), Reading.quiet(), tifffile.TiffFile(path) as file:
        page = _only_page(path, file)
        require_size(path, page.shape, CatalogError, MAX_IMAGE_PIXELS, "samples")
        require_upright(path, page.tags.valueof(ORIENTATION))
        image = _page(path, page, variable)
        for mask in file.pages:
            # Bit 2 of NewSubfileType: a mask; those of overviews have other shapes.
            if int(mask.subfiletype) & 0b100 and mask.shape[:2] == image.values.shape:
                image.values[mask.asarray() == 0] = np.nan
        return image


def _only_page(path: Path, file: Any) -> Any:
    # Bits 0 and 2 of NewSubfileType: a smaller copy of another page, and a mask of it.
    pages = [page for page in file.pages if not int(page.subfiletype) & 0b101]
    if len(pages) != 1:
        raise CatalogError(f"{path}: {len(pages)} pictures in one file; allowed: 1")
    return pages[0]


def _page(path: Path, page: Any, variable: str | None) -> SatelliteImage:
    bands = _bands(path, page)
    hidden = np.zeros(bands.shape[1:], dtype=np.bool_)
    if bands.shape[0] > 1 and bands.shape[0] == page.samplesperpixel and page.extrasamples[-1:] in _ALPHA:
        bands, hidden = bands[:-1], bands[-1] == 0
    missing = _missing_value(page)
    names = [str(number) for number in range(1, bands.shape[0] + 1)]
    is_picture = page.photometric.name == "RGB" and bands.dtype == np.uint8 and bands.shape[0] == 3
    if is_picture and variable is None:
        values, name, used = luminance(np.moveaxis(bands, 0, -1).astype(np.float64)), "", bands
    else:
        name = choose_plane(path, variable, names, names)
        used = bands[int(name) - 1 : int(name)]
        values = used[0].astype(np.float64)
    about = _gdal_metadata(page, int(name or 1) - 1)
    values = values * float(about.get("scale", 1.0)) + float(about.get("offset", 0.0))
    values[hidden | (used == missing).all(axis=0)] = np.nan
    if page.photometric.name == "MINISWHITE":
        values = -values
    size, note, north_first = _pixel_size(path, page)
    return SatelliteImage(
        values=values,
        pixel_size_m=size,
        bright_is_cloud=True,
        units=about.get("unittype", ""),
        long_name=f"band {name}" if name else "grey level",
        source=path.name,
        north_first=north_first,
        pixel_size_note=note,
        variable=name if len(names) > 1 else "",
        date=str(page.tags.valueof(_DATE_TIME) or ""),
    )


def _bands(path: Path, page: Any) -> NDArray[Any]:
    """Return the samples (bands, rows, columns)."""
    if page.photometric.name == "PALETTE":
        samples, axes = _with_pillow(path), "YXS"
    else:
        try:
            samples, axes = page.asarray(), page.axes
        except (ValueError, ImportError) as error:
            if page.samplesperpixel > 1 and page.dtype != np.uint8:
                raise CatalogError(
                    f"{path}: compression {page.compression.name}; allowed: none, deflate, LZMA, PackBits, or "
                    "install the package imagecodecs"
                ) from error
            samples = _with_pillow(path)
            axes = "YX" if samples.ndim == 2 else "YXS"
    if "Y" not in axes or "X" not in axes or samples.dtype.kind not in "biuf":
        raise CatalogError(f"{path}: samples of {samples.dtype} with the axes {axes}; allowed: real numbers")
    order = [axes.index("Y"), axes.index("X")]
    others = [axis for axis in range(samples.ndim) if axis not in order]
    planes: NDArray[Any] = samples.transpose(*others, *order)
    return planes.reshape(-1, *planes.shape[-2:])


def _with_pillow(path: Path) -> NDArray[Any]:
    from PIL import Image as Picture

    with Picture.open(path) as picture:
        return np.asarray(picture.convert("RGB") if picture.mode == "P" else picture)


def _missing_value(page: Any) -> float | None:
    """Return the value of missing pixels from GDAL's tag 42113; None without the tag or a number."""
    try:
        return float(str(page.tags.valueof(42113)).strip("\0 "))
    except ValueError:
        return None


def _gdal_metadata(page: Any, sample: int) -> dict[str, str]:
    """Return scale, offset and unittype of a sample from GDAL's tag 42112, as far as the file has them."""
    text = str(page.tags.valueof(42112) or "")
    found = re.findall(r'<Item name="\w+" sample="(\d+)" role="(scale|offset|unittype)">([^<]*)<', text)
    return {role: value for number, role, value in found if int(number) == sample}


def _pixel_size(path: Path, page: Any) -> tuple[float | None, str, bool]:
    """Return the pixel size in metres, or why there is none, and whether the first row is the northernmost."""
    tags = page.geotiff_tags or {}
    if not tags:
        return None, "", True
    if "ModelPixelScale" in tags:
        step_x, step_y = float(tags["ModelPixelScale"][0]), -float(tags["ModelPixelScale"][1])
        top = float(np.ravel(tags["ModelTiepoint"])[4]) if "ModelTiepoint" in tags else math.nan
    elif "ModelTransformation" in tags:
        (step_x, turn_x, _, _), (turn_y, step_y, _, top) = tags["ModelTransformation"][:2]
        if turn_x or turn_y:
            raise CatalogError(f"{path}: the grid is rotated relative to north; resample the image")
    else:
        return None, "", True
    if not (step_x > 0.0 and step_y != 0.0 and math.isfinite(step_x) and math.isfinite(step_y)):
        raise CatalogError(f"{path}: pixels of {step_x:g} x {-step_y:g}; allowed: sides that are not 0, east > 0")
    north_first = step_y < 0.0
    model = int(tags.get("GTModelTypeGeoKey", 0))
    if model == _PROJECTED:
        unit = int(tags.get("ProjLinearUnitsGeoKey", 9001))
        metres = _METRES.get(unit) or float(tags.get("ProjLinearUnitSizeGeoKey", math.nan))
        if not math.isfinite(metres):
            return None, f"its unit of length has the code {unit}, which is not known", north_first
        return square_side(path, step_x * metres, abs(step_y) * metres), "", north_first
    if model == _GEOGRAPHIC and int(tags.get("GeogAngularUnitsGeoKey", _DEGREE)) == _DEGREE:
        latitude = top + step_y * page.imagelength / 2.0
        return *_of_degrees(step_x, abs(step_y), latitude), north_first
    return None, "its grid unit is neither a length nor degrees", north_first


def _of_degrees(step_x: float, step_y: float, latitude: float) -> tuple[float | None, str]:
    """Return the pixel size in metres of a grid in degrees at its central latitude, or why there is none."""
    if not math.isfinite(latitude) or abs(latitude) >= 90.0:
        return None, "its grid is in degrees without a latitude"
    side_y = math.radians(step_y) * MEAN_EARTH_RADIUS_M
    side_x = math.radians(step_x) * MEAN_EARTH_RADIUS_M * math.cos(math.radians(latitude))
    if abs(side_x - side_y) > SQUARE * max(side_x, side_y):
        return None, (
            f"its pixels, in degrees, are {side_x:.4g} m x {side_y:.4g} m at latitude {latitude:.4g}: not square; "
            "resample it, or give the pixel size to assume"
        )
    return math.sqrt(side_x * side_y), ""
