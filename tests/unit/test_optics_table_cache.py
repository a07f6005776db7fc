"""Tables of bulk optics: found by content, kept between runs, whole or not at all."""

import itertools
import os
from dataclasses import replace

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CacheWarning, CatalogError
from hcss_twin.models.optics import bulk, table_store
from hcss_twin.models.optics.bulk import Accuracy, BulkTable
from hcss_twin.models.optics.size_distribution import gamma_distribution
from hcss_twin.models.optics.table_store import TableStore, cache_folder
from hcss_twin.models.refractive_index import load_refractive_index

CLOUD = gamma_distribution("water", 5.0, 0.1, 1e-4)
ACCURACY = Accuracy(radius_nodes=50, spectral_step=0.05, moments=16)
WINDOW = np.log(np.linspace(10.0, 11.0, 9))
MEDIUM = np.log(np.linspace(3.5, 4.0, 9))
LONG = np.log(np.linspace(6.0, 15.0, 400))
"""So many wavelengths that a run tells of them: more than 64 nodes."""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache" / "optics"


@pytest.fixture(scope="module")
def index():
    return load_refractive_index(Catalog(), "water")


def make(index, cloud=CLOUD, accuracy=ACCURACY):
    return BulkTable(cloud, index, accuracy)


def completed(index, position=WINDOW):
    table = make(index)
    TableStore(Catalog()).complete(table, position)
    return table


def refuse(*_):
    raise AssertionError("computed what is in the cache")


def test_a_second_run_computes_nothing_and_gives_the_same_numbers(index, folder, monkeypatch) -> None:
    first = completed(index)
    assert [path.name for path in folder.iterdir()] == [f"{first.key}.nc"]
    monkeypatch.setattr(bulk, "bulk_properties", refuse)
    monkeypatch.setattr(bulk, "bulk_moments", refuse)
    for ours, theirs in zip(completed(index)(WINDOW), first(WINDOW), strict=True):
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("damage", ["cut", "noise", "text", "empty", "folder"])
def test_a_damaged_file_is_computed_again(damage, index, folder) -> None:
    good = completed(index)
    path = folder / f"{good.key}.nc"
    content = path.read_bytes()
    if damage == "folder":
        path.unlink()
        path.mkdir()
    elif damage == "noise":
        data = bytearray(content)
        middle = len(data) // 2
        data[middle : middle + 400] = bytes(255 - each for each in data[middle : middle + 400])
        path.write_bytes(bytes(data))
    else:
        path.write_bytes({"cut": content[: len(content) // 2], "text": b"hello\n", "empty": b""}[damage])
    again = completed(index)
    for ours, theirs in zip(again(WINDOW), good(WINDOW), strict=True):
        np.testing.assert_array_equal(ours, theirs)
    if damage != "folder":
        table_store.read_into(make(index), path)  # whole again
    assert [each.name for each in folder.iterdir()] == [path.name]


def test_runs_side_by_side_lose_nothing(index, folder) -> None:
    parts = [WINDOW, MEDIUM, np.log(np.linspace(8.0, 9.0, 9)), np.log(np.linspace(12.0, 13.0, 9))]
    children = []
    for part in parts:  # processes, as the library under NetCDF is not made for threads
        child = os.fork() if hasattr(os, "fork") else pytest.skip("no fork on this system")
        if child == 0:
            status = 1
            try:
                completed(index, part)
                status = 0
            finally:
                os._exit(status)
        children.append(child)
    assert all(os.waitpid(child, 0)[1] == 0 for child in children)
    table = make(index)
    table_store.read_into(table, folder / f"{table.key}.nc")
    known = sum(table.properties.missing(part).size == 0 for part in parts)
    assert known >= 1  # a lost race costs time in the next run, never a damaged file
    assert len(list(folder.iterdir())) == 1


def test_later_wavelengths_are_added_to_the_file(index, folder) -> None:
    completed(index, WINDOW)
    completed(index, MEDIUM)
    table = make(index)
    table_store.read_into(table, folder / f"{table.key}.nc")
    assert table.properties.missing(np.concatenate([WINDOW, MEDIUM])).size == 0
    assert table.moments.missing(np.concatenate([WINDOW, MEDIUM])).size == 0


def test_the_key_tells_apart_whatever_changes_the_numbers(index) -> None:
    key = make(index).key
    others = [
        make(index, replace(CLOUD, b=CLOUD.b * (1 + 1e-12))),
        make(index, replace(CLOUD, radius_range_um=(0.1, 40.0))),
        make(index, accuracy=replace(ACCURACY, moments=17)),
        make(index, accuracy=replace(ACCURACY, radius_nodes=51)),
        make(load_refractive_index(Catalog(), "water-273K")),
    ]
    assert len({key, *(other.key for other in others)}) == 6
    assert make(index, replace(CLOUD, number_density_m3=1.0)).key == key


def test_a_cache_that_cannot_be_written_only_costs_time(index, tmp_path, monkeypatch) -> None:
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path / "file"))
    with pytest.warns(CacheWarning, match="file is no folder"):
        assert np.all(np.isfinite(completed(index)(WINDOW)[0]))


def test_a_user_without_a_home_gets_results_all_the_same(index, monkeypatch) -> None:
    def homeless(*_, **__):
        raise RuntimeError("no home")

    for name in ("HCSS_CACHE_DIR", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("platformdirs.user_cache_path", homeless)
    assert cache_folder() is None
    assert np.all(np.isfinite(completed(index)(WINDOW)[0]))


@pytest.mark.skipif(os.name == "nt", reason="Windows has no HOME")
def test_an_empty_home_is_no_home_and_not_the_root_folder(monkeypatch) -> None:
    for name in ("HCSS_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.delenv("HOME", raising=False)
    usual = cache_folder()
    monkeypatch.setenv("HOME", "")
    assert cache_folder() == usual


def test_a_file_of_another_table_is_refused(index, tmp_path) -> None:
    table = completed(index)
    table_store.write(table, tmp_path / "one.nc")
    with pytest.raises(CatalogError, match="another table"):
        table_store.read_into(make(index, accuracy=replace(ACCURACY, moments=8)), tmp_path / "one.nc")


def test_the_cache_lies_where_the_user_says(monkeypatch, tmp_path) -> None:
    assert cache_folder() == tmp_path / "cache" / "optics"
    monkeypatch.delenv("HCSS_CACHE_DIR")
    monkeypatch.setenv("LOCALAPPDATA" if os.name == "nt" else "XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder() == tmp_path / "hcss-twin" / "optics"


def to_compute(index, position):
    """Number of nodes that an empty table needs."""
    table = make(index)
    return table.properties.missing(position).size + table.moments.missing(position).size


def test_a_long_computation_is_announced_once_with_its_time(index, monkeypatch, caplog) -> None:
    """A piece of 16 wavelengths seems to take 5 s."""
    clock = itertools.count(0.0, 5.0)
    monkeypatch.setattr(table_store.time, "monotonic", lambda: next(clock))
    completed(index, LONG)
    left = to_compute(index, LONG) - 16
    assert left > 64
    (message,) = caplog.messages
    assert f"{left} wavelengths" in message
    assert f"{5.0 / 16 * left:.0f} s" in message
    caplog.clear()
    assert 0 < to_compute(index, MEDIUM) - 16 < 32
    completed(index, MEDIUM)
    assert not caplog.messages


def test_progress_is_shown_on_a_terminal_only(index, monkeypatch, capsys, tmp_path) -> None:
    completed(index, LONG)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path / "another"))
    completed(index, LONG)
    assert "cloud optics" in capsys.readouterr().err
