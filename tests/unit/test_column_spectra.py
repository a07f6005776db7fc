"""Spectra of columns add up to band radiances, and a cube gives those of its scenario."""

import numpy as np
import pytest
from cheap import CHEAP

from hcss_twin import Scenario, column_spectra, make_plan, simulate
from hcss_twin.models.radiance.spectral_grid import SpectralGrid

SMALL = {**CHEAP, "image.rows": 4, "image.columns": 4, "frames.count": 1, "output.certificate": 0}


@pytest.fixture(scope="module")
def scenario():
    return Scenario.load("stratus", SMALL)


def test_spectra_integrate_to_the_band_radiance_of_their_columns(scenario):
    plan, found = make_plan(scenario), column_spectra(scenario, 30.0)
    assert found.thickness_m[0] == 0.0
    np.testing.assert_allclose(
        found.thickness_m[[1, -1], 0], [plan.layers[0].thickness_min_m, plan.layers[0].thickness_max_m]
    )
    sun = plan.sun_up_at(30.0)
    setting = plan.assembly.setting(sun)
    expected = SpectralGrid.reference_radiance(plan.assembly.model, setting, plan.spectral_grid, found.thickness_m)
    np.testing.assert_allclose(found.radiance @ found.weights_cm1.T, expected, rtol=1e-9)
    assert found.bands == tuple(band.name for band in plan.bands)


def test_a_cube_has_the_spectra_of_its_scenario(scenario, tmp_path):
    simulate(scenario, tmp_path / "c.nc").close()
    np.testing.assert_array_equal(column_spectra(tmp_path / "c.nc").radiance, column_spectra(scenario).radiance)
