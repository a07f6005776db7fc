"""Cubes of a camera: against the grid on the ground, at the limb, and what is refused."""

import ast
import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from camera_scenes import MWIR, PASS, SCENE, STARING, merged, scenario
from click.testing import CliRunner
from hcss_payload import Circular, Track
from hcss_payload.directions import Hemisphere, Strip, directions_around
from hcss_payload.rays import geographic

import hcss_twin
from hcss_twin.cli import cli
from hcss_twin.core.errors import ScenarioError
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.verification import verify_cube
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.plan import make_plan
from hcss_twin.plan.error_budget import beyond_accuracy
from hcss_twin.plan.scene_analysis import analyse_scene
from hcss_twin.plan.views import views_over_image
from hcss_twin.providers import View
from hcss_twin.reports.plan_text import plan_text


@pytest.fixture(scope="module")
def pass_path(tmp_path_factory):
    path = tmp_path_factory.mktemp("pass") / "pass.nc"
    hcss_twin.simulate(scenario(PASS), path).close()
    return path


@pytest.mark.parametrize("clouds", [{"type": "paper-stratus"}, {"type": "paper-cumulus"}])
def test_a_nadir_camera_gives_the_cube_of_the_ground_grid(clouds):
    output = {"variables": ["radiance", "cloud_mask", "cloud_thickness"], "certificate": 0}
    grid = hcss_twin.simulate(scenario({"clouds": clouds, "output": output}))
    cube = hcss_twin.simulate(scenario(STARING, {"clouds": clouds, "output": output}))
    assert cube["radiance"].dims == ("time", "band", "row", "column")
    # The first row of a focal plane with north up is the northern one, that of a grid the southern one.
    expected, seen = grid["radiance"].values[..., ::-1, :].astype(float), cube["radiance"].values.astype(float)
    assert np.sqrt(np.mean((seen - expected) ** 2)) <= 0.005 * expected.std()
    assert abs(seen.mean() / expected.mean() - 1.0) <= 1e-3
    assert np.mean(cube["cloud_mask"].values == grid["cloud_mask"].values[:, ::-1]) > 0.999
    assert np.all(np.diff(cube["pixel_latitude"].values[0, :, 0]) < 0.0)
    assert np.all(np.diff(cube["pixel_longitude"].values[0, 0]) > 0.0)


def test_a_narrow_camera_has_the_tables_of_its_one_view():
    plan = hcss_twin.make_plan(scenario(STARING, {"output": {"certificate": 0}}))
    (view,) = views_over_image(plan.assembly).at(plan.views.places)
    (of_view,) = compile_tables(plan).over
    nodes = of_view.spectrum.nodes
    terms = plan.assembly.toward(view).clear(nodes.wavenumber_cm1, plan.sun_at(0.0))
    exact = np.sum(list(terms.values()), axis=0) @ nodes.weights_cm1.T
    np.testing.assert_allclose(of_view.tables[0].clear[0], exact, rtol=1e-9)


def test_a_plan_tells_the_pixels_of_the_camera_and_those_of_the_plane_of_the_scene():
    lines = plan_text(hcss_twin.make_plan(scenario(PASS))).splitlines()
    told = {line[2:15].strip(): line[15:] for line in lines[1:] if line[2:15].strip()}
    assert told["image"].startswith("40 rows x 48 columns of about ")
    assert told["plane"].startswith("64 rows x 64 columns of 100 m (6.4 x 6.4 km)")


def test_only_pixels_of_one_point_lack_what_their_footprint_holds():
    what = "clouds within the footprint of a pixel", "surfaces within the footprint of a pixel"
    coast = {"place": {"latitude": 36.7, "longitude": -6.4}, "surfaces": {"provider": "coast"}}
    over = {
        "orbit": PASS["orbit"] | {"above": [36.7, -3.5]},
        "clouds": {"type": "cumulus"},
        "image": {"pixel_size": 300},
    }
    for points, lacks in ((None, False), (1, True), (2, False)):
        camera = {} if points is None else {"camera": {"points": points}}
        plan = hcss_twin.make_plan(scenario(PASS, coast, over, camera))
        assert [any(item.what == name for item in plan.omissions) for name in what] == [lacks, lacks], points


