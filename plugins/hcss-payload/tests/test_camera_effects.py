"""Shadows, resolved waves and texture of the sea in images of cameras, against geometry and columns of each pixel."""

from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np
import pytest
from camera_scenes import SCENE, STARING, merged, scenario

import hcss_twin
from hcss_twin.core.errors import ScenarioError
from hcss_twin.engine import stream as stream_module
from hcss_twin.engine.certificate.certificate_pixels import PixelSample
from hcss_twin.engine.certificate.certify import certify
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.stream import PartMaker, stream
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.plan.displaced_clouds import DisplacedClouds
from hcss_twin.plan.texture import TextureFields
from hcss_twin.plan.windows import windows
from hcss_twin.providers import CloudDeclaration, Declaration, OutputVariable, Sun, View
from hcss_twin.providers.registry import Origin, ProviderSpec, Registry, hookimpl

PLACE = 30.0, 150.0
BESIDE = {
    "place": {"latitude": PLACE[0], "longitude": PLACE[1]},
    "time": "2024-04-20T02:30:00Z",
    "bands": ["mwir-3.7", "lwir-10.8"],
    "camera": {"rows": 40, "columns": 48, "focal_length": 0.15, "detector_pitch": 3.0e-4, "points": 1},
    "orbit": {"altitude": 7e5, "inclination": 98.2, "above": [30.0, 153.0], "above_time": 0.0},
    "attitude": {"provider": "track"},
    "image": {"rows": 64, "columns": 64, "pixel_size": 500.0},
    "frames": {"count": 1},
    "accuracy": 1e-2,
    "sea": {"temperature_texture": 0.0, "waves": "off"},
    "atmosphere": {"water_vapour_texture": 0.0},
}
"""Pixels of 1.4 km and more, seen at zenith angles around 25 degrees from the east."""

HIGH = {"type": "cirrus", "base": 9000.0, "top": 10_000.0, "thickness_min": 1.0, "anchor": "top"}
WATER = HIGH | {"type": "cumulus"}
ICE = np.array([[0.0, 900.0, 0.0, 20.0], [0.0, 0.0, 100.0, 0.0], [900.0, 0.0, 0.0, 0.0]])
SQUARE = 16
"""Points along each side of a square of the clouds, 8 km."""


@dataclass
class FixedSun:
    sun: Sun

    def at(self, time_s):
        return self.sun

    def positions(self, time_s):
        return tuple(np.full(time_s.size, x) for x in (self.sun.zenith_deg, self.sun.azimuth_deg, self.sun.distance_au))


@dataclass
class Squares:
    """Squares of ice over the whole plane, by rows and columns of the scene."""

    margin: tuple = (0, 0)
    declares = CloudDeclaration()

    def thickness_m(self, time_s, rows, columns):
        y, x = np.mgrid[rows, columns]
        return squares(y - self.margin[0], x - self.margin[1]).astype(np.float32)

    def thickness_around_m(self, time_s, rows, columns, summary):
        return self.thickness_m(time_s, rows, columns)


def squares(y, x):
    """Thickness at places, in points of the scene; its points are at whole numbers."""
    across, up = (np.floor((place + 0.5) / SQUARE).astype(int) for place in (x, y))
    return ICE[up % 3, across % 4]


def beside(*parts):
    raw = merged(SCENE, BESIDE, *parts)
    if raw["orbit"].get("provider") == "geostationary":
        raw["orbit"] = {"provider": "geostationary", "longitude": raw["orbit"]["longitude"]}
    if "layers" in raw["clouds"]:
        raw["clouds"] = {"layers": raw["clouds"]["layers"]}
    return hcss_twin.Scenario.from_dict(raw)


ALL = {"output": {"variables": ["all"], "certificate": 0}}


