"""A third geometry of rays: against the same sea on a grid, and through clouds."""

import json
from pathlib import Path

import netCDF4
import numpy as np
import pytest

from hcss_twin import Scenario, ScenarioError, make_plan, simulate

SCENARIO = Path(__file__).parents[1] / "scenarios" / "conical-scanner.toml"
CHEAP = {"radiance.model": "as-printed", "sea.model": "cox-munk"}
ARC = {
    "clouds.type": "cumulus",
    "clouds.generator": "fractal",
    "conical_scanner": {"half_arc": 20.0, "rows": 24, "columns": 48},
}


def of(**overrides):
    return Scenario.load(SCENARIO, CHEAP | ARC | {"output.variables": ["radiance"]} | overrides)


def test_clear_pixels_have_the_radiance_of_their_views():
    clear = {"clouds.coverage": 0.0, "sea.temperature_texture": 0.0, "atmosphere.water_vapour_texture": 0.0}
    arc = simulate(of(**clear))
    assert arc.attrs["hcss_certificate"].startswith("computed as specified")
    for column, azimuth in ((0, 180.0 - 20.0 * 47 / 48), (31, 180.0 + 20.0 * 15 / 48)):
        grid = {"view.zenith": 53.0, "view.azimuth": azimuth, "image.rows": 8, "image.columns": 8}
        raw = json.loads(of(**clear, **grid).to_json())
        del raw["conical_scanner"]
        grid = simulate(Scenario.from_dict(raw))
        assert arc["radiance"].values[0, :, :, column] == pytest.approx(
            np.tile(grid["radiance"].values[0, :, :1, 0], 24), rel=2e-3
        )


def test_clouds_are_seen_and_certified_where_rays_meet_their_layer():
    cube = simulate(of(**{"output.variables": ["radiance", "cloud_fraction"]}))
    assert cube.attrs["hcss_certificate"].startswith("computed as specified")
    assert cube["cloud_fraction"].values.mean() == pytest.approx(0.4, abs=0.05)
    assert "clear in shadow" in cube.attrs["hcss_certificate_strata"]
    rays = make_plan(of()).rays
    low, high = (np.stack(rays.points_m((slice(0, 24), slice(0, 48)), 0.0, height)) for height in (0.0, 1000.0))
    # A line at zenith 53 degrees passes a height h tan(53 degrees) nearer to the platform.
    assert np.hypot(*(high - low)) == pytest.approx(np.full(high.shape[1:], 1000.0 * np.tan(np.radians(53.0))))
    assert np.all((high - low)[1] < 0.0)


@pytest.mark.parametrize("altitude", [0.0, 4000.0])
def test_points_appear_where_lines_of_sight_meet_their_height(altitude):
    rays = make_plan(of()).rays
    points = rays.points_m((slice(0, 24), slice(0, 48)), 0.0, altitude)
    row, column = rays.project(*points, np.full(points[0].shape, altitude), 0.0)
    middles = ((np.arange(count * 3) + 0.5) / 3 for count in (24, 48))
    assert np.stack([row, column]) == pytest.approx(np.stack(np.meshgrid(*middles, indexing="ij")), abs=1e-6)
    assert rays.project(np.array([9e5]), np.zeros(1), np.zeros(1), 0.0)[1][0] < 0.0  # beside all cones
    # Across the line of sight the parallelogram between neighbouring points is as large as that of a pixel.
    across, up = (np.gradient(coordinate[4:7, 130:133]) for coordinate in points)
    ground_m2 = 9.0 * abs(float((across[0] * up[1] - across[1] * up[0])[1, 1]))  # of 3 x 3 points
    at_m = float(points[0][5, 131]), float(points[1][5, 131]), altitude
    area_m2 = rays.pixel_area_m2(5.5 / 3, 131.5 / 3, 0.0, at_m)
    assert area_m2 == pytest.approx(ground_m2 * np.cos(np.radians(53.0)), rel=1e-3)


def test_a_target_shines_from_the_pixel_that_looks_at_it():
    height, intensity = 2000.0, 1e7
    (x_m,), (y_m,) = (at.ravel() for at in ray_of(of(), 7, 30, height))
    source = {"x": x_m, "y": y_m, "altitude": height, "intensity": intensity}
    bare = {"clouds.coverage": 0.0, "sea.temperature_texture": 0.0, "bands": [[10.5, 11.0]]}
    shining = of(**bare, elements=[{"provider": "point-sources", "parameters": {"tracks": [source]}}])
    with_target, without = (simulate(scene)["radiance"].values[0].astype(float) for scene in (shining, of(**bare)))
    extra = with_target[0] - without[0]
    assert np.unravel_index(np.argmax(extra), extra.shape) == (7, 30)
    assert np.count_nonzero(extra > 1e-3 * extra.max()) == 1
    # The intensity over the area of the pixel, weakened by the air above the target.
    plan = make_plan(shining)
    arriving = extra[7, 30] * plan.rays.pixel_area_m2(7.5, 30.5, 0.0, (x_m, y_m, height))
    assert 0.3 * intensity < arriving < intensity


