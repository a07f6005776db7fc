"""Laws of cloud shadows on the sea and of the parallax of clouds."""

from dataclasses import replace
from functools import lru_cache, partial

import numpy as np
import pytest
from cheap import CHEAP
from hand_made import HandMade, paths_of, with_clouds
from scipy.integrate import trapezoid

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.engine import stream as stream_module
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.stages.shadows import sun_paths
from hcss_twin.engine.stream import stream
from hcss_twin.laws.samples import PlainOptics
from hcss_twin.plan.displaced_clouds import DisplacedClouds
from hcss_twin.plan.windows import windows
from hcss_twin.providers import Sun, View

SIZE, PIXEL_M = 60, 50.0
BANDS = ["mwir-3.7", "lwir-10.8"]
LOW = {"type": "cumulus", "base": 1000.0, "top": 1010.0, "thickness_min": 1.0, "anchor": "base"}
HIGH = {"type": "cirrus", "base": 2000.0, "top": 2010.0, "thickness_min": 1.0, "anchor": "top"}
THICK = {"type": "cumulus", "base": 1000.0, "top": 1900.0, "thickness_min": 1.0, "anchor": "base"}


def raw(layers, **overrides):
    clouds = [{"coverage": 0.4, "coverage_mode": "field"} | layer for layer in layers]
    base = {
        "time": "2024-04-20T12:30:00+10:00",
        "place": {"latitude": 35.0, "longitude": 150.0},
        "view": {"zenith": 20.0, "azimuth": 18.72},
        "image": {"rows": SIZE, "columns": SIZE, "pixel_size": PIXEL_M},
        "frames": {"count": 1},
        "bands": BANDS,
        "atmosphere": {"profile": "us-standard-1976"},
        "clouds": {"layers": clouds},
        "sea": {"temperature": 291.4, "wind_speed": 10.0, "temperature_texture": 0.0},
    }
    return Scenario.from_dict(base, {**CHEAP, **overrides})


@lru_cache
def plain_plan(layers, zenith, azimuth):
    layers = [dict(layer) for layer in layers]
    return make_plan(raw(layers, **{"view.zenith": zenith, "view.azimuth": azimuth}))


def staged(layers, shapes, sun=(30.0, 0.0), view=(0.0, 0.0), shadows=True, parallax=False, optics=None):
    """A plan with hand-made clouds and a sun where it is wanted."""
    plan = plain_plan(tuple(tuple(each.items()) for each in layers), *view)
    slant = paths_of(shadows, parallax, View(*view), np.array([sun[0]]), np.array([sun[1]]))
    made = with_clouds(plan, shapes, slant, Sun(*sun, 1.0), shadows=True)
    return replace(made, assembly=replace(made.assembly, optics=optics or plan.assembly.optics))


def frame(plan):
    return next(stream(plan, compile_tables(plan)))


def block(thickness, row=30, column=30):
    """Cloud on 3 x 5 pixels."""
    return lambda y, x: np.where((abs(y - row) <= 1) & (abs(x - column) <= 2), thickness, 0.0)


def mask_of(shape):
    return shape(*np.mgrid[0:SIZE, 0:SIZE]) > 0


# North is toward larger rows, east toward larger columns.
BEARINGS = {"N": (0.0, (-20, 0)), "E": (90.0, (0, -20)), "S": (180.0, (20, 0)), "W": (270.0, (0, 20))}


@pytest.mark.parametrize("bearing", BEARINGS)
def test_a_shadow_falls_away_from_the_sun(bearing):
    azimuth, (rows, columns) = BEARINGS[bearing]
    made = frame(staged([LOW], [block(10.0)], sun=(45.0, azimuth)))
    np.testing.assert_array_equal(made["cloud_mask"], mask_of(block(1.0)))
    np.testing.assert_array_equal(made["shadow_mask"], mask_of(block(1.0, 30 + rows, 30 + columns)))


@pytest.mark.parametrize("bearing", BEARINGS)
def test_a_cloud_is_seen_against_the_sea_away_from_the_sensor(bearing):
    azimuth, (rows, columns) = BEARINGS[bearing]
    made = frame(staged([LOW], [block(10.0)], view=(45.0, azimuth), shadows=False, parallax=True))
    np.testing.assert_array_equal(made["cloud_mask"], mask_of(block(1.0, 30 + rows, 30 + columns)))


