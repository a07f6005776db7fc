"""Regenerate ``climatology/coads-monthly.nc``.

Package: ``ferret-datasets`` 7.6.0-5 of Debian: ``apt-get download ferret-datasets`` and
``dpkg -x ferret-datasets_*.deb unpacked``.
Origin: COADS, the Comprehensive Ocean-Atmosphere Data Set: means of all ship reports of each month of the
year, 1946-1989, in cells of 2 degrees (``coads_climatology.cdf``, NOAA Pacific Marine Environmental
Laboratory); land from ETOPO at 60 minutes (``etopo60.cdf``, NOAA).
Rights: works of the US government, public domain.

Run as ``python catalogs/recipes/coads_climatology.py unpacked/usr/share/ferret-vis/data`` with numpy and
netCDF4 installed. Values are rounded to 0.01 of their unit; nothing is smoothed and no gap is filled.
"""

from __future__ import annotations

import hashlib
import sys
from dataclasses import dataclass
from pathlib import Path

import netCDF4
import numpy as np
from numpy.typing import NDArray

OUTPUT = Path(__file__).resolve().parents[1] / "climatology" / "coads-monthly.nc"
MISSING = -32768
STEP = 0.01
"""Rounding of every variable, in its own unit; the reports themselves are good to 0.1."""

SHA256 = {
    "coads_climatology.cdf": "b94f55034d13d63f33e2153afddc0c5e00347076c35ab3e34937aec38ce9c4c1",
    "etopo60.cdf": "36b4cb72a01cf4c6dc155e52dca6c4ff148aea5958d056d3136fe2789646c4ad",
}


@dataclass(frozen=True)
class Field:
    """One climatological field.

    Parameters
    ----------
    origin : str
        Name in the origin's file.
    name, standard_name, units : str
        Name, CF standard name and unit here.
    offset : float
        Added to the origin's number.
    """

    origin: str
    name: str
    standard_name: str
    units: str
    offset: float = 0.0


FIELDS = (
    Field("SST", "sea_surface_temperature", "sea_surface_temperature", "K", 273.15),
    Field("AIRT", "air_temperature", "air_temperature", "K", 273.15),
    Field("SPEH", "specific_humidity", "specific_humidity", "g kg-1"),
    Field("WSPD", "wind_speed", "wind_speed", "m s-1"),
)


def checked(folder: Path, name: str) -> Path:
    """Return the path of an input file after comparing its hash.

    Raises
    ------
    ValueError
        If it is another file than the one this recipe was written for.
    """
    path = folder / name
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    if digest != SHA256[name]:
        raise ValueError(f"{path}: SHA-256 {digest}; expected {SHA256[name]}")
    return path


def eastward(longitude: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return longitudes from 0 to 360 and the order that sorts them."""
    wrapped = longitude % 360.0
    order = np.argsort(wrapped)
    return wrapped[order], order


def read_fields(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64], list[NDArray[np.float64]]]:
    """Read latitude (Y,), longitude (X,) and the fields (12, Y, X), NaN where nobody reported."""
    with netCDF4.Dataset(path) as origin:
        longitude, order = eastward(np.asarray(origin["COADSX"][:], dtype=np.float64))
        latitude = np.asarray(origin["COADSY"][:], dtype=np.float64)
        fields = []
        for field in FIELDS:
            values = np.ma.filled(origin[field.origin][:].astype(np.float64), np.nan)
            fields.append(values[:, :, order] + field.offset)
    return latitude, longitude, fields


def read_sea(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.uint8]]:
    """Read latitude (Y,), longitude (X,) and where the mean elevation is below sea level (Y, X)."""
    with netCDF4.Dataset(path) as origin:
        longitude, order = eastward(np.asarray(origin["ETOPO60X"][:], dtype=np.float64))
        latitude = np.asarray(origin["ETOPO60Y"][:], dtype=np.float64)
        elevation = np.ma.filled(origin["ROSE"][:].astype(np.float64), 0.0)[:, order]
    return latitude, longitude, (elevation < 0).astype(np.uint8)


def packed(values: NDArray[np.float64], offset: float) -> NDArray[np.int16]:
    """Round to whole steps above an offset."""
    steps = np.rint((values - offset) / STEP)
    present = np.isfinite(steps)
    if np.any(np.abs(steps[present]) >= -MISSING):
        raise ValueError("a value does not fit into 16 bits")
    return np.where(present, steps, MISSING).astype(np.int16)


def axis(dataset: netCDF4.Dataset, name: str, values: NDArray[np.float64], units: str) -> None:
    """Write a dimension and its coordinate variable."""
    dataset.createDimension(name, values.size)
    variable = dataset.createVariable(name, "f8", (name,))
    variable.units = units
    variable[:] = values


def main(folder: Path) -> None:
    """Write the catalog file."""
    latitude, longitude, fields = read_fields(checked(folder, "coads_climatology.cdf"))
    sea_latitude, sea_longitude, sea = read_sea(checked(folder, "etopo60.cdf"))
    OUTPUT.parent.mkdir(exist_ok=True)
    with netCDF4.Dataset(OUTPUT, "w") as out:
        out.format = "hcss-climatology"
        out.format_version = np.int32(1)
        out.title = "Monthly climatology of the sea surface and the air above it, COADS 1946-1989"
        out.source = (
            "COADS, Comprehensive Ocean-Atmosphere Data Set (NOAA, CIRES, NCAR): simple means of all ship reports of "
            "each month of the year, 1946-1989, in cells of 2 degrees, as distributed by the NOAA Pacific Marine "
            "Environmental Laboratory; land from ETOPO at 60 minutes (NOAA)"
        )
        out.origin = "catalogs/recipes/coads_climatology.py from the Debian package ferret-datasets 7.6.0-5"
        out.license = "public domain (works of the US government)"
        out.comment = (
            "Rounded to 0.01 of each unit; not smoothed, gaps not filled. Missing: no report in that month, on land or "
            "at sea. Poleward of 45 S and 65 N cells often rest on a few reports of one season."
        )
        axis(out, "month", np.arange(1.0, 13.0), "1")
        axis(out, "latitude", latitude, "degrees_north")
        axis(out, "longitude", longitude, "degrees_east")
        axis(out, "sea_latitude", sea_latitude, "degrees_north")
        axis(out, "sea_longitude", sea_longitude, "degrees_east")
        out["month"].comment = "each value belongs to the middle of its month, (month - 1/2) / 12 of a year"
        for field, values in zip(FIELDS, fields, strict=True):
            variable = out.createVariable(
                field.name,
                "i2",
                ("month", "latitude", "longitude"),
                compression="zlib",
                complevel=9,
                fill_value=MISSING,
            )
            variable.set_auto_maskandscale(False)
            variable.standard_name = field.standard_name
            variable.units = field.units
            variable.scale_factor = STEP
            variable.add_offset = field.offset
            variable[:] = packed(values, field.offset)
        mask = out.createVariable("sea", "u1", ("sea_latitude", "sea_longitude"), compression="zlib", complevel=9)
        mask.long_name = "1 where the mean elevation of the cell is below sea level"
        mask[:] = sea
    print(f"{OUTPUT.name}: {OUTPUT.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
