"""Pixels with views and places of their own have them from the whole image, in windows and tiles too."""

import netCDF4
import numpy as np
import pytest
from cheap import CHEAP

from hcss_twin import Scenario, ScenarioError, make_plan, open_cube
from hcss_twin.cube.variables import GEOMETRY
from hcss_twin.engine import parts as tiles_module
from hcss_twin.engine.certificate.certificate_pixels import PixelSample
from hcss_twin.engine.certificate.certify import certify
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.cube_sensor import read_clean
from hcss_twin.engine.parts import stream_parts
from hcss_twin.engine.simulate import run
from hcss_twin.engine.stream import stream
from hcss_twin.engine.verification import verify_cube

WIDE = {
    **CHEAP,
    "image.rows": 30,
    "image.columns": 40,
    "image.pixel_size": 3000.0,
    "frames.count": 2,
    "bands": ["lwir-10.8"],
    "accuracy": 1e-3,
    "platform.altitude": "800 km",
    "platform.mode": "push-broom",
    "output.certificate": 0,
    "output.variables": ["radiance", "terms", "cloud_thickness", "geometry"],
}
LAYERS = [
    {"type": "stratus", "coverage": 0.4, "coverage_mode": "field"},
    {"type": "cirrus", "coverage": 0.5, "coverage_mode": "field"},
]
SCENES = {
    "one layer": {"clouds.coverage_mode": "frame"},
    "two layers, means over points": {
        "clouds": {"layers": LAYERS},
        "image.samples_per_pixel": 2,
        "output.variables": ["radiance", "cloud_thickness", "geometry"],  # terms are those of one layer
    },
    "clear": {"clouds": {}},
}
ROWS, COLUMNS = [17, 30], [3, 36]
WINDOW = {"image.window": {"rows": ROWS, "columns": COLUMNS}}
PART = slice(*ROWS), slice(*COLUMNS)
NAMES = [spec.name for spec in GEOMETRY]


def planned(**overrides):
    return make_plan(Scenario.load("stratus", {**WIDE, **overrides}))


@pytest.fixture
def small_tiles():
    """Tiles of a few pixels; frames are cut into windows of fewer still."""

    def cut():
        patch.setattr(tiles_module, "LARGEST_FRAME_BYTES", 0)
        patch.setattr(tiles_module, "TILE_PIXELS", 150)
        patch.setattr("hcss_twin.engine.clouds.WHOLE_POINTS", 0)
        patch.setattr("hcss_twin.plan.windows.windows.__defaults__", (77, None))

    # Patches of its own, on which no analysis of a scene depends: those of other tests serve.
    with pytest.MonkeyPatch.context() as patch:
        yield cut


@pytest.mark.parametrize("scene", SCENES)
def test_windows_and_tiles_equal_the_same_part_of_a_wide_field(scene, small_tiles):
    plan, part = planned(**SCENES[scene]), planned(**SCENES[scene], **WINDOW)
    assert plan.views.varies
    assert part.views == plan.views
    whole, alone = (list(stream(each, tables_of(each))) for each in (plan, part))
    small_tiles()
    made = [{name: np.empty_like(values) for name, values in frame.items()} for frame in alone]
    count = 0
    for tile in stream_parts(part, tables_of(part)):
        count += 1
        for name, values in tile.arrays.items():
            made[tile.frame][name][(..., *tile.place)] = values
    assert count > 4
    for one, other, third in zip(whole, alone, made, strict=True):
        assert set(one) == set(other) == {spec.name for spec in plan.variables if spec.kind != "geometry"}
        for name in one:
            expected = one[name][(..., *PART)].tobytes()
            assert other[name].tobytes() == expected, name
            assert third[name].tobytes() == expected, name


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_coordinates_of_pixels_are_those_of_the_whole_image(suffix, tmp_path, small_tiles):
    if suffix == ".zarr":
        pytest.importorskip("zarr")
    few = {"output.variables": ["cloud_mask", "geometry"], "output.compression": 1}
    run(planned(**few), tmp_path / "whole.nc")
    window = run(planned(**few, **WINDOW), tmp_path / f"window{suffix}")
    small_tiles()
    tiled = run(planned(**few, **WINDOW), tmp_path / f"tiled{suffix}")
    assert str(verify_cube(tiled).verdict) == "identical"
    with open_cube(tmp_path / "whole.nc") as whole, open_cube(window) as one, open_cube(tiled) as other:
        assert whole["pixel_latitude"].dims == ("time", "y", "x")
        for name in NAMES:
            expected = whole[name].isel(y=PART[0], x=PART[1])
            for found in (one[name], other[name]):
                assert found.to_numpy().tobytes() == expected.to_numpy().tobytes(), name
                assert found.dims == expected.dims
                assert found.attrs == expected.attrs
            assert name in one["cloud_mask"].coords