def test_a_single_frame_of_a_camera_shows_part_of_a_sky_with_one_threshold():
    one = {"frames": {"count": 1}, "clouds": {"coverage_mode": None}}
    assert [layer.coverage_mode for layer in scenario(PASS, one).clouds.layers] == ["field"]
    assert [layer.coverage_mode for layer in scenario(one).clouds.layers] == ["frame"]
    with pytest.raises(ScenarioError, match="one coverage of every image"):
        hcss_twin.make_plan(scenario(PASS, one, {"clouds": {"coverage_mode": "frame"}}))


def test_the_error_of_one_sun_is_that_over_what_the_camera_sees_however_large_the_plane():
    def bound(**image):
        day = {"time": "2024-04-20T03:00:00Z", "bands": [MWIR], "frames": {"count": 1}, "image": image}
        coarse = {"orbit": {"above_time": 0.0}, "accuracy": 1e-2}  # for which one sun is good enough
        plan = hcss_twin.make_plan(scenario(PASS, day, coarse))
        return next(item.bound for item in plan.omissions if item.what == "sun angles of single pixels")

    small = bound(rows=64, columns=64)
    assert small > 0.0
    assert bound(rows=2000, columns=2000) == small


WIDE_DAY = {
    "time": "2024-04-20T05:30:00Z",
    "bands": [MWIR],
    "camera": {"rows": 96, "columns": 96, "points": 1, "focal_length": 0.06},
    "clouds": {"coverage": 0.0},
    "sea": {"temperature_texture": 0.0, "waves": "off"},
}

SEEN = {
    "a frame": {"frames": {"count": 1}, "orbit": {"above_time": 0.0}},
    "a camera that looks down": {
        "time": "2024-04-20T02:30:00Z",
        "attitude": {"provider": "nadir"},
        "orbit": {"above": [30.0, 150.0], "above_time": 10.0},
        "frames": {"interval": 10.0},
    },
    "a camera that follows a place": {},
}


@pytest.mark.parametrize("seen", SEEN)
def test_each_pixel_of_a_frame_has_the_sun_of_its_place_where_one_sun_is_not_accurate_enough(seen):
    plan = hcss_twin.make_plan(scenario(PASS, WIDE_DAY, SEEN[seen]))
    assert not any("sun angles" in each for each in beyond_accuracy(plan))
    cube, grid = hcss_twin.simulate(scenario(PASS, WIDE_DAY, SEEN[seen])), plan.spectral_grid
    assert cube.attrs["hcss_certificate"].startswith("computed as specified")
    of_centre = []
    for number, time_s in enumerate(plan.frame_times_s.tolist()):
        for row, column in ((0, 0), (0, 95), (95, 0), (95, 95), (20, 50)):
            pixel = cube.isel(time=number, row=row, column=column)
            # Both angles count from the north of the place.
            view = View(float(pixel["pixel_view_zenith"]), float(pixel["pixel_view_azimuth"]))
            place = {f"{name}_deg": float(pixel[f"pixel_{name}"]) for name in ("latitude", "longitude")}
            of_place = replace(plan.sun_track, **place).at(time_s)
            exact, of_one_sun = (
                np.sum(list(plan.assembly.toward(view).clear(grid.wavenumber_cm1, sun).values()), axis=0)
                @ grid.weights_cm1[0]
                for sun in (of_place, plan.sun_track.at(time_s))
            )
            of_centre.append(abs(of_one_sun / exact - 1.0))
            assert float(pixel["radiance"][0]) == pytest.approx(exact, rel=3e-4)
    assert max(of_centre) > 1e-3


def test_a_scene_with_suns_of_its_places_is_analysed_once(monkeypatch):
    analysed = []

    def analyse(*given):
        analysed.append(analyse_scene(*given))
        return analysed[-1]

    monkeypatch.setattr(make_plan, "analyse_scene", analyse)
    plan = make_plan.make_plan(scenario(PASS, WIDE_DAY, SEEN["a frame"]), keeps_results=False)
    assert len(analysed) == 1
    assert not any("sun angles" in item.what for item in plan.omissions if item.exceeds(plan.accuracy.relative))