def test_a_higher_layer_is_displaced_farther_and_by_its_own_flat_side():
    made = frame(
        staged([LOW, HIGH], [block(5.0), block(5.0)], view=(26.56505117707799, 90.0), shadows=False, parallax=True)
    )
    low, high = made["cloud_layer_thickness"] > 0
    np.testing.assert_array_equal(low, mask_of(block(1.0, 30, 20)))  # 1000 m / 2
    np.testing.assert_array_equal(high, mask_of(block(1.0, 30, 10)))  # 2010 m / 2, rounded


def test_with_both_the_shadow_stays_with_the_sea():
    """The line of sight moves the cloud; the shadow lies where the sun puts it."""
    plan = staged([LOW], [block(10.0)], sun=(45.0, 0.0), view=(45.0, 90.0), parallax=True)
    made = frame(plan)
    np.testing.assert_array_equal(made["cloud_mask"], mask_of(block(1.0, 30, 10)))
    np.testing.assert_array_equal(made["shadow_mask"], mask_of(block(1.0, 10, 30)))


def test_looking_from_the_sun_no_thin_cloud_s_shadow_is_seen():
    plan = staged([LOW], [block(10.0)], sun=(45.0, 70.0), view=(45.0, 70.0), parallax=True)
    assert not frame(plan)["shadow_mask"].any()


def test_with_the_sun_in_the_zenith_shadows_lie_under_their_clouds():
    clouds = [THICK], [block(300.0)]
    shaded, sunlit = (frame(staged(*clouds, sun=(0.0, 0.0), shadows=on)) for on in (True, False))
    assert not shaded["shadow_mask"].any()
    for name in shaded:
        np.testing.assert_array_equal(shaded[name], sunlit[name])


@pytest.mark.parametrize("anchor", ["base", "top"])
def test_an_opaque_cloud_takes_the_glint_and_nothing_else(anchor):
    layer = THICK | {"anchor": anchor}
    shape = lambda y, x: np.where(abs(y - 50) <= 15, 900.0, 0.0)  # noqa: E731
    shaded, sunlit = (frame(staged([layer], [shape], sun=(45.0, 0.0), shadows=on)) for on in (True, False))
    # Deep in the shadow the sun shines through all of the cloud; at its ends through a part.
    glint = sunlit["radiance_sea_reflected_sun"]
    gone = shaded["radiance_sea_reflected_sun"] < 1e-7 * glint
    assert gone.sum() > 10
    assert np.all(gone.any(axis=0) <= (shaded["shadow_mask"] == 1))
    expected = (sunlit["radiance"].astype(float) - glint)[gone]
    np.testing.assert_allclose(shaded["radiance"][gone], expected, rtol=3e-7)
    for name in ("radiance_sea_emission", "radiance_path_emission", "radiance_cloud_emission", "cloud_mask"):
        np.testing.assert_array_equal(shaded[name], sunlit[name])
    lit = np.broadcast_to(shaded["shadow_mask"] == 0, glint.shape)
    np.testing.assert_array_equal(shaded["radiance"][lit], sunlit["radiance"][lit])


def test_the_total_is_the_sum_of_its_terms_in_shadow_too():
    made = frame(staged([LOW, HIGH], [block(1.0), block(10.0)], sun=(45.0, 0.0)))
    terms = [values.astype(float) for name, values in made.items() if name.startswith("radiance_")]
    np.testing.assert_allclose(np.sum(terms, axis=0), made["radiance"], rtol=3e-7)


@pytest.mark.parametrize("thickness", [1.0, 3.0, 10.0])
def test_grey_clouds_follow_bouguer(thickness):
    """exp(-k h / mu0), with the grey extinction of plain optics."""
    optics = PlainOptics(cross_section_m2=3e-10)
    plan = staged([LOW], [block(thickness, 50)], sun=(60.0, 0.0), optics=optics)
    k = optics.single_scattering(plan.layers[0].microphysics, np.ones(1)).extinction_m1[0]
    made = frame(plan)
    shadow = made["shadow_mask"] == 1
    assert shadow.any()
    glint = made["radiance_sea_reflected_sun"]
    left = glint[:, shadow] / glint[:, -1, -1, None]
    np.testing.assert_allclose(left, np.exp(-k * thickness / 0.5), rtol=1e-6)


