"""An effect of points that a package brings: smoke, against Bouguer's law, and certified beside other effects."""

import numpy as np
import pytest

from hcss_twin import Scenario, make_plan, simulate

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
