"""Matplotlib figures within a page: their style, and their embedding as data URLs."""

from __future__ import annotations

import base64
import io
from typing import TYPE_CHECKING, Any

from hcss_twin.reports.page import Markup, element

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


INK = "#1f4e79"
WIDTH_IN = 4.7
LETTERS = 9

DRAWN_BANDS = 8
"""Maximum number of bands in a figure; tables list all."""


def new_figure(width_in: float, height_in: float) -> Figure:
    """Return an empty figure with automatic layout; matplotlib is imported here, when needed."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width_in, height_in), layout="constrained")


def panels(count: int, height_in: float = 1.5) -> tuple[Figure, list[Axes]]:
    """Return a figure of stacked panels, readable on a phone."""
    figure = new_figure(WIDTH_IN, max(2.6, height_in * count + 0.5))
    axes = list(figure.subplots(count, 1, squeeze=False)[:, 0])
    for axis in axes:
        plain(axis)
    return figure, axes


def plain(axis: Any) -> None:
    """Apply the common font sizes and line styles to axes."""
    axis.tick_params(labelsize=LETTERS - 1)
    axis.spines[["top", "right"]].set_visible(False)
    axis.grid(color="#e3e8ed", linewidth=0.6)
    axis.set_axisbelow(True)


def axis_label(text: str, units: str) -> str:
    """Return a label with its unit."""
    return f"{text} ({units})" if units else text


def data_address(content: bytes, media_type: str = "image/png") -> str:
    """Return bytes as a data URL."""
    return f"data:{media_type};base64,{base64.b64encode(content).decode('ascii')}"


def png_of(figure: Figure, dpi: int = 110) -> bytes:
    """Return a figure as PNG; the same figure gives the same bytes."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=dpi, metadata={"Software": None})
    return stream.getvalue()


def drawing(figure: Figure, alternative: str, caption: str = "", wide: bool = False) -> Markup:
    """Return a figure of lines as SVG, sharp at any size; the same figure gives the same bytes.

    Parameters
    ----------
    figure : Figure
    alternative, caption : str
        As for :func:`picture`.
    wide : bool
        Keep its size on narrow screens, where it scrolls.
    """
    import matplotlib as mpl

    stream = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": "hcss", "svg.fonttype": "path"}):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    return _figure(data_address(stream.getvalue(), "image/svg+xml"), alternative, caption, wide)


def picture(content: Figure | bytes, alternative: str, caption: str = "") -> Markup:
    """Return a picture with its caption.

    Parameters
    ----------
    content : Figure or bytes
        A figure of matplotlib, or the bytes of a PNG file.
    alternative : str
        Alternative text for screen readers.
    caption : str, optional
        Caption below the picture.
    """
    png = content if isinstance(content, bytes) else png_of(content)
    return _figure(data_address(png), alternative, caption)


def _figure(address: str, alternative: str, caption: str, wide: bool = False) -> Markup:
    image = element("img", src=address, alt=alternative, loading="lazy")
    shown = element("div", image, class_="scroll keeps-size") if wide else image
    return element("figure", shown, *([element("figcaption", caption)] if caption else []))
