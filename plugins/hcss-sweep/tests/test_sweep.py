"""Laws of sweeps: each cube is that of its point alone, nothing is computed twice, and a fault stays with its point."""

import functools
import json
import os
import shutil

import hcss_sweep.points
import numpy as np
import pytest
from cheap import CHEAP
from hcss_sweep import SweepError, open_sweep, points, sweep
from hcss_sweep.points import PointOutcome, compute

from hcss_twin import CubeError, Scenario, open_cube, simulate
from hcss_twin.core.environment import versions
from hcss_twin.core.files import draft_of
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.engine import compile
from hcss_twin.models.atmosphere.band_model import provider as band_model
from hcss_twin.plan.accuracy import RequestedAccuracy

SMALL = {
    **CHEAP,
    "image.rows": 6,
    "image.columns": 8,
    "frames.count": 2,
    "bands": ["lwir-10.8"],
    "output.certificate": 0,
}
MASK = SMALL | {"output.variables": ["cloud_mask"]}
"""Without radiance, for what is not about numbers."""
OVER = {"view.zenith": [0, 30], "seed": [1, 2]}


@pytest.fixture(autouse=True)
def _settings(monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")


@pytest.fixture
def computed(monkeypatch):
    """Numbers of the points that were computed; those in ``failing`` fail, and one interrupts."""
    numbers, failing = [], {}

    def watched(task, shelf):
        numbers.append(task.point)
        if task.point in failing:
            raise failing[task.point]
        return compute(task, shelf)

    monkeypatch.setattr(points, "compute", watched)
    return numbers, failing


def swept(folder, over=OVER, overrides=MASK, **more):
    return sweep("stratus", folder, over=over, overrides=overrides, **more)


def bytes_of(folder):
    return {path.name: path.read_bytes() for path in folder.glob("point-*.nc")}


def test_each_cube_is_that_of_its_scenario_alone(tmp_path):
    scene = SMALL | {"output.certificate": 2}
    result = swept(tmp_path / "sweep", overrides=scene)
    assert [dict(record.values) for record in result.points] == [
        {"view.zenith": zenith, "seed": seed} for zenith in (0.0, 30.0) for seed in (1, 2)
    ]
    for record in result.points:
        scenario = Scenario.load("stratus", {**scene, **record.values})
        simulate(scenario, tmp_path / "alone.nc").close()
        assert result.cube(record.point).read_bytes() == (tmp_path / "alone.nc").read_bytes()
        assert record.bytes == result.cube(record.point).stat().st_size
    index = json.loads((tmp_path / "sweep" / "index.json").read_text())
    assert index["points"] == [record.as_dict() for record in result.points]
    assert index["states"] == {"done": 4, "failed": 0, "pending": 0}


def test_points_of_equal_tables_compile_them_once_and_read_files_once(tmp_path, monkeypatch):
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path / "cache"))
    compiled, read = [], []
    compile_tables, read_coefficients = compile.compile_tables, band_model.read_coefficients
    monkeypatch.setattr(compile, "compile_tables", lambda plan: compiled.append(plan) or compile_tables(plan))
    counted = functools.wraps(read_coefficients)(lambda path: read.append(path) or read_coefficients(path))
    monkeypatch.setattr(band_model, "read_coefficients", counted)
    swept(tmp_path / "sweep", overrides=SMALL)
    assert len(compiled) == 2
    assert len(read) == 1