def test_pixels_of_a_pass_agree_with_its_geometry_and_certificate(pass_path):
    with hcss_twin.open_cube(pass_path) as cube:
        assert cube.attrs["hcss_certificate"].startswith("computed as specified")
        assert max(json.loads(cube.attrs["hcss_accuracy_achieved"]).values()) < 1e-3
        orbit = Circular.above(7e5, 98.2, 30.0, 153.0, 60.0)
        for number, time_s in enumerate((0.0, 60.0, 120.0)):
            position = orbit.at(time_s)
            assert cube["platform_position"].values[number] == pytest.approx(position)
            frame = cube.isel(time=number)
            latitude, longitude = (frame[f"pixel_{name}"].values for name in ("latitude", "longitude"))
            ground_m = Ellipsoid.to_earth_centred(latitude, longitude)
            away = position - ground_m
            distance = np.linalg.norm(away, axis=-1)
            assert frame["pixel_slant_range"].values == pytest.approx(distance, abs=20.0)
            lat, lon = np.radians(latitude), np.radians(longitude)
            up = np.stack((np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)), axis=-1)
            east = np.stack((-np.sin(lon), np.cos(lon), 0 * lon), axis=-1)
            north = np.cross(up, east)
            zenith = np.degrees(np.arccos(np.sum(away * up, axis=-1) / distance))
            azimuth = np.degrees(np.arctan2(np.sum(away * east, axis=-1), np.sum(away * north, axis=-1))) % 360.0
            assert frame["pixel_view_zenith"].values == pytest.approx(zenith, abs=1e-3)
            assert frame["pixel_view_azimuth"].values == pytest.approx(azimuth, abs=2e-3)
            # The tracked place is in the middle.
            assert latitude[19:21, 23:25].mean() == pytest.approx(30.0, abs=1e-3)


def test_a_cube_is_verified_and_its_scenario_read_again(pass_path):
    assert str(verify_cube(pass_path, frames=1).verdict) == "identical"
    again = hcss_twin.Scenario.from_cube(pass_path)
    assert json.loads(again.to_json()) == json.loads(scenario(PASS).to_json())


def test_the_page_of_a_pass_shows_its_frames(pass_path, tmp_path):
    page = tmp_path / "page.html"
    done = CliRunner().invoke(cli, ["report", str(pass_path), "-o", str(page)])
    assert done.exit_code == 0, done.output
    text = page.read_text(encoding="utf-8")
    with hcss_twin.open_cube(pass_path) as cube:
        rows, columns = cube.sizes["row"], cube.sizes["column"]
    assert text.count("<img") >= 2
    assert f"{rows} rows x {columns} columns<" in text  # of no size on the ground


def test_a_frame_has_the_same_bits_in_every_list_of_frames_of_a_pass(pass_path):
    with hcss_twin.open_cube(pass_path) as cube:
        whole = cube["radiance"].values
    fewer = hcss_twin.simulate(
        scenario(PASS, {"frames": {"count": 2, "interval": 120.0}, "output": {"certificate": 0}})
    )
    assert np.array_equal(fewer["radiance"].values, whole[::2])


def test_higher_layers_move_farther_against_the_sea():
    layers = [
        {"type": "stratus", "coverage": 0.4, "coverage_mode": "field", "base": 1000.0, "top": 1600.0},
        {"type": "cirrus", "coverage": 0.4, "coverage_mode": "field", "base": 8000.0, "top": 9000.0},
    ]
    cube = hcss_twin.simulate(with_layers(layers))
    plan = hcss_twin.make_plan(with_layers(layers))
    samples, everywhere = plan.samples_per_pixel, (slice(0, 40), slice(0, 48))
    places = [plan.rays.points_m(everywhere, 0.0, height) for height in (0.0, 8000.0)]
    moved = np.hypot(*(high - low for low, high in zip(*places, strict=True)))
    moved = moved.reshape(40, samples, 48, samples).mean(axis=(1, 3))
    zenith = np.radians(cube["pixel_view_zenith"].values[0])
    # A straight line over the ellipsoid: h tan(zenith) to first order in h over the Earth's radius.
    assert moved == pytest.approx(8000.0 * np.tan(zenith), rel=0.01)
    assert cube.attrs["hcss_certificate"].startswith("computed as specified")
    assert np.all(cube["cloud_layer_thickness"].values.max(axis=(0, 2, 3)) > 0.0)


def with_layers(layers):
    raw = merged(SCENE, PASS, {"frames": {"count": 1}, "output": {"variables": ["radiance", "cloud_layer_thickness"]}})
    raw["clouds"] = {"layers": layers}
    return hcss_twin.Scenario.from_dict(raw)


