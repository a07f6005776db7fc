"""Scenes larger than memory: windows, tiles and workers give the bits of the scene made whole."""

import json
import os
import subprocess
import sys
from contextlib import contextmanager

import netCDF4
import numpy as np
import pytest
import xarray as xr
from cheap import CHEAP, CHEAP_OPTIONS

from hcss_twin import ProviderError, Scenario, ScenarioError, make_plan, open_cube, simulate
from hcss_twin.cube.geometry import footprint
from hcss_twin.engine import parts as tiles_module
from hcss_twin.engine.certificate.certificate_pixels import PixelSample
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.parts import parts_of, stream_parts, tile_shape, tiles
from hcss_twin.engine.simulate import cube_header, run
from hcss_twin.engine.stream import stream
from hcss_twin.engine.verification import verify_cube
from hcss_twin.models.clouds.fractal.generator import FractalClouds

SMALL = {
    **CHEAP,
    "image.rows": 50,
    "image.columns": 70,
    "frames.count": 2,
    "bands": ["mwir-3.7"],
    "output.certificate": 0,
    "output.variables": ["all"],
}
LAYERS = [
    {"type": "stratus", "coverage": 0.4, "coverage_mode": "field"},
    {"type": "cirrus", "coverage": 0.5, "coverage_mode": "field", "edge_taper": 0.2},
]
SCENES = {
    "one threshold for the sky": {"clouds.coverage_mode": "field"},
    "the coverage of the frame": {"clouds.coverage_mode": "frame"},
    "two layers, means over points": {"clouds": {"layers": LAYERS}, "image.samples_per_pixel": 2},
    "shadows and parallax": {
        "clouds": {"layers": LAYERS[:1]},
        "slant": {"shadows": "on", "parallax": "on"},
        "image.pixel_size": 200.0,
        "view.zenith": 30.0,
    },
    "waves": {"clouds.coverage_mode": "field", "sea.model": "rough-sea", "sea.waves": "on"},
    "rounded numbers": {"clouds.coverage_mode": "frame", "output.quantization": 1e-4},
    "clear": {"clouds": {}},
}
WINDOW = slice(11, 42), slice(3, 66)


def planned(**overrides):
    return make_plan(Scenario.load("stratus", {**SMALL, **overrides}))


@contextmanager
def small_tiles(pixels=400):
    # Patches of its own: analyses of scenes do not depend on tiles, those of other tests serve.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tiles_module, "LARGEST_FRAME_BYTES", 0)
        patch.setattr(tiles_module, "TILE_PIXELS", pixels)
        # Frames of whose coverage windows need a summary are those of large images.
        patch.setattr("hcss_twin.engine.clouds.WHOLE_POINTS", 0)
        yield


def frames_of(plan, tables):
    """Frames put together from their parts, which must not meet."""
    made = []
    for part in stream_parts(plan, tables):
        if part.frame == len(made):
            made.append({})
            seen = np.zeros(plan.pixels, dtype=int)
        place = (slice(None), slice(None)) if part.place is None else part.place
        seen[place] += 1
        for name, values in part.arrays.items():
            shape = (*values.shape[:-2], *plan.pixels)
            made[-1].setdefault(name, np.zeros(shape, values.dtype))[(..., *place)] = values
        assert seen.max() == 1
    return made


@pytest.fixture(scope="module", params=SCENES)
def made_whole(request):
    """A scene by its overrides, with its plan, its tables and its frames."""
    plan = planned(**SCENES[request.param])
    tables = tables_of(plan)
    return SCENES[request.param], plan, tables, list(stream(plan, tables))


def test_a_frame_made_by_tiles_is_the_frame_made_whole(made_whole):
    _, plan, tables, whole = made_whole
    with small_tiles():
        assert len(tiles(plan)) > 6
        tiled = frames_of(plan, tables)
    assert len(tiled) == len(whole) == 2
    for one, other in zip(whole, tiled, strict=True):
        assert set(one) == set(other) == {spec.name for spec in plan.variables}
        for name in one:
            assert one[name].tobytes() == other[name].tobytes(), name


def test_a_window_equals_the_same_part_of_the_whole(made_whole):
    scene, plan, _, whole = made_whole
    rows, columns = ([each.start, each.stop] for each in WINDOW)
    part = planned(**scene, **{"image.window": {"rows": rows, "columns": columns}})
    assert part.is_window
    assert not plan.is_window
    # With tables of its own: they must not depend on the window either.
    tables = tables_of(part)
    alone = list(stream(part, tables))
    with small_tiles():
        tiled = frames_of(part, tables)
    for one, other, third in zip(whole, alone, tiled, strict=True):
        for name in one:
            expected = one[name][(..., *WINDOW)].tobytes()
            assert other[name].tobytes() == expected, name
            assert third[name].tobytes() == expected, name