def test_a_dataset_has_every_cube_at_its_place(tmp_path):
    over = {"time": ["2024-01-20T02:30:00Z", "2024-07-20T02:30:00Z"], "clouds.coverage": [0.2, 0.7], "seed": [4, 5]}
    result = swept(tmp_path / "sweep", over, SMALL, dataset=tmp_path / "all.nc")
    with open_sweep(result.dataset) as data:
        assert data.radiance.dims == ("start_time", "clouds_coverage", "seed", "time", "band", "y", "x")
        for record in result.points:
            start, coverage, seed = record.values.values()
            at_point = data.sel(clouds_coverage=coverage, seed=seed, start_time=np.datetime64(start[:-1]))
            with open_cube(result.cube(record.point)) as cube:
                for name in ("radiance", "cloud_mask"):
                    np.testing.assert_array_equal(at_point[name], cube[name])
                    assert at_point[name].dtype == cube[name].dtype
                for name in ("x", "y", "wavelength", "latitude", "solar_zenith_angle", "sensor_zenith_angle"):
                    np.testing.assert_array_equal(at_point[name], cube[name])
                np.testing.assert_array_equal(at_point.frame_time, cube.time)
                np.testing.assert_array_equal(at_point.elapsed_time, [0.0, 1.0])
                assert at_point.point_scenario.item() == cube.attrs["hcss_scenario"]
                assert at_point.point_number.item() == record.point
                assert at_point.point_state.item() == 0
                assert data.attrs["hcss_versions"] == cube.attrs["hcss_versions"]
        assert data.radiance.sel(band="lwir-10.8").shape == (2, 2, 2, 2, 6, 8)
        # What does not differ has no dimension of the sweep.
        assert data.latitude.dims == ()
        assert data.solar_zenith_angle.dims[0] == "start_time"


def test_sweeps_of_place_and_text_make_a_dataset(tmp_path):
    over = {"place.latitude": [10, 35], "clouds.type": ["stratus", "cumulus"], "place.longitude": [150]}
    scene = SMALL | {"output.variables": ["radiance", "cloud_layer_thickness"]}
    result = swept(tmp_path / "sweep", over, scene, dataset=tmp_path / "all.nc")
    with open_sweep(result.dataset) as data:
        assert data.layer_name.values.ravel().tolist() == ["stratus", "cumulus"] * 2
        one = data.sel(place_latitude=35, clouds_type="cumulus", place_longitude=150)
        assert one.latitude == 35.0
        # No single plane has both places.
        assert "local_plane" not in data.variables
        with open_cube(result.cube(3)) as cube:
            np.testing.assert_array_equal(one.radiance, cube.radiance)
            np.testing.assert_array_equal(one.footprint_latitude, cube.footprint_latitude)


def test_compressed_cubes_make_a_compressed_dataset(tmp_path):
    result = sweep(
        "stratus", tmp_path / "sweep", over={"seed": [1, 2]}, overrides=SMALL | {"output.compression": 4},
        dataset=tmp_path / "all.nc",
    )  # fmt: skip
    with open_sweep(result.dataset) as data, open_cube(result.cube(1)) as cube:
        np.testing.assert_array_equal(data.radiance.sel(seed=2), cube.radiance)
        assert data.radiance.encoding["zlib"]
        assert data.radiance.encoding["chunksizes"] == (1, 1, 1, 6, 8)


def test_a_failed_point_is_recorded_and_the_others_are_done(tmp_path):
    # Only the plan finds out that no optics are known there.
    over = {"bands.0": [[10, 11], [16.5, 17], [11, 12]]}
    result = swept(tmp_path / "sweep", over, {key: value for key, value in SMALL.items() if key != "bands"})
    assert [record.state for record in result.points] == ["done", "failed", "done"]
    (failed,) = result.failed
    assert failed.error.startswith("bands[0]: '16.5-17")
    assert failed.file is None
    with pytest.raises(SweepError, match="point 1 has no cube"):
        result.cube(1)


def test_points_without_a_cube_are_missing_in_the_dataset(tmp_path, monkeypatch):
    failing = {1}

    def faulty(task, shelf):
        return PointOutcome(task.point, error="out of luck") if task.point in failing else compute(task, shelf)

    monkeypatch.setattr(points, "compute", faulty)
    result = swept(tmp_path / "sweep", {"seed": [1, 2, 3]}, SMALL, dataset=tmp_path / "all.nc")
    with open_sweep(result.dataset) as data:
        assert data.point_state.values.tolist() == [0, 1, 0]
        assert np.isnan(data.radiance.sel(seed=2)).all()
        assert np.isnan(data.cloud_mask.sel(seed=2)).all()
        assert np.isfinite(data.radiance.sel(seed=[1, 3])).all()
    failing.clear()
    again = swept(tmp_path / "sweep", {"seed": [1, 2, 3]}, SMALL, dataset=tmp_path / "all.nc")
    assert again.computed == (1,)
    with open_sweep(again.dataset) as data:
        assert np.isfinite(data.radiance).all()
        assert data.cloud_mask.dtype == np.uint8


