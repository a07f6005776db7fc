"""Scenarios with slant paths: what is refused, what the plan says, and images as clouds."""

import json

import numpy as np
import pytest
from cheap import CHEAP

from hcss_twin import Scenario, ScenarioError, make_plan, simulate
from hcss_twin.engine.compile import compile_tables
from hcss_twin.models.radiance.as_printed import AsPrinted
from hcss_twin.plan.omissions import GLINT_SAFETY_FACTOR

BASE = {
    "time": "2024-04-20T12:30:00+10:00",
    "place": {"latitude": 35.0, "longitude": 150.0},
    "view": {"zenith": 20.0, "azimuth": 18.72},
    "image": {"rows": 40, "columns": 50, "pixel_size": 50.0},
    "frames": {"count": 2},
    "bands": ["mwir-3.7", "lwir-10.8"],
    "atmosphere": {"profile": "us-standard-1976"},
    "clouds": {"type": "cumulus", "base": 1000.0, "top": 1900.0, "coverage": 0.4, "coverage_mode": "field"},
    "sea": {"temperature": 291.4, "wind_speed": 10.0},
}


ON = {"slant.shadows": "on", "slant.parallax": "on"}
AUTO = {"slant.shadows": "auto", "slant.parallax": "auto"}
MASKS_OFF = {"slant.shadows": "off", "slant.parallax": "off", "output.variables": ["cloud_mask"]}


def scenario(**overrides):
    return Scenario.from_dict(BASE, {**CHEAP, **overrides})


def problem(**overrides):
    with pytest.raises(ScenarioError) as caught:
        make_plan(scenario(**overrides))
    (found,) = caught.value.problems
    return found


