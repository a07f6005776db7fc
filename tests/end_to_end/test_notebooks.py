"""What a notebook needs: one line to a cube, readable scenarios and plans, and the accessor ``cube.hcss``."""

import json
import subprocess
import sys
from html.parser import HTMLParser

import matplotlib
import numpy as np
import pytest
import xarray as xr
from cheap import CHEAP

import hcss_twin
import hcss_twin.reports.accessor  # cameras of these tests are no results of functions that load it
from hcss_twin.core.errors import CubeError, OptionError, ScenarioError
from hcss_twin.physics.geodesy import to_geographic

matplotlib.use("Agg")

SCENE = CHEAP | {"image.rows": 20, "image.columns": 30, "frames.count": 3, "output.certificate": 0}
SCENE |= {"image.pixel_size": 100.0, "motion.platform_speed": 1000.0, "bands": ["mwir", "lwir"]}


@pytest.fixture(scope="module")
def cube():
    return hcss_twin.simulate("stratus", overrides=SCENE)


def test_a_name_a_path_tables_and_a_scenario_give_the_same_cube(cube, tmp_path):
    scenario = hcss_twin.Scenario.load("stratus", SCENE)
    path = tmp_path / "scene.json"
    path.write_text(scenario.to_json())
    for source in (scenario, path, str(path), json.loads(scenario.to_json())):
        xr.testing.assert_identical(hcss_twin.simulate(source).radiance, cube.radiance)
    assert hcss_twin.make_plan(path).scenario.to_json() == scenario.to_json()
    assert hcss_twin.Twin(str(path)).plan.pixels == (20, 30)


def test_overrides_change_every_form_and_what_is_no_scenario_is_refused():
    scenario = hcss_twin.Scenario.load("stratus")
    changed = hcss_twin.Scenario.of(scenario, {"frames.count": 2})
    assert changed == hcss_twin.Scenario.load("stratus", {"frames.count": 2})
    assert hcss_twin.Scenario.of(scenario) is scenario
    with pytest.raises(ScenarioError, match="closest is 'stratus'"):
        hcss_twin.simulate("stratos")
    for wrong in (3, None, xr.Dataset(), ["stratus"]):
        with pytest.raises(OptionError, match="scenario"):
            hcss_twin.simulate(wrong)


class Closed(HTMLParser):
    """Checks that elements are closed in order, and collects the text."""

    def __init__(self, text):
        super().__init__()
        self.open, self.text = [], ""
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def test_scenarios_and_plans_are_short_at_the_prompt_and_tables_in_a_notebook():
    scenario = hcss_twin.Scenario.load("cirrus-over-cumulus", {"title": "<b>Two & more</b>"})
    plan = hcss_twin.make_plan(scenario)
    for one, most in ((scenario, 12), (plan, 25)):
        text = repr(one)
        assert len(text.splitlines()) <= most
        shown = Closed(one._repr_html_()).text
        for part in ("<b>Two & more</b>", "paper-cirrus", "paper-cumulus"):
            assert part in text
            assert part in shown
    assert scenario.to_json() in Closed(scenario._repr_html_()).text
    assert str(plan.pixels[0]) in repr(plan)


def test_the_accessor_has_the_brightness_temperature_of_the_function_or_of_the_cube(cube):
    kelvin = cube.hcss.brightness_temperature()
    xr.testing.assert_identical(kelvin, hcss_twin.brightness_temperature(cube))
    with_kelvin = cube.assign(brightness_temperature=kelvin + 1.0)
    xr.testing.assert_identical(with_kelvin.hcss.brightness_temperature(), with_kelvin.brightness_temperature)


def test_a_plot_has_the_pixels_of_the_frame_in_kelvin_of_the_band_with_most_to_see(cube):
    axes = cube.hcss.plot(frame=1)
    [image] = axes.images
    expected = hcss_twin.brightness_temperature(cube).sel(band="lwir").isel(time=1)
    np.testing.assert_array_equal(image.get_array(), expected)
    assert "lwir" in axes.get_title()
    [image] = cube.hcss.plot("radiance", band="mwir", axes=axes).images[1:]
    np.testing.assert_array_equal(image.get_array(), cube.radiance.sel(band="mwir").isel(time=0))
    for wrong, told in (
        ({"band": "swir"}, "allowed: lwir, mwir|allowed: mwir, lwir"),
        ({"frame": 3}, "allowed: 0 to 2"),
    ):
        with pytest.raises(CubeError, match=told):
            cube.hcss.plot(**wrong)
    with pytest.raises(CubeError, match="holds no 'cloud_tops'"):
        cube.hcss.plot("cloud_tops")


