"""Elements at the edges of images and windows, below blurring optics, in wide fields and in sweeps."""

import math

import numpy as np
import pytest
from cheap import CHEAP
from scipy.special import ndtr
from whole_frames import first_frame

from hcss_twin import Scenario, make_plan, open_cube, sense
from hcss_twin.core.errors import CubeError
from hcss_twin.cube.variables import ELEMENT_PLACE, ELEMENT_RATE
from hcss_twin.engine.simulate import run
from hcss_twin.physics.paths import to_space
from hcss_twin.physics.viewing import LinesOfSight

SCENE = """
time = 2024-04-20T22:30:00+10:00
place = {latitude = 35.0, longitude = 150.0}
image = {rows = 12, columns = 16, pixel_size = 20.0}
frames.count = 1
bands = ["lwir-10.8"]
output = {variables = ["radiance", "element", "element_share", "element_radiance"], certificate = 0}
"""
BLUR = {"sensor": {"parameters": {"psf": "gaussian", "psf_sigma": 1.2}}}
WIDE = {"image.rows": 30, "image.columns": 40, "image.pixel_size": 3000.0, "platform.altitude": "800 km"}
STRENGTH = 1e5


def planned(tracks, footprint=0.0, **changes):
    raw = {**CHEAP, **changes, "elements": [{"parameters": {"tracks": tracks, "footprint": footprint}}]}
    return make_plan(Scenario.from_toml(SCENE, raw))


def source(x, y, **more):
    return {"x": x, "y": y, "intensity": STRENGTH, **more}


def transmitted(plan, altitude_m, zenith_deg):
    """Band mean of the transmittance to space, for light of no colour."""
    grid = plan.spectral_grid
    [through] = plan.assembly.transmittance.transmittance(grid.wavenumber_cm1, [to_space(altitude_m, zenith_deg)])
    return float((grid.weights_cm1 @ through)[0] / grid.weights_cm1.sum())


@pytest.mark.parametrize(
    ("x", "y", "inside"),
    [
        # Squares of 50 m; the image extends 160 m and 120 m from its centre.
        (160.0, 0.0, 0.5),
        (-170.0, 3.0, 0.3),
        (0.0, -120.0, 0.5),
        (159.0, 119.0, 0.52 * 0.52),
        (200.0, 0.0, 0.0),
    ],
)
def test_an_image_has_the_share_of_a_source_that_lies_in_it(x, y, inside):
    plan = planned([source(x, y)], footprint=50.0)
    result = first_frame(plan)
    assert np.nansum(result["element_share"]) == pytest.approx(inside, abs=1e-6)
    flux = result["element_radiance"].sum() * 400.0 * math.cos(math.radians(plan.view.zenith_deg))
    assert flux == pytest.approx(inside * STRENGTH * transmitted(plan, 0.0, plan.view.zenith_deg), rel=1e-4, abs=1e-6)


@pytest.fixture(scope="module")
def wide():
    places = (-5e3, 2.2e3, 1e4), (59e3, -44e3, 0.0), (-61e3, 44.5e3, 0.0), (20.1e3, 30.3e3, 100.0)
    tracks = [source(x, y, altitude=altitude, intensity=1e3 * STRENGTH) for x, y, altitude in places]
    plan = planned(tracks, footprint=4500.0, **WIDE, **{"view.zenith": 40.0})
    assert plan.views.varies
    return plan, tracks, first_frame(plan)


def test_in_a_wide_field_each_source_has_the_path_of_the_line_of_sight_of_its_pixel(wide):
    plan, tracks, result = wide
    view = plan.scenario.view
    lines = LinesOfSight(35.0, 150.0, view.zenith, view.azimuth, 800e3)
    expected, zeniths = np.zeros((30, 40)), []
    for each in tracks:
        centre = ((math.floor(each[name] / 3e3) + 0.5) * 3e3 for name in ("x", "y"))
        zenith = float(lines.from_points(*map(np.array, centre)).zenith_deg)
        zeniths.append(zenith)
        for row, column in np.ndindex(30, 40):
            x, y = (column - 19.5) * 3e3, (row - 14.5) * 3e3
            overlap = [
                max(min(at + 1.5e3, middle + 2.25e3) - max(at - 1.5e3, middle - 2.25e3), 0.0) / 4.5e3
                for at, middle in ((x, each["x"]), (y, each["y"]))
            ]
            if math.prod(overlap):
                reach = math.prod(overlap) * 1e3 * STRENGTH * transmitted(plan, each["altitude"], zenith)
                expected[row, column] += reach / (9e6 * math.cos(math.radians(zenith)))
    assert max(zeniths) - min(zeniths) > 4.0
    np.testing.assert_array_equal(result["element"] > 0, expected > 0)
    np.testing.assert_allclose(result["element_radiance"][0], expected, rtol=2e-5, atol=2e-6)


