"""Means of cubes of the shipped scenario ``baseline``, as ``hcss run`` makes them, for Tables II and IV to VII."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from hcss_paper.inputs import AssumedInput, Moment, assumed, coverage_of, in_words, published
from hcss_paper.scene import BANDS, COLUMNS, PHYSICAL, Model
from hcss_twin import Scenario, simulate
from hcss_twin.providers import Array

SIDE_PIXELS, SIDE_M = 100, 16_000.0
"""Of the cubes: their mean differs by 1e-4 from that of 800 pixels along the same side."""

ACCURACY = {"as-printed": 1e-3, "physical": 1e-2}

NADIR_CHOICE = "nadir view, although section IV-A states 20 deg"

SCENE_CHOICES = (
    "clouds with base and top of cumulus (66 m and 3 km, Table III), not of simulated, at the temperature of the air",
    "no sunlight reflected by the cloud: the printed rows do not include eq 16",
)


@lru_cache(maxsize=256)
def cube_mean(model: Model, coverage: float, view_zenith_deg: float = 0.0, moment: Moment | None = None) -> Array:
    """Return the mean radiance (bands,) of a cube of scenario ``baseline``, in the bands of :data:`BANDS`.

    Parameters
    ----------
    model : {"as-printed", "physical"}
    coverage : float
    view_zenith_deg : float
    moment : Moment, optional
        Another time and place than the scenario's. The cube then has 3-5 um alone, (1,).
    """
    changes: dict[str, Any] = {
        **COLUMNS,
        "bands": list(BANDS.values()),
        "clouds.coverage": coverage,
        "view.zenith": view_zenith_deg,
        "frames.count": 1,
        "image": {"rows": SIDE_PIXELS, "columns": SIDE_PIXELS, "pixel_size": SIDE_M / SIDE_PIXELS},
        "accuracy": ACCURACY[model],
        "output.certificate": 0,
    }
    if moment is not None:
        site = {"latitude": moment.latitude_deg, "longitude": moment.longitude_deg}
        changes |= {"bands": [BANDS["3.0-5.0"]], "time": moment.time.isoformat(), "place": site}
    if model == "physical":
        changes |= PHYSICAL
    radiance = simulate(Scenario.load("baseline", changes)).radiance
    means: Array = radiance.astype(np.float64).mean(dim=[name for name in radiance.dims if name != "band"]).to_numpy()
    return means


def over_views(model: Model, row: str, band: str) -> Array:
    """Return a row (views,) of Table II or IV at its coverage; ``band`` is a key of :data:`BANDS`."""
    views, band_index = published()["view_zenith_deg"], list(BANDS).index(band)
    return np.array([cube_mean(model, coverage_of(row), float(view))[band_index] for view in views])


def over_moments(model: Model, row: str, moments: Sequence[Moment]) -> Array:
    """Return the radiance (moments,) of Table V or VI: 3-5 um, seen from above."""
    return np.array([cube_mean(model, coverage_of(row), 0.0, moment)[0] for moment in moments])


def over_coverages(model: Model, coverages: Sequence[float]) -> Array:
    """Return the radiance (coverages,) of Table VII: 3-5 um, seen from above."""
    band_index = list(BANDS).index("3.0-5.0")
    return np.array([cube_mean(model, float(coverage))[band_index] for coverage in coverages])


def scene_inputs(*choices: str) -> tuple[AssumedInput, ...]:
    """Return what the cubes assume, for a reproduction."""
    return (*assumed(["sea temperature", "glint scale", "water content"]), *in_words(*SCENE_CHOICES, *choices))
