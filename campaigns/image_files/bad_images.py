"""100 bad images: each is refused, or what is wrong with it is named; none is silently cloud.

``words`` are regular expressions that the error or the notes must match, in any case.
"""

import io
import re
import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import tifffile
from image_scenes import patch, scene
from PIL import Image


@dataclass(frozen=True)
class Bad:
    """A file, what its message must name, and the coverage of what is visible, if the file is accepted."""

    path: Path
    words: tuple[str, ...]
    coverage: float | None = None
    variable: str | None = None
    options: dict[str, Any] = field(default_factory=dict)


def write(folder, values, form, **attributes):
    """Write values as .npy, .npz, .nc (no attributes but those given), .tif (no tags) or .png."""
    path = folder / f"a.{form}"
    if form == "npy":
        np.save(path, values)
    elif form == "npz":
        np.savez(path, image=values)
    elif form == "tif":
        tifffile.imwrite(path, values)
    elif form == "png":
        Image.fromarray(values).save(path)
    else:
        with netCDF4.Dataset(path, "w") as file:
            for name, size in zip("yx", values.shape, strict=True):
                file.createDimension(name, size)
            item = file.createVariable("image", values.dtype, ("y", "x"), fill_value=False)
            item.set_auto_maskandscale(False)
            item.setncatts(attributes)
            item[...] = values
    return path


def unstated(folder, quantity, seed, dtype, form, fill=None, word="kelvin", hidden=False):
    values, _ = scene(quantity, seed)
    gone = patch(seed)
    if hidden:
        values = np.where(gone, np.nan, values)
    if fill is not None:
        values = np.where(gone, fill, values)
    words = (
        (word,)
        if fill is None
        else (word, rf"(?<![\d.]){re.escape(f'{fill:g}')}(?!\d)", rf"\b{np.count_nonzero(gone)}\b")
    )
    return Bad(write(folder, values.astype(dtype), form), words)


def filled(folder, quantity, seed, dtype, form, fill, shown=None, single=False, options=None, **attributes):
    """A scene with an undeclared value for pixels without one."""
    values, cloud = scene(quantity, seed)
    gone = patch(seed)
    if single:
        gone = np.zeros(values.shape, bool)
        gone[11, 17] = True
    values = np.where(gone, fill, values).astype(dtype)
    number = shown or rf"{float(np.asarray(fill).astype(dtype)):g}".replace("+", r"\+")
    words = (rf"(?<![\d.]){number}", rf"\b{np.count_nonzero(gone)}\b")
    return Bad(write(folder, values, form, **attributes), words, float(cloud[~gone].mean()), options=options or {})


def two_fills(folder, quantity, seed, dtype, form, fills, **attributes):
    values, cloud = scene(quantity, seed)
    gone, other = patch(seed), patch(seed + 500)
    values = np.where(other, fills[1], np.where(gone, fills[0], values)).astype(dtype)
    words = tuple(rf"(?<![\d.]){each:g}" for each in fills)
    return Bad(write(folder, values, form, **attributes), words, float(cloud[~gone & ~other].mean()))


def bordered(folder, seed, level, form, sides=(4, 4, 4, 4), quantity="grey", dtype=np.uint8):
    values, cloud = scene(quantity, seed)
    inside = np.zeros(values.shape, bool)
    top, bottom, left, right = sides
    inside[top : values.shape[0] - bottom, left : values.shape[1] - right] = True
    values = np.where(inside, values, level).astype(dtype)
    if form == "jpg":
        Image.fromarray(values).save(folder / "a.jpg", quality=95)
        path = folder / "a.jpg"
    else:
        path = write(folder, values, form)
    return Bad(path, ("border",), float(cloud[inside].mean()))


def impossible(folder, values, word, **attributes):
    return Bad(write(folder, values, "nc", **attributes), (word,))


def odd_array(folder, values, *words):
    np.save(folder / "a.npy", values, allow_pickle=values.dtype.kind == "O")
    return Bad(folder / "a.npy", words)


def declared(folder, shape, *words):
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": shape})
    (folder / "a.npy").write_bytes(stream.getvalue() + bytes(64))
    return Bad(folder / "a.npy", words)


def odd_picture(folder, values, mode, suffix, *words, **options):
    path = folder / f"a.{suffix}"
    Image.fromarray(values.astype(np.uint8), mode if mode in ("LA", "RGBA") else None).save(path, **options)
    return Bad(path, words)


