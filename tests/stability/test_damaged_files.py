"""Files that are damaged, or declare more than they contain: one error that names the file, or a valid result."""

import struct
import time
import zlib

import netCDF4
import numpy as np
import pytest
from damage import fresh_copy, what_escapes
from file_readers import READERS
from input_files import make_files

from hcss_twin.core.errors import CatalogError, CubeError, HcssError
from hcss_twin.core.reading import MAX_IMAGE_PIXELS, Reading
from hcss_twin.cube import header
from hcss_twin.cube.reader import open_cube
from hcss_twin.models.atmosphere.table_file import FORMAT, FORMAT_VERSION, AtmosphereTable
from hcss_twin.models.clouds.imagery.reader import read_image

GROUPS = ("fast", pytest.param("slow", marks=pytest.mark.long))


@pytest.fixture(scope="module", params=GROUPS)
def group(request, tmp_path_factory):
    """A group of readers with its files, the folder of these, and a folder for copies."""
    folder = tmp_path_factory.mktemp(request.param)
    return request.param, make_files(folder / "files", runs=request.param != "fast"), folder


def test_every_reader_reads_the_file_before_it_is_damaged(group):
    name, files, folder = group
    for file, readers in READERS[name].items():
        for reader in readers.values():
            reader(fresh_copy(files[file], folder))


@pytest.mark.parametrize(("number", "size"), [(0, 0), (1, 2**64 - 16)])
def test_a_collection_of_texts_that_never_ends_is_refused(tmp_path, number, size):
    # HDF5 2.0 would look for the next object for ever; here nothing opens the file.
    path = tmp_path / "texts.nc"
    with netCDF4.Dataset(path, "w") as file:
        file.setncattr_string("text", "abc")
    with Reading(path, CubeError), netCDF4.Dataset(path) as file:
        assert file.text == "abc"
    data = bytearray(path.read_bytes())
    first = data.index(b"GCOL") + 16
    assert struct.unpack_from("<H6xQ", data, first) == (1, 3)
    struct.pack_into("<H6xQ", data, first, number, size)
    path.write_bytes(data)
    with pytest.raises(CubeError, match=r"texts\.nc.*an object of no size"), Reading(path, CubeError):
        pytest.fail("the file would be opened")


def test_only_errors_of_the_package_escape(group):
    # Each file with each reader; campaigns/unbreakable has 112 000 and 2000.
    escaped, outcomes = what_escapes(*group, range(10_000, 10_300 if group[0] == "fast" else 10_060))
    assert not escaped
    assert outcomes["refused"]


def npy(path, shape):
    with path.open("wb") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f4", "fortran_order": False, "shape": shape})


def netcdf(path, shape):
    with netCDF4.Dataset(path, "w") as file:
        for name, size in zip("yx", shape, strict=True):
            file.createDimension(name, size)
        file.createVariable("Rad", "f4", ("y", "x"), zlib=True, chunksizes=(1000, 1000))


def png(path, shape):
    def part(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    size = struct.pack(">IIBBBBB", shape[1], shape[0], 8, 0, 0, 0, 0)
    rows = zlib.compress(bytes((shape[1] + 1) * 10))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + part(b"IHDR", size) + part(b"IDAT", rows) + part(b"IEND", b""))


@pytest.mark.parametrize(("write", "shape"), [(npy, (10**6, 10**6)), (netcdf, (10**6, 10**6)), (png, (12_000, 12_000))])
def test_an_image_is_refused_by_its_declared_size(tmp_path, write, shape):
    path = tmp_path / f"bomb.{write.__name__}"
    write(path, shape)
    start = time.process_time()
    with pytest.raises(CatalogError, match=rf"declares {shape[0]} x {shape[1]} pixels; allowed: {MAX_IMAGE_PIXELS}"):
        read_image(path)
    assert time.process_time() - start < 2.0


def test_a_cube_is_refused_by_its_declared_size(tmp_path):
    path = tmp_path / "cube.nc"
    netcdf(path, (10**6, 10**6))
    with netCDF4.Dataset(path, "a") as file:
        file.setncattr(header.FORMAT_ATTRIBUTE, np.int32(header.FORMAT_VERSION))
    with pytest.raises(CubeError, match=r"declares 4000000 MB of values, which cannot be in a file of 0\.\d MB"):
        open_cube(path)


def test_a_table_is_refused_by_its_declared_size(tmp_path):
    path = tmp_path / "table.nc"
    netcdf(path, (10**6, 10**6))
    with netCDF4.Dataset(path, "a") as file:
        file.format, file.format_version = FORMAT, FORMAT_VERSION
    with pytest.raises(CatalogError, match="declares 1000000 x 1000000 values of Rad"):
        AtmosphereTable.read(path)


def test_the_door_names_the_file_keeps_the_cause_and_lets_our_errors_and_interrupts_pass():
    cause = ValueError("odd\n bytes")
    message = r"^cannot read a\.nc: it is damaged .*: ValueError: odd bytes$"
    with pytest.raises(CubeError, match=message) as caught, Reading("a.nc", CubeError):
        raise cause
    assert caught.value.__cause__ is cause
    with pytest.raises(CubeError, match="declares more values than fit into memory"), Reading("a.nc", CubeError):
        raise MemoryError
    for passing in (HcssError("ours"), KeyboardInterrupt(), ImportError("a package")):

        @Reading.argument(CubeError)
        def fail(path, error):
            raise error

        with pytest.raises(type(passing)) as caught:
            fail("a.nc", error=passing)
        assert caught.value is passing