def test_a_window_lies_where_it_lies_in_the_whole():
    overrides = {**SMALL, "output.variables": ["cloud_mask"], "motion.platform_speed": 1000.0}
    whole = simulate(Scenario.load("stratus", overrides))
    window = {"rows": [11, 42], "columns": [3, 66]}
    part = simulate(Scenario.load("stratus", {**overrides, "image.window": window}))
    expected = whole.isel(y=WINDOW[0], x=WINDOW[1])
    for name in ("x", "y", "cloud_mask"):
        np.testing.assert_array_equal(part[name], expected[name])
    same = ("latitude", "longitude", "solar_zenith_angle", "centre_displacement")
    for name in same:
        np.testing.assert_array_equal(part[name], whole[name])
    assert json.loads(part.attrs["hcss_window"]) == {**window, "image_rows": 50, "image_columns": 70}
    assert "hcss_window" not in whole.attrs
    assert part.attrs["id"] != whole.attrs["id"]


def test_the_footprint_of_a_window_is_that_of_an_image_of_its_own_around_its_middle():
    """For windows in the middle of the image, whose own centre is that of the whole."""
    part = planned(**{"image.window": {"rows": [10, 40], "columns": [20, 50]}, "clouds": {}})
    alone = planned(**{"image.rows": 30, "image.columns": 30, "clouds": {}})
    assert footprint(cube_header(part, None)) == footprint(cube_header(alone, None))
    corner = planned(**{"image.window": {"rows": [0, 10], "columns": [0, 10]}, "clouds": {}})
    south_west = footprint(cube_header(corner, None))
    whole = footprint(cube_header(planned(clouds={}), None))
    assert south_west.outline[0] == whole.outline[0]
    assert south_west.north < whole.north
    assert south_west.east < whole.east


@pytest.mark.parametrize(
    ("window", "problem"),
    [
        ({"rows": [40, 60]}, r"rows = \[40, 60\]; allowed: .* <= 50, the image's rows; closest .* is \[40, 50\]"),
        ({"columns": [9, 3]}, r"closest valid choice is \[9, 10\]"),
        ({"columns": [-4, 3]}, r"closest valid choice is \[0, 3\]"),
        ({"rows": [1, 2, 3]}, "at most 2"),
        ({"row": [1, 2]}, "closest is 'rows'"),
    ],
)
def test_a_window_outside_the_image_is_refused_with_the_closest_inside(window, problem):
    with pytest.raises(ScenarioError, match=rf"image\.window.*{problem}"):
        Scenario.load("stratus", {**SMALL, "image.window": window})


