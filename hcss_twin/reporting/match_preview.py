"""Picture of an image beside a simulation of it, and of their semivariances."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path

from hcss_twin.drafts import draft_of
from hcss_twin.errors import CatalogError
from hcss_twin.matching.cloud_image import CloudImage
from hcss_twin.matching.dimension_range import DimensionMatch
from hcss_twin.matching.match import Match
from hcss_twin.matching.structure import Structure

PIXELS_SHOWN = 1024
"""Longest side of a drawn panel in pixels; larger images are thinned."""

_PANEL_INCHES = 5.2

# Quantities in the title: those of eq 24, coverage and the two other dimensions.
_IN_TITLE = 7

# Of the simulation, and of the image beside it: told apart without colour by the marker.
_IMAGE, _SIMULATED = "#222222", "#d1495b"


def draw_match(match: Match, path: Path) -> None:
    """Draw the image, the simulation whose RMSE is the median, and both semivariances into a PNG file.

    Raises
    ------
    CatalogError
        If the file cannot be written.
    """
    seed = match.typical_seed
    rmse = match.rmse[match.seeds.index(seed)]
    values = ", ".join(
        f"{each.name} {each.image:.4g} / {each.simulated:.4g}" for each in match.quantities[:_IN_TITLE]
    )
    _draw(
        [
            (match.target.source, match.target.image),
            (
                f"simulated, seed {seed}: the median of {len(match.seeds)}, RMSE {rmse:.1%}",
                match.simulate(seed),
            ),
        ],
        f"mean RMSE of eq 24 {match.mean_rmse:.1%}; image / mean of simulations: {values}",
        (match.structure, match.simulated_structure),
        path,
    )


def draw_dimension(found: DimensionMatch, panels: Sequence[tuple[str, CloudImage]], path: Path) -> None:
    """Draw images with their titles, one of them with a wanted dimension, into a PNG file.

    Raises
    ------
    CatalogError
        If the file cannot be written.
    """
    low, high = found.wanted
    _draw(panels, f"{found.dimension} dimension {low:g} to {high:g} wanted", None, path)


def _draw(
    panels: Sequence[tuple[str, CloudImage]],
    title: str,
    structures: tuple[Structure, Structure] | None,
    path: Path,
) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    rows, columns = panels[0][1].level.shape
    count = len(panels) + (structures is not None)
    height = 0.95 * _PANEL_INCHES * min(max(rows / columns, 0.5), 2.0)
    figure = Figure(figsize=(count * _PANEL_INCHES, height + 1.1), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, count, squeeze=False)[0]
    step = max(1, -(-max(rows, columns) // PIXELS_SHOWN))
    for axis, (name, image) in zip(axes, panels, strict=False):
        size = image.pixel_size_m / 1e3
        axis.imshow(
            image.level[::step, ::step],
            extent=(0.0, columns * size, 0.0, rows * size),
            origin="lower",
            cmap="gray",
            vmin=0,
            vmax=255,
            interpolation="nearest",
        )
        axis.set_title("\n".join(textwrap.wrap(name, 62)), fontsize=8)
        axis.set_xlabel("x (km, east)", fontsize=8)
        axis.tick_params(labelsize=7)
    axes[0].set_ylabel("y (km, north)", fontsize=8)
    if structures is not None:
        axis = axes[-1]
        for structure, colour, name in zip(
            structures, (_IMAGE, _SIMULATED), ("image", "simulated"), strict=True
        ):
            axis.loglog(
                structure.lags, structure.along_x, "o-", color=colour, ms=4, lw=1.2, label=f"{name}, along x"
            )
            axis.loglog(
                structure.lags, structure.along_y, "^--", color=colour, ms=4, lw=1.2, label=f"{name}, along y"
            )
        axis.set_title("semivariance of the grey levels", fontsize=8)
        axis.set_xlabel("lag (pixels)", fontsize=8)
        axis.tick_params(labelsize=7)
        axis.legend(fontsize=7)
    figure.suptitle("\n".join(textwrap.wrap(title, 68 * count)), fontsize=9)
    with draft_of(path, CatalogError) as draft:
        figure.savefig(draft, dpi=110, format="png")
