"""Images of the ``simulated`` cloud type as in Tables VIII and IX, and what the paper measures of them."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.analysis.measures.morphology import Morphology, morphology
from hcss_twin.models.clouds.coverage import cloud_fraction_value, cloudy_pixels
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.scenario.scenario import Scenario

SEED = 1
"""Of the images to which inputs are fitted, and the command's default."""

IMAGES = 8
"""Over so many skies measures are averaged: one standard deviation of a single one is 1 % of Den and DP, .03 of FD."""

MEASURES = ("EV", "Den", "DP", "FD")


@lru_cache(maxsize=2 * IMAGES)
def cloud_field(cloud_type: str, seed: int) -> NDArray[Any]:
    """Return eqs 2 and 3 for 800 x 800 pixels of 20 m, (800, 800)."""
    loaded = Scenario.load(
        "baseline", {"clouds.type": cloud_type, "seed": seed, "frames.count": 1, "output.variables": ["cloud_mask"]}
    )
    generator: Any = make_plan(loaded).assembly.generators[0]
    rows, columns = loaded.image.rows, loaded.image.columns
    field: NDArray[Any] = generator.field(0.0, slice(0, rows), slice(0, columns))
    return field


def cloud_mask(cloud_type: str, coverage: float, seed: int) -> NDArray[np.bool_]:
    """Return the cloudy pixels of one sky."""
    mask: NDArray[np.bool_] = cloudy_pixels(cloud_field(cloud_type, seed), coverage)
    return mask


@lru_cache(maxsize=8 * IMAGES)
def measured(cloud_type: str, coverage: float, seed: int) -> Morphology:
    """Return the measures of one sky."""
    field = cloud_field(cloud_type, seed)
    return morphology(cloud_fraction_value(field), cloudy_pixels(field, coverage))


def mean_measures(cloud_type: str, coverage: float, seed: int) -> dict[str, float]:
    """Return EV, Den, DP and FD as the paper prints them, means over :data:`IMAGES` skies from ``seed`` on.

    The paper prints ten times the density of eq 22, which cannot exceed 1.
    """
    found = [measured(cloud_type, coverage, seed + place) for place in range(IMAGES)]
    return {
        "EV": float(np.mean([each.entropy for each in found])),
        "Den": 10.0 * float(np.mean([each.density for each in found])),
        "DP": float(np.mean([each.diagonal_peak for each in found])),
        "FD": float(np.mean([each.fractal_dimension for each in found])),
    }