def test_tiles_are_few_and_alike_and_cover_the_extent_once():
    for rows, columns in ((20_000, 20_000), (100_000, 1_500), (1_300, 100_000), (100_000, 100_000)):
        plan = planned(**{"image.rows": rows, "image.columns": columns, "clouds.coverage_mode": "field"})
        height, width = tile_shape(plan)
        bytes_per_pixel = plan.uncompressed_bytes / plan.frame_times_s.size / (rows * columns)
        area = min(tiles_module.TILE_PIXELS, tiles_module.TILE_BYTES // bytes_per_pixel)
        assert 0.3 * area < height * width <= area
        count = -(-rows // height) * -(-columns // width)
        assert len(tiles(plan)) == count
        assert sum((r.stop - r.start) * (c.stop - c.start) for r, c in tiles(plan)) == rows * columns
        # No row or column of tiles is a sliver.
        assert rows % height == 0 or rows % height > height / 2
        assert columns % width == 0 or columns % width > width / 2


def test_frames_that_fit_are_made_whole():
    assert tile_shape(planned(**{"image.rows": 800, "image.columns": 800})) is None
    assert parts_of(planned()) == 2


def test_a_generator_that_needs_whole_frames_is_refused_beyond_what_memory_may_hold(monkeypatch):
    huge = {"image.rows": 100_000, "image.columns": 90_000}
    planned(**huge, **{"clouds.coverage_mode": "frame"})
    monkeypatch.delattr(FractalClouds, "frame_summary")
    with pytest.raises(
        ScenarioError, match=r'image\.rows: .*closest valid choice is 2982; or .*coverage_mode = "field"'
    ):
        planned(**huge, **{"clouds.coverage_mode": "frame"})
    planned(**huge, **{"clouds.coverage_mode": "field"})
    with pytest.raises(ScenarioError, match=r"image\.rows: 100001 .*allowed: >= 1 and <= 100000"):
        planned(**{"image.rows": 100_001})


@pytest.fixture
def fixed_date(monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")


@pytest.mark.long
def test_workers_write_the_bytes_of_one(tmp_path, fixed_date):
    plan = planned(**{"output.certificate": 48, "clouds.coverage_mode": "frame", "output.compression": 1})
    with small_tiles(900):
        assert parts_of(plan) > 4
        alone = run(plan, tmp_path / "alone.nc")
        together = run(plan, tmp_path / "together.nc", workers=2)
    assert alone.read_bytes() == together.read_bytes()


@pytest.mark.long
@pytest.mark.filterwarnings("ignore")
def test_a_dask_cluster_writes_the_bytes_of_one(tmp_path, fixed_date):
    distributed = pytest.importorskip("distributed")
    plan = planned(**{"output.certificate": 48, "clouds.coverage_mode": "frame"})
    with (
        small_tiles(900),
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0") as cluster,
    ):
        alone = run(plan, tmp_path / "alone.nc")
        together = run(plan, tmp_path / "together.nc", scheduler=cluster.scheduler_address)
    assert alone.read_bytes() == together.read_bytes()


def test_the_certificate_of_tiles_speaks_for_all_pixels(tmp_path):
    plan = planned(**{"output.certificate": 48, "clouds.coverage_mode": "field"})
    told = []
    with small_tiles():
        run(plan, tmp_path / "cube.nc", report=told.append)
    (certificate,) = told
    assert certificate.passed
    assert sum(stratum.pixels for stratum in certificate.strata) == 2 * 50 * 70
    assert sum(stratum.checked for stratum in certificate.strata) == 48


def test_the_certificate_of_a_frame_made_whole_does_not_know_of_parts(tmp_path, fixed_date):
    """Parts as large as the frame draw the pixels that the stream of whole frames draws."""
    plan = planned(**{"output.certificate": 48, "clouds.coverage_mode": "field"})
    tables, one, other = tables_of(plan), PixelSample(plan), PixelSample(plan)
    assert len(list(stream(plan, tables, one))) == len(list(stream_parts(plan, tables, other)))
    for a, b in zip(one.frames, other.frames, strict=True):
        for name in vars(a):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name))


def test_a_cube_of_tiles_verifies_and_a_changed_pixel_is_found_where_it_is(tmp_path):
    plan = planned(**{"clouds.coverage_mode": "field"})
    with small_tiles():
        cube = run(plan, tmp_path / "cube.nc")
        assert str(verify_cube(cube).verdict) == "identical"
        with netCDF4.Dataset(cube, "a") as file:
            file["radiance"][1, 0, 37, 61] *= 1.5
        found = verify_cube(cube)
    assert str(found.verdict) == "different"
    (wrong,) = [each for each in found.variables if each.unequal]
    assert wrong.unequal == 1
    assert dict(wrong.first.position) == {"frame": 1, "band": "mwir-3.7", "row": 37, "column": 61}


@pytest.mark.long
def test_a_worker_that_dies_leaves_no_cube(tmp_path, monkeypatch):
    monkeypatch.setattr("hcss_twin.engine.parts._make_given", _die)
    with pytest.raises(ProviderError, match="a worker process ended before its part"):
        run(planned(), tmp_path / "cube.nc", workers=2)
    assert list(tmp_path.iterdir()) == []


def _die(*_):
    os._exit(9)


@pytest.mark.long
def test_the_command_line_takes_windows_and_workers(tmp_path):
    command = [sys.executable, "-m", "hcss_twin", "run", "stratus", *CHEAP_OPTIONS]
    command += ["--set", "image.window={rows=[10, 30], columns=[5, 45]}", "--set", "bands=['lwir']"]
    for workers in ("1", "2"):
        done = subprocess.run(
            [*command, "--workers", workers, "-o", f"{workers}.nc"], cwd=tmp_path, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
    one, two = (open_cube(tmp_path / f"{workers}.nc").load() for workers in "12")
    assert dict(one.sizes)["y"] == 20
    for each in (one, two):
        each.attrs = {name: value for name, value in each.attrs.items() if name not in ("history", "date_created")}
    xr.testing.assert_identical(one, two)
