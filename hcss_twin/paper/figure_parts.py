"""What the figures share: blank pages, panels of images, and the verdict that follows from their checks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.paper.item import Check, Drawing, Reproduction, Row, TakenInput, Verdict
from hcss_twin.paper.verdict import verdict_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


RADIANCE = "W m-2 sr-1"
RADIANCE_SHOWN = "W m$^{-2}$ sr$^{-1}$"

PANEL_PIXELS = 200
"""Most pixels along a side of a panel: larger images are shown by the means of blocks."""

SHADES = 64
"""Of grey: as many as the eye tells apart in a small picture, and a third fewer bytes than 256."""


def blank(width: float, height: float) -> Figure:
    """Return an empty figure of that size in inches, belonging to no window system."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def reduced(values: NDArray[Any], most: int = PANEL_PIXELS) -> NDArray[np.float64]:
    """Return means over blocks, so that no side has more than ``most`` pixels; what is left over is cut off.

    Parameters
    ----------
    values : ndarray (rows, columns)
    most : int
        At least 1.
    """
    image = np.asarray(values, dtype=np.float64)
    step = -(-max(image.shape) // most)
    rows, columns = (side // step for side in image.shape)
    cut = image[: rows * step, : columns * step]
    means: NDArray[np.float64] = cut.reshape(rows, step, columns, step).mean(axis=(1, 3))
    return means


def shades(name: str = "gray") -> Any:
    """Return a colour map of matplotlib in :data:`SHADES` steps."""
    from matplotlib import colormaps

    return colormaps[name].resampled(SHADES)


def image_panel(
    axis: Axes,
    values: NDArray[Any],
    title: str = "",
    limits: tuple[float, float] | None = None,
    most: int = PANEL_PIXELS,
) -> Any:
    """Draw a grey image without ticks, north up, and return it for a colour bar."""
    low, high = limits if limits is not None else (float(np.min(values)), float(np.max(values)))
    drawn = axis.imshow(
        reduced(values, most), origin="lower", cmap=shades(), vmin=low, vmax=high, interpolation="nearest"
    )
    axis.set_xticks([])
    axis.set_yticks([])
    if title:
        axis.set_title(title, fontsize=9)
    return drawn


def concluded(
    rows: Sequence[Row],
    checks: Sequence[Check],
    holds: str,
    fails: str,
    chosen: Sequence[TakenInput] = (),
    notes: Sequence[str] = (),
    drawings: Sequence[Drawing] = (),
    missing: str = "",
) -> Reproduction:
    """Return an item with the verdict of its checks.

    Parameters
    ----------
    rows, checks, notes, drawings
        As in :class:`Reproduction`.
    holds, fails : str
        The reason where all checks hold, and where one does not.
    chosen : sequence of TakenInput
        Inputs and readings that the paper does not state.
    missing : str
        What it would take and is not published: the figure is then not reproducible whatever its checks say.

    Raises
    ------
    ValueError
        If there is no check: nothing could fail.
    """
    good = verdict_of(checks, chosen) != "not reproducible"
    verdict: Verdict = "not reproducible" if missing else verdict_of(checks, chosen)
    reason = f"{missing} {holds if good else fails}".strip()
    return Reproduction(verdict, reason, rows, checks, chosen, notes, drawings)