@pytest.fixture
def image(tmp_path):
    def make(rows, columns):
        values = np.full((rows, columns), 0.1)
        values[rows // 2 - 3 : rows // 2 + 3, columns // 2 - 2 : columns // 2 + 2] = 0.9
        values[0, 0] = 0.95
        path = tmp_path / "block.npy"
        np.save(path, values)
        parameters = {"image": str(path), "method": "coverage", "cloud_is": "bright"}
        coverage = np.mean(values > 0.5)
        return {"clouds.generator": "imagery", "clouds.parameters": parameters, "clouds.coverage": coverage}

    return make


def test_a_frame_has_the_coverage_that_was_asked_for_and_shadows_where_the_sun_puts_them():
    """The clouds are those that the sensor sees; paths of sunlight, and those from outside, are displaced from them."""
    thin = {"clouds.base": 1000.0, "clouds.top": 1002.0, "clouds.thickness_min": 1.0, "clouds.coverage_mode": "frame"}
    wanted = {**thin, "output.variables": ["cloud_mask", "shadow_mask"]}
    plain, slant = (simulate(scenario(**{**wanted, **more})) for more in (MASKS_OFF, ON))
    cloud = slant.cloud_mask.values[0]
    assert cloud.mean() == pytest.approx(0.4, abs=1.0 / cloud.size)
    assert np.array_equal(cloud, plain.cloud_mask.values[0])
    sun = np.radians((float(slant.solar_zenith_angle[0]), float(slant.solar_azimuth_angle[0])))
    away = [1001.0 * np.tan(sun[0]) * turn(sun[1]) / 50.0 for turn in (np.cos, np.sin)]
    seen = [1000.0 * np.tan(np.radians(20.0)) * turn(np.radians(18.72)) / 50.0 for turn in (np.cos, np.sin)]
    down, right = (int(np.rint(one) - np.rint(other)) for one, other in zip(away, seen, strict=True))
    rows, columns = np.mgrid[: cloud.shape[0], : cloud.shape[1]]
    inside = (rows + down >= 0) & (rows + down < cloud.shape[0]) & (columns + right >= 0)
    inside &= (columns + right < cloud.shape[1]) & (cloud == 0)
    shaded = cloud[(rows + down)[inside], (columns + right)[inside]]
    assert 0.1 < shaded.mean() < 0.9
    assert np.array_equal(slant.shadow_mask.values[0][inside], shaded)
    outside = ~inside & (cloud == 0)
    assert 0 < slant.shadow_mask.values[0][outside].sum() < outside.sum()


def test_an_image_of_clouds_without_room_has_no_slant_paths_unless_they_are_asked_for(image):
    paths = make_plan(scenario(**image(44, 80), **AUTO)).assembly.slant
    assert not paths.shadows
    assert not paths.parallax
    assert "cannot be made beyond the image" in paths.why_not["shadows"].why


def test_a_coverage_of_the_frame_is_allowed_where_no_path_leaves_it():
    options = {"slant.parallax": "on", "view.zenith": 0.0, "clouds.coverage_mode": "frame"}
    assert make_plan(scenario(**options)).assembly.slant.parallax


def test_an_image_without_room_for_slant_paths_is_refused_with_the_room_they_need(image):
    found = problem(**image(44, 80), **{"slant.shadows": "on"})
    assert found.field == "image.rows"
    assert "outside the image that slant paths meet: 16 rows and 6 columns" in found.message
    assert make_plan(scenario(**image(44, 80))).layers


def test_an_image_with_room_casts_its_shadow_away_from_the_sun(image):
    cube = simulate(
        scenario(**image(100, 80), **{"slant.shadows": "on", "output.variables": ["cloud_mask", "shadow_mask"]})
    )
    cloud, shadow = (np.argwhere(cube[name].values[0]).mean(axis=0) for name in ("cloud_mask", "shadow_mask"))
    # The sun stands in the south-southwest at noon: the shadow lies to the north-northeast.
    assert cube.solar_azimuth_angle[0] == pytest.approx(198.7, abs=0.1)
    assert 5 < shadow[0] - cloud[0] < 20
    assert 1 < shadow[1] - cloud[1] < 7


@pytest.mark.parametrize(("beyond", "mode"), [("mirror", "symmetric"), ("clear", "constant")])
def test_clouds_beyond_an_image_cast_their_shadows_into_it(tmp_path, beyond, mode):
    """The mask is that of a larger image, displaced along the line of sight and the sun's path by hand."""
    np.save(tmp_path / "image.npy", np.random.default_rng(0).gamma(1.5, 0.1, (40, 50)))
    parameters = {"image": str(tmp_path / "image.npy"), "method": "coverage", "cloud_is": "bright"}
    thin = {"clouds.base": 1000.0, "clouds.top": 1002.0, "clouds.thickness_min": 1.0, "clouds.generator": "imagery"}
    of_image = thin | {"clouds.parameters": parameters | {"beyond": beyond}}
    output = {"output.variables": ["radiance", "cloud_mask", "shadow_mask"], "output.certificate": 16}
    cube = simulate(scenario(**of_image, **ON, **output, **{"frames.count": 1, "accuracy": 1e-2}))
    assert cube.attrs["hcss_certificate"].startswith("computed as specified")
    cloud, room = cube.cloud_mask.values[0], 30
    around = np.pad(cloud, room, mode=mode)
    sun = np.radians((float(cube.solar_zenith_angle[0]), float(cube.solar_azimuth_angle[0])))
    away = [1001.0 * np.tan(sun[0]) * turn(sun[1]) / 50.0 for turn in (np.cos, np.sin)]
    seen = [1000.0 * np.tan(np.radians(20.0)) * turn(np.radians(18.72)) / 50.0 for turn in (np.cos, np.sin)]
    down, right = (room + int(np.rint(one) - np.rint(other)) for one, other in zip(away, seen, strict=True))
    expected = around[down : down + 40, right : right + 50] * (1 - cloud)
    assert (down - room) ** 2 + (right - room) ** 2 > 100
    np.testing.assert_array_equal(cube.shadow_mask.values[0], expected)


def test_an_image_that_ends_is_refused_with_the_key_that_says_how_it_goes_on(image):
    options = {"slant.shadows": "on", "clouds.coverage_mode": "frame"}
    found = problem(**image(44, 80), **options)
    assert found.field == "clouds.generator"
    assert "known in the image only" in found.message
    assert "allowed: clouds.parameters.beyond = 'mirror', or clouds.generator = 'fractal', or" in found.message
    given = image(44, 80)
    given["clouds.parameters"]["beyond"] = "mirror"
    assert make_plan(scenario(**given, **options)).has_shadows


def test_shadows_of_a_sun_near_the_horizon_are_refused():
    found = problem(**{"slant.shadows": "on", "time": "2024-04-20T18:10:00+10:00"})
    assert found.field == "time"
    assert "cannot be computed with slant.shadows = 'on'" in found.message
    assert "allowed: frames with the sun up to 85 deg or below the horizon" in found.message


def test_what_excludes_shadows_is_told_where_they_are_left_to_the_plan():
    low = make_plan(scenario(**AUTO, time="2024-04-20T18:10:00+10:00"))
    assert not low.has_shadows
    assert low.assembly.slant.parallax
    (left_out,) = [item for item in low.omissions if item.what == "shadows of clouds on the sea"]
    assert "the sun at zenith 8" in left_out.why
    assert left_out.needs == "time: frames with the sun up to 85 deg or below the horizon"
    assert not left_out.decision
    off = make_plan(scenario(**{"slant.shadows": "off", "slant.parallax": "off"}))
    by_user = {item.what: item.decision for item in off.omissions if item.decision}
    assert by_user["shadows of clouds on the sea"] == by_user["parallax of clouds"] == "switched off"


def test_pixels_too_small_for_the_sun_s_paths_are_refused_with_the_size_that_is_not():
    tiny = {"slant.shadows": "on", "image.pixel_size": 0.05}
    found = problem(**tiny)
    assert found.field == "image.pixel_size"
    closest = float(found.message.split("closest valid choice is ")[1].split(",")[0])
    assert make_plan(scenario(**tiny | {"image.pixel_size": closest})).assembly.slant.shadows


def test_a_radiance_model_that_does_not_name_its_sunlight_is_refused(monkeypatch):
    monkeypatch.setattr(AsPrinted, "sea_sun_terms", frozenset())
    found = problem(**{"slant.shadows": "on"})
    assert found.field == "radiance.model"
    assert "sea_sun_terms" in found.message


def test_the_mask_is_refused_without_shadows():
    with pytest.raises(ScenarioError, match=r"output\.variables: 'shadow_mask'.*slant\.shadows = .on."):
        scenario(**{"output.variables": ["shadow_mask"]})
    with pytest.raises(ScenarioError, match=r"slant\.shadows: .*.perhaps."):
        scenario(**{"slant.shadows": "perhaps"})


def test_a_plan_without_shadows_bounds_what_they_could_change():
    plan = make_plan(scenario())
    (left_out,) = [item for item in plan.omissions if item.what == "shadows of clouds on the sea"]
    columns = compile_tables(plan).tables[0].clear[0], simulate_clear_terms(plan)
    glint, total = columns[1]["sea_reflected_sun"], sum(columns[1].values())
    assert left_out.bound == pytest.approx(GLINT_SAFETY_FACTOR * float(np.max(glint / total)), rel=1e-3)
    np.testing.assert_allclose(columns[0], total, rtol=plan.budget.wavenumbers)
    assert "shadows" not in json.dumps([item.what for item in make_plan(scenario(**{"slant.shadows": "on"})).omissions])


def simulate_clear_terms(plan):
    """Bands of the clear column at the first frame."""
    grid = plan.spectral_grid
    terms = plan.assembly.clear(grid.wavenumber_cm1, plan.sun_track.at(0.0))
    return {name: grid.weights_cm1 @ values for name, values in terms.items()}


def test_a_plan_without_parallax_says_how_far_clouds_would_move():
    (left_out,) = [item for item in make_plan(scenario()).omissions if item.what == "parallax of clouds"]
    assert "up to 364 m (7.3 pixels)" in left_out.why  # 1000 m x tan 20 deg
    vertical = make_plan(scenario(**{"view.zenith": 0.0}))
    assert not any(item.what == "parallax of clouds" for item in vertical.omissions)
    for switch in ("on", "off"):
        notes = make_plan(scenario(**{"view.zenith": 0.0, "slant.parallax": switch})).assembly.notes()
        assert not any("parallax" in note for note in notes)


def test_what_the_options_leave_out_is_in_plan_and_cube():
    on = {"slant.shadows": "on", "slant.parallax": "on"}
    assert not any(note.startswith(("shadows:", "parallax:")) for note in make_plan(scenario()).assembly.notes())
    notes = json.loads(simulate(scenario(**on)).attrs["hcss_notes"])
    assert sum(note.startswith(("shadows:", "parallax:")) for note in notes) == 2
