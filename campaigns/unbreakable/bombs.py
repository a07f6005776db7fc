"""Small files that declare, or unfold to, more than any memory or patience holds, and the commands that read them."""

import json
import struct
import zipfile
import zlib
from io import BytesIO

import netCDF4
import numpy as np

HUGE = (10**6, 10**6)


def npy(path, shape=HUGE):
    """Write the header of an array without its values."""
    with path.open("wb") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f4", "fortran_order": False, "shape": shape})


def npz(path, shape=HUGE, name="a.npy", values=b""):
    """Write an archive with the header of an array, and some values."""
    header = BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "|u1", "fortran_order": False, "shape": shape})
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, header.getvalue() + values)


def unfolding_npz(path):
    """Write an archive of some hundred kB with an image of 400 MB."""
    npz(path, (20_000, 20_000), values=bytes(400_000_000))


def netcdf(path, shape=HUGE, name="Rad", **attributes):
    """Write a variable of a size without its values."""
    with netCDF4.Dataset(path, "w") as file:
        for axis, size in zip("yx", shape, strict=True):
            file.createDimension(axis, size)
        file.createVariable(name, "f4", ("y", "x"), zlib=True, chunksizes=(1000, 1000))
        file.setncatts(attributes)


def cube(path):
    """Write the same with the mark of a cube."""
    netcdf(path, name="radiance", hcss_cube_format=np.int32(1))


def posterior(path):
    """Write the same with the mark of a posterior."""
    netcdf(path, name="H", hcss_posterior_version=np.int32(1))


def propagation(path):
    """Write the same with the mark of a propagation."""
    netcdf(path, name="mean", hcss_propagation_version=np.int32(1))


def swept(path):
    """Write the same with the mark of the dataset of a sweep."""
    netcdf(path, name="radiance", hcss_sweep="x", hcss_cube_format=np.int32(1))


def table(path):
    """Write the same with the mark of an atmosphere table."""
    netcdf(path, name="transmittance", format="hcss-atmosphere-table", format_version=np.int32(1))


def zarr(path):
    """Write a Zarr folder that declares an array of 4 TB."""
    (path / "radiance").mkdir(parents=True)
    about = {"zarr_format": 2, "shape": HUGE, "chunks": HUGE, "dtype": "<f4", "compressor": None, "fill_value": 0,
             "order": "C", "filters": None}  # fmt: skip
    (path / ".zgroup").write_text('{"zarr_format": 2}')
    (path / ".zattrs").write_text('{"hcss_cube_format": 1}')
    (path / "radiance" / ".zarray").write_text(json.dumps(about))
    (path / "radiance" / ".zattrs").write_text('{"_ARRAY_DIMENSIONS": ["y", "x"]}')


def _part(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(path, shape=(12_000, 12_000), text=b"", profile=b""):
    """Write a picture of a size with few of its rows, perhaps with a compressed text or colour profile."""
    size = struct.pack(">IIBBBBB", shape[1], shape[0], 8, 0, 0, 0, 0)
    rows = zlib.compress(bytes((shape[1] + 1) * min(shape[0], 40)))
    parts = [_part(b"IHDR", size)]
    parts += [_part(b"zTXt", b"Comment\0\0" + zlib.compress(text))] if text else []
    parts += [_part(b"iCCP", b"profile\0\0" + zlib.compress(profile))] if profile else []
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join([*parts, _part(b"IDAT", rows), _part(b"IEND", b"")]))


def png_text(path):
    """Write a picture of 40 x 40 pixels with a comment of 500 MB."""
    png(path, (40, 40), text=bytes(500_000_000))


def png_profile(path):
    """Write a picture of 40 x 40 pixels with a colour profile of 500 MB."""
    png(path, (40, 40), profile=bytes(500_000_000))


def tiff(path):
    """Write a TIFF header of 100 000 x 100 000 pixels."""
    tags = [(256, 100_000), (257, 100_000), (258, 8), (259, 1), (262, 1), (273, 8), (278, 100_000), (279, 8)]
    entries = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags)
    path.write_bytes(b"II*\0\x10\0\0\0" + bytes(8) + struct.pack("<H", len(tags)) + entries + bytes(4))


