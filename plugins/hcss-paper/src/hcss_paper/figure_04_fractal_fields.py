"""Fig 4: effect of the parameters of the fractal field."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from hcss_evaluate.measures.fractal_dimension import variogram_dimension
from hcss_evaluate.measures.semivariance import semivariances

from hcss_paper.eq_5 import fraction_value
from hcss_paper.figure_base import blank, reduced, scenario_of, shades
from hcss_paper.inputs import in_words
from hcss_paper.reproduction import Check, Drawing, Reproduction, Row, judged
from hcss_twin import make_plan
from hcss_twin.models.clouds.fractal.expected_variogram import KernelCorrelation
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure


PIXEL_M = 20.0

FIXED: dict[str, Any] = {"gamma": 2.0, "H": 0.5, "L": [5, 5], "k": [0, 6]}
"""Parameters that a row does not change; the paper does not state them."""

ROWS: tuple[tuple[tuple[str, dict[str, Any]], ...], ...] = (
    tuple((f"γ = {gamma}", {"gamma": float(gamma), "k": [0, 4]}) for gamma in (2, 3, 4)),
    tuple((f"H = {hurst}", {"H": hurst}) for hurst in (0.1, 0.5, 0.8)),
    tuple((f"L = [{cells}, {cells}]", {"L": [cells, cells]}) for cells in (5, 20, 50)),
    tuple((f"kmax = {last}", {"k": [0, last]}) for last in (0, 2, 4)),
)
"""Each row of the figure changes one parameter; with the paper's values."""

LAGS = ((1, 2), (4, 8, 16, 32), (4, 8, 16, 32), (4, 8, 16, 32))
"""Lags in pixels at which the dimension of each row is measured; gamma affects the finest detail."""

LARGEST_OFF = 0.1
"""Largest deviation of the dimension: four standard deviations of individual images with large cells."""

LARGEST_LENGTH_OFF = 0.35
"""Relative; fields with L = 5 have only five cells along a side and vary strongly."""

_ALL_LAGS = tuple(range(1, 400))


def field(change: dict[str, Any], seed: int) -> Array:
    """Return V of eq 2 (800, 800) in pixels of 20 m, with one parameter changed."""
    scenario = scenario_of(
        "stratus",
        "as-printed",
        {
            "clouds.parameters": {**FIXED, **change},
            "image.pixel_size": PIXEL_M,
            "output.variables": ["cloud_mask"],
            "seed": seed,
        },
    )
    generator: Any = make_plan(scenario).assembly.generators[0]
    values: Array = generator.field(0.0, slice(0, 800), slice(0, 800)).astype(np.float64)
    return values