def test_a_tracked_target_is_in_its_pixel_on_the_coast():
    site = {"latitude": 36.7, "longitude": -6.42}
    source = {"x": 0.0, "y": 0.0, "altitude": 0.0, "intensity": 1e6}
    parts = {
        "place": site,
        "orbit": {"above": [36.7, -3.4]},
        "clouds": {"coverage": 0.0},
        "surfaces": {"provider": "coast"},
        "elements": [{"provider": "point-sources", "parameters": {"tracks": [source]}}],
        "output": {"variables": ["radiance", "surface_class", "element"]},
    }
    cube = hcss_twin.simulate(scenario(PASS, parts))
    assert cube.attrs["hcss_certificate"].startswith("computed as specified")
    plan = hcss_twin.make_plan(scenario(PASS, parts))
    for number, time_s in enumerate((0.0, 60.0, 120.0)):
        row, column = plan.rays.project(*np.zeros((3, 1)), time_s)
        assert np.hypot(row - 20.0, column - 24.0) < 0.02
        radiance = cube["radiance"].values[number, 0]
        bright = np.unravel_index(np.argmax(radiance), radiance.shape)
        assert bright[0] in (19, 20)
        assert bright[1] in (23, 24)
        # Its intensity over the pixel's area, seen through the air: between all and half of it arrives.
        distance = cube["pixel_slant_range"].values[number][bright]
        extra = (radiance.max() - np.median(radiance)) * (distance * 1e-4) ** 2
        assert 0.3e6 < extra < 1e6
    assert set(np.unique(cube["surface_class"].values)) == {0, 1}


DISK = {
    "camera": {
        "rows": 96,
        "columns": 96,
        "focal_length": 0.1,
        "detector_pitch": 3.2e-4,
        "points": 2,
        "beyond": "missing",
    },
    "orbit": {"provider": "geostationary", "longitude": 140.7},
    "image": {"pixel_size": 30e3, "rows": 400, "columns": 400},
    "frames": {"count": 1},
    "clouds": {"base": 1000.0, "top": 4000.0},
}


def test_a_full_disk_has_ground_missing_limb_and_space_of_no_radiance():
    cube = hcss_twin.simulate(scenario(DISK))
    assert cube.attrs["hcss_certificate"].startswith("computed as specified")
    kind, radiance = cube["pixel_kind"].values[0], cube["radiance"].values[0, 0]
    zenith = cube["pixel_view_zenith"].values[0]
    assert set(np.unique(kind)) == {0, 1, 2, 3}
    assert np.all(radiance[kind == 0] > 1.0)
    assert np.all(np.isnan(radiance[(kind == 1) | (kind == 2)]))
    assert np.all(radiance[kind == 3] == 0.0)
    assert np.nanmax(zenith[kind == 0]) <= 75.0 < np.nanmin(zenith[kind == 1])
    assert np.all(np.isnan(cube["pixel_latitude"].values[0][kind >= 2]))
    # The disk of the Earth: its radius seen from the geostationary orbit is 8.7 degrees.
    seen = np.sqrt(np.sum(kind <= 1) / np.pi) * 3.2e-3
    assert np.degrees(np.arctan(seen)) == pytest.approx(8.7, abs=0.1)
    plan = hcss_twin.make_plan(scenario(DISK))
    assert isinstance(plan.rays.directions, Hemisphere)
    # Its radiance changes little, because the air is as warm as the sea, but not its path through the air.
    assert plan.views.edges
    assert len(plan.views.extremes) > 1


@pytest.mark.parametrize(("latitude", "longitude"), [(89.9, 10.0), (10.0, 179.98)])
def test_passes_over_pole_and_date_line(latitude, longitude):
    parts = {
        "place": {"latitude": latitude, "longitude": longitude},
        "orbit": {"inclination": 90.0, "above": [min(latitude, 88.0), longitude]},
        "frames": {"count": 2, "interval": 60.0},
        "atmosphere": {"profile": "midlatitude-summer"},
    }
    cube = hcss_twin.simulate(scenario(PASS, parts))
    assert cube.attrs["hcss_certificate"].startswith("computed as specified")
    assert np.all(np.abs(cube["pixel_longitude"].values - longitude) <= 180.0)
    middle = cube["pixel_latitude"].values[:, 19:21, 23:25].mean(axis=(1, 2))
    assert middle == pytest.approx(latitude, abs=0.01)


