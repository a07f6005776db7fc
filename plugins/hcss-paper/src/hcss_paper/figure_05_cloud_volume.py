"""Fig 5: cloud thickness computed from the fractal field, and the cloud in three dimensions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_paper.eq_5 import cloudy_pixels, fraction_value
from hcss_paper.figure_base import scenario_of
from hcss_paper.inputs import CLOUD_HEIGHTS_KM, in_words
from hcss_paper.reproduction import Check, Drawing, Reproduction, Row, judged
from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.providers import Array, Catalog
from hcss_twin.reports.cloud_volume import cloud_volume_figure

if TYPE_CHECKING:
    pass


TYPE = "cumulus"
COVERAGE = 0.3
SIDE_PIXELS = 400

LARGEST_OFF_M = 0.05
"""The single precision of the field gives an error of about 1 cm in 2.9 km."""


def eq_7(field: Array, cloudy: NDArray[np.bool_], thinnest_m: float, thickest_m: float) -> Array:
    """Return the thickness of eq 7 in metres, 0 where clear.

    Parameters
    ----------
    field : ndarray (rows, columns)
        V of eq 4.
    cloudy : ndarray of bool (rows, columns)
    thinnest_m, thickest_m : float
        Th_min and Th_max.
    """
    p = fraction_value(field)
    low, high = float(p[cloudy].min()), float(p[cloudy].max())
    mapped: Array = np.where(cloudy, thinnest_m + (thickest_m - thinnest_m) * (p - low) / (high - low), 0.0)
    return mapped


def figure_5(seed: int) -> Reproduction:
    """Return a three-dimensional cumulus field, with eq 7 checked at every pixel."""
    scenario = scenario_of(
        TYPE,
        "as-printed",
        {
            "title": "Cumulus of Table III",
            "image": {"rows": SIDE_PIXELS, "columns": SIDE_PIXELS, "pixel_size": 20.0},
            "clouds.coverage": COVERAGE,
            "output.variables": ["cloud_thickness", "cloud_top_altitude"],
            "seed": seed,
        },
    )
    generator: Any = make_plan(scenario).assembly.generators[0]
    every = slice(0, SIDE_PIXELS)
    field: Array = generator.field(0.0, every, every).astype(np.float64)
    cube = simulate(scenario)
    found, top = (cube[name][0].to_numpy().astype(np.float64) for name in ("cloud_thickness", "cloud_top_altitude"))
    cloudy = found > 0.0
    layer = Scenario.cloud_type(f"paper-{TYPE}", Catalog()).layer
    # The heights are those of Table III; the paper does not print the thinnest cloud.
    base_km, top_km = CLOUD_HEIGHTS_KM[TYPE]
    wanted = eq_7(field, cloudy, layer.thickness_min, 1e3 * (top_km - base_km))
    off = float(np.max(np.abs(found - wanted)))
    highest = cloudy_pixels(field, COVERAGE)
    base = (top - found)[cloudy]
    rows = [
        Row("coverage", "1", None, float(cloudy.mean())),
        Row("base", "km", base_km, float(np.median(base)) / 1e3),
        Row("highest top", "km", top_km, float(np.nanmax(top)) / 1e3),
        Row("thinnest cloud", "m", None, float(found[cloudy].min())),
        Row("thickest cloud", "m", 1e3 * (top_km - base_km), float(found.max())),
        Row("mean thickness of the cloudy pixels", "m", None, float(found[cloudy].mean())),
    ]
    flat = float(np.ptp(base))
    checks = (
        Check(f"difference from eq 7 at any pixel: {off:.1e} m, at most {LARGEST_OFF_M} m", off < LARGEST_OFF_M),
        Check("the pixels with the highest field values are cloudy", bool(np.array_equal(cloudy, highest))),
        Check(
            f"the base is flat: {flat:.1e} m between lowest and highest, at most {LARGEST_OFF_M} m",
            flat < LARGEST_OFF_M,
        ),
    )
    return judged(
        rows,
        checks,
        holds="Thickness agrees with eq 7 at every pixel, between the heights of Table III.",
        fails="Thickness differs from eq 7.",
        chosen=in_words(
            f"type {TYPE}, coverage {COVERAGE:.0%}, {SIDE_PIXELS} x {SIDE_PIXELS} pixels of 20 m: not stated",
            f"thinnest cloud {layer.thickness_min:g} m: Th_min is not printed",
        ),
        drawings=(
            Drawing(
                "Cumulus in three dimensions, in section, and by altitude",
                cloud_volume_figure(cube),
                "Steep clouds of different heights with a flat base over a blue sea; below, a vertical section and "
                "the cloud-covered fraction of the area at each altitude.",
            ),
        ),
    )