def deep_json(path):
    """Write 200 000 nested lists."""
    path.write_text('{"MODTRAN": ' + "[" * 200_000)


def deep_toml(path):
    """Write 50 000 nested arrays."""
    path.write_text("bands = " + "[" * 50_000)


def long_toml(path):
    """Write a number of 10 million digits."""
    path.write_text("seed = " + "9" * 10_000_000)


def long_profile(path):
    """Write a profile of 3 million levels."""
    path.write_text("altitude_m,pressure_Pa,temperature_K,h2o\n" + "0,101325,288,0.01\n" * 3_000_000)


def long_response(path):
    """Write a spectral response of 2 million rows."""
    path.write_text("wavelength_um,response\n" + "10,1\n" * 2_000_000)


def gz(path):
    """Write 500 MB of zeros, compressed."""
    import gzip

    path.write_bytes(gzip.compress(bytes(500_000_000)))


IMPORT = ["import", "{file}", "--pixel-size", "1 km"]
PLAN = ["plan", "stratus", "--set"]

BOMBS = {
    "array": (npy, "bomb.npy", IMPORT),
    "archive": (npz, "bomb.npz", IMPORT),
    "archive that unfolds": (unfolding_npz, "bomb.npz", IMPORT),
    "picture": (png, "bomb.png", IMPORT),
    "picture with a text": (png_text, "bomb.png", IMPORT),
    "picture with a profile": (png_profile, "bomb.png", IMPORT),
    "TIFF": (tiff, "bomb.tif", IMPORT),
    "NetCDF image": (netcdf, "bomb.nc", IMPORT),
    "compressed file": (gz, "bomb.npy.gz", IMPORT),
    "compressed scene": (gz, "bomb.toml", ["plan", "{file}"]),
    "cube, export": (cube, "bomb.nc", ["export", "{file}", "--to", "fits"]),
    "cube, preview": (cube, "bomb.nc", ["preview", "{file}"]),
    "cube, report": (cube, "bomb.nc", ["report", "{file}"]),
    "cube, verify": (cube, "bomb.nc", ["verify", "{file}"]),
    "cube, sense": (cube, "bomb.nc", ["sense", "{file}", "--sensor", "generic-mwir"]),
    "cube, evaluate": (cube, "bomb.nc", ["evaluate", "{file}", "{file}"]),
    "Zarr cube": (zarr, "bomb.zarr", ["export", "{file}", "--to", "fits"]),
    "posterior": (posterior, "bomb.nc", ["report", "{file}"]),
    "propagation": (propagation, "bomb.nc", ["report", "{file}"]),
    "dataset of a sweep": (swept, "bomb.nc", ["report", "{file}"]),
    "atmosphere table": (table, "bomb.nc", [*PLAN, "atmosphere.provider=table", "--set",
                                            "atmosphere.parameters.file={file}"]),
    "nested JSON": (deep_json, "bomb.json", ["atmosphere", "import", "{file}", "-o", "table.nc"]),
    "nested TOML": (deep_toml, "bomb.toml", ["plan", "{file}"]),
    "number in TOML": (long_toml, "bomb.toml", ["plan", "{file}"]),
    "profile": (long_profile, "bomb.csv", [*PLAN, "atmosphere.profile={file}"]),
    "response": (long_response, "bomb.csv", [*PLAN, 'bands=[{name = "x", response = "{file}"}]']),
    "raster": (netcdf, "bomb.nc", [*PLAN, "surfaces.provider=raster", "--set", "surfaces.parameters.file={file}",
                                   "--set", 'surfaces.parameters.classes={0 = "sea"}']),
    "sweep of 1e10 points": (npy, "bomb.npy", ["sweep", "stratus",
                                               "--over", "sea.temperature={from=280, to=290, steps=100000}",
                                               "--over", "view.zenith={from=0, to=30, steps=100000}"]),
}  # fmt: skip
"""What writes a bomb, its file, and the command that reads it."""
