"""Draw the panels of Figs 4 and 10 of the HCSS paper with the public interface.

::

    python docs/figures/fractal_panels.py FOLDER

writes ``fig4.png`` (gamma, H, L and kmax varied one at a time) and ``fig10.png`` (four cloud types). The paper does not
say what it held fixed in Fig 4, nor the coverage of Fig 10; what is used here stands in the pictures.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import hcss_twin

FIXED: dict[str, Any] = {"gamma": 2.0, "H": 0.5, "L": [5, 5], "k": [0, 6]}

# Each row changes one parameter; the ends of a series are those of the paper.
ROWS: tuple[tuple[tuple[str, dict[str, Any]], ...], ...] = (
    tuple((f"γ = {gamma}", {"gamma": float(gamma), "k": [0, 4]}) for gamma in (2, 3, 4)),
    tuple((f"H = {hurst}", {"H": hurst}) for hurst in (0.1, 0.5, 0.8)),
    tuple((f"L = [{cells}, {cells}]", {"L": [cells, cells]}) for cells in (5, 20, 50)),
    tuple((f"kmax = {last}", {"k": [0, last]}) for last in (0, 2, 4)),
)

TYPES = ("cumulus", "stratocumulus", "cirrus", "simulated")
COVERAGE = 0.5


def thickness(kind: str, coverage: float, parameters: dict[str, Any]) -> np.ndarray:
    """Return one frame of geometric thickness (800, 800) in metres; 20 m pixels."""
    scenario = hcss_twin.Scenario.load(
        "stratus",
        {
            "clouds.type": kind,
            "clouds.coverage": coverage,
            "clouds.parameters": parameters,
            "frames.count": 1,
            "bands": ["lwir"],
            "output.variables": ["cloud_thickness"],
        },
    )
    cube = hcss_twin.simulate(scenario)
    return cube.cloud_thickness.isel(time=0).to_numpy()


def draw_fig4(path: Path) -> None:
    """Draw the field p itself: at full coverage thickness is linear in p."""
    figure = Figure(figsize=(9.0, 12.4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(4, 3)
    for letter, axis, (title, change) in zip(
        "abcdefghijkl", axes.ravel(), (panel for row in ROWS for panel in row), strict=True
    ):
        values = thickness("stratus", 1.0, {**FIXED, **change})
        image = axis.imshow(
            (values - values.min()) / (values.max() - values.min()),
            origin="lower",
            cmap="gray",
            vmin=0,
            vmax=1,
        )
        axis.set_title(f"({letter}) {title}", fontsize=11)
        axis.set_xticks([])
        axis.set_yticks([])
    figure.colorbar(image, ax=axes, shrink=0.35, label="p of eq 5", location="bottom", aspect=40, pad=0.01)
    figure.suptitle(
        f"800 x 800 pixels of 20 m; otherwise γ = {FIXED['gamma']:g}, H = {FIXED['H']}, L = {FIXED['L']}, "
        f"k = {FIXED['k'][0]}-{FIXED['k'][1]} (first row: k = 0-4)",
        fontsize=10,
    )
    figure.savefig(path, dpi=110)


def draw_fig10(path: Path) -> None:
    """Draw the thickness of four cloud types over a dark sea."""
    extent = (0.0, 16.0, 0.0, 16.0)
    figure = Figure(figsize=(11.0, 10.0), layout="constrained")
    FigureCanvasAgg(figure)
    for letter, axis, kind in zip("abcd", figure.subplots(2, 2).ravel(), TYPES, strict=True):
        values = thickness(kind, COVERAGE, {})
        shown = np.ma.masked_equal(values, 0.0)
        darkest = -0.3 * float(values.max())
        image = axis.imshow(shown, origin="lower", cmap="bone", vmin=darkest, extent=extent)
        axis.set_facecolor("#0b2a4a")
        axis.set_title(f"({letter}) {kind}", fontsize=11)
        axis.set_xlabel("x (km)")
        axis.set_ylabel("y (km)")
        bar = figure.colorbar(image, ax=axis, shrink=0.85, label="thickness (m)")
        bar.ax.set_ylim(0.0, float(values.max()))
    figure.suptitle(
        f"800 x 800 pixels of 20 m, coverage {COVERAGE:.0%}, parameters of the catalog", fontsize=10
    )
    figure.savefig(path, dpi=110)


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit("usage: python docs/figures/fractal_panels.py FOLDER")
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    draw_fig4(folder / "fig4.png")
    draw_fig10(folder / "fig10.png")


if __name__ == "__main__":
    main()