@pytest.mark.parametrize(("row", "column"), [(0, 12), (7, 29), (19, 10)])
def test_the_series_of_a_place_follows_it_through_the_frames(cube, row, column):
    """The platform moves by 10 pixels a frame to the east, so that a place moves to the west."""
    east, north = (np.array(float(axis)) for axis in (cube.x[column], cube.y[row]))
    latitude, longitude = to_geographic(east, north, float(cube.latitude), float(cube.longitude))
    series = cube.hcss.at(float(latitude), float(longitude))
    assert series.radiance.dims == ("time", "band")
    assert (float(series.latitude), float(series.longitude)) == (float(latitude), float(longitude))
    for frame in range(3):
        there = column - 10 * frame
        expected = cube.radiance[frame, :, row, there] if there >= 0 else np.full(2, np.nan)
        np.testing.assert_array_equal(series.radiance[frame], expected)
        assert series.x[frame] == cube.x[there] if there >= 0 else np.isnan(series.x[frame])
    kelvin = series.hcss.brightness_temperature()
    np.testing.assert_array_equal(kelvin[0], cube.hcss.brightness_temperature()[0, :, row, column])


def test_a_place_that_no_frame_sees_is_refused(cube):
    with pytest.raises(CubeError, match="no frame of the cube sees that place"):
        cube.hcss.at(0.0, 0.0)
    with pytest.raises(OptionError, match="at: latitude: 150"):
        cube.hcss.at(150.0, 35.0)


def camera(turn_deg=30.0, pixel_m=100.0, rows=21, columns=31):
    """A camera turned by this angle over a scene whose values are the distance to the north, m."""
    y, x = np.mgrid[0:rows, 0:columns] * pixel_m - np.reshape([rows - 1, columns - 1], (2, 1, 1)) * pixel_m / 2
    turn = np.radians(turn_deg)
    east, north = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    latitude, longitude = to_geographic(east, north, 36.0, 179.99)
    places = {"pixel_latitude": latitude, "pixel_longitude": (longitude + 180.0) % 360.0 - 180.0}
    pixels = {name: (("time", "row", "column"), values[None]) for name, values in places.items()}
    axes = {"row": np.arange(rows), "column": np.arange(columns), "time": np.array(["2024-01-01"], "datetime64[ns]")}
    values = {"radiance": (("time", "band", "row", "column"), np.float32(north)[None, None])}
    return xr.Dataset(values, coords={**axes, "band": ["lwir"], **pixels})


def test_a_camera_image_lies_on_the_ground_north_up_with_its_pixels_where_they_look():
    ground = camera().hcss.to_ground()
    assert ground.radiance.dims == ("time", "band", "y", "x")
    known = np.isfinite(ground.radiance[0, 0])
    rows, columns = ground.sizes["y"], ground.sizes["x"]
    assert 0.4 < float(known.mean()) < 0.95  # a turned rectangle within the upright one
    difference = (ground.radiance[0, 0] - ground.y).where(known)
    assert float(np.abs(difference).max()) <= 0.75 * 100.0
    assert abs(float(difference.mean())) < 10.0
    half = camera().hcss.to_ground(50.0)
    assert half.sizes["y"] == pytest.approx(2 * rows, abs=2)
    assert half.sizes["x"] == pytest.approx(2 * columns, abs=2)
    for size in (-1.0, 1e-9):
        with pytest.raises(CubeError, match="pixel_size_m"):
            camera().hcss.to_ground(size)


def test_a_camera_has_the_series_of_the_pixel_that_looks_at_a_place():
    seen = camera()
    latitude, longitude = (float(seen[f"pixel_{name}"][0, 4, 17]) for name in ("latitude", "longitude"))
    series = seen.hcss.at(latitude + 1e-5, longitude)
    assert (int(series.row[0]), int(series.column[0])) == (4, 17)
    assert float(series.radiance[0, 0]) == float(seen.radiance[0, 0, 4, 17])
    for elsewhere in ((latitude + 0.5, longitude), (latitude, longitude - 180.0)):
        with pytest.raises(CubeError, match="no frame"):
            seen.hcss.at(*elsewhere)


def test_a_cube_on_the_ground_stays_as_it_is(cube):
    assert cube.hcss.to_ground() is cube
    with pytest.raises(CubeError, match="on the ground already"):
        cube.hcss.to_ground(50.0)


def test_the_package_and_its_scenarios_load_neither_xarray_nor_matplotlib():
    code = (
        "import sys, hcss_twin; hcss_twin.Scenario.load('stratus'); "
        "hcss_twin.make_plan, hcss_twin.brightness_temperature; "
        "print(sorted({'xarray', 'matplotlib', 'IPython'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
