"""Style of matplotlib figures within a page."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Figures"]


class Figures:
    """Figures of one style.

    Attributes
    ----------
    INK : str
        Colour of lines.
    WIDTH_IN, LETTERS : float
        Width of a figure in inches, and size of its letters in points.
    DRAWN_BANDS : int
        Maximum number of bands in a figure; tables list all.
    """

    INK: ClassVar = "#1f4e79"
    WIDTH_IN: ClassVar = 4.7
    LETTERS: ClassVar = 9
    DRAWN_BANDS: ClassVar = 8

    @staticmethod
    def new(width_in: float, height_in: float) -> Figure:
        """Return an empty figure with automatic layout; matplotlib is imported here, when needed."""
        from matplotlib.figure import Figure

        return Figure(figsize=(width_in, height_in), layout="constrained")

    @staticmethod
    def panels(count: int, height_in: float = 1.5) -> tuple[Figure, list[Axes]]:
        """Return a figure of stacked panels, readable on a phone."""
        figure = Figures.new(Figures.WIDTH_IN, max(2.6, height_in * count + 0.5))
        axes = list(figure.subplots(count, 1, squeeze=False)[:, 0])
        for axis in axes:
            Figures.plain(axis)
        return figure, axes

    @staticmethod
    def plain(axis: Any) -> None:
        """Apply the common font sizes and line styles to axes."""
        axis.tick_params(labelsize=Figures.LETTERS - 1)
        axis.spines[["top", "right"]].set_visible(False)
        axis.grid(color="#e3e8ed", linewidth=0.6)
        axis.set_axisbelow(True)

    @staticmethod
    def axis_label(text: str, units: str) -> str:
        """Return a label with its unit."""
        return f"{text} ({units})" if units else text

    @staticmethod
    def png(figure: Figure, dpi: int = 110) -> bytes:
        """Return a figure as PNG; the same figure gives the same bytes."""
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=dpi, metadata={"Software": None})
        return stream.getvalue()
