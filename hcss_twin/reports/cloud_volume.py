"""Figure of a cloud volume as in Fig 5 of the HCSS paper: a 3-D view, a section and a profile."""

from __future__ import annotations

import math
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.core.errors import CubeError
from hcss_twin.core.files import Writing
from hcss_twin.reports.cloud_columns import CloudColumns, altitude_edges, occupancy, read_columns
from hcss_twin.reports.tables import Table

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


__all__ = ["cloud_volume_figure"]

NODES_SHOWN = 250
"""Maximum number of columns along the longer side of the 3-D view; larger frames are thinned, not averaged."""

_HEIGHT_SHARE = 0.3
_LEVELS = 60
_ROWS = 64
_SEA, _BASE = "#3b6a8f", "#8a8f98"


def draw_volume(columns: CloudColumns, path: Path) -> Path:
    """Draw the cloud of one frame to a file; its suffix sets the format.

    Raises
    ------
    CubeError
        If the frame is clear, is a single row or column, or the picture cannot be written.
    """
    figure = drawn(columns)
    with Writing(path, CubeError, "picture") as draft:
        figure.savefig(draft, dpi=110, format=path.suffix.removeprefix(".") or "png")
    return path


def cloud_volume_figure(cube: str | Path | xr.Dataset, frame: int = 0) -> Figure:
    """Draw the cloud of one frame of a cube: a 3-D view, a section and the cloud fraction by altitude.

    Raises
    ------
    CubeError
        If the cube has no cloud of one layer with thickness and top altitude on a grid on the ground, or no such frame;
        if the frame is clear, or is a single row or column.
    """
    return drawn(read_columns(cube, frame))


def drawn(columns: CloudColumns) -> Figure:
    """Draw the cloud of one frame: a 3-D view, a section and the cloud fraction by altitude.

    Raises
    ------
    CubeError
        If the frame is clear, or is a single row or column.
    """
    # This import registers the 3-D projection with matplotlib.
    import mpl_toolkits.mplot3d  # noqa: F401
    from matplotlib.figure import Figure

    class Calm(Figure):
        """Faces at the cloud edges have fewer corners.

        Matplotlib projects the uninitialised ones, which may overflow, and masks them afterwards.
        """

        def draw(self, renderer: Any) -> None:
            with np.errstate(over="ignore", invalid="ignore"):
                super().draw(renderer)

    if columns.is_clear:
        raise CubeError(f"frame {columns.frame} has no cloud: there is no volume to draw")
    if min(columns.top_m.shape) < 2:
        raise CubeError(f"a frame of {columns.top_m.shape} pixels has no surface; at least 2 x 2 is needed")
    # Positioned manually, because automatic layouts give the 3-D view too much or too little space.
    figure = Calm(figsize=(12.0, 10.0))
    _space(figure, figure.add_axes((0.02, 0.29, 0.86, 0.64), projection="3d"), columns)
    section = figure.add_axes((0.07, 0.065, 0.63, 0.185))
    _section(section, columns)
    _profile(figure.add_axes((0.78, 0.065, 0.19, 0.185), sharey=section), columns)
    moment = str(columns.time.astype("datetime64[s]")).replace("T", " ")
    figure.suptitle(textwrap.fill(f"{columns.title} — frame {columns.frame}, {moment} UTC", 120), fontsize=11)
    return figure


def _lowest_drawn(columns: CloudColumns) -> float:
    """Return the lowest altitude drawn: 0 (the sea), or slightly below the cloud base if that is high."""
    base, top = float(np.nanmin(columns.base_m)), float(np.nanmax(columns.top_m))
    return 0.0 if base < top - base else base - 0.1 * (top - base)


def _vertical_scale(columns: CloudColumns) -> float:
    """Return the round vertical exaggeration (..., 0.5, 1, 2, 5, ...) that suits the drawn width."""
    width = max(np.ptp(columns.x_m), np.ptp(columns.y_m))
    ideal = _HEIGHT_SHARE * width / (float(np.nanmax(columns.top_m)) - _lowest_drawn(columns))
    # Keep true proportions if the ideal factor is near 1.
    if 0.6 <= ideal < 2.0:
        return 1.0
    decade = 10.0 ** math.floor(math.log10(ideal))
    return max(factor * decade for factor in (1.0, 2.0, 5.0) if factor * decade <= ideal)


