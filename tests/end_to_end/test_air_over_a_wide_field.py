"""A scene with several profiles, against scenes that use the profile of one place everywhere."""

from dataclasses import replace

import netCDF4
import numpy as np
import pytest
from hand_made import paths_of, with_clouds

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.core.errors import ScenarioError
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.stream import stream
from hcss_twin.engine.tables.over_views import plans_over_views
from hcss_twin.engine.tables.table_key import table_key
from hcss_twin.physics.geodesy import to_geographic

PRESSURE_PA = np.array([101300.0, 95000.0, 90000.0, 85000.0, 70000.0, 50000.0, 30000.0, 20000.0, 10000.0])
HEIGHT_M = 44330.0 * (1.0 - (PRESSURE_PA / 101300.0) ** 0.19)
SCENE = """
time = 2024-04-20T00:30:00+10:00
place = {latitude = 36.0, longitude = 150.0}
bands = ["swir-2.7-3.0"]
clouds.layers = []
sea = {temperature = 291.0, wind_speed = 6.0, temperature_texture = 0.0}
image = {rows = 7, columns = 1, pixel_size = 100e3}
frames = {count = 1}
accuracy = 0.02
radiance.model = "as-printed"
atmosphere.water_vapour_texture = 0.0
"""


def air(latitude):
    """Temperature (K) and relative humidity (%), linear in latitude."""
    return 289.0 - 6.3e-3 * HEIGHT_M - 0.5 * (latitude - 36.0), 70.0 - HEIGHT_M / 300.0 - 1.5 * (latitude - 36.0)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path, latitude = tmp_path_factory.mktemp("air") / "air.nc", np.array([30.0, 34.0, 38.0, 42.0])
    with netCDF4.Dataset(path, "w") as dataset:
        for name, values in (("latitude", latitude), ("pressure_level", PRESSURE_PA)):
            dataset.createDimension(name, values.size)
            dataset.createVariable(name, "f8", (name,))[:] = values
        dataset["pressure_level"].units = "Pa"
        for row, (name, units) in enumerate((("t", "K"), ("rh", "percent"))):
            variable = dataset.createVariable(name, "f8", ("pressure_level", "latitude"))
            variable.units, variable[:] = units, np.array([air(each)[row] for each in latitude]).T
    return path


def scenario(profile, text=SCENE, **changes):
    return Scenario.from_toml(text, {"atmosphere.profile": str(profile)} | changes)


def clear_radiance(file, tmp_path, name, **changes):
    simulate(scenario(file, **changes), output=tmp_path / name)
    with netCDF4.Dataset(tmp_path / name) as cube:
        return np.asarray(cube["radiance"][0, 0])


INVERSION = {"height": 1200.0, "strength": 4.0}


@pytest.mark.parametrize("inversion", [None, INVERSION], ids=["as given", "inversion"])
def test_each_pixel_has_the_air_of_its_place(file, tmp_path, inversion):
    """An inversion lies over air that is as warm at the sea as that of the place."""
    low = {"bands": [[10.5, 11.0]]}  # where air below an inversion is seen
    changes = {} if inversion is None else low | {"atmosphere.inversion": inversion}
    radiance = clear_radiance(file, tmp_path, "wide.nc", **changes)
    assert np.ptp(radiance) > (0.02 if inversion is None else 0.0015) * np.mean(radiance)
    latitude, _ = to_geographic(np.zeros(3), np.array([-3, 0, 3]) * 100e3, 36.0, 150.0)
    for row, north in zip((0, 3, 6), latitude, strict=True):
        own = tmp_path / f"own-{row}.csv"
        lines = [f"{p},{t:.9f},{rh:.9f}" for p, t, rh in zip(PRESSURE_PA, *air(north), strict=True)]
        own.write_text("\n".join(["pressure_Pa,temperature_K,relative_humidity_percent", *lines]))
        if inversion is not None:
            changes = low | {"atmosphere.inversion": inversion | {"surface_temperature": float(air(north)[0][0])}}
        alone = clear_radiance(own, tmp_path, f"own-{row}.nc", **changes)
        np.testing.assert_allclose(radiance[row, 0], alone[3, 0], rtol=0.002 if inversion is None else 5e-4)


