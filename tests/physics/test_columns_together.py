"""Columns of the model `physical` that are computed together are those computed one by one."""

import numpy as np
import pytest

import hcss_twin
from hcss_twin.models.radiance.physical.setting_columns import VALUES_TOGETHER

TWO_LAYERS = "cirrus-over-cumulus"
ONE_BY_ONE = {"image.rows": 8, "image.columns": 8, "frames.count": 1}
BANDS = {"bands": [[3.6, 4.1], [10.3, 11.3]]}


def columns_of(plan, count):
    """Thicknesses (N, L): each layer alone, both, the extremes, and repeated ones."""
    rng = np.random.default_rng(3)
    low = np.array([layer.thickness_min_m for layer in plan.layers])
    high = np.array([layer.thickness_max_m for layer in plan.layers])
    thickness = low * (high / low) ** rng.random((count, low.size))
    thickness[0], thickness[1] = low, high
    if low.size > 1:
        thickness[2::4, 0] = 0.0
        thickness[3::4, 1] = 0.0
    return np.concatenate((thickness, thickness[::-3]))


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("stratus", {}),
        ("stratus", {"time": "2024-04-20T02:30:00Z"}),
        ("stratus", {"clouds.base": 0.0}),
        ("stratus", {"atmosphere.provider": "table"}),
        ("stratus", {"radiance.model": "physical-two-stream"}),
        (TWO_LAYERS, {"radiance.model": "physical-two-stream"}),
    ],
    ids=["day", "night", "fog", "paths instead of amounts", "two-stream", "two layers"],
)
def test_columns_computed_together_are_those_computed_one_by_one(name, overrides):
    plan = hcss_twin.make_plan(hcss_twin.Scenario.load(name, ONE_BY_ONE | BANDS | overrides))
    sun = plan.sun_at(0.0)
    # So few that all columns with the same layers are one stack, and so many that they are several: how stacks are cut
    # depends on the number of layers alone.
    grid = plan.spectral_grid.wavenumber_cm1
    cases = ((grid[::8], 6, False), (grid, 9, True))
    for wavenumber, count, several in cases if not overrides or name == TWO_LAYERS else cases[:1]:
        thickness = columns_of(plan, count)
        if len(plan.layers) == 1:
            assert (len(thickness) > VALUES_TOGETHER // wavenumber.size) == several
        together = plan.assembly.cloudy(wavenumber, thickness, sun)
        total = sum(np.asarray(together[term]) for term in plan.assembly.model.terms)
        for row, own in enumerate(thickness):
            alone = plan.assembly.cloudy(wavenumber, own[None], sun)
            for term in plan.assembly.model.terms:
                away = np.abs(np.asarray(together[term])[row] - np.asarray(alone[term])[0])
                np.testing.assert_array_less(away, 1e-13 * total[row] + 1e-300, err_msg=term)