def test_a_changed_coordinate_of_a_window_is_found_where_it_is(tmp_path, small_tiles):
    small_tiles()
    few = {"output.variables": ["cloud_mask", "geometry"]}
    cube = run(planned(**few, **WINDOW), tmp_path / "cube.nc")
    with netCDF4.Dataset(cube, "a") as file:
        file["pixel_latitude"][1, 11, 30] += 1.0
        file["pixel_view_zenith"][7, 20] += 1.0
    found = {each.name: each for each in verify_cube(cube).variables if each.unequal}
    assert set(found) == {"pixel_latitude", "pixel_view_zenith"}
    assert dict(found["pixel_latitude"].first.position) == {"frame": 1, "row": 11, "column": 30}
    assert dict(found["pixel_view_zenith"].first.position) == {"row": 7, "column": 20}


def test_the_certificate_of_a_window_follows_the_views_of_the_whole_image():
    # Pixels of one corner are not certified as those of another one, which is seen otherwise.
    settings = {"output.certificate": 24, "frames.count": 1, "view.zenith": 45.0}
    plan, other = (
        planned(**settings, **{"image.window": {"rows": [row, row + 6], "columns": [column, column + 8]}})
        for row, column in ((24, 32), (0, 0))
    )
    tables, sample, of_other = tables_of(plan), PixelSample(plan), PixelSample(other)
    list(stream(plan, tables, sample))
    certificate = certify(plan, tables, sample.frames)
    assert sum(stratum.checked for stratum in certificate.strata) == 24
    assert certificate.passed
    list(stream(other, tables_of(other), of_other))  # rows and columns count from those of the window
    assert not certify(plan, tables, of_other.frames).passed


def test_a_sensor_measures_a_platform_that_says_its_pixels_and_speed_by_optics_and_orbit(tmp_path):
    optics = {"platform.focal_length": 0.1, "platform.detector_pitch": 3e-4, "platform.off_nadir": 10.0}
    raw, base = Scenario.read_file("stratus")
    del raw["image"], raw["view"], raw["motion"]
    changes = {**WIDE, **optics, "image.rows": 6, "image.columns": 8, "sensor.name": "generic-mwir"}
    del changes["image.pixel_size"]
    changes |= {"output.variables": ["radiance", "geometry"], "bands": ["mwir-3.7"]}
    with pytest.raises(ScenarioError, match=r"4e-05 \(of 'generic-mwir'\) rad, and platform\.detector_pitch 0\.0003 m"):
        make_plan(Scenario.from_dict(raw, changes, base))
    changes |= {"sensor.parameters": {"pixel_angle": 3e-3, "aperture_diameter": 2e-3}}  # the same electrons
    plan = make_plan(Scenario.from_dict(raw, changes, base))
    assert plan.sensor.stages
    clean = run(plan, tmp_path / "clean.nc")
    measured = tmp_path / "clean.sensor.nc"
    with open_cube(clean) as one, open_cube(measured) as other:
        for name in NAMES:
            assert other[name].to_numpy().tobytes() == one[name].to_numpy().tobytes(), name
        inputs = read_clean(one, "clean", None).inputs
    assert inputs.grid == plan.grid
    assert inputs.platform_speed_m_s == plan.assembly.motion.platform_speed_m_s > 6000.0
    assert str(verify_cube(measured).verdict) == "identical"


def test_a_sweep_over_altitudes_has_the_coordinates_of_every_pixel_by_point(tmp_path):
    hcss_sweep = pytest.importorskip("hcss_sweep")
    scene = {**WIDE, "image.rows": 4, "image.columns": 5, "image.pixel_size": 100.0}
    del scene["platform.altitude"]
    scene["output.variables"] = ["cloud_mask", "geometry"]
    over = {"platform.altitude": [500e3, 800e3]}
    result = hcss_sweep.sweep("stratus", tmp_path / "sweep", over=over, overrides=scene, dataset=tmp_path / "all.nc")
    with hcss_sweep.open_sweep(result.dataset) as data:
        np.testing.assert_array_equal(data["platform_altitude"], [500e3, 800e3])
        np.testing.assert_array_equal(data["sensor_altitude"], [500e3, 800e3])
        for point in range(2):
            with open_cube(result.cube(point)) as cube:
                for name in NAMES:
                    # What is the same at all points has no dimension of the sweep.
                    found = data[name].isel(platform_altitude=point, missing_dims="ignore")
                    np.testing.assert_array_equal(found, cube[name])