def exact_transmission(plan, heights, mu0):
    """Reference: the dense spectrum of the clear column's glint through clouds, integrated over each band."""
    grid, sun = plan.spectral_grid, plan.sun_track.at(0.0)
    glint = plan.assembly.clear(grid.wavenumber_cm1, sun)["sea_reflected_sun"]
    path = sum(
        plan.assembly.optics.single_scattering(layer.microphysics, grid.wavenumber_cm1).extinction_m1 * height / mu0
        for layer, height in zip(plan.layers, heights, strict=True)
    )
    result = []
    for nodes, response in zip(grid.nodes, grid.response, strict=True):
        nu = grid.wavenumber_cm1[nodes]
        weakened, all_of_it = (
            trapezoid(glint[nodes] * each * response, nu) for each in (np.exp(-path[nodes]), np.ones(nodes.size))
        )
        result.append(weakened / all_of_it)
    return np.array(result)


def glint_left(plan):
    """Share of the glint that is left where the sun shines through the middle of the shadows."""
    made = frame(plan)
    lit = made["radiance_sea_reflected_sun"][:, -1, -1]
    return made["radiance_sea_reflected_sun"].min(axis=(1, 2)) / lit


@pytest.mark.parametrize("thickness", [1.0, 4.0, 10.0])
@pytest.mark.parametrize("layer", [LOW, HIGH], ids=["water", "ice"])
def test_a_cloud_s_transmission_is_that_of_the_dense_spectrum(layer, thickness):
    plan = staged([layer], [block(thickness, 40, 30)], sun=(30.0, 0.0))
    expected = exact_transmission(plan, [thickness], np.cos(np.radians(30.0)))
    np.testing.assert_allclose(glint_left(plan), expected, atol=1e-4)


def test_two_clouds_on_the_sun_s_path_transmit_the_product():
    """To 1e-3: the exact value keeps the order of the wavenumbers in both."""
    sun = (26.56505117707799, 0.0)  # 1000 m and 2000 m move by 10 and 20 pixels
    plan = staged([LOW, HIGH], [block(4.0, 30, 30), block(8.0, 40, 30)], sun=sun)
    expected = exact_transmission(plan, [4.0, 8.0], np.cos(np.radians(sun[0])))
    np.testing.assert_allclose(glint_left(plan), expected, atol=1e-3)


@pytest.mark.parametrize("anchor", ["base", "top"])
def test_the_shadow_of_a_wall_is_as_long_as_geometry_says(anchor):
    """Cloud north of a line, sun in the north: the path at a distance d is in cloud above d / tan(theta)."""
    height, zenith, point_m = 600.0, 60.0, 10.0
    layer = replace(plain_plan((tuple(THICK.items()),), 0.0, 0.0).layers[0], base_m=0.0, top_m=900.0, anchor=anchor)
    paths = sun_paths(layer, Sun(zenith, 0.0, 1.0), point_m)
    margin = int(np.abs(paths.shifts).max()), 0
    wall = DisplacedClouds(HandMade(lambda y, x: np.where(y >= 200, height, 0.0), margin), margin, (0, 0))
    found = paths.heights_m(wall, 0.0, slice(0, 200), slice(0, 1))[:, 0]
    above = (200 - np.arange(200)) * point_m / np.tan(np.radians(zenith))
    top = height if anchor == "base" else 900.0
    expected = np.clip(top - np.maximum(above, top - height), 0.0, height)
    # Half a point by rounding, half a point by the slices.
    np.testing.assert_allclose(found, expected, atol=point_m / np.tan(np.radians(zenith)) + 1e-3)
    assert (expected == 0).any()
    assert (expected > 0).any()


@pytest.mark.parametrize("azimuth", [0.0, 37.0, 200.0])
def test_under_a_sheet_the_path_is_as_high_as_the_sheet(azimuth):
    layer = plain_plan((tuple(THICK.items()),), 0.0, 0.0).layers[0]
    paths = sun_paths(layer, Sun(70.0, azimuth, 1.0), 20.0)
    margin = tuple(np.abs(paths.shifts).max(axis=0).tolist())
    sheet = DisplacedClouds(HandMade(lambda y, x: np.full(y.shape, 432.1), margin), margin, (0, 0))
    found = paths.heights_m(sheet, 0.0, slice(0, 3), slice(0, 4))
    np.testing.assert_allclose(found, 432.1, rtol=3e-6)


@pytest.mark.parametrize("shift", [(0, 0), (7, -5), (-20, 30), (40, 40)])
def test_clouds_that_the_sensor_has_seen_are_the_same_for_the_sun(shift):
    def clouds():
        return DisplacedClouds(HandMade(lambda y, x: (y * 31.0 + x * 17.0) % 97.0, (40, 40)), (40, 40), (2, 3))

    seen, window = clouds(), (slice(0, 61), slice(5, 48))
    seen.thickness_m(0.0, slice(0, 50), slice(0, 40))
    np.testing.assert_array_equal(seen.displaced_m(0.0, *window, shift), clouds().displaced_m(0.0, *window, shift))