@lru_cache
def squares_under(zenith_deg, azimuth_deg, water=False, shadows="on"):
    """The plan and a frame of a sea below squares of ice or water, under a sun."""
    sun = Sun(zenith_deg, azimuth_deg, 1.0)
    layer = (WATER if water else HIGH) | {"coverage": 0.4, "coverage_mode": "field"}
    plan = hcss_twin.make_plan(beside({"clouds": {"layers": [layer]}}, ALL, {"slant": {"shadows": shadows}}))
    slant = replace(plan.assembly.slant, sun_zenith_deg=np.array([zenith_deg]), sun_azimuth_deg=np.array([azimuth_deg]))
    margin = slant.margin(plan.layers[0], 500.0)
    clouds = DisplacedClouds(Squares(margin), margin, (0, 0))
    plan = replace(
        plan,
        assembly=replace(plan.assembly, slant=slant, generators=(clouds,)),
        sun_track=FixedSun(sun),
        sun_zenith_deg=slant.sun_zenith_deg,
        sun_azimuth_deg=slant.sun_azimuth_deg,
    )
    return plan, next(stream(plan, compile_tables(plan)))


def places_m(made):
    """Place of each pixel in the plane of the scene, and the direction to the camera along its axes."""
    return Ellipsoid.to_plane(made["pixel_latitude"], made["pixel_longitude"], *PLACE)


def views_of(plan, made, pixels):
    """Views of pixels: straight lines to the camera, whose bearing counts from the axis of the plane."""
    camera = position_of(plan)
    latitude, longitude = (made[f"pixel_{name}"][pixels] for name in ("latitude", "longitude"))
    ground = Ellipsoid.to_earth_centred(latitude, longitude)
    ray = camera - ground
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    east, north, up = (np.sum(axis * ray, axis=-1) for axis in Ellipsoid.east_north_up(latitude, longitude))
    # A step of 1e-5 rad toward the camera, in the plane.
    step = np.degrees(1e-5) * np.stack((north, east / np.cos(np.radians(latitude)))) / np.hypot(east, north)
    x, y = (
        after - before
        for after, before in zip(
            Ellipsoid.to_plane(latitude + step[0], longitude + step[1], *PLACE),
            Ellipsoid.to_plane(latitude, longitude, *PLACE),
            strict=True,
        )
    )
    return [
        View(float(zenith), float(azimuth) % 360.0)
        for zenith, azimuth in zip(np.degrees(np.arccos(up)), np.degrees(np.arctan2(x, y)), strict=True)
    ]


def position_of(plan):
    """Place of the camera."""
    coordinates = plan.rays.layout(plan.scenario).coordinates
    return {spec.name: values for spec, values in coordinates}["platform_position"][0]


def traced(plan, made, zenith_deg, azimuth_deg, heights_m):
    """Thickness that straight rays from the pixels meet at heights (H, y, x), and their distance to an edge, points."""
    x_m, y_m = places_m(made)
    away = heights_m[:, None, None] * np.tan(np.radians(zenith_deg))
    row, column = plan.scene.in_points(
        x_m + away * np.sin(np.radians(azimuth_deg)), y_m + away * np.cos(np.radians(azimuth_deg))
    )
    edge = [np.abs((place + 0.5 + 0.5 * SQUARE) % SQUARE - 0.5 * SQUARE) for place in (row, column)]
    return squares(row, column), np.minimum(*edge)


SUNS = [(35.0, 250.0), (0.0, 0.0)]
"""The last one overhead: a camera beside the scene sees the shadow below the cloud."""

ANOTHER_SUN = pytest.param((30.0, 300.0), marks=pytest.mark.campaign)