def test_a_window_of_a_wide_field_cuts_through_sources(wide):
    _, tracks, result = wide
    rows, columns = (14, 25), (17, 26)
    assert 0 < np.count_nonzero(result["element"][slice(*rows), slice(*columns)]) < np.count_nonzero(result["element"])
    window = {"image.window": {"rows": list(rows), "columns": list(columns)}}
    part = first_frame(planned(tracks, footprint=4500.0, **WIDE, **window, **{"view.zenith": 40.0}))
    for name, values in part.items():
        assert values.tobytes() == result[name][(..., slice(*rows), slice(*columns))].tobytes(), name


def test_optics_show_sources_at_and_beyond_the_edges_as_a_gaussian_averaged_over_pixels(tmp_path):
    # Rows and columns of the sources: in the image, on its edge, and outside.
    places = [(3.2, 4.4), (-0.4, 9), (13, 12.1), (7, -2)]
    tracks = [source(20.0 * (column - 7.5), 20.0 * (row - 5.5), altitude=2e5) for row, column in places]
    measured = []
    for name, elements in (("with", tracks), ("without", [source(0.0, 0.0, intensity=0.0)])):
        run(planned(elements, **BLUR), tmp_path / f"{name}.nc")
        with open_cube(tmp_path / f"{name}.sensor.nc") as cube:
            measured.append(cube["radiance"].to_numpy()[0, 0].astype(float))
    spread = sum(
        np.outer(*(np.diff(ndtr((np.arange(n + 1) - 0.5 - at) / 1.2)) for n, at in ((12, y), (16, x))))
        for y, x in places
    )
    plan = planned(tracks)
    expected = spread * STRENGTH / (400.0 * math.cos(math.radians(plan.view.zenith_deg)))
    np.testing.assert_allclose(measured[0] - measured[1], expected, atol=1e-4 * expected.max())


def test_a_finished_cube_shows_targets_as_a_run_does_and_needs_their_places(tmp_path):
    # On a uniform sea the mirror image beyond the edges is the sea itself.
    names = ["radiance", "element_point_radiance", *ELEMENT_PLACE, *ELEMENT_RATE]
    moving = source(13.0, -7.0, velocity=[4e3, 6e3, 0.0])
    body = {"x": -66.0, "y": 41.0, "altitude": 5e3, "temperature": 230.0, "area": 100.0}
    sensor = {"parameters": {"psf": "gaussian", "psf_sigma": 0.6, "integration_time": 1e-2}}
    plan = planned([moving, body], sensor=sensor, **{"output.variables": names})
    run(plan, tmp_path / "c.nc")
    with open_cube(tmp_path / "c.sensor.nc") as cube:
        expected = cube["radiance"].to_numpy()[0, 0].astype(float)
    found = sense(tmp_path / "c.nc", sensor)["radiance"].to_numpy()[0, 0]
    with open_cube(tmp_path / "c.nc") as cube:
        clean = cube["radiance"].to_numpy()[0, 0].astype(float)
        added = cube["element_point_radiance"].to_numpy()[0, 0].astype(float)
        in_memory = sense(cube.load(), sensor)["radiance"].to_numpy()[0, 0]
        with pytest.raises(CubeError, match=r"lacks element_row; allowed: a cube with these output\.variables"):
            sense(cube.drop_vars("element_row").load(), sensor)
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    np.testing.assert_array_equal(found, in_memory)
    # 6 m/ms for 10 ms are 3 pixels of motion: the variance of the image along the rows is that of all three.
    sea = (clean - added)[0, 0]
    image = np.where(np.indices(clean.shape)[1] > 5, expected - sea, 0.0)
    assert image.sum() == pytest.approx(added[5, 8], rel=1e-3)
    y = np.arange(12) + 0.5
    rows = image.sum(axis=1) / image.sum()
    assert rows @ y == pytest.approx(6.0 - 7.0 / 20.0, abs=0.01)
    assert rows @ (y - rows @ y) ** 2 == pytest.approx(3.0**2 / 12.0 + 0.6**2 + 1.0 / 12.0, rel=0.01)


@pytest.mark.long
def test_a_sweep_in_processes_has_the_elements_of_a_serial_one(tmp_path):
    hcss_sweep = pytest.importorskip("hcss_sweep")
    (tmp_path / "scene.toml").write_text(
        SCENE + "[[elements]]\nparameters = {footprint = 50.0, tracks = [{x = 150, intensity = 1e5}]}\n"
    )
    cubes = []
    for name, workers in (("serial", 1), ("processes", 2)):
        result = hcss_sweep.sweep(
            str(tmp_path / "scene.toml"),
            tmp_path / name,
            over={"view.zenith": [0.0, 30.0]},
            overrides=CHEAP,
            workers=workers,
            dataset=tmp_path / f"{name}.nc",
        )
        with hcss_sweep.open_sweep(result.dataset) as data:
            cubes.append(data.load())
    assert float(cubes[0]["element_share"].max()) > 0.0
    for name in cubes[0].data_vars:
        np.testing.assert_array_equal(cubes[0][name], cubes[1][name], err_msg=name)