def test_angles_of_pixels_are_those_of_their_lines_of_sight():
    rays, window = make_plan(of()).rays, (slice(3, 5), slice(40, 48))
    low, high = (np.stack(rays.points_m(window, 0.0, height))[:, 1::3, 1::3] for height in (0.0, 1000.0))
    zenith, azimuth = rays.angles_deg(window, 0.0)
    assert np.degrees(np.arctan(np.hypot(*(high - low)) / 1000.0)) == pytest.approx(zenith)
    assert np.degrees(np.arctan2(*(high - low))) % 360.0 == pytest.approx(azimuth)


def ray_of(scene, row, column, height_m):
    """Where the middle line of sight of a pixel of three by three points meets a height."""
    points = make_plan(scene).rays.points_m((slice(row, row + 1), slice(column, column + 1)), 0.0, height_m)
    return [coordinate[1:2, 1:2] for coordinate in points]


def test_what_needs_more_of_the_rays_is_refused():
    with pytest.raises(Exception, match=r"clouds\.coverage_mode: 'frame'.*allowed: 'field'"):
        make_plan(of(**{"clouds.coverage_mode": "frame"}))


def test_clouds_that_do_not_state_it_have_the_coverage_of_the_whole_sky():
    raw = json.loads(of(**{"frames.count": 1}).to_json())
    del raw["clouds"]["layers"][0]["coverage_mode"]
    assert Scenario.from_dict(raw).clouds.layers[0].coverage_mode == "field"
    del raw["conical_scanner"]
    assert Scenario.from_dict(raw).clouds.layers[0].coverage_mode == "frame"


PRESSURE_PA = np.array([101300.0, 95000.0, 90000.0, 85000.0, 70000.0, 50000.0, 30000.0, 20000.0, 10000.0])


def air(north_deg, east_deg):
    """Temperature (K) and relative humidity (%), linear in latitude and longitude, from those of the centre."""
    height_m = 44330.0 * (1.0 - (PRESSURE_PA / 101300.0) ** 0.19)
    return (
        289.0 - 6.3e-3 * height_m - 1.5 * north_deg + 1.0 * east_deg,
        np.exp(-height_m / 6000.0) * (55.0 - 4.0 * north_deg - 3.0 * east_deg),
    )


def test_each_pixel_has_the_air_of_its_place(tmp_path):
    """Scenes with the profile of one place everywhere have its radiance there."""
    scenario = of(**{"clouds.coverage": 0.0}).to_json()
    place = json.loads(scenario)["place"]
    degrees, field = np.linspace(-6.0, 6.0, 5), tmp_path / "air.nc"
    with netCDF4.Dataset(field, "w") as file:
        for name, values in (
            ("latitude", place["latitude"] + degrees), ("longitude", place["longitude"] + degrees),
            ("pressure_level", PRESSURE_PA),
        ):  # fmt: skip
            file.createDimension(name, values.size)
            file.createVariable(name, "f8", (name,))[:] = values
        file["pressure_level"].units = "Pa"
        for number, (name, units) in enumerate((("t", "K"), ("rh", "percent"))):
            variable = file.createVariable(name, "f8", ("latitude", "longitude", "pressure_level"))
            variable.units = units
            variable[:] = np.array([[air(north, east)[number] for east in degrees] for north in degrees])
    wide = {
        "clouds.coverage": 0.0, "bands": [[8.4, 9.0]], "accuracy": 5e-3, "sea.temperature": 290.0,
        "sea.temperature_texture": 0.0, "atmosphere.water_vapour_texture": 0.0,
        "conical_scanner": {"half_arc": 20.0, "rows": 8, "columns": 12, "step": 50e3},
    }  # fmt: skip
    plan = make_plan(of(**wide, **{"atmosphere.profile": str(field)}))
    assert min(plan.air_by_place[0].along_x.nodes.size, plan.air_by_place[0].along_y.nodes.size) > 1
    made = simulate(of(**wide, **{"atmosphere.profile": str(field)}))
    assert made.attrs["hcss_certificate"].startswith("computed as specified")
    radiance = made["radiance"].values[0, 0].astype(float)
    assert np.ptp(radiance) > 0.02 * radiance.mean()
    for row, column in ((0, 0), (3, 6), (7, 9), (1, 11)):
        pixel = slice(row, row + 1), slice(column, column + 1)
        latitude, longitude = plan.rays.locations_deg(pixel, 0.0, plan.scenario)
        there = air(float(latitude[0, 0]) - place["latitude"], float(longitude[0, 0]) - place["longitude"])
        rows = [f"{p},{kelvin:.9f},{rh:.9f}" for p, kelvin, rh in zip(PRESSURE_PA, *there, strict=True)]
        own = tmp_path / f"{row}-{column}.csv"
        own.write_text("\n".join(["pressure_Pa,temperature_K,relative_humidity_percent", *rows]))
        alone = simulate(of(**wide, **{"atmosphere.profile": str(own), "output.certificate": 0}))
        assert radiance[row, column] == pytest.approx(float(alone["radiance"].values[0, 0, row, column]), rel=1e-3)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("image.window", {"rows": [0, 4], "columns": [0, 4]}),
        ("platform.altitude", 7e5),
        ("view.zenith", 30.0),
        ("motion.platform_speed", 100.0),
    ],
)
def test_keys_of_another_view_are_refused(key, value):
    with pytest.raises(ScenarioError, match=rf"{key}: .* cannot be computed with a camera or scanner"):
        make_plan(of(**{key: value}))