@pytest.mark.parametrize("sun", [*SUNS, ANOTHER_SUN])
def test_shadows_are_where_rays_counted_by_hand_cross_the_clouds(sun):
    plan, made = squares_under(*sun)
    seen, far = traced(plan, made, made["pixel_view_zenith"], made["pixel_view_azimuth"], np.array([10_000.0]))
    sure = far[0] > 1.5
    np.testing.assert_array_equal(made["cloud_mask"][sure], seen[0][sure] > 0.0)
    heights = 9000.0 + 1000.0 * (np.arange(400) + 0.5) / 400.0
    through, far = traced(plan, made, *sun, heights)
    inside = np.sum(10_000.0 - heights[:, None, None] <= through, axis=0) * 2.5
    sure &= np.min(far, axis=0) > 1.5
    shaded = (inside > 0.0) & (made["cloud_mask"] == 0)
    assert np.count_nonzero(sure & shaded) > 50
    np.testing.assert_array_equal(made["shadow_mask"][sure], shaded[sure])


@pytest.mark.parametrize("sun", [SUNS[0], ANOTHER_SUN])
def test_a_shadow_takes_the_glint_of_the_pixel_s_own_view_through_the_cloud(sun):
    """The dense spectrum of the glint toward each pixel, behind a cloud of Bouguer on the path of the sun."""
    plan, made = squares_under(*sun)
    heights = 9000.0 + 1000.0 * (np.arange(400) + 0.5) / 400.0
    through, far = traced(plan, made, *sun, heights)
    inside = np.sum(10_000.0 - heights[:, None, None] <= through, axis=0) * 2.5
    pixels = np.nonzero((np.min(far, axis=0) > 1.5) & (inside > 0.0) & (made["cloud_mask"] == 0))
    some = np.linspace(0, pixels[0].size - 1, 24).astype(int)
    pixels = pixels[0][some], pixels[1][some]
    weights, wavenumber = plan.spectral_grid.weights_cm1, plan.spectral_grid.wavenumber_cm1
    extinction = plan.assembly.optics.single_scattering(plan.layers[0].microphysics, wavenumber).extinction_m1
    worst, one_view, unshaded = 0.0, 0.0, 0.0
    for row, column, view in zip(*pixels, views_of(plan, made, pixels), strict=True):
        behind = np.exp(-extinction * inside[row, column] / np.cos(np.radians(sun[0])))
        errors = []
        for toward, kept in ((view, behind), (plan.view, behind), (view, 1.0)):
            terms = plan.assembly.toward(toward).clear(wavenumber, Sun(*sun, 1.0))
            terms = {**terms, "sea_reflected_sun": terms["sea_reflected_sun"] * kept}
            expected = weights @ np.sum(list(terms.values()), axis=0)
            errors.append(np.max(np.abs(made["radiance"][:, row, column] / expected - 1.0)))
        worst, one_view, unshaded = (max(pair) for pair in zip((worst, one_view, unshaded), errors, strict=True))
    assert worst < 0.5 * plan.accuracy.relative
    assert one_view > plan.accuracy.relative
    assert unshaded > 5.0 * plan.accuracy.relative


def test_behind_opaque_clouds_a_camera_sees_no_glint():
    sun = SUNS[0]
    (plan, shaded), (_, sunlit) = squares_under(*sun, True), squares_under(*sun, True, "off")
    through, far = traced(plan, shaded, *sun, np.array([9100.0, 9500.0, 9950.0]))
    opaque = np.all((through == 900.0) & (far > 1.5), axis=0) & (shaded["cloud_mask"] == 0)
    assert np.count_nonzero(opaque) > 20
    glint, left = (made["radiance_sea_reflected_sun"][:, opaque].astype(float) for made in (sunlit, shaded))
    assert np.max(left / glint) < 1e-4
    expected = sunlit["radiance"][:, opaque].astype(float) - glint
    np.testing.assert_allclose(shaded["radiance"][:, opaque], expected, rtol=2e-4)
    clear = (shaded["cloud_mask"] == 0) & (shaded["shadow_mask"] == 0)
    np.testing.assert_array_equal(shaded["radiance"][:, clear], sunlit["radiance"][:, clear])


# --- waves ----------------------------------------------------------------------------------

