"""Wavenumbers that are chosen for a scene serve all suns of it."""

import numpy as np
import pytest
from cheap import CHEAP

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.engine.tables.spectrum import choose_spectrum


@pytest.mark.parametrize(
    ("model", "bands"), [("as-printed", ["mwir-3.7", "mwir"]), ("physical-two-stream", ["mwir-3.7"])]
)
def test_clouds_under_suns_that_no_choice_knew_keep_the_share(model, bands):
    """The scattering angle goes through that of the rainbow, where neighbouring wavenumbers part."""
    scene = {
        **CHEAP,
        "radiance.model": model,
        "optics.provider": "bulk",
        "bands": bands,
        "view.zenith": 40.0,
        "view.azimuth": 160.0,
        "frames.count": 200,
        "frames.interval": 60.0,
    }
    plan = make_plan(Scenario.load("stratus", scene))
    spectrum = choose_spectrum(plan, plan.budget.wavenumbers)
    grid = plan.spectral_grid
    kept = np.searchsorted(grid.wavenumber_cm1, spectrum.nodes.wavenumber_cm1)
    assert kept.size < grid.wavenumber_cm1.size
    for time_s in plan.frame_times_s[[7, 61, 171]]:
        terms = plan.assembly.cloudy(grid.wavenumber_cm1, np.array([[40.0], [700.0]]), plan.sun_at(time_s))
        total = np.sum(list(terms.values()), axis=0)
        found = total[:, kept] @ spectrum.nodes.weights_cm1.T
        np.testing.assert_allclose(found, total @ grid.weights_cm1.T, rtol=plan.budget.wavenumbers)


def test_a_scene_of_which_all_terms_are_left_out_is_black():
    every = ["cloud_emission", "cloud_reflected_sun", "sea_emission", "sea_reflected_sun", "path_emission"]
    every += ["reflected_air_emission", "path_scattered_sun"]
    black = {"radiance.model": "physical-two-stream", "radiance.parameters.leave_out": every}
    small = {"image.rows": 8, "image.columns": 8, "frames.count": 1, "bands": ["mwir-3.7"]}
    made = simulate(Scenario.load("stratus", {**CHEAP, **black, **small}))
    assert float(made.radiance.max()) == 0.0
