"""Parts of the benchmark that can be wrong: rounds, the timed stages, peers, and bytes written raw."""

import os
import time

import numpy as np
import pytest
from cheap_scene import CHEAP
from hcss_bench.benchmark import even_wavelengths, every_nth, points_of_scene, random_columns
from hcss_bench.reference import column_radiance
from hcss_bench.stages import Rounds, Watch, private_cache, time_certificate, time_stages, write_raw

from hcss_twin import Scenario, make_plan

SMALL = CHEAP | {"image.rows": 30, "image.columns": 40, "frames.count": 3, "output.certificate": 0}


@pytest.fixture(scope="module")
def plan():
    return make_plan(Scenario.load("stratus", SMALL))


def test_ratios_are_taken_within_a_round():
    times = Rounds()
    for base in (1.0, 10.0, 100.0):
        times.add("one", base)
        times.add("two", 2.0 * base)
    assert times.ratio("two", "one") == 2.0
    assert times.seconds("one") == 10.0
    assert times.shortest_ratio("two", "one") == 2.0
    assert times.last("two") == 200.0


def test_what_was_timed_in_the_first_round_only_is_compared_within_it():
    times = Rounds()
    times.add("once", 6.0)
    for seconds in (2.0, 600.0):
        times.add("often", seconds)
    assert times.ratio("once", "often") == 3.0


def test_stages_are_parts_of_the_whole_run_and_tables_are_new_only_where_that_is_asked_for(tmp_path):
    scenario, times = Scenario.load("stratus", SMALL), Rounds()
    with private_cache(tmp_path / "cache"):
        time_stages(times, "new, ", scenario, tmp_path, True)
        time_stages(times, "kept, ", scenario, tmp_path, False)
    for prefix in ("new, ", "kept, "):
        for stage in ("clouds", "look-up", "write", "plan"):
            assert times.seconds(prefix + stage) > 0.0
        assert times.seconds(prefix + "write") < times.seconds(prefix + "whole run, kept tables")
    assert times.seconds("new, compile tables") > times.seconds("new, tables kept earlier")
    with pytest.raises(KeyError):
        times.seconds("kept, compile tables")


def test_the_time_of_a_certificate_is_that_after_the_last_frame(tmp_path):
    times = Rounds()
    scenario = Scenario.load("stratus", SMALL | {"output.certificate": 4})
    certificate = time_certificate(times, "", scenario, tmp_path)
    assert certificate.checked == 4
    assert times.seconds("certificate") > 0.0


def test_a_watch_counts_the_time_until_each_part_as_computation():
    def parts():
        for number in range(3):
            time.sleep(0.02)
            yield number

    watch, seen = Watch(), []
    for part in watch(parts(), 3):
        time.sleep(0.01)
        seen.append(part)
    assert seen == [0, 1, 2]
    assert watch.computing >= 0.06
    assert 0.03 <= watch.other() < 0.03 + watch.computing


def test_random_columns_are_clear_as_often_as_the_scene(plan):
    columns = random_columns(plan, 300)
    layer = plan.layers[0]
    cloudy = columns[columns > 0]
    # Three standard deviations of a share of one half in 300.
    assert abs(cloudy.size / 300 - 0.5) < 0.09
    assert layer.thickness_min_m <= cloudy.min() <= cloudy.max() <= layer.thickness_max_m


def test_brute_force_integrates_what_the_bands_hold(plan):
    everywhere, columns = every_nth(plan, 1), random_columns(plan, 6)
    np.testing.assert_array_equal(everywhere.wavenumber_cm1, plan.spectral_grid.wavenumber_cm1)
    exact = column_radiance(plan, everywhere, columns)
    np.testing.assert_allclose(column_radiance(plan, everywhere, columns, 6), exact, rtol=1e-12)
    for grid, size in (
        (every_nth(plan, 8), plan.spectral_grid.wavenumber_cm1.size / 8),
        (even_wavelengths(plan, 1000), 2999),
    ):
        assert abs(grid.wavenumber_cm1.size - size) < 8
        # Each band keeps its width, so that fewer wavenumbers err by structure in the spectrum alone.
        width = [10_000 / band.lower_um - 10_000 / band.upper_um for band in plan.bands]
        np.testing.assert_allclose(grid.weights_cm1.sum(axis=1), width, rtol=1e-9)
    errors = [np.max(np.abs(column_radiance(plan, every_nth(plan, step), columns) / exact - 1.0)) for step in (2, 16)]
    assert 0.0 < errors[0] < errors[1] < 0.3


def test_points_of_a_scene_count_the_points_within_pixels():
    points = make_plan(Scenario.load("stratus", SMALL | {"image.samples_per_pixel": 2}))
    assert points_of_scene(points) == 3 * 30 * 40 * 4


def test_raw_bytes_are_those_of_the_planes_and_nothing_else_is_left(tmp_path):
    plane = np.arange(12, dtype=np.float32).reshape(3, 4)
    path = tmp_path / "raw.bin"
    path.write_bytes(b"old" * 1000)
    write_raw(path, plane, 3)
    assert path.read_bytes() == plane.tobytes() * 3
    assert list(tmp_path.iterdir()) == [path]


def test_raw_bytes_that_the_disk_refuses_leave_nothing(tmp_path):
    plane = np.zeros(2**20, np.uint8)
    with pytest.raises(OSError):
        write_raw(tmp_path / "raw.bin", plane, 2**42)
    assert list(tmp_path.iterdir()) == []


def test_a_private_cache_gives_the_own_one_back(tmp_path, monkeypatch):
    monkeypatch.setenv("HCSS_CACHE_DIR", "own")
    monkeypatch.delenv("HCSS_CACHE_MB", raising=False)
    with pytest.raises(ZeroDivisionError):
        _fail_with_a_cache_in(tmp_path)
    assert os.environ["HCSS_CACHE_DIR"] == "own"
    assert "HCSS_CACHE_MB" not in os.environ


def _fail_with_a_cache_in(folder):
    with private_cache(folder):
        assert os.environ["HCSS_CACHE_DIR"] == str(folder)
        raise ZeroDivisionError
