"""Picture files of clouds in images: a matched image beside its simulation, and an entry of the cloud database."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hcss_twin.core.files import Writing
from hcss_twin.providers import CatalogError
from hcss_twin.reports.figures import Figures

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from hcss_evaluate.matching.dimension_range import DimensionMatch
    from hcss_evaluate.matching.match import Match
    from hcss_evaluate.matching.structure import CloudImage, Structure
    from hcss_twin.models.clouds.database import CloudEntry

PANEL_PIXELS = 1024
"""Longest side of a panel of a cloud image in pixels; larger images are thinned."""

_PANEL_INCHES = 5.2
_IN_TITLE = 7  # quantities: those of eq 24, coverage and the two other dimensions

# Line styles of the image and the simulation, which also differ in their markers.
_IMAGE, _SIMULATED = "#222222", "#d1495b"

_COLOURS, _COLOUR_COUNT = "tab20", 20


def draw_match(match: Match, path: Path) -> None:
    """Draw the image, the simulation with the median RMSE, and both semivariances to a PNG file.

    Raises
    ------
    CatalogError
        If the file cannot be written.
    """
    seed = match.typical_seed
    rmse = match.rmse[match.seeds.index(seed)]
    values = ", ".join(
        f"{quantity.name} {quantity.image:.4g} / {quantity.simulated:.4g}" for quantity in match.quantities[:_IN_TITLE]
    )
    _draw(
        [
            (match.target.source, match.target.image),
            (f"simulated, seed {seed}: the median of {len(match.seeds)}, RMSE {rmse:.1%}", match.simulate(seed)),
        ],
        f"mean RMSE of eq 24 {match.mean_rmse:.1%}; image / mean of simulations: {values}",
        (match.structure, match.simulated_structure),
        path,
    )


def draw_dimension(match: DimensionMatch, panels: Sequence[tuple[str, CloudImage]], path: Path) -> None:
    """Draw images with titles, one of them with the requested dimension, to a PNG file.

    Raises
    ------
    CatalogError
        If the file cannot be written.
    """
    low, high = match.wanted
    _draw(panels, f"{match.dimension} dimension {low:g} to {high:g} wanted", (), path)


def _draw(panels: Sequence[tuple[str, CloudImage]], title: str, structures: Sequence[Structure], path: Path) -> None:
    rows, columns = panels[0][1].level.shape
    count = len(panels) + bool(structures)
    height = 0.95 * _PANEL_INCHES * min(max(rows / columns, 0.5), 2.0)
    figure = Figures.new(count * _PANEL_INCHES, height + 1.1)
    axes = figure.subplots(1, count, squeeze=False)[0]
    step = max(1, -(-max(rows, columns) // PANEL_PIXELS))
    grey = {"cmap": "gray", "vmin": 0, "vmax": 255, "interpolation": "nearest", "origin": "lower"}
    for axis, (name, image) in zip(axes, panels, strict=False):
        size = image.pixel_size_m / 1e3
        axis.imshow(image.level[::step, ::step], extent=(0.0, columns * size, 0.0, rows * size), **grey)
        axis.set_title(textwrap.fill(name, 62), fontsize=8)
        axis.set_xlabel("x (km, east)", fontsize=8)
        axis.tick_params(labelsize=7)
    axes[0].set_ylabel("y (km, north)", fontsize=8)
    if structures:
        axis = axes[-1]
        for structure, colour, name in zip(structures, (_IMAGE, _SIMULATED), ("image", "simulated"), strict=True):
            for values, style, way in ((structure.along_x, "o-", "x"), (structure.along_y, "^--", "y")):
                axis.loglog(structure.lags, values, style, color=colour, ms=4, lw=1.2, label=f"{name}, along {way}")
        axis.set_title("semivariance of the grey levels", fontsize=8)
        axis.set_xlabel("lag (pixels)", fontsize=8)
        axis.tick_params(labelsize=7)
        axis.legend(fontsize=7)
    figure.suptitle(textwrap.fill(title, 68 * count), fontsize=9)
    _save(figure, path)


def _save(figure: Figure, path: Path) -> None:
    with Writing(path, CatalogError, "PNG") as draft:
        figure.savefig(draft, dpi=110, format="png")


def draw_entry(entry: CloudEntry, name: str, path: Path) -> None:
    """Draw an entry of the cloud database (image, mask outline, single clouds) to a PNG file.

    Raises
    ------
    CatalogError
        If the file cannot be written.
    """
    from matplotlib import colormaps

    facts = entry.facts
    rows, columns = entry.grey.shape
    step = max(1, -(-max(rows, columns) // PANEL_PIXELS))
    thin = (slice(None, None, step), slice(None, None, step))
    km = facts.pixel_size_m / 1e3
    shown = {"extent": (0.0, columns * km, 0.0, rows * km), "interpolation": "nearest"}
    height = 0.9 * _PANEL_INCHES * min(max(rows / columns, 0.3), 2.0)
    figure = Figures.new(3 * _PANEL_INCHES, height + 1.2)
    axes = figure.subplots(1, 3, sharex=True, sharey=True)
    image = entry.image[thin]
    hatch = np.ma.masked_where(~entry.missing[thin], np.ones(image.shape))
    for axis, title in zip(axes, ("image", "outline of the mask", "single clouds"), strict=True):
        axis.set_title(title, fontsize=9)
        axis.tick_params(labelsize=7)
    for axis in axes[:2]:
        axis.imshow(image, cmap="gray", vmin=0, vmax=255, **shown)
        axis.imshow(hatch, cmap="cool", vmin=0, vmax=1, **shown)
    mask = entry.mask[thin].astype(np.float64)
    line = {"levels": [0.5], "origin": "upper", "colors": "#ff3b1f", "linewidths": 0.7}
    axes[1].contour(mask, extent=shown["extent"], **line)
    # Neighbouring labels get colours far apart: 7 and 20 have no common divisor.
    labels = entry.labels[thin]
    colours = np.asarray(colormaps[_COLOURS]((labels * 7) % _COLOUR_COUNT))
    colours[labels == 0] = (0.0, 0.0, 0.0, 1.0)
    axes[2].imshow(colours, **shown)
    figure.supxlabel("x (km, east)", fontsize=9)
    figure.supylabel("y (km, north)", fontsize=9)
    lines = (
        f"{name}: {facts.coverage:.1%} cloud, {facts.clouds} clouds, fractal dimension "
        f"{facts.fractal_dimension:.3f}, {rows} x {columns} pixels of {facts.pixel_size_m:.5g} m",
        f"{facts.source_file}; band: {facts.band}; threshold: {facts.method}; licence: {facts.licence}",
    )
    figure.suptitle("\n".join(textwrap.fill(text, 170) for text in lines), fontsize=9)
    _save(figure, path)