NEAR = {
    "camera": {"rows": 1500, "columns": 2000, "focal_length": 0.1, "detector_pitch": 1.0e-5},
    "orbit": {"altitude": 1.2e5, "above": [30.0, 150.7]},
    "image": {"rows": 512, "columns": 512, "pixel_size": 10.0},
    "sea": {"model": "rough-sea", "wind_speed": 8.0, "wind_from": 40.0, "waves": "on"},
    "clouds": {"coverage": 0.0},
    "time": "2024-04-20T03:30:00Z",
}
"""Pixels of 13 m and more over 20 km, which a camera at 120 km sees from the east."""

PARTS = [(slice(y, y + 6), slice(x, x + 8)) for y in (0, 400, 1100, 1494) for x in (200, 770, 1600)]


@lru_cache
def sea_in_parts():
    """Parts of a sea with resolved waves."""
    plan = hcss_twin.make_plan(beside(NEAR, ALL))
    tables = compile_tables(plan)
    return plan, tables, [PartMaker(plan, tables).part(0, part)[0] for part in PARTS]


def over_tilted_sea(plan, view, sun, upwind, crosswind):
    """Bands of the terms of clear sky over a sea that waves tilt, crosswind clockwise from upwind."""
    clockwise = (sun.azimuth_deg - view.azimuth_deg) % 360.0 < 180.0
    sea = plan.assembly.sea.tilted(upwind, crosswind if clockwise else -crosswind, plan.grid.pixel_size_m)
    terms = plan.assembly.over_sea(sea).toward(view).clear(plan.spectral_grid.wavenumber_cm1, sun)
    return {name: plan.spectral_grid.weights_cm1 @ spectrum for name, spectrum in terms.items()}


@lru_cache
def level_over_mean_of_waves(view):
    """What makes the mean over all waves of each term toward a view that of the mean sea."""
    plan = sea_in_parts()[0]
    sun = plan.sun_track.at(0.0)
    spectra = plan.assembly.toward(view).clear(plan.spectral_grid.wavenumber_cm1, sun)
    mean = dict.fromkeys(spectra, 0.0)
    places, shares = np.polynomial.hermite_e.hermegauss(5)
    for u, a in zip(places, shares, strict=True):
        for c, b in zip(places, shares, strict=True):
            tilted_here = over_tilted_sea(plan, view, sun, u * plan.waves.rms[0], c * plan.waves.rms[1])
            mean = {name: mean[name] + a * b * bands / shares.sum() ** 2 for name, bands in tilted_here.items()}
    level = {name: plan.spectral_grid.weights_cm1 @ spectrum for name, spectrum in spectra.items()}
    return {name: level[name] / mean[name] for name in mean if np.all(mean[name] > 0.0)}


def toward(view, upwind, crosswind):
    """Radiance of a pixel whose terms have, over all waves, the mean of the mean sea."""
    plan = sea_in_parts()[0]
    here = over_tilted_sea(plan, view, plan.sun_track.at(0.0), upwind, crosswind)
    return sum(here[name] * factor for name, factor in level_over_mean_of_waves(view).items())


def test_a_wave_is_a_tilted_sea_at_the_pixel_s_own_place_and_view():
    plan, tables, parts = sea_in_parts()
    assert len(tables.over) == len(plan.views.places) >= 4
    wind = np.radians(plan.scenario.sea.wind_from)
    errors, one_view, tilts = [], [], []
    for made in parts[::3]:
        y, x = np.unravel_index(np.argmax(np.abs(made["sea_slope_y"])), made["sea_slope_y"].shape)
        slope = float(made["sea_slope_x"][y, x]), float(made["sea_slope_y"][y, x])
        row, column = (int(np.rint(place[y, x])) for place in plan.scene.in_points(*places_m(made)))
        point = plan.waves.shapes.slopes(0.0, slice(row, row + 1), slice(column, column + 1))
        np.testing.assert_allclose(point.ravel(), slope, rtol=1e-5)
        upwind = slope[0] * np.sin(wind) + slope[1] * np.cos(wind)
        crosswind = slope[0] * np.cos(wind) - slope[1] * np.sin(wind)
        (view,), found = views_of(plan, made, ([y], [x])), made["radiance"][:, y, x]
        errors.append(np.max(np.abs(found / toward(view, upwind, crosswind) - 1.0)))
        one_view.append(np.max(np.abs(found / toward(plan.view, upwind, crosswind) - 1.0)))
        tilts.append(np.max(np.abs(found / toward(view, 0.0, 0.0) - 1.0)))
    assert max(errors) < 0.5 * plan.accuracy.relative
    assert max(one_view) > 5.0 * plan.accuracy.relative
    assert max(tilts) > 5.0 * plan.accuracy.relative


