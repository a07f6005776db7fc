"""An effect of points that a package brings: smoke, against Bouguer's law, and certified beside other effects."""

from types import SimpleNamespace

import numpy as np
import pytest
from hcss_examples.smoky_air import SmokyAir

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.providers import AtmosphereDeclaration, Profile, planck, to_space

CHEAP = {"radiance.model": "as-printed", "sea.model": "cox-munk"}
SMALL = {"image.rows": 24, "image.columns": 24, "image.pixel_size": 500.0, "view.zenith": 30.0, "output.certificate": 8}
SMOKE = {"smoke": {"optical_depth": 0.8, "bearing": 30.0, "width": 3000.0}}


def of(name="stratus", **overrides):
    return Scenario.load(name, SMALL | overrides)


def test_smoke_attenuates_what_the_sea_emits_by_bouguers_law():
    """In a narrow band, whose transmittance through smoke is that of its middle."""
    clear = {"clouds.coverage": 0.0, "bands": [[3.99, 4.01]], "output.variables": ["terms"], "output.certificate": 0}
    without, smoky = simulate(of(**CHEAP, **clear)), simulate(of(**CHEAP, **clear, **SMOKE))
    ratio = smoky["radiance_sea_emission"].values[0, 0] / without["radiance_sea_emission"].values[0, 0]
    place = (np.arange(24) - 11.5) * 500.0
    x_m, y_m = np.meshgrid(place, place)
    distance = x_m * np.cos(np.radians(30.0)) - y_m * np.sin(np.radians(30.0))
    depth = 0.8 * np.exp(-((distance / 3000.0) ** 2)) / 4.0
    assert ratio == pytest.approx(np.exp(-depth / np.cos(np.radians(30.0))), rel=2e-3)


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"image.samples_per_pixel": 2},
        {"platform.altitude": 8e5, "image.pixel_size": 10e3, "smoke": {"optical_depth": 0.3, "width": 60e3}},
        {"sea.temperature_texture": 0.3, "atmosphere.water_vapour_texture": 0.05},
        {"slant.shadows": "on", "slant.parallax": "on"},
        {"clouds": {"layers": [{"type": kind, "coverage": 0.5} for kind in ("stratus", "altocumulus", "cirrus")]}},
    ],
    ids=["clouds", "points within a pixel", "views of pixels", "texture", "shadows", "three layers"],
)
def test_smoke_is_certified_beside_other_effects(more):
    made = simulate(of(**(CHEAP | SMOKE | {"bands": ["lwir-10.8"], "accuracy": 1e-2} | more)))
    assert made.attrs["hcss_certificate"].startswith("computed as specified")


def test_smoke_of_the_physical_model_is_certified():
    made = simulate(of(**SMOKE, **{"bands": ["lwir-10.8"], "accuracy": 1e-2, "output.certificate": 4}))
    assert made.attrs["hcss_certificate"].startswith("computed as specified")


@pytest.mark.parametrize(
    "more", [{}, {"platform.altitude": 8e5, "image.pixel_size": 2e3}], ids=["grid", "views of pixels"]
)
def test_waves_and_shadows_in_the_glint_lie_behind_the_smoke(more):
    glint = {"view.zenith": 24.0, "bands": ["mwir-3.7"], "accuracy": 1e-2, "output.certificate": 60}
    glint |= {"radiance.model": "as-printed", "sea.model": "rough-sea", "smoke": {"optical_depth": 1.5, "width": 8e3}}
    made = simulate(of("cumulus", **(glint | {"image.pixel_size": 200.0} | more)))
    assert "waves" not in made.attrs.get("hcss_left_out", "")
    assert made.attrs["hcss_certificate"].startswith("computed as specified")


def test_values_outside_their_range_are_refused(monkeypatch):
    monkeypatch.setattr("hcss_examples.smoke.Smoke.values", lambda self, x_m, y_m, time_s: x_m)
    with pytest.raises(Exception, match=r"section 'smoke' of .*values .*allowed: .*from 0 to 0.8"):
        simulate(of(**CHEAP, **SMOKE, **{"bands": ["lwir-10.8"]}))


def test_the_plan_says_how_many_values_have_tables():
    (planned,) = make_plan(of(**CHEAP, **SMOKE, **{"bands": ["lwir-10.8"]})).point_effects
    assert planned.described()["smoke"]["nodes"][0] == 0.0
    assert planned.described()["smoke"]["nodes"][-1] == 0.8


NARROW_GLINT = {
    "time": "2024-06-20T10:00:00+09:30",
    "place": {"latitude": 20.0, "longitude": 140.0},
    "image": {"rows": 16, "columns": 16, "pixel_size": 20.0},
    "view": {"zenith": 30.0, "azimuth": 255.0},
    "sea": {"model": "rough-sea", "temperature": 300.0, "wind_speed": 6.0, "temperature_texture": 0.0},
    "atmosphere": {"water_vapour_texture": 0.0},
    "clouds": {
        "layers": [{"type": "cumulus", "base": 600.0, "top": 1500.0, "coverage": 0.3, "coverage_mode": "field"}]
    },
    "radiance": {"model": "as-printed"},
    "bands": [[3.99, 4.01]],
    "accuracy": 1e-3,
    "output": {"variables": ["terms", "cloud_mask"], "certificate": 0},
}
EVERYWHERE = {"smoke": {"optical_depth": 1.0, "width": 1e6}}
"""Smoke of one optical depth at all places of such an image, but for 1e-5."""