def figure_4(seed: int) -> Reproduction:
    """Return the twelve fields with their fractal dimensions, measured and expected."""
    panels = [[(title, change, field(change, seed)) for title, change in row] for row in ROWS]
    kernel = KernelCorrelation.tabulate()
    rows, found, expected = [], [], []
    letters = iter("abcdefghijkl")
    for lags, row in zip(LAGS, panels, strict=True):
        over = f"lags of {PIXEL_M * lags[0]:g} to {PIXEL_M * lags[-1]:g} m"
        for title, change, values in row:
            found.append(variogram_dimension(values, lags).dimension)
            expected.append(_expected_dimension(change, lags, kernel))
            rows.append(Row(f"({next(letters)}) {title}: fractal dimension, {over}", "1", None, found[-1]))
    of_gamma, of_hurst, _, of_last = (found[start : start + 3] for start in (0, 3, 6, 9))
    cells = [float(change["L"][0]) for _, change in ROWS[2]]
    lengths_m = [PIXEL_M * _half_length(values) for _, _, values in panels[2]]
    for (title, _), length in zip(ROWS[2], lengths_m, strict=True):
        rows.append(Row(f"{title}: lag of half the variance", "m", None, length))
    off = float(np.max(np.abs(np.array(found) - expected)))
    scaled = np.array(lengths_m) * cells
    uneven = float(np.max(np.abs(scaled / scaled[-1] - 1.0)))
    checks = (
        Check(f"H .1, .5, .8: increasingly smooth, dimension {_listed(of_hurst)}", _falls(of_hurst), "section III-A"),
        Check(f"γ 2, 3, 4: more detail, dimension {_listed(of_gamma)}", _falls(of_gamma[::-1]), "section III-A"),
        Check(f"kmax 0, 2, 4: more detail, dimension {_listed(of_last)}", _falls(of_last[::-1])),
        Check(
            f"L 5, 20, 50: increasingly small structures; lag of half the variance times L varies by "
            f"{100 * uneven:.0f} %, at most {100 * LARGEST_LENGTH_OFF:.0f} %",
            uneven < LARGEST_LENGTH_OFF and _falls(lengths_m),
        ),
        Check(
            f"difference from the dimension of eq 2's variogram in closed form: {off:.3f}, at most {LARGEST_OFF}",
            off < LARGEST_OFF,
        ),
    )
    return judged(
        rows,
        checks,
        holds="Each parameter has the effect that the text describes: gamma and kmax add detail, H smooths, L sets "
        "the number of cells.",
        fails="A parameter does not have the effect that the text describes.",
        chosen=in_words(
            "fixed parameters of each row: gamma 2, H .5, L [5, 5], k 0-6 (first row k 0-4), not stated",
            "L is the number of lattice cells per 16 km (800 pixels of 20 m): the text does not define it",
        ),
        drawings=(
            Drawing(
                "Fractal fields p of eq 5, 800 x 800 pixels of 20 m",
                drawn([[(title, values) for title, _, values in row] for row in panels]),
                "Twelve grey textures in four rows: finer grain with larger gamma, smoother with larger H, smaller "
                "blobs with larger L, from blobs to detail with larger kmax.",
            ),
        ),
    )


def drawn(panels: list[list[tuple[str, Array]]], most: int = 100) -> Figure:
    """Draw V mapped to p, each panel with its title and at most ``most`` pixels along a side."""
    figure = blank(5.4, 7.5)
    axes = figure.subplots(4, 3)
    flat = [panel for row in panels for panel in row]
    for letter, axis, (title, values) in zip("abcdefghijkl", axes.ravel(), flat, strict=True):
        p = reduced(fraction_value(values), most)
        shown = (p - p.min()) / (p.max() - p.min())
        image = axis.imshow(shown, origin="lower", cmap=shades(), vmin=0, vmax=1)
        axis.set_title(f"({letter}) {title}", fontsize=10)
        axis.set_xticks([])
        axis.set_yticks([])
    figure.colorbar(
        image, ax=axes, shrink=0.5, label="p of eq 5, from minimum to maximum", location="bottom", aspect=40, pad=0.01
    )
    figure.suptitle(
        f"otherwise γ = {FIXED['gamma']:g}, H = {FIXED['H']}, L = {FIXED['L']}, k = {FIXED['k'][0]}-{FIXED['k'][1]} "
        "(first row: k = 0-4)",
        fontsize=9,
    )
    return figure


def _expected_dimension(change: dict[str, Any], lags: tuple[int, ...], kernel: KernelCorrelation) -> float:
    """Return 3 minus half the slope of eq 2's variogram over ``lags``, along the axes."""
    parameters = FractalParameters.model_validate({**FIXED, **change})
    values = kernel.expected_variogram(parameters, PIXEL_M, lags, np.zeros(len(lags)))
    return float(3.0 - 0.5 * np.polyfit(np.log(lags), np.log(values), 1)[0])


def _half_length(values: Array) -> float:
    """Return the lag in pixels at which the semivariance of V, which has unit variance, first reaches 0.5."""
    pooled = semivariances(values, _ALL_LAGS).pooled
    lag = int(np.argmax(pooled >= 0.5))
    if pooled[lag] < 0.5:
        return float(_ALL_LAGS[-1])
    before = pooled[lag - 1] if lag else 0.0
    return lag + float((0.5 - before) / (pooled[lag] - before))


def _falls(values: list[float]) -> bool:
    return bool(np.all(np.diff(values) < 0))


def _listed(values: list[float]) -> str:
    return ", ".join(f"{value:.2f}" for value in values)