def test_waves_of_a_camera_have_the_slopes_of_the_sea():
    """A nearest point, not a mean of neighbours, which would be flatter."""
    plan, _, parts = sea_in_parts()
    slopes = np.array([[part[name] for name in ("sea_slope_x", "sea_slope_y")] for part in parts]).astype(float)
    assert np.mean(slopes**2) * 2.0 == pytest.approx(np.sum(np.square(plan.waves.rms)), rel=0.25)


# --- texture of clear sky -------------------------------------------------------------------

TEXTURED = {
    "sea": {"temperature": 295.0, "temperature_texture": 1.0},
    "atmosphere": {"profile": "midlatitude-summer", "water_vapour_texture": 0.05},
    "accuracy": 2e-3,
    "clouds": {"coverage": 0.0},
}


def test_the_texture_of_a_pixel_is_that_of_its_place_and_changes_its_own_view():
    """Fields between the pixels of the scene, and the exact column over the warmer sea in drier air."""
    plan = hcss_twin.make_plan(beside(TEXTURED, ALL))
    made = next(stream(plan, compile_tables(plan)))
    rows, columns = (place / plan.scene.samples for place in plan.scene.in_points(*places_m(made)))
    fields, inside = TextureFields(plan.scenario, plan.assembly, plan.texture), slice(-60, 130)
    warmer, drier = (field.astype(float) for field in fields.at(0.0, inside, inside))
    sun, weights = plan.sun_track.at(0.0), plan.spectral_grid.weights_cm1
    pixels = np.random.default_rng(1).integers((0, 0), (40, 48), (12, 2)).T
    errors, without = [], []
    for y, x, view in zip(*pixels, views_of(plan, made, tuple(pixels)), strict=True):
        top, left = int(np.floor(rows[y, x])), int(np.floor(columns[y, x]))
        up, side = rows[y, x] - top, columns[y, x] - left
        mix = np.outer((1.0 - up, up), (1.0 - side, side))
        here = slice(top + 60, top + 62), slice(left + 60, left + 62)
        kelvin, factor = (
            plan.texture.steps[0] * np.sum(mix * warmer[here]),
            1.0 - plan.texture.steps[1] * np.sum(mix * drier[here]),
        )
        assert made["sea_temperature"][y, x] == pytest.approx(295.0 + kelvin, abs=2e-3)
        assert made["water_vapour_factor"][y, x] == pytest.approx(factor, abs=2e-4)
        for scene, found in ((plan.assembly.perturbed(kelvin, factor), errors), (plan.assembly, without)):
            terms = scene.toward(view).clear(plan.spectral_grid.wavenumber_cm1, sun)
            expected = weights @ np.sum(list(terms.values()), axis=0)
            found.append(np.max(np.abs(made["radiance"][:, y, x] / expected - 1.0)))
    assert max(errors) < plan.accuracy.relative
    assert max(without) > 5.0 * plan.accuracy.relative


