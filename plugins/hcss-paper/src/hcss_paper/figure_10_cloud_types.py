"""Fig 10: four cloud types over the sea, and the sea surface elevation."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import ndtri

from hcss_paper.figure_base import PANEL_PIXELS, blank, reduced, shades, simulated
from hcss_paper.inputs import CLOUD_HEIGHTS_KM, in_words
from hcss_paper.reproduction import Check, Drawing, Reproduction, Row, judged
from hcss_paper.sea_surface import elevation_variance_m2, significant_wave_height_m, surface_elevation
from hcss_twin import Scenario
from hcss_twin.providers import Array, Catalog

if TYPE_CHECKING:
    from matplotlib.figure import Figure


TYPES = ("cumulus", "stratocumulus", "cirrus", "simulated")
STRATOCUMULUS_KM = (0.6, 1.0)
"""Heights of the type that Table III lacks: those of research flight 1 of DYCOMS-II."""

COVERAGE = 0.5
SIDE_PIXELS = 800
PIXEL_M = 20.0
WIND_M_S = 10.0
WAVES = 200
"""Components of the drawn sea."""

LARGEST_M = 2.5
"""Largest undulation of the sea stated in the text for Fig 10."""


def thickness(kind: str, seed: int, size: int = SIDE_PIXELS) -> Array:
    """Return one frame of geometric thickness (size, size) in metres; 20 m pixels."""
    base_km, top_km = CLOUD_HEIGHTS_KM.get(kind, STRATOCUMULUS_KM)
    cube = simulated(
        "stratus",
        "as-printed",
        {
            "clouds.type": _catalog_name(kind),
            "clouds.base": 1e3 * base_km,
            "clouds.top": 1e3 * top_km,
            "clouds.coverage": COVERAGE,
            "image": {"rows": size, "columns": size, "pixel_size": PIXEL_M},
            "output.variables": ["cloud_thickness"],
            "seed": seed,
        },
    )
    values: Array = cube.cloud_thickness.isel(time=0).to_numpy().astype(np.float64)
    return values


def _catalog_name(kind: str) -> str:
    """Return the cloud type of the catalog with the shape that the paper prints."""
    return f"paper-{kind}" if kind in CLOUD_HEIGHTS_KM else kind


def sea(seed: int, size: int = SIDE_PIXELS) -> Array:
    """Return the elevation of the sea at the pixels (size, size), metres."""
    places = PIXEL_M * np.arange(size, dtype=np.float64)
    return surface_elevation(places[None, :], places[:, None], 0.0, WIND_M_S, 270.0, seed, components=WAVES)


def figure_10(seed: int, size: int = SIDE_PIXELS) -> Reproduction:
    """Return four types of cloud over the sea.

    Parameters
    ----------
    seed : int
    size : int
        Pixels along a side; the paper has 800.
    """
    clouds = {kind: thickness(kind, seed, size) for kind in TYPES}
    surface = sea(seed, size)
    rows: list[Row] = [Row("pixels along a side", "1", 800.0, float(size)), Row("pixel", "m", 20.0, PIXEL_M)]
    within, covered, catalog = True, True, Catalog()
    for kind, values in clouds.items():
        cloudy = values > 0.0
        base_km, top_km = CLOUD_HEIGHTS_KM.get(kind, STRATOCUMULUS_KM)
        printed = (base_km, top_km) if kind in CLOUD_HEIGHTS_KM else (None, None)
        rows += [
            Row(f"{kind}, base", "km", printed[0], base_km),
            Row(f"{kind}, highest top", "km", printed[1], base_km + float(values.max()) / 1e3),
        ]
        thinnest = Scenario.cloud_type(_catalog_name(kind), catalog).layer.thickness_min
        least = float(values[cloudy].min()) - thinnest
        most = float(values.max()) - 1e3 * (top_km - base_km)
        within &= max(abs(least), abs(most)) < 0.01
        covered &= abs(float(cloudy.mean()) - COVERAGE) <= 0.5 / values.size
    off = max(abs(row.difference or 0.0) for row in rows)
    highest = float(np.max(np.abs(surface)))
    expected = expected_highest_m(surface.size)
    rows += [
        Row(f"largest undulation of the sea at {WIND_M_S:g} m/s", "m", LARGEST_M, highest),
        Row("the same, expected of as many independent points", "m", LARGEST_M, expected),
        Row("significant wave height", "m", None, significant_wave_height_m(WIND_M_S)),
    ]
    checks = (
        Check(f"image size and heights of Table III: largest difference {off:.1e}, at most 1e-5", off < 1e-5),
        Check("thickness spans the full range of eq 7 in every type, within 1 cm", bool(within)),
        Check(f"coverage {COVERAGE:.0%} in every type, exact to one pixel", bool(covered)),
        Check(
            f"largest undulation {highest:.2f} m, printed as around {LARGEST_M} m: within 15 %",
            abs(highest / LARGEST_M - 1.0) < 0.15,
        ),
    )
    return judged(
        rows,
        checks,
        holds="Image size, resolution, heights and the largest sea elevation agree with the printed values.",
        fails="Image size, heights, coverage or sea elevation differ from the printed values.",
        chosen=in_words(
            f"coverage {COVERAGE:.0%}: not stated",
            "stratocumulus is not in Table III: gamma 3, H .333, L [2, 2], k 0-7, 600-1000 m from published "
            "measurements (catalog)",
        ),
        notes=(
            f"The significant wave height at 10 m/s is {significant_wave_height_m(WIND_M_S):.2f} m, "
            "sea state 4; the paper states sea state 5 (2.5 to 4 m) and compares it with the largest elevation, a "
            "different quantity.",
            f"The sea in the figure has {WAVES} waves of eq 1; the pixels are larger than the wavelengths.",
        ),
        drawings=(
            Drawing(
                "Four cloud types",
                drawn(clouds),
                "Four panels of cloud over a dark sea: small cumulus, a ragged layer, streaks, large smooth clouds.",
            ),
            Drawing(
                "A 500 m section of the sea surface with 2.5 m pixels",
                _drawn_sea(seed),
                "Wave crests perpendicular to the west wind, up to 2 m high.",
            ),
        ),
    )


def drawn(clouds: dict[str, Array], most: int = PANEL_PIXELS) -> Figure:
    """Draw the thickness of four cloud types over a dark sea, with at most ``most`` pixels along a side."""
    figure = blank(8.6, 7.6)
    for letter, axis, (kind, values) in zip("abcd", figure.subplots(2, 2).ravel(), clouds.items(), strict=True):
        side_km = PIXEL_M * values.shape[0] / 1e3
        shown = np.ma.masked_equal(reduced(values, most), 0.0)
        darkest = -0.3 * float(values.max())
        image = axis.imshow(
            shown,
            origin="lower",
            cmap=shades("bone"),
            vmin=darkest,
            vmax=values.max(),
            extent=(0.0, side_km, 0.0, side_km),
        )
        axis.set_facecolor("#0b2a4a")
        axis.set_title(f"({letter}) {kind}", fontsize=11)
        axis.set_xlabel("x (km)")
        axis.set_ylabel("y (km)")
        bar = figure.colorbar(image, ax=axis, shrink=0.85, label="thickness (m)")
        bar.ax.set_ylim(0.0, float(values.max()))
    figure.suptitle(f"800 x 800 pixels of 20 m, coverage {COVERAGE:.0%}, parameters of the catalog", fontsize=10)
    return figure


def _drawn_sea(seed: int) -> Figure:
    figure = blank(5.2, 4.2)
    axis = figure.subplots()
    places = 2.5 * np.arange(200, dtype=np.float64)
    values = surface_elevation(places[None, :], places[:, None], 0.0, WIND_M_S, 270.0, seed, components=WAVES)
    image = axis.imshow(values, origin="lower", cmap=shades("Blues_r"), extent=(0.0, 0.5, 0.0, 0.5))
    axis.set(xlabel="x (km)", ylabel="y (km)", title=f"wind {WIND_M_S:g} m/s from the west")
    figure.colorbar(image, ax=axis, label="elevation (m)")
    return figure


def expected_highest_m(count: int) -> float:
    """Return the highest elevation to expect in an image of the sea: that of as many independent points.

    Parameters
    ----------
    count : int
        Number of points, normal with the variance of eq 1.

    Returns
    -------
    float
        Median of the largest absolute value: m deviations, where 2 (1 - Phi)(m) = 1 - 2^(-1/count).
    """
    quantile: Any = ndtri(1.0 - 0.5 * (1.0 - 0.5 ** (1.0 / count)))
    return math.sqrt(elevation_variance_m2(WIND_M_S)) * float(quantile)
