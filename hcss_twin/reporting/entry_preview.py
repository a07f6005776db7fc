"""Picture of a database entry: the image, the outline of its mask, and the single clouds."""

from __future__ import annotations

import textwrap
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hcss_twin.clouds.database.entry import CloudEntry
from hcss_twin.drafts import draft_of
from hcss_twin.errors import CatalogError

PIXELS_SHOWN = 1024
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
    with draft_of(path, CatalogError) as draft:
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