def test_a_camera_and_a_grid_see_the_same_texture():
    parts = TEXTURED | {"sea": {"temperature": 295.0, "temperature_texture": 1.0, "waves": "off"}}
    grid, cube = (
        next(stream(plan, compile_tables(plan)))
        for plan in (
            hcss_twin.make_plan(scenario(parts, ALL, {"bands": ["lwir-10.8"]}, *of)) for of in ((), (STARING,))
        )
    )
    for name in ("sea_temperature", "water_vapour_factor", "radiance"):
        expected, seen = grid[name][..., ::-1, :].astype(float), cube[name].astype(float)
        assert np.sqrt(np.mean((seen - expected) ** 2)) <= 0.02 * expected.std()


# --- all together ---------------------------------------------------------------------------

EVERYTHING = {
    "camera": {"rows": 60, "columns": 100, "focal_length": 0.1, "detector_pitch": 1.0e-5, "points": 2},
    "orbit": {"altitude": 1.2e5, "above": [30.0, 150.7]},
    "image": {"rows": 128, "columns": 128, "pixel_size": 10.0},
    "sea": {"model": "rough-sea", "wind_speed": 8.0, "waves": "on", "temperature_texture": 0.3},
    "clouds": {"type": "cumulus", "coverage": 0.4},
    "slant": {"shadows": "on"},
    "output": {"variables": ["all"], "certificate": 12},
}


def test_all_effects_go_together_in_whatever_windows_and_pass_the_certificate(monkeypatch):
    plan = hcss_twin.make_plan(beside(EVERYTHING))
    assert {"views", "texture", "shadows", "waves"} <= {effect.kind for effect in plan.effects}
    tables, sample = compile_tables(plan), PixelSample(plan)
    whole = next(stream(plan, tables, sample))
    assert 0.0 < whole["shadow_mask"].mean() < 1.0
    found = certify(plan, tables, sample.frames)
    assert found.passed
    assert found.checked == 12
    assert next(stratum for stratum in found.strata if stratum.name == "clear in shadow").checked >= 2
    assert not any(any(stratum.left_out.values()) for stratum in found.strata)
    monkeypatch.setattr(stream_module, "windows", partial(windows, most_points=310))
    strips = next(stream(plan, tables))
    part = PartMaker(plan, tables).part(0, (slice(10, 50), slice(20, 90)))[0]
    for name, values in whole.items():
        np.testing.assert_array_equal(strips[name], values)
        np.testing.assert_array_equal(part[name], values[..., 10:50, 20:90])


DISK = {
    "camera": {"rows": 24, "columns": 24, "focal_length": 0.1, "detector_pitch": 1.28e-3, "beyond": "missing"},
    "orbit": {"provider": "geostationary", "longitude": 150.0},
    "place": {"latitude": 0.0},
    "attitude": {"provider": "nadir"},
    "image": {"pixel_size": 30e3, "rows": 400, "columns": 400},
    "clouds": {"base": 1000.0, "top": 4000.0},
    "sea": {"temperature_texture": None, "waves": "auto"},
    "bands": ["lwir-10.8"],
    "accuracy": 5e-2,
}


def test_a_full_disk_has_no_shadows_from_one_sun():
    assert "full disk" in hcss_twin.make_plan(beside(DISK)).assembly.slant.why_not["shadows"].why
    for on in ({"slant": {"shadows": "on"}}, {"sea": {"temperature_texture": 0.5}}):
        with pytest.raises(ScenarioError, match=r"image: a full disk"):
            hcss_twin.make_plan(beside(DISK, on))


# --- derived variables ----------------------------------------------------------------------


class Where:
    """Location and view of a pixel, apart, beside its radiance."""

    declares = Declaration()
    needs: tuple[str, ...] = ("radiance", "latitude", "longitude", "view_zenith", "view_azimuth")
    variables = {  # noqa: RUF012
        "where": OutputVariable("1", "sum", "Location and view.", dtype="float64"),
        "bright": OutputVariable("1", "twice the radiance", "Of the first band.", dtype="float64"),
    }

    def __init__(self, inputs, parameters):
        self.size = inputs.grid.rows, inputs.grid.columns

    def values(self, fields, time_s):
        angles = [fields[name] for name in self.needs[1:]]
        assert all(np.all(np.isfinite(angle)) for angle in angles)
        total = sum(angle * 1000.0**number for number, angle in enumerate(angles))
        return {"where": total, "bright": 2.0 * fields["radiance"][0].astype(float)}