def several(folder, form):
    first, second = (np.rint(scene("grey", seed)[0]).astype(np.uint8) for seed in (90, 91))
    path = folder / f"a.{form}"
    if form in ("gif", "tif", "webp"):
        Image.fromarray(first).save(path, save_all=True, append_images=[Image.fromarray(second)])
        return Bad(path, (r"\b2\b",))
    if form == "npz":
        np.savez(path, one=first, two=second)
        return Bad(path, ("one", "two"))
    with netCDF4.Dataset(path, "w") as file:
        for name, size in zip(("time", "y", "x"), (2, *first.shape), strict=True):
            file.createDimension(name, size)
        file.createVariable("stack", "u1", ("time", "y", "x"))[...] = np.stack([first, second])
    return Bad(path, ("dimension",))


def npz_of_text(folder):
    with zipfile.ZipFile(folder / "a.npz", "w") as archive:
        archive.writestr("readme.txt", "no array")
    return Bad(folder / "a.npz", ("array|image",))


def bad_cases():
    """Return (name, function of a folder) of the 100 bad images."""
    cases = []

    def add(name, function, *args, **kwargs):
        cases.append((name, lambda folder: function(folder, *args, **kwargs)))

    for seed, (dtype, form, fill) in enumerate([
        ("f4", "npy", None), ("f8", "npy", None), ("i2", "npy", None), ("u2", "npy", None), ("f4", "npz", None),
        ("u2", "png", None), ("f4", "tif", None), ("u2", "tif", None), ("f4", "nc", None), ("i2", "nc", None),
        ("f4", "npy", 0.0), ("f4", "npy", -9999.0), ("f8", "tif", -999.0), ("u2", "png", 0.0), ("u2", "npy", 65535.0),
        ("f4", "nc", 1e20), ("i2", "npy", -32768.0), ("f4", "npz", 9999.0),
    ]):  # fmt: skip
        add(f"kelvin-unstated-{form}-{dtype}-{fill}", unstated, "kelvin", seed, dtype, form, fill)
    add("kelvin-unstated-nan", unstated, "kelvin", 20, "f4", "npy", hidden=True)
    add("celsius-unstated-npy", unstated, "celsius", 21, "f4", "npy", word="celsius")
    add("celsius-unstated-tif", unstated, "celsius", 22, "f4", "tif", word="celsius")

    for seed, (quantity, dtype, form, fill) in enumerate([
        ("grey", "i2", "npy", -9999), ("grey", "f4", "npy", -999), ("grey", "i4", "npy", 99999),
        ("grey", "i2", "npy", -1),
        ("grey", "i2", "npz", -32768), ("grey", "i2", "npy", 32767), ("grey", "u2", "npy", 65535),
        ("grey", "f8", "npy", 1e20),
        ("counts", "f4", "npy", -9999), ("counts", "i4", "tif", -2147483648),
        ("counts", "f4", "tif", -3.4028234663852886e38),
        ("counts12", "u2", "png", 65535), ("counts12", "u2", "tif", 65535), ("counts12", "i2", "npy", 32767),
        ("counts12", "i2", "npy", -999), ("reflectance", "f4", "npy", -9999), ("reflectance", "f4", "npz", -999),
        ("reflectance", "f8", "npy", 9.969209968386869e36), ("reflectance", "f4", "tif", 1e20),
        ("reflectance", "f4", "npy", -1),
        ("reflectance", "f4", "npy", 9999), ("reflectance", "f4", "npy", 65535), ("reflectance", "f4", "npy", -32767),
        ("reflectance", "f4", "npy", 255), ("percent", "u1", "npy", 255), ("percent", "f4", "npy", 999),
        ("percent", "i2", "tif", -99),
        ("radiance", "f4", "npy", -9999), ("radiance", "f4", "tif", 1e30), ("radiance", "f4", "npz", -99.9),
        ("anomaly", "f8", "npy", -9999), ("anomaly", "f8", "npy", 1e20), ("thickness", "f4", "npy", -9999),
        ("thickness", "f4", "npy", 99999),
    ]):  # fmt: skip
        add(f"fill-{quantity}-{form}-{dtype}-{fill:g}", filled, quantity, 30 + seed, dtype, form, fill)
    stated = {"units": "K", "long_name": "brightness temperature"}
    for seed, (dtype, fill) in enumerate([
        ("f4", 0.0), ("f4", -9999.0), ("f4", -999.0), ("f4", 9.969209968386869e36), ("f4", 1e20), ("f8", 65535.0),
        ("i2", -32768), ("i2", 0), ("f4", -1.0), ("f4", 999.0), ("f4", 1.0), ("f4", 50.0),
    ]):  # fmt: skip
        add(f"fill-kelvin-nc-{dtype}-{fill:g}", filled, "kelvin", 70 + seed, dtype, "nc", fill, **stated)
    add("fill-kelvin-npy-dark-0", filled, "kelvin", 83, "f4", "npy", 0.0, options={"cloud_is": "dark"})
    add("fill-kelvin-npy-dark--9999", filled, "kelvin", 84, "f4", "npy", -9999.0, options={"cloud_is": "dark"})
    add("fill-thermal-npy-dark--1", filled, "thermal", 85, "f4", "npy", -1.0, options={"cloud_is": "dark"})
    add("fill-thermal-npy-dark-0", filled, "thermal", 86, "f4", "npy", 0.0, options={"cloud_is": "dark"})
    add("spike-counts", filled, "counts12", 87, "f4", "npy", 1e6, single=True)
    add("spike-reflectance", filled, "reflectance", 88, "f4", "npy", -500.0, single=True)
    add("fills-reflectance", two_fills, "reflectance", 89, "f4", "npy", (-9999.0, 9999.0))
    add("fills-kelvin", two_fills, "kelvin", 90, "f4", "nc", (-9999.0, 0.0), **stated)
    add("fills-counts", two_fills, "counts12", 91, "i4", "tif", (-9999.0, 65535.0))

    for seed, (level, form, sides) in enumerate([
        (255, "png", (4, 4, 4, 4)), (255, "tif", (4, 4, 4, 4)), (255, "jpg", (8, 8, 8, 8)), (255, "npy", (0, 6, 0, 0)),
        (255, "png", (0, 0, 0, 7)), (0, "png", (4, 4, 4, 4)), (0, "jpg", (8, 8, 8, 8)), (0, "tif", (0, 0, 5, 5)),
    ]):  # fmt: skip
        add(f"border-{level}-{form}-{seed}", bordered, 100 + seed, level, form, sides)

    kelvin = scene("kelvin", 110)[0]
    add("nc-packed-kelvin-without-scale", impossible, np.rint(kelvin * 100).astype("i2"), r"\bK\b", **stated)
    add("nc-packed-kelvin-tenths", impossible, np.rint(kelvin * 10).astype("i2"), r"\bK\b", **stated)
    add("nc-reflectance-called-kelvin", impossible, scene("reflectance", 111)[0], r"\bK\b", **stated)
    add("nc-celsius-called-kelvin", impossible, scene("celsius", 112)[0], r"\bK\b", **stated)
    add("nc-kelvin-called-celsius", impossible, kelvin, "degC", units="degC", long_name="brightness temperature")

    wide = np.arange(60.0).reshape(1, 60)
    add("shape-1-row", odd_array, wide, r"\b1 x 60\b")
    add("shape-1-column", odd_array, wide.T, r"\b60 x 1\b")
    add("shape-1-pixel", odd_array, np.ones((1, 1)), r"\b1 x 1\b")
    add("shape-no-rows", odd_array, np.ones((0, 5)), r"\b0 x 5\b|\(0, 5\)")
    add("shape-no-columns", odd_array, np.ones((5, 0)), r"\b5 x 0\b|\(5, 0\)")
    add("shape-1-d", odd_array, np.arange(50.0), "shape|rows")
    add("shape-3-d", odd_array, np.ones((3, 40, 40)), "shape|rows")
    add("type-complex", odd_array, np.ones((40, 40), complex), "complex")
    add("type-object", odd_array, np.full((40, 40), None), "object|pickle")
    add("type-text", odd_array, np.full((40, 40), "7"), "<U1|text")
    add("type-date", odd_array, np.zeros((40, 40), "M8[s]"), "datetime64")
    add("type-fields", odd_array, np.zeros((40, 40), [("a", "f4")]), "'a'")
    add("value-constant", odd_array, np.full((40, 40), 7.0), r"\b7\b")
    add("value-nan", odd_array, np.full((40, 40), np.nan), "missing")
    add("value-infinite", odd_array, np.full((40, 40), np.inf), "missing|inf")
    add("value-all-fill-but-one", odd_array, np.where(np.arange(1600).reshape(40, 40) == 7, 0.5, np.nan), "value")
    add("declared-huge", declared, (2**20, 2**20), "1048576 x 1048576")
    add("declared-more-than-there-is", declared, (400, 400), "read|damaged")
    add(
        "png-all-transparent",
        odd_picture,
        np.stack([scene("grey", 120)[0], np.zeros((40, 56))], -1),
        "LA",
        "png",
        "missing",
    )
    add("png-1-row", odd_picture, wide, "L", "png", r"\b1 x 60\b")
    add("png-constant", odd_picture, np.full((40, 40), 9), "L", "png", r"\b9\b")
    for form in ("gif", "tif", "webp", "npz", "nc"):
        add(f"several-{form}", several, form)
    add("npz-of-text", npz_of_text)
    return cases