def test_the_plan_states_the_interpolation_and_keeps_the_tables_apart(file):
    plan = make_plan(scenario(file))
    assert plan.views.varies
    assert plan.views.order_y > 0
    rows = {item.what: item for item in plan.omissions}
    # Temperature is linear in latitude, but the altitudes of the few pressure levels are not.
    assert 0.0 < rows["air between the profiles of the file"].bound < 1e-3
    assert "no key" not in rows["view angles of single pixels"].needs
    keys = [table_key(each) for each in plans_over_views(plan)]
    assert len(set(keys)) == len(keys)


def test_profiles_that_do_not_cover_the_image_are_refused(file):
    with pytest.raises(ScenarioError, match=r"atmosphere\.profile.*latitude .* lies outside the profiles"):
        make_plan(scenario(file, SCENE.replace("rows = 7", "rows = 19")))


def test_a_shadow_is_that_of_the_glint_in_the_air_of_its_place(file):
    """Against the dense spectrum of the glint in each place's air, behind a cloud of Bouguer."""
    cloud = {"type": "cirrus", "base": 9000.0, "top": 10_000.0, "thickness_min": 1.0, "anchor": "top"}
    day = {
        "time": "2024-04-20T12:30:00+10:00",
        "view": {"zenith": 25.0, "azimuth": 25.0},
        "image": {"rows": 200, "columns": 6, "pixel_size": 3000.0},
        "clouds": {"layers": [cloud | {"coverage": 0.4, "coverage_mode": "field"}]},
        "atmosphere.profile": str(file),
        "bands": ["mwir-3.7", "lwir-10.8"],
    }
    plan = make_plan(Scenario.from_toml(SCENE, day))
    sun = plan.sun_track.at(0.0)
    away = 9500.0 * np.tan(np.radians(sun.zenith_deg)) / 3000.0
    down, right = (int(np.rint(away * part(np.radians(sun.azimuth_deg)))) for part in (np.cos, np.sin))
    shape = lambda y, x: np.where(y // 3 % 2 == 1, np.where(x < 3, 30.0, 300.0), 0.0)  # noqa: E731
    angles = np.array([sun.zenith_deg]), np.array([sun.azimuth_deg])
    slant = replace(paths_of(True, False, plan.view, *angles), sight=plan.assembly.slant.sight)
    planned = with_clouds(plan, [shape], slant, sun, shadows=True, waves=False)
    made = next(stream(planned, compile_tables(planned)))
    y, x = np.mgrid[:200, :6]
    through = np.where(made["cloud_mask"] > 0, 0.0, shape(y + down, x + right))
    np.testing.assert_array_equal(made["shadow_mask"], through > 0)
    grid = plan.spectral_grid
    extinction = plan.assembly.optics.single_scattering(plan.layers[0].microphysics, grid.wavenumber_cm1).extinction_m1
    shaded = np.argwhere(through > 0)
    errors, one_air = [], []
    for row, column in shaded[np.linspace(0, len(shaded) - 1, 12).astype(int)]:
        behind = np.exp(-extinction * through[row, column] / np.cos(np.radians(sun.zenith_deg)))
        (view,) = plan.rays.views_of_pixels([row], [column], 0.0)
        for assembly, found in ((plan.assembly.toward(view), errors), (plan.assembly, one_air)):
            terms = assembly.clear(grid.wavenumber_cm1, sun)
            total = np.sum(list(terms.values()), axis=0) - terms["sea_reflected_sun"] * (1.0 - behind)
            found.append(np.max(np.abs(made["radiance"][:, row, column] / (grid.weights_cm1 @ total) - 1.0)))
    assert max(errors) < 0.1 * plan.accuracy.relative
    assert max(one_air) > plan.accuracy.relative