class Sunny(Where):
    needs = ("radiance", "sun_zenith")


class Plugin:
    @hookimpl
    def hcss_register_variables(self):
        kinds = (Where, Sunny)
        return [ProviderSpec(kind.__name__.lower(), f"{__name__}:{kind.__name__}", None, 3, "a test") for kind in kinds]


@pytest.fixture
def derived(monkeypatch):
    registry = Registry.defaults_only()
    registry.add(Plugin(), Origin("test", "hcss-test", "1.0"))
    monkeypatch.setattr(Registry, "discover", classmethod(lambda cls: registry))

    def of(provider):
        return {"output": {"variables": ["radiance", "where", "bright"], "derived": [{"provider": provider}]}}

    return of


def test_derived_variables_have_location_and_view_of_each_pixel(derived):
    plan = hcss_twin.make_plan(beside(derived("where"), {"sea": {"waves": "off"}}))
    made = next(stream(plan, compile_tables(plan)))
    assert plan.assembly.derived[0].variables.keys() == {"where", "bright"}
    names = ("pixel_latitude", "pixel_longitude", "pixel_view_zenith", "pixel_view_azimuth")
    expected = sum(made[name].astype(float) * 1000.0**number for number, name in enumerate(names))
    np.testing.assert_allclose(made["where"], expected, rtol=1e-7)
    np.testing.assert_array_equal(made["bright"], 2.0 * made["radiance"][0].astype(float))


def test_derived_variables_are_missing_where_no_ground_is_seen(derived):
    plan = hcss_twin.make_plan(beside(DISK, derived("where"), {"clouds": {"coverage": 0.0}}))
    made = next(stream(plan, compile_tables(plan)))
    ground = made["pixel_kind"] == 0
    assert 0.3 < ground.mean() < 0.9
    for name in ("where", "bright"):
        np.testing.assert_array_equal(np.isfinite(made[name]), ground)
        assert next(spec for spec in plan.variables if spec.name == name).may_be_missing
    with pytest.raises(ScenarioError, match=r"output\.derived: a variable of the sun's angles"):
        hcss_twin.make_plan(beside(DISK, derived("sunny")))


@pytest.mark.parametrize(("beyond", "mode"), [("mirror", "symmetric"), ("clear", "constant")])
def test_a_camera_sees_the_clouds_of_an_image_and_beyond_it_what_is_said(tmp_path, beyond, mode):
    """Places of the lines of sight at the height of the layer, in an image that is made larger by hand."""
    smooth = np.cumsum(np.cumsum(np.random.default_rng(0).normal(size=(64, 64)), 0), 1)
    np.save(tmp_path / "image.npy", smooth - smooth.min())
    parameters = {"image": str(tmp_path / "image.npy"), "method": "coverage", "cloud_is": "bright", "beyond": beyond}
    layer = HIGH | {"coverage": 0.4, "coverage_mode": "field", "generator": "imagery", "parameters": parameters}
    output = {"output": {"variables": ["radiance", "cloud_mask"], "certificate": 12}}
    plan = hcss_twin.make_plan(beside({"clouds": {"layers": [layer]}}, output))
    made = hcss_twin.simulate(plan.scenario)
    assert made.attrs["hcss_certificate"].startswith("computed as specified")
    image = plan.assembly.generators[0].thickness_m(0.0, slice(0, 64), slice(0, 64)) > 0
    room = 64
    around = np.pad(image, room, mode=mode)
    x_m, y_m = plan.rays.points_m((slice(0, 40), slice(0, 48)), 0.0, plan.layers[0].top_m)
    row, column = (room + place / 500.0 + 31.5 for place in (y_m, x_m))
    low_y, low_x = (np.floor(place).astype(int) for place in (row, column))
    near = np.stack([around[low_y + i, low_x + j] for i in (0, 1) for j in (0, 1)])
    alike = np.all(near == near[0], axis=0)
    outside = (np.minimum(row, column) < room) | (np.maximum(row, column) > room + 63)
    assert np.count_nonzero(alike & outside) > 500
    np.testing.assert_array_equal(made.cloud_mask.values[0][alike] > 0, near[0][alike])
    assert np.count_nonzero(near[0][alike & outside]) > 100 or beyond == "clear"