def test_directions_invert_their_views():
    rng = np.random.default_rng(2)
    for spread, kind in ((0.05, Strip), (0.9, Hemisphere)):
        flat = rng.uniform(-spread, spread, (200, 2)) / np.sqrt(2)
        toward = np.column_stack((flat, np.sqrt(1.0 - np.sum(flat**2, axis=1))))
        directions = directions_around(toward)
        assert isinstance(directions, kind)
        x, y = directions.places(toward, toward)
        assert max(np.abs(x).max(), np.abs(y).max()) <= 1.0
        for view, direction in zip(directions.at(zip(x, y, strict=True)), toward, strict=True):
            zenith, azimuth = np.radians(view.zenith_deg), np.radians(view.azimuth_deg)
            again = np.sin(zenith) * np.sin(azimuth), np.sin(zenith) * np.cos(azimuth), np.cos(zenith)
            assert direction == pytest.approx(again, abs=1e-6)


def test_an_orbit_passes_above_its_place():
    for rising in (True, False):
        orbit = Circular.above(7e5, 98.2, 30.0, -120.0, 100.0, rising)
        latitude, longitude, _ = geographic(orbit.at(100.0))
        assert latitude == pytest.approx(30.0, abs=0.01)
        assert np.cos(np.radians(longitude + 120.0)) == pytest.approx(1.0)
        assert (geographic(orbit.at(101.0))[0] > latitude) == rising
    assert Track(orbit, 30.0, -120.0).at(100.0).shape == (4,)


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"view": {"zenith": 10.0}}, r"view\.zenith: .*cannot be computed with a camera"),
        ({"platform": {"altitude": 7e5}}, r"platform\.altitude: .*cannot be computed with a camera"),
        ({"clouds": {"coverage_mode": "frame"}}, r"clouds\.coverage_mode: 'frame'.*allowed: 'field'"),
        ({"orbit": {"altitude": 4e4}}, r"orbit\.altitude: 40000\.0 is out of range; allowed: >= 100000.*closest"),
        ({"orbit": {"longitude": 3.0}}, r"orbit: longitude given with provider 'circular'; its keys are altitude"),
        ({"orbit": {"provider": "circlar"}}, r"orbit: .*closest is 'circular'"),
        ({"camera": {"row": 3}}, r"camera\.row: unknown key.*rows"),
        ({"attitude": {"provider": "track", "latitude": -60.0}}, r"attitude.*below the horizon"),
        ({"attitude": {"provider": "push-broom", "roll": 61.0}}, r"camera\.beyond: 'refuse', and at time 0 s"),
        ({"attitude": {"provider": "aem", "file": "nothing.aem"}}, r"attitude\.file: no file 'nothing\.aem'"),
    ],
)
def test_wrong_sections_are_named(parts, message):
    with pytest.raises(ScenarioError, match=message):
        hcss_twin.make_plan(scenario(PASS, parts))


def test_a_camera_without_orbit_is_refused():
    with pytest.raises(ScenarioError, match=r"orbit: .*\[camera\] and \[orbit\]"):
        hcss_twin.make_plan(scenario({"camera": PASS["camera"]}))


def test_a_scenario_without_sections_imports_only_the_hooks_of_this_package():
    code = (
        "import sys, json, hcss_twin; hcss_twin.make_plan(hcss_twin.Scenario.from_dict(json.loads(sys.argv[1])));"
        "print([name for name in sys.modules if name.startswith('hcss_payload') or name.endswith('core.sections')])"
    )
    answer = subprocess.run([sys.executable, "-c", code, json.dumps(SCENE)], capture_output=True, text=True, check=True)
    assert set(ast.literal_eval(answer.stdout)) <= {"hcss_payload", "hcss_payload.hooks"}


def test_workers_jitter_and_stores_give_the_same_pixels(tmp_path, pass_path):
    from hcss_twin.engine.simulate import run

    shaken = {"jitter": {"rms": ["0.5 mrad", "0.5 mrad", "100 urad"]}, "output": {"certificate": 0}}
    shaken["frames"] = {"count": 2, "interval": 120.0}  # the first and the last of the steady pass
    plan = hcss_twin.make_plan(scenario(PASS, shaken))
    paths = [
        run(plan, tmp_path / "one.nc"),
        run(plan, tmp_path / "two.nc", workers=2),
        run(plan, tmp_path / "store.zarr"),
    ]
    one, *others = (hcss_twin.open_cube(path).load() for path in paths)
    for other in others:
        assert other["radiance"].dims == one["radiance"].dims
        assert np.array_equal(other["radiance"].values, one["radiance"].values)
        assert np.array_equal(other["pixel_latitude"].values, one["pixel_latitude"].values)
    with hcss_twin.open_cube(pass_path) as steady:
        assert np.abs(one["pixel_latitude"].values - steady["pixel_latitude"].values[::2]).max() > 1e-4