# --- whole scenes -------------------------------------------------------------------------

ON = {"slant.shadows": "on", "slant.parallax": "on"}
ALL = {"output.variables": ["all"]}


def cube(layers, **overrides):
    return simulate(raw(layers, **({"accuracy": 1e-2} | overrides)))


@pytest.mark.parametrize("what", ["night", "vertical view"])
def test_what_can_change_nothing_changes_nothing_to_the_bit(what):
    if what == "night":
        layers, common, option = [THICK], {"time": "2024-04-20T00:30:00+10:00"}, {"slant.shadows": "on"}
    else:
        layers, common, option = [THICK, HIGH], {"view.zenith": 0.0}, {"slant.parallax": "on"}
    off, on = (cube(layers, **ALL, **common, **more) for more in ({}, option))
    for name in off:
        np.testing.assert_array_equal(off[name], on[name])


def test_shadows_leave_sky_and_terms_of_clouds_as_they_are():
    off, on = (cube([THICK, HIGH], **ALL, **more) for more in ({}, {"slant.shadows": "on"}))
    assert 0 < on.shadow_mask.mean() < 1
    untouched = set(off) - {"radiance", "radiance_sea_reflected_sun", "brightness_temperature"}
    for name in untouched:
        np.testing.assert_array_equal(off[name], on[name])
    assert not (on.shadow_mask.values & off.cloud_mask.values).any()
    assert np.all((on.radiance < off.radiance).any("band").values <= (on.shadow_mask == 1).values)


@pytest.mark.parametrize("model", ["as-printed", pytest.param("physical", marks=pytest.mark.long)])
def test_windows_of_a_frame_are_parts_of_the_whole(model, monkeypatch):
    layers = [THICK, HIGH] if model == "as-printed" else [THICK]
    plan = make_plan(raw(layers, **ON, **ALL, **{"radiance.model": model, "accuracy": 0.05}))
    tables = compile_tables(plan)
    whole = next(stream(plan, tables))
    monkeypatch.setattr(stream_module, "windows", partial(windows, most_points=77))
    parts = next(stream(plan, tables))
    assert whole["shadow_mask"].any()
    for name, values in whole.items():
        np.testing.assert_array_equal(values, parts[name])


def test_a_pixel_in_shadow_is_the_mean_of_its_points():
    fine = cube([THICK], **ON, **ALL)
    half = {"image.rows": SIZE // 2, "image.columns": SIZE // 2, "image.pixel_size": 2 * PIXEL_M}
    coarse = cube([THICK], **ON, **ALL, **half, **{"image.samples_per_pixel": 2})
    for name in ("radiance", "radiance_sea_reflected_sun"):
        blocks = fine[name].values.astype(float).reshape(1, 2, SIZE // 2, 2, SIZE // 2, 2)
        # What is left is a difference of single-precision numbers of up to 0.1.
        np.testing.assert_allclose(coarse[name], blocks.mean(axis=(3, 5)), rtol=1e-6, atol=1e-8)
    blocks = fine.shadow_mask.values.reshape(1, SIZE // 2, 2, SIZE // 2, 2)
    np.testing.assert_array_equal(coarse.shadow_mask, blocks.max(axis=(2, 4)))
    assert 0 < coarse.shadow_mask.mean() < 1


def test_a_frame_alone_is_the_frame_of_a_sequence():
    """Within the accuracy: tables between time nodes are interpolated, the sun's paths are not."""
    hours = {"accuracy": 1e-3, "frames.interval": 1800.0, "motion.platform_speed": 0.0, "slant.shadows": "on"}
    sequence = cube([THICK], **hours, **ALL, **{"frames.count": 4})
    alone = cube([THICK], **hours, **ALL, **{"frames.count": 1, "frames.first": 2})
    np.testing.assert_array_equal(sequence.shadow_mask[2], alone.shadow_mask[0])
    np.testing.assert_allclose(sequence.radiance[2], alone.radiance[0], rtol=1e-3)


def test_the_mask_needs_no_radiance():
    only = cube([THICK], **ON, **{"output.variables": ["shadow_mask"]})
    full = cube([THICK], **ON, **ALL)
    np.testing.assert_array_equal(only.shadow_mask, full.shadow_mask)
    assert list(only) == ["shadow_mask"]
