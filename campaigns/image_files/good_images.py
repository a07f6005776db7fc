"""100 good images: each is read without an error, without a question, and with the values of an independent reader."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import rasterio
from image_scenes import patch, scene
from PIL import Image
from rasterio.transform import from_origin


@dataclass(frozen=True)
class Good:
    """A file and what is known of it: ``coverage`` of what is visible, None where the classes are not separate."""

    path: Path
    cloud_is: str
    coverage: float | None
    variable: str | None = None
    options: dict[str, Any] = field(default_factory=dict)


def visible_coverage(cloud, hidden):
    return float(cloud[~hidden].mean())


def numpy_file(folder, quantity, seed, dtype, *, order="C", hidden=False, archive=False, **options):
    values, cloud = scene(quantity, seed)
    gone = patch(seed) if hidden else np.zeros(values.shape, bool)
    values = np.asarray(values).astype(dtype, order=order)
    if hidden:
        values[gone] = np.nan
    path = folder / ("a.npz" if archive else "a.npy")
    if archive:
        np.savez(path, image=values)
    else:
        np.save(path, values)
    dark = quantity in ("kelvin", "celsius", "thermal")
    return Good(path, "dark" if dark else "bright", visible_coverage(cloud, gone), options=options)


def special(folder, values, cloud=None, cloud_is="bright"):
    np.save(folder / "a.npy", values)
    return Good(folder / "a.npy", cloud_is, None if cloud is None else float(cloud.mean()))


def netcdf(folder, quantity, seed, dtype="f4", *, form="NETCDF4", fill=None, name="image", dims=2, hidden=True, **atts):
    values, cloud = scene(quantity, seed)
    gone = patch(seed) if hidden else np.zeros(values.shape, bool)
    with netCDF4.Dataset(folder / "a.nc", "w", format=form) as file:
        file.createDimension("y", values.shape[0])
        file.createDimension("x", values.shape[1])
        file.createDimension("time", 1)
        names = ("time", "y", "x")[3 - dims :]
        item = file.createVariable(name, dtype, names, fill_value=fill)
        item.setncatts(atts)
        whole = np.ma.masked_array(values, gone)
        if "valid_max" in atts or "valid_min" in atts or "valid_range" in atts:
            item.set_auto_mask(False)
            outside = atts.get("valid_max", np.ravel(atts.get("valid_range", [0, 0]))[1]) + 7
            if "valid_min" in atts:
                outside = atts["valid_min"] - 7
            whole = np.where(gone, outside * atts.get("scale_factor", 1.0) + atts.get("add_offset", 0.0), values)
        elif "missing_value" in atts:
            whole = np.where(gone, atts["missing_value"], values)
        item[...] = whole if dims == 2 else whole[None]
    dark = quantity in ("kelvin", "celsius", "thermal")
    return Good(folder / "a.nc", "dark" if dark else "bright", visible_coverage(cloud, gone), name)


def geotiff(folder, quantity, seed, dtype, *, nodata=None, mask=False, alpha=False, bands=1, unit=None, packed=False,
            **profile):  # fmt: skip
    values, cloud = scene(quantity, seed)
    gone = patch(seed) if nodata is not None or mask or alpha else np.zeros(values.shape, bool)
    stored = (values - 200.0) / 0.01 if packed else values
    stored = np.where(gone, np.nan if nodata is None else nodata, stored) if nodata is not None else stored
    stored = stored.astype(dtype)
    about = {"driver": "GTiff", "height": values.shape[0], "width": values.shape[1], "count": bands + alpha,
             "dtype": dtype, "nodata": nodata, "crs": "EPSG:32631",
             "transform": from_origin(5e5, 5e6, 1e3, 1e3), **profile}  # fmt: skip
    if alpha:
        about["alpha"] = "YES"
    with rasterio.Env(GDAL_TIFF_INTERNAL_MASK=True), rasterio.open(folder / "a.tif", "w", **about) as file:
        for band in range(1, bands + 1):
            file.write(stored, band)
        if alpha:
            file.write(np.where(gone, 0, np.iinfo(dtype).max).astype(dtype), bands + 1)
            file.colorinterp = [*([rasterio.enums.ColorInterp.gray] if bands == 1 else
                                  [rasterio.enums.ColorInterp(each) for each in (3, 4, 5)]),
                                rasterio.enums.ColorInterp.alpha]  # fmt: skip
        if mask:
            file.write_mask(~gone)
        if unit:
            file.set_band_unit(1, unit)
        if packed:
            file.scales, file.offsets = (0.01,) * bands, (200.0,) * bands
    dark = unit is not None
    variable = "1" if bands == 2 else None
    return Good(folder / "a.tif", "dark" if dark else "bright", visible_coverage(cloud, gone), variable)


def picture(folder, seed, mode, suffix="png", *, quantity="grey", hidden=False, **options):
    values, cloud = scene(quantity, seed)
    gone = patch(seed) if hidden else np.zeros(values.shape, bool)
    grey = np.rint(values)
    path = folder / f"a.{suffix}"
    if mode == "I;16":
        image = Image.fromarray(np.where(gone, 7, grey).astype(np.uint16))
        options |= {"transparency": 7} if hidden else {}
    elif mode == "L":
        image = Image.fromarray(np.where(gone, 255, grey).astype(np.uint8))
        options |= {"transparency": 255} if hidden else {}
    elif mode == "1":
        image = Image.fromarray(cloud)
    elif mode in ("LA", "RGBA"):
        alpha = np.where(gone, 0, 255)
        parts = [np.where(gone, 255, grey)] * (len(mode) - 1) + [alpha]
        image = Image.fromarray(np.stack(parts, -1).astype(np.uint8))
    elif mode == "P":
        image = Image.fromarray(np.where(gone, 255, np.minimum(grey, 254)).astype(np.uint8))
        image.putpalette([level for each in range(256) for level in (each, each, each)])
        options |= {"transparency": 255} if hidden else {}
    elif mode == "CMYK":
        image = Image.fromarray(grey.astype(np.uint8)).convert("RGB").convert("CMYK")
    else:
        image = Image.fromarray(np.stack([np.where(gone, 255, grey)] * 3, -1).astype(np.uint8))
        options |= {"transparency": (255, 255, 255)} if hidden else {}
    image.save(path, **options)
    return Good(path, "bright", visible_coverage(cloud, gone))


def _lognormal(seed):
    return np.random.default_rng([42, seed]).lognormal(0.0, 1.2, (40, 56))


def _plateau(quantity, top, dtype):
    values, cloud = scene(quantity, 31)
    values = np.where(cloud, values * 1.15, values)
    return np.minimum(values, top).astype(dtype), cloud


def _bordered(sea):
    values, cloud = scene("grey", 33)
    inside = np.zeros(values.shape, bool)
    inside[6:-6, 6:-6] = True
    return np.where(cloud & inside, values, sea).astype(np.uint8), cloud & inside


def good_cases():
    """Return (name, function of a folder) of the 100 good images."""
    cases = []

    def add(name, function, *args, **kwargs):
        cases.append((name, lambda folder: function(folder, *args, **kwargs)))

    for seed, (quantity, dtype) in enumerate([
        ("grey", "u1"), ("haze", "u1"), ("grey", "<u2"), ("counts", ">u2"), ("counts", "i4"), ("counts12", "i2"),
        ("reflectance", "f4"), ("reflectance", "f8"), ("reflectance", "f2"), ("percent", "f8"), ("radiance", "f4"),
        ("anomaly", "f8"), ("thickness", "f4"), ("grey", "f4"), ("counts", "f8"), ("percent", "u1"), ("haze", "u1"),
    ]):  # fmt: skip
        add(f"npy-{quantity}-{dtype.strip('<>')}-{seed}", numpy_file, quantity, seed, dtype)
    add("npy-12-bit-counts-like-kelvin", numpy_file, "dark12", 17, "u2")  # may be questioned
    add("npy-fortran", numpy_file, "grey", 18, "f8", order="F")
    for seed, quantity in ((20, "reflectance"), (21, "grey"), (22, "radiance"), (23, "thickness")):
        add(f"npy-nan-{quantity}", numpy_file, quantity, seed, "f4", hidden=True)
    for seed, (quantity, dtype) in enumerate([("kelvin", "f4"), ("kelvin", "f8"), ("kelvin", "i2"), ("thermal", "f4")]):
        add(f"npy-{quantity}-{dtype}-dark-stated", numpy_file, quantity, seed + 24, dtype, cloud_is="dark")
    add("npz-kelvin-dark-stated", numpy_file, "kelvin", 28, "f4", archive=True, cloud_is="dark", hidden=True)
    add("npy-celsius-dark-stated", numpy_file, "celsius", 29, "f4", cloud_is="dark")
    add("npz-grey", numpy_file, "grey", 30, "u1", archive=True)
    add("npz-reflectance", numpy_file, "reflectance", 31, "f4", archive=True, hidden=True)
    add("npy-saturated-8-bit", lambda folder: special(folder, *_plateau("grey", 255, np.uint8)))
    add("npy-saturated-16-bit", lambda folder: special(folder, *_plateau("counts", 65535, np.uint16)))
    add("npy-saturated-12-bit", lambda folder: special(folder, *_plateau("counts12", 4095, np.uint16)))
    for seed in range(3):
        add(f"npy-lognormal-{seed}", lambda folder, seed=seed: special(folder, _lognormal(seed)))
    add("npy-mask-bool", lambda folder: special(folder, scene("grey", 32)[1], scene("grey", 32)[1]))
    add("npy-mask-0-255", lambda folder: special(folder, scene("grey", 32)[1] * np.uint8(255), scene("grey", 32)[1]))
    add("npy-mask-0-1", lambda folder: special(folder, scene("grey", 32)[1] * 1.0, scene("grey", 32)[1]))
    add("npy-three-levels", lambda folder: special(folder, np.digitize(scene("grey", 34)[0], [100, 220]).astype("u1")))
    add("npy-sea-of-one-value", lambda folder: special(folder, *_bordered(12)))
    add("npy-sea-of-zeros", lambda folder: special(folder, *_bordered(0)))

    kelvin = {"units": "K", "long_name": "brightness temperature"}
    for seed, unit in enumerate(("K", "kelvin", "Kelvin", "degK", "degrees_kelvin", "deg K")):
        add(f"nc-unit-{unit}", netcdf, "kelvin", 40 + seed, units=unit, fill=-999.0)
    add("nc-celsius", netcdf, "celsius", 46, units="degC", long_name="brightness temperature")
    add("nc-standard-name", netcdf, "kelvin", 47, standard_name="toa_brightness_temperature")
    add("nc-default-fill", netcdf, "kelvin", 48, **kelvin)
    add("nc-nan-fill", netcdf, "kelvin", 49, fill=np.nan, **kelvin)
    add("nc-missing-value", netcdf, "kelvin", 50, missing_value=np.float32(-9999.0), **kelvin)
    add("nc-valid-max", netcdf, "reflectance", 51, valid_max=np.float32(2.0), units="1")
    add("nc-valid-min", netcdf, "reflectance", 52, valid_min=np.float32(0.0), units="1")
    add("nc-valid-range", netcdf, "kelvin", 53, valid_range=np.float32([150.0, 350.0]), **kelvin)
    for seed, form in enumerate(("NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET", "NETCDF4_CLASSIC")):
        add(f"nc-{form.lower()}", netcdf, "kelvin", 54 + seed, form=form, fill=-1e30, **kelvin)
    add("nc-packed", netcdf, "kelvin", 57, "i2", fill=-32768, scale_factor=0.01, add_offset=200.0, **kelvin)
    add("nc-packed-default", netcdf, "kelvin", 58, "i2", scale_factor=0.01, add_offset=200.0, **kelvin)
    add("nc-packed-reflectance", netcdf, "reflectance", 59, "u2", fill=65535, scale_factor=1e-4, units="1")
    add("nc-percent", netcdf, "percent", 60, units="%", long_name="reflectance")
    add("nc-radiance", netcdf, "radiance", 61, units="W m-2 sr-1 um-1", hidden=False)
    add("nc-counts", netcdf, "counts", 62, "u2", hidden=False)
    add("nc-time-of-one", netcdf, "kelvin", 63, dims=3, **kelvin)
    add("nc-no-units-reflectance", netcdf, "reflectance", 64, hidden=False)
    add("nc-grey", netcdf, "grey", 65, "u1", hidden=False, units="1")

    for seed, (quantity, dtype, nodata) in enumerate([
        ("grey", "uint8", 0), ("grey", "uint8", 255), ("counts", "uint16", 0), ("counts", "uint16", 65535),
        ("reflectance", "float32", -9999.0), ("reflectance", "float32", np.nan),
        ("radiance", "float32", -3.4028234663852886e38),
        ("counts", "int32", -2147483648), ("percent", "float64", 1e20),
    ]):  # fmt: skip
        add(f"tif-nodata-{nodata:g}-{dtype}", geotiff, quantity, 70 + seed, dtype, nodata=nodata)
    add("tif-plain", geotiff, "grey", 80, "uint8")
    add("tif-mask", geotiff, "grey", 81, "uint8", mask=True)
    add("tif-mask-float", geotiff, "reflectance", 82, "float32", mask=True)
    add("tif-grey-alpha", geotiff, "grey", 83, "uint8", alpha=True)
    add("tif-grey-alpha-16", geotiff, "counts", 84, "uint16", alpha=True)
    add("tif-rgba", geotiff, "grey", 85, "uint8", bands=3, alpha=True, photometric="RGB")
    add("tif-rgb", geotiff, "grey", 86, "uint8", bands=3, photometric="RGB")
    add("tif-rgb-nodata", geotiff, "grey", 87, "uint8", bands=3, photometric="RGB", nodata=0)
    add("tif-kelvin-unit", geotiff, "kelvin", 88, "float32", unit="K")
    add("tif-kelvin-packed", geotiff, "kelvin", 89, "int16", unit="K", packed=True, nodata=-32768)
    add("tif-two-bands", geotiff, "reflectance", 90, "float32", bands=2)
    add(
        "tif-deflate-tiled",
        geotiff,
        "counts",
        91,
        "uint16",
        compress="deflate",
        tiled=True,
        blockxsize=16,
        blockysize=16,
    )
    add("tif-big", geotiff, "counts", 92, "uint16", BIGTIFF="YES")

    for seed, (mode, hidden) in enumerate([
        ("L", False), ("L", True), ("LA", False), ("LA", True), ("RGB", False), ("RGB", True), ("RGBA", True),
        ("P", False), ("P", True), ("1", False),
    ]):  # fmt: skip
        add(f"png-{mode}{'-transparent' if hidden else ''}", picture, 100 + seed, mode, hidden=hidden)
    add("png-16-bit", picture, 110, "I;16", quantity="counts")
    add("png-16-bit-transparent", picture, 111, "I;16", quantity="counts", hidden=True)
    add("png-haze", picture, 112, "L", quantity="haze")
    add("jpg-grey", picture, 113, "L", "jpg", quality=95)
    add("jpg-colour", picture, 114, "RGB", "jpg", quality=95)
    add("bmp", picture, 116, "L", "bmp")
    add("gif", picture, 117, "P", "gif")
    add("webp", picture, 118, "RGBA", "webp", hidden=True, lossless=True)
    return cases
