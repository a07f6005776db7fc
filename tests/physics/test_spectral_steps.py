"""Clouds of dense spectra are solved at few wavenumbers: what lies between them agrees with clouds solved there."""

import dataclasses

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.laws.samples import sample_high_layer, sample_layer, sample_radiance_inputs
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.parameters import PhysicalParameters
from hcss_twin.models.radiance.physical.model import Physical
from hcss_twin.models.radiance.physical.numerics import LEVELS
from hcss_twin.models.radiance.physical.operator_table import DENSE, spectral_steps
from hcss_twin.providers import OpticsInputs, Sun, cloudy_columns
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.providers.registry.specs import Kind

SUN = Sun(40.0, 100.0, 1.0)
GRID = np.concatenate((np.arange(1000.0, 1201.0, 5.0), np.arange(2400.0, 2601.0, 5.0)))


def bent(wavenumber_cm1):
    """A property with a kink."""
    return (1e-3 * wavenumber_cm1 + np.abs(wavenumber_cm1 - 2503.0) * 2e-3)[None]


def test_what_lies_between_solved_wavenumbers_is_within_the_tolerance():
    steps = spectral_steps(GRID, bent, 1e-3)
    assert steps.wavenumber_cm1.size < 0.5 * GRID.size
    operator = np.exp(0.5 * bent(steps.wavenumber_cm1))
    np.testing.assert_allclose(steps.spread(operator), np.exp(0.5 * bent(GRID)), rtol=2e-3)


def test_a_grid_and_its_refinement_solve_the_same_wavenumbers():
    between = np.union1d(0.5 * (GRID[1:] + GRID[:-1])[np.diff(GRID) == 5.0], GRID[[0, 40, 41, -1]])
    coarse, fine = (spectral_steps(each, bent, 1e-3) for each in (GRID, between))
    np.testing.assert_array_equal(coarse.wavenumber_cm1, fine.wavenumber_cm1)


@pytest.mark.parametrize(("grid", "tolerance"), [(GRID, 0.0), (GRID[: DENSE - 1], 1e-3)], ids=["exact", "sparse"])
def test_sparse_grids_and_exact_levels_solve_every_wavenumber(grid, tolerance):
    assert spectral_steps(grid, bent, tolerance).spread(grid) is grid


@pytest.mark.parametrize("layer", [sample_layer(), sample_high_layer()], ids=["water", "ice"])
@pytest.mark.parametrize("sun", [SUN, None], ids=["day", "night"])
def test_radiance_of_a_dense_spectrum_is_that_of_clouds_solved_everywhere(layer, sun, monkeypatch):
    registry, profile = Registry.defaults_only(), load_profile("us-standard-1976", Catalog())
    entry = registry.resolve(Kind.OPTICS, "bulk")
    optics = registry.create(entry, OpticsInputs(Catalog()), registry.parameters_model(entry)())
    inputs = dataclasses.replace(sample_radiance_inputs(profile, (layer,)), optics=optics, numerical_level=0)
    thickness, setting = (
        np.geomspace(layer.thickness_min_m, layer.thickness_max_m, 5)[:, None],
        inputs.setting.under(sun),
    )

    def radiance():
        return sum(cloudy_columns(Physical(inputs, PhysicalParameters()), setting, GRID, thickness).values())

    few = radiance()
    monkeypatch.setattr(
        "hcss_twin.models.radiance.physical.numerics.LEVELS",
        tuple(dataclasses.replace(each, between_wavenumbers=0.0) for each in LEVELS),
    )
    monkeypatch.setattr("hcss_twin.models.radiance.physical.numerics.COARSEST", {})
    every = radiance()
    assert np.any(few != every)
    np.testing.assert_allclose(few, every, rtol=2e-3)
    np.testing.assert_allclose(np.sum(few, axis=1), np.sum(every, axis=1), rtol=1e-4)