def test_a_fault_of_the_code_is_one_of_its_point(tmp_path, monkeypatch):
    make_plan = hcss_sweep.points.make_plan

    def faulty(scenario, **kept):
        if scenario.seed == 2:
            raise ZeroDivisionError("of a plugin")
        return make_plan(scenario, **kept)

    monkeypatch.setattr("hcss_sweep.points.make_plan", faulty)
    result = swept(tmp_path / "sweep", {"seed": [1, 2, 3]})
    assert [record.error for record in result.failed] == ["ZeroDivisionError: of a plugin"]


def test_a_cube_that_misses_its_accuracy_is_kept_told_and_not_made_again(tmp_path, computed, monkeypatch):
    class Failed:
        passed = False
        lines = ("NOT as specified: by 2e-2",)
        requested, achieved, achieved_K = RequestedAccuracy(1e-2), {"lwir": 2e-2}, {}

    run = hcss_sweep.points.run
    monkeypatch.setattr(
        "hcss_sweep.points.run",
        lambda plan, path, report, from_curves: run(plan, path, report=lambda _: report(Failed)),
    )
    scene = SMALL | {"output.certificate": 1}
    result = swept(tmp_path / "sweep", {"seed": [1, 2]}, scene)
    assert [record.error for record in result.failed] == ["certificate NOT as specified: by 2e-2"] * 2
    assert [record.certified for record in result.failed] == [2.0, 2.0]
    assert result.cube(0).is_file()
    assert swept(tmp_path / "sweep", {"seed": [1, 2]}, scene).computed == ()
    assert computed[0] == [0, 1]


def test_a_sweep_run_again_computes_what_is_missing_and_nothing_else(tmp_path, computed):
    folder = tmp_path / "sweep"
    first = swept(folder)
    assert first.computed == tuple(range(4))
    assert swept(folder).computed == ()
    before = bytes_of(folder)
    first.cube(1).unlink()
    first.cube(3).write_bytes(b"shorter")
    again = swept(folder)
    assert again.computed == (1, 3)
    assert bytes_of(folder) == before
    assert sorted(computed[0]) == [0, 1, 1, 2, 3, 3]


def test_cubes_that_the_log_does_not_know_are_not_made_again(tmp_path, computed):
    folder = tmp_path / "sweep"
    first = swept(folder)
    log = folder / "points.jsonl"
    lines = log.read_text().splitlines(keepends=True)
    # Killed after the cubes of the last two points had their names: one line is cut off, one was not begun.
    log.write_text("".join(lines[:2]) + lines[2][:30])
    # A cube of another scenario is not taken for that of this point.
    lost = [json.loads(line)["point"] for line in lines[2:]]
    shutil.copy(first.cube(json.loads(lines[0])["point"]), first.cube(lost[1]))
    before = list(computed[0])
    again = swept(folder)
    assert computed[0][len(before) :] == [lost[1]]
    assert [record.sha256 for record in again.points] == [record.sha256 for record in first.points]
    assert swept(folder).computed == ()
    # The half line stays alone: what was written after it is read.
    broken = [line for line in log.read_text().splitlines() if not line.endswith("}")]
    assert broken == [lines[2][:30]]


def test_an_interrupt_leaves_whole_cubes_and_an_index_that_is_gone_on_with(tmp_path, computed):
    numbers, failing = computed
    folder = tmp_path / "sweep"
    failing[3] = KeyboardInterrupt()
    over = {"seed": {"count": 6}}
    with pytest.raises(KeyboardInterrupt):
        swept(folder, over)
    draft_of(folder / "point-0003.nc").write_bytes(b"half")
    index = json.loads((folder / "index.json").read_text())
    assert [point["state"] for point in index["points"]] == ["done"] * 3 + ["pending"] * 3
    failing.clear()
    assert swept(folder, over).computed == (3, 4, 5)
    assert numbers == [0, 1, 2, 3, 3, 4, 5]
    assert not list(folder.glob(".*"))


