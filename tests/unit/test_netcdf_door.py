"""The door to NetCDF files: one handle for each file that is read, closed by its last user, from any thread."""

import gc
import multiprocessing
import os
import pickle
import shutil
import threading
import warnings

import netCDF4
import numpy as np
import pytest
import xarray as xr

from hcss_twin.core.netcdf import NetcdfFile, netcdf_lock

TEXTS = ["a", "bc"]


@pytest.fixture
def path(tmp_path):
    with NetcdfFile(tmp_path / "a.nc", "w") as file:
        file.title = "mine"
        file.createDimension("n", 2)
        file.createVariable("name", str, ("n",))[:] = np.array(TEXTS, dtype=object)
        packed = file.createVariable("packed", "i2", ("n",), fill_value=-1)
        packed.setncatts({"scale_factor": 0.5, "units": "m"})
        packed[:] = np.ma.masked_array([4.0, 0.0], [False, True])
    return tmp_path / "a.nc"


def handles(path):
    return sum(os.path.samefile(f"/proc/self/fd/{each}", path) for each in os.listdir("/proc/self/fd") if _is(each))


def _is(number):
    return os.path.exists(f"/proc/self/fd/{number}")


on_linux = pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="counts open files in /proc")


def test_what_is_written_is_what_others_read(path):
    with netCDF4.Dataset(path) as file:
        assert file.title == "mine"
        assert list(file["name"][:]) == TEXTS
        assert file["packed"][:].tolist() == [4.0, None]


def test_readers_of_one_file_have_their_own_settings(path):
    with NetcdfFile(path) as one, NetcdfFile(path) as other:
        one.set_auto_maskandscale(False)
        assert one["packed"][:].tolist() == [8, -1]
        assert other["packed"][:].tolist() == [4.0, None]
        other.variables["packed"].set_auto_mask(False)
        assert other["packed"][:].tolist() == [4.0, -0.5]
        assert one["packed"][:].tolist() == [8, -1]


@on_linux
def test_the_last_reader_closes_the_file(path):
    held = NetcdfFile.open_with_xarray(path)
    for _ in range(3):
        with NetcdfFile(path) as file:
            assert file.title == "mine"
        assert handles(path) == 1
        with NetcdfFile.open_with_xarray(path) as other:
            assert list(other["name"].values) == TEXTS
    held.close()
    assert handles(path) == 0
    assert list(held["name"].values) == TEXTS  # as xarray's own files, it opens again
    held.close()
    with pytest.raises(RuntimeError, match="closed"):
        file.ncattrs()


@on_linux
def test_a_file_that_others_have_open_is_read_without_a_warning(path):
    """The list of open files is left early; what is left early must not warn when it is collected."""
    with netCDF4.Dataset(path) as others, open(os.devnull), warnings.catch_warnings():
        warnings.simplefilter("error")
        with NetcdfFile(path) as ours:
            assert ours.variables.keys() == others.variables.keys()
        gc.collect()


def test_files_that_nobody_uses_are_closed_by_whatever_thread_finds_them(path):
    def lose():
        file = NetcdfFile(path)
        assert file["packed"].units == "m"

    for run in (lose, lambda: NetcdfFile.open_with_xarray(path)["name"].values):
        thread = threading.Thread(target=run)
        thread.start()
        thread.join()
    gc.collect()
    assert handles(path) == 0


@on_linux
def test_the_garbage_collector_does_not_wait_for_a_thread_that_reads(path):
    locked, done = threading.Event(), threading.Event()

    def hold():
        with netcdf_lock():
            locked.set()
            done.wait(10)

    file = NetcdfFile(path)
    thread = threading.Thread(target=hold)
    thread.start()
    locked.wait(10)
    del file
    gc.collect()
    assert handles(path) == 1
    done.set()
    thread.join()
    assert handles(path) == 0


def test_values_of_xarrays_own_files_and_ours_are_read_in_turns(path):
    another = shutil.copy(path, path.with_name("another.nc"))
    with xr.open_dataset(another, engine="netcdf4") as theirs, NetcdfFile.open_with_xarray(path, cache=False) as ours:
        lock = xr.backends.netCDF4_.NETCDF4_PYTHON_LOCK
        with netcdf_lock():
            assert lock.locked()
            assert list(ours["name"].values) == TEXTS
        assert not lock.locked()
        ours.to_netcdf(path.with_name("copy.nc"))
        with lock:
            waiting = threading.Thread(target=lambda: ours["packed"].load())
            waiting.start()
            waiting.join(0.05)
            assert waiting.is_alive()
        waiting.join()
        np.testing.assert_array_equal(theirs["packed"].values, [4.0, np.nan])
    with NetcdfFile.open_with_xarray(path.with_name("copy.nc")) as copy:
        assert list(copy["name"].values) == TEXTS


def test_a_dataset_goes_to_another_process_and_a_copied_process_reads(path):
    with NetcdfFile.open_with_xarray(path) as held:
        assert list(pickle.loads(pickle.dumps(held))["name"].values) == TEXTS
        if "fork" in multiprocessing.get_all_start_methods():
            copy = multiprocessing.get_context("fork").Process(target=held["name"].load)
            with netcdf_lock():
                copy.start()
            copy.join(20)
            assert copy.exitcode == 0


def test_what_xarray_writes_through_the_door_is_what_it_writes_itself(tmp_path):
    dataset = xr.Dataset({"a": ("x", [1.0, 2.0]), "b": ("x", ["u", "v"])}, attrs={"title": "t"})
    encoding = {"a": {"zlib": True, "_FillValue": None}}
    NetcdfFile.write_with_xarray(dataset, tmp_path / "ours.nc", encoding=encoding)
    dataset.to_netcdf(tmp_path / "theirs.nc", engine="netcdf4", encoding=encoding)
    assert (tmp_path / "ours.nc").read_bytes() == (tmp_path / "theirs.nc").read_bytes()
