"""Picture of an image beside a simulation of it, and of their semivariances.

Picture of a database entry: the image, the outline of its mask, and the single clouds.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hcss_twin.analysis.matching.dimension_range import DimensionMatch
from hcss_twin.analysis.matching.match import Match
from hcss_twin.analysis.matching.structure import CloudImage, Structure
from hcss_twin.core.errors import CatalogError
from hcss_twin.core.files import atomic_write
from hcss_twin.models.clouds.database import CloudEntry

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
    values = ", ".join(f"{each.name} {each.image:.4g} / {each.simulated:.4g}" for each in match.quantities[:_IN_TITLE])
    _draw(
        [
            (match.target.source, match.target.image),
            (f"simulated, seed {seed}: the median of {len(match.seeds)}, RMSE {rmse:.1%}", match.simulate(seed)),
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
    panels: Sequence[tuple[str, CloudImage]], title: str, structures: tuple[Structure, Structure] | None, path: Path
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
        for structure, colour, name in zip(structures, (_IMAGE, _SIMULATED), ("image", "simulated"), strict=True):
            axis.loglog(structure.lags, structure.along_x, "o-", color=colour, ms=4, lw=1.2, label=f"{name}, along x")
            axis.loglog(structure.lags, structure.along_y, "^--", color=colour, ms=4, lw=1.2, label=f"{name}, along y")
        axis.set_title("semivariance of the grey levels", fontsize=8)
        axis.set_xlabel("lag (pixels)", fontsize=8)
        axis.tick_params(labelsize=7)
        axis.legend(fontsize=7)
    figure.suptitle("\n".join(textwrap.wrap(title, 68 * count)), fontsize=9)
    with atomic_write(path, CatalogError) as draft:
        figure.savefig(draft, dpi=110, format="png")


"""Longest side of a drawn panel in pixels; larger images are thinned."""

# Neighbours in the list differ, and numbers that are next to each other get neighbours of the list.
_COLOURS = "tab20"
_COLOUR_COUNT = 20


def draw_entry(entry: CloudEntry, name: str, path: Path) -> None:
    """Draw an entry into a PNG file.

    Raises
    ------
    CatalogError
        If the file cannot be written.
    """
    from matplotlib import colormaps
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    facts = entry.facts
    rows, columns = entry.grey.shape
    step = max(1, -(-max(rows, columns) // PIXELS_SHOWN))
    thin = (slice(None, None, step), slice(None, None, step))
    extent = (0.0, columns * facts.pixel_size_m / 1e3, 0.0, rows * facts.pixel_size_m / 1e3)
    panel = 5.2
    height = 0.9 * panel * min(max(rows / columns, 0.3), 2.0)
    figure = Figure(figsize=(3 * panel, height + 1.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, 3, sharex=True, sharey=True)
    image = entry.image[thin]
    hatch = np.ma.masked_where(~entry.missing[thin], np.ones(image.shape))
    for axis, title in zip(axes, ("image", "outline of the mask", "single clouds"), strict=True):
        axis.set_title(title, fontsize=9)
        axis.tick_params(labelsize=7)
    for axis in axes[:2]:
        axis.imshow(image, extent=extent, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
        axis.imshow(hatch, extent=extent, cmap="cool", vmin=0, vmax=1, interpolation="nearest")
    axes[1].contour(
        entry.mask[thin].astype(np.float64),
        levels=[0.5],
        extent=extent,
        origin="upper",
        colors="#ff3b1f",
        linewidths=0.7,
    )
    axes[2].imshow(_coloured(entry.labels[thin], colormaps[_COLOURS]), extent=extent, interpolation="nearest")
    figure.supxlabel("x (km, east)", fontsize=9)
    figure.supylabel("y (km, north)", fontsize=9)
    figure.suptitle(_title(entry, name), fontsize=9)
    with atomic_write(path, CatalogError) as draft:
        figure.savefig(draft, dpi=110, format="png")


def _coloured(labels: NDArray[np.int32], colours: object) -> NDArray[np.float64]:
    """Return red, green, blue and opacity (rows, columns, 4): a colour for each cloud on black."""
    # 7 and 20 have no common divisor: clouds that follow each other get colours far apart.
    picture: NDArray[np.float64] = np.asarray(colours((labels * 7) % _COLOUR_COUNT))  # type: ignore[operator]
    picture[labels == 0] = (0.0, 0.0, 0.0, 1.0)
    return picture


def _title(entry: CloudEntry, name: str) -> str:
    facts = entry.facts
    rows, columns = entry.grey.shape
    lines = [
        f"{name}: {facts.coverage:.1%} cloud, {facts.clouds} clouds, fractal dimension "
        f"{facts.fractal_dimension:.3f}, {rows} x {columns} pixels of {facts.pixel_size_m:.5g} m",
        f"{facts.source_file}; band: {facts.band}; threshold: {facts.method}; licence: {facts.licence}",
    ]
    return "\n".join("\n".join(textwrap.wrap(line, 170)) for line in lines)