@pytest.mark.parametrize(("effect", "pixel_m"), [("slant.shadows", 100.0), ("sea.waves", 20.0)])
def test_what_shadows_and_waves_change_is_weakened_by_bouguers_law_on_both_ways(effect, pixel_m):
    """The sunlight that they change crosses the smoke twice; in a narrow band, which has one transmittance."""
    keys = {"slant.shadows": "off", "slant.parallax": "off", "sea.waves": "off", "image.pixel_size": pixel_m}
    term = "radiance_sea_reflected_sun"

    def change(smoke):
        of_key = (simulate(Scenario.from_dict(NARROW_GLINT | smoke, keys | {effect: key})) for key in ("on", "off"))
        with_it, without = (made.isel(time=0) for made in of_key)
        return (with_it[term] - without[term]).values[0][with_it["cloud_mask"].values == 0]

    alone, smoky = change({}), change(EVERYWHERE)
    large = np.abs(alone) > 0.3 * np.abs(alone).max()
    assert np.count_nonzero(large) > 5
    zenith = np.radians([30.0, make_plan(Scenario.from_dict(NARROW_GLINT)).sun_at(0.0).zenith_deg])
    assert smoky[large] / alone[large] == pytest.approx(np.exp(-0.25 * np.sum(1.0 / np.cos(zenith))), rel=1e-3)


def test_an_element_behind_smoke_is_weakened_by_bouguers_law():
    source = {"x": 50.0, "y": -30.0, "altitude": 0.0, "intensity": 1e4}
    more = {
        "elements": [{"provider": "point-sources", "parameters": {"tracks": [source]}}],
        "clouds": {"layers": []},
        "output": {"variables": ["radiance", "element_radiance"], "certificate": 0},
    }
    alone, smoky = (
        simulate(Scenario.from_dict(NARROW_GLINT | more | smoke, {"sea.waves": "off"}))["element_radiance"].values.sum()
        for smoke in ({}, EVERYWHERE)
    )
    assert smoky / alone == pytest.approx(np.exp(-0.25 / np.cos(np.radians(30.0))), rel=2e-3)


class IsothermalTable:
    """Grey air of one temperature, known from 20 km and lower."""

    declares = AtmosphereDeclaration(valid={"target_altitude_m": (0.0, 20e3)}, legs="to_space")

    def transmittance(self, wavenumber_cm1, paths):
        legs = [path.legs[0] for path in paths]
        assert all(leg.lower_m <= 20e3 for leg in legs)
        depth = [0.7 * np.exp(-leg.lower_m / 8e3) / np.cos(np.radians(leg.zenith_deg)) for leg in legs]
        return np.exp(-np.array(depth))[:, None] * np.ones_like(wavenumber_cm1)

    def path_radiance(self, wavenumber_cm1, paths):
        return (1.0 - self.transmittance(wavenumber_cm1, paths)) * planck(wavenumber_cm1, 260.0)


def test_smoke_in_isothermal_air_of_a_table_emits_what_it_absorbs():
    """Kirchhoff's law: whatever the path, radiance is (1 - transmittance) times that of a black body."""
    levels = np.arange(0.0, 50e3, 1e3)
    profile = Profile("isothermal", levels, 1e5 * np.exp(-levels / 8e3), np.full(levels.shape, 260.0), {})
    setting = SimpleNamespace(profile=profile, transmittance=IsothermalTable())
    wavenumber, paths = np.array([900.0, 2600.0]), [to_space(height, 40.0) for height in (0.0, 700.0, 6000.0)]
    smoky = SmokyAir(setting, 1500.0, 2.0)
    through = smoky.transmittance(wavenumber, paths)
    assert np.all(through[0] < 0.9 * setting.transmittance.transmittance(wavenumber, paths)[0])
    black = planck(wavenumber, 260.0)
    np.testing.assert_allclose(smoky.path_radiance(wavenumber, paths), (1.0 - through) * black, rtol=1e-5)


def test_smoke_beside_a_table_of_air_adds_what_it_adds_to_the_air_that_the_table_is_of():
    """The table holds LOWTRAN7's air, which the band model computes, too."""

    def of_air(provider, **more):
        keys = {"atmosphere.provider": provider, "bands": ["lwir-10.8"], "accuracy": 2e-3} | more
        keys |= (
            {"atmosphere.gases.others": "profile", "atmosphere.inversion": "off"} if provider == "band-model" else {}
        )
        clear = {"clouds": {"layers": []}, "output": {"variables": ["radiance"], "certificate": 0}}
        return [
            simulate(Scenario.from_dict(NARROW_GLINT | clear | smoke, keys))["radiance"].values[0, 0].astype(float)
            for smoke in ({}, {"smoke": {"optical_depth": 3.0, "width": 1e6}})
        ]

    table, model = (
        of_air("table"),
        of_air("band-model", **{"atmosphere.profile": "us-standard-1976", "atmosphere.coefficients": "lowtran7"}),
    )
    (alone, smoky), (other, darkened) = table, model
    assert smoky - alone == pytest.approx(darkened - other, rel=3e-2)
    assert np.all(smoky < 0.99 * alone)
