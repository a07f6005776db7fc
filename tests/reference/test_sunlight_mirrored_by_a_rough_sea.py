"""Sunlight that thin clouds scatter and a rough sea mirrors, against discrete ordinates with all 128 moments.

Scenes and reference values are those of the campaign ``glint``, which also has a Monte Carlo of them.
"""

import csv
import sys
from pathlib import Path

import numpy as np
import pytest

from hcss_twin.models.radiance.physical import sunlight_between

CAMPAIGN = Path(__file__).parents[1] / "campaign" / "glint"
FINEST_SUNLIGHT = 6
"""Level of sunlight toward the sensor; at level 1, with 6 streams and 12 moments, all else depended on their number."""


@pytest.fixture(scope="module")
def campaign():
    sys.path.insert(0, str(CAMPAIGN))
    try:
        import glint_product
        import glint_scenes

        with (CAMPAIGN / "results.csv").open(encoding="utf-8") as file:
            exact = {int(row["scene"]): float(row["discrete_ordinates"]) for row in csv.DictReader(file)}
        yield glint_product.product, glint_scenes.glint_scenes(), exact
    finally:
        sys.path.remove(str(CAMPAIGN))


def error(campaign, number, level):
    product, scenes, exact = campaign
    sunlight, share = product(scenes[number], level, FINEST_SUNLIGHT - level)
    return share * abs(sunlight / exact[number] - 1.0)


@pytest.mark.parametrize(
    ("number", "level"),
    [*((0, 1), (9, 1), (10, 4)), *(pytest.param(n, 4, marks=pytest.mark.campaign) for n in range(20) if n != 10)],
)
def test_a_glint_through_thin_cloud_has_the_radiance_of_discrete_ordinates(campaign, number, level):
    assert error(campaign, number, level) < 1e-3


def test_without_the_peak_the_radiance_is_wrong(campaign, monkeypatch):
    def nothing(slabs, where, mirror, sea, beams, direct):
        return np.zeros((2, direct.shape[-1]))

    monkeypatch.setattr(sunlight_between, "mirrored", nothing)
    assert error(campaign, 0, 1) > 3e-3