def _space(figure: Any, axis: Any, columns: CloudColumns) -> None:
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LightSource, ListedColormap, Normalize

    exaggeration, lowest = _vertical_scale(columns), _lowest_drawn(columns) / 1e3
    step = max(1, -(-max(columns.top_m.shape) // NODES_SHOWN))
    thin = (slice(None, None, step), slice(None, None, step))
    x, y = np.meshgrid(columns.x_m[thin[1]] / 1e3, columns.y_m[thin[0]] / 1e3)
    base, top = columns.base_m[thin] / 1e3, columns.top_m[thin] / 1e3
    scale = Normalize(0.0, float(np.nanmax(columns.thickness_m)))
    colours = colormaps["bone"](0.35 + 0.6 * scale(np.nan_to_num(columns.thickness_m[thin])))
    spacing = float(x[0, 1] - x[0, 0])
    light = LightSource(azdeg=300.0, altdeg=35.0)
    # Clear columns are excluded from the surface; the shading assumes the lowest base there.
    relief = np.where(np.isnan(top), np.nanmin(base), top)
    shaded = light.shade_rgb(
        colours[..., :3], relief, vert_exag=exaggeration, dx=spacing, dy=spacing, blend_mode="soft"
    )
    # Draw surfaces from bottom to top, because matplotlib sorts whole surfaces by their centres.
    axis.computed_zorder = False
    flat = {"rcount": NODES_SHOWN, "ccount": NODES_SHOWN, "linewidth": 0.0, "antialiased": False, "clip_on": False}
    span_x, span_y = x[0, [0, -1]], y[[0, -1], 0]
    if lowest == 0.0:
        sea = np.zeros((2, 2))
        axis.plot_surface(
            *np.meshgrid(span_x, span_y), sea, color=_SEA, alpha=0.55, shade=False, zorder=0, clip_on=False
        )
    axis.plot_surface(x, y, base, color=_BASE, shade=False, zorder=1, **flat)
    axis.plot_surface(x, y, top, facecolors=shaded, shade=False, zorder=2, **flat)
    height = 1.05 * (float(np.nanmax(top)) - lowest)
    axis.set_zlim(lowest, lowest + height)
    axis.set_xlim(*span_x)
    axis.set_ylim(*span_y)
    axis.set_box_aspect((np.ptp(span_x), np.ptp(span_y), height * exaggeration), zoom=1.2)
    axis.view_init(elev=28.0, azim=-62.0)
    axis.set_xlabel("x (km, east)", labelpad=8.0)
    axis.set_ylabel("y (km, north)", labelpad=8.0)
    axis.set_zlabel("altitude (km)")
    axis.locator_params(axis="z", nbins=4)
    heights = "true proportions" if exaggeration == 1.0 else f"vertical exaggeration {exaggeration:g}"
    thinned = "" if step == 1 else f"; every {Table.ordinal(step)} pixel shown"
    below = "sea (blue)" if lowest == 0.0 else "the sea is not shown"
    figure.text(0.5, 0.925, f"cloud top (shaded), base (grey), {below}; {heights}{thinned}", ha="center", fontsize=10)
    # the range of the colour map used by the surface
    shades = ListedColormap(colormaps["bone"](np.linspace(0.35, 0.95, 256)))
    bar = ScalarMappable(Normalize(0.0, scale.vmax), shades)
    figure.colorbar(bar, cax=figure.add_axes((0.91, 0.42, 0.015, 0.36)), label="cloud thickness (m)")


def _section(axis: Axes, columns: CloudColumns) -> None:
    """Draw base to top along the middle row, with each pixel at its true width."""
    row = columns.top_m.shape[0] // 2
    half = 0.5 * float(columns.x_m[1] - columns.x_m[0])
    x = np.repeat(columns.x_m, 2) + np.tile([-half, half], columns.x_m.size)
    base, top = np.repeat(columns.base_m[row], 2) / 1e3, np.repeat(columns.top_m[row], 2) / 1e3
    axis.fill_between(x / 1e3, base, top, where=~np.isnan(top), color="#5f6b7a", linewidth=0.0)
    axis.axhline(0.0, color=_SEA, lw=2.0)
    axis.set_xlim(x[0] / 1e3, x[-1] / 1e3)
    axis.set_ylim(0.0, 1.08 * float(np.nanmax(columns.top_m)) / 1e3)
    axis.set_xlabel("x (km, east)")
    axis.set_ylabel("altitude (km)")
    axis.set_title(f"section along y = {columns.y_m[row] / 1e3:g} km (heights not to scale)", fontsize=10)


def _profile(axis: Axes, columns: CloudColumns) -> None:
    """Draw the cloud fraction of the frame at each altitude."""
    top = float(np.nanmax(columns.top_m))
    edges = altitude_edges(0.0, top, top / _LEVELS)
    # Process blocks of rows, because the volume of a large frame would not fit into memory.
    sums = np.zeros(edges.size - 1)
    for start in range(0, columns.top_m.shape[0], _ROWS):
        rows = slice(start, start + _ROWS)
        shares = occupancy(columns.base_m[rows], columns.top_m[rows], edges)
        sums += np.sum(shares * columns.fraction[rows], axis=(1, 2))
    shares_of_frame = sums / columns.top_m.size
    axis.stairs(shares_of_frame, edges / 1e3, orientation="horizontal", fill=True, color="#5f6b7a")
    axis.set_xlim(0.0, max(1e-3, 1.08 * float(shares_of_frame.max())))
    axis.set_xlabel("cloudy fraction of the area")
    axis.set_title("cloud in the frame, by altitude", fontsize=10)
    axis.grid(alpha=0.3)