@dataclass
class Towers(Squares):
    """The same squares of cloud, whose tops vary from square to square."""

    cloud_top_range_m = 5000.0, 10_000.0

    def cloud_top_m(self, time_s, rows, columns):
        y, x = np.mgrid[rows, columns]
        return tower_tops(y - self.margin[0], x - self.margin[1]).astype(np.float32)


def tower_tops(y, x):
    """Altitude of the top of each square."""
    across, up = (np.floor((place + 0.5) / SQUARE).astype(int) for place in (x, y))
    return 5000.0 + 1000.0 * ((2 * across + up) % 6)


class TowersPlugin:
    @hookimpl
    def hcss_register_cloud_generators(self):
        return [ProviderSpec("towers", f"{__name__}:of_inputs", None, 3, "a test")]


def of_inputs(inputs, parameters):
    towers = Towers(((inputs.grid.rows - 64) // 2, (inputs.grid.columns - 64) // 2))
    towers.image_coverage, towers.expected_failures = 0.4, {"frozen_field_only_translates": "it stands still"}
    return towers


def test_a_camera_sees_the_first_column_of_clouds_with_tops_of_their_own(monkeypatch):
    """Lines of sight of the camera, followed by steps of 5 m in height."""
    registry = Registry.defaults_only()
    registry.add(TowersPlugin(), Origin("test", "hcss-test", "1.0"))
    monkeypatch.setattr(Registry, "discover", classmethod(lambda cls: registry))
    layer = WATER | {"generator": "towers", "coverage_mode": "field"}
    output = {"output": {"variables": ["radiance", "cloud_thickness", "cloud_top_altitude"], "certificate": 12}}
    plan = hcss_twin.make_plan(beside({"clouds": {"layers": [layer]}}, output))
    made = hcss_twin.simulate(plan.scenario)
    assert made.attrs["hcss_certificate"].startswith("computed as specified")
    expected, tops = np.zeros((40, 48)), np.zeros((40, 48))
    for height_m in np.arange(10_000.0, 4000.0, -5.0).tolist():
        x_m, y_m = plan.rays.points_m((slice(0, 40), slice(0, 48)), 0.0, height_m)
        y, x = np.rint(y_m / 500.0 + 31.5), np.rint(x_m / 500.0 + 31.5)
        cloud, top = squares(y, x), tower_tops(y, x)
        met = (expected == 0.0) & (cloud > 0.0) & (height_m <= top) & (height_m >= top - cloud)
        expected, tops = np.where(met, cloud, expected), np.where(met, top, tops)
    assert np.unique(tops).size == 7  # six heights, and none
    found = made.cloud_thickness.values[0], np.nan_to_num(made.cloud_top_altitude.values[0])
    assert np.mean((found[0] == expected) & (found[1] == tops)) > 0.95


def test_parallax_of_a_camera_is_that_of_its_lines_of_sight():
    layer = HIGH | {"coverage": 0.4, "coverage_mode": "field"}
    output = {"output": {"variables": ["radiance", "cloud_mask"], "certificate": 0}}
    auto, on = (
        hcss_twin.simulate(beside({"clouds": {"layers": [layer]}, "slant": {"parallax": parallax}}, output))
        for parallax in ("auto", "on")
    )
    for name in ("radiance", "cloud_mask"):
        np.testing.assert_array_equal(on[name].values, auto[name].values)