def test_a_folder_belongs_to_one_sweep(tmp_path):
    folder = tmp_path / "sweep"
    swept(folder, {"seed": [1, 2]})
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(SweepError, match=r"another sweep: 2 points over seed; this one has 3 over seed.*--force"):
        swept(folder, {"seed": [1, 2, 3]})
    with pytest.raises(SweepError, match="or differs in another key"):
        sweep("stratus", folder, over={"seed": [1, 2]}, overrides=MASK | {"view.zenith": 3})
    before = bytes_of(folder)
    assert len(before) == 2
    assert swept(folder, {"seed": [7]}, force=True).computed == (0,)
    assert sorted(path.name for path in folder.iterdir()) == [
        "index.json", "notes.txt", "point-0000.nc", "points.jsonl"
    ]  # fmt: skip


def test_a_folder_with_something_else_is_left_alone(tmp_path):
    (tmp_path / "point-0000.nc").write_text("precious")
    with pytest.raises(SweepError, match="not empty and holds no sweep"):
        swept(tmp_path, {"seed": [1]}, force=True)
    assert (tmp_path / "point-0000.nc").read_text() == "precious"


def test_a_sweep_of_other_versions_is_not_gone_on_with(tmp_path, monkeypatch):
    folder = tmp_path / "sweep"
    swept(folder, {"seed": [1]})
    monkeypatch.setattr(ResultCache, "versions", lambda self: {**versions(), "numpy": "0.9"})
    with pytest.raises(SweepError, match=r"numpy .*, now 0\.9"):
        swept(folder, {"seed": [1]})


def test_two_processes_do_not_compute_the_same_sweep(tmp_path):
    fcntl = pytest.importorskip("fcntl")
    folder = tmp_path / "sweep"
    swept(folder, {"seed": [1]})
    handle = os.open(folder, os.O_RDONLY)
    fcntl.flock(handle, fcntl.LOCK_EX)
    with pytest.raises(SweepError, match="another process is computing this sweep"):
        swept(folder, {"seed": [1]})
    os.close(handle)
    assert swept(folder, {"seed": [1]}).computed == ()


@pytest.mark.parametrize("name", ["index.json", "sweep", "nowhere/all.nc", "sweep/point-0000.nc"])
def test_a_dataset_replaces_nothing_but_itself(tmp_path, computed, name):
    folder = tmp_path / "sweep"
    (tmp_path / "index.json").write_text("precious")
    folder.mkdir()
    with pytest.raises(SweepError, match=r"is not the dataset|it is a folder|no folder|another file|is NetCDF, not"):
        swept(folder, {"seed": [1]}, dataset=tmp_path / name)
    assert not computed[0]
    swept(folder, {"seed": [1]}, dataset=tmp_path / "all.nc")
    swept(folder, {"seed": [1]}, dataset=tmp_path / "all.nc")
    with pytest.raises(CubeError, match="not a sweep dataset"):
        open_sweep(folder / "point-0000.nc")
    with pytest.raises(CubeError, match="not a finished cube"):
        open_cube(tmp_path / "all.nc")


def test_cubes_of_other_variables_are_refused_as_one_dataset_and_stay(tmp_path):
    over = {"clouds": [{"type": "stratus"}, {"layers": [{"type": "stratus"}, {"type": "cirrus"}]}]}
    with pytest.raises(SweepError, match="points 0 and 1 differ in the variables cloud_layer_thickness"):
        sweep(
            "stratus", tmp_path / "sweep", over=over, dataset=tmp_path / "all.nc",
            overrides=SMALL | {"output.variables": ["cloud_mask", "truth"]},
        )  # fmt: skip
    assert len(bytes_of(tmp_path / "sweep")) == 2
    assert not list(tmp_path.glob("*all.nc*"))


@pytest.mark.parametrize(
    ("more", "words"), [({"workers": 0}, "1 or more"), ({"workers": 2, "scheduler": "tcp://x"}, "one of them")]
)
def test_workers_that_cannot_be_are_refused(tmp_path, more, words):
    with pytest.raises(SweepError, match=words):
        swept(tmp_path / "sweep", **more)
