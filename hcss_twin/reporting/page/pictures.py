"""Pictures within a page: nothing is fetched from elsewhere."""

from __future__ import annotations

import base64
import io
from typing import TYPE_CHECKING

from hcss_twin.reporting.page.markup import Markup, element

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def data_address(content: bytes, media_type: str = "image/png") -> str:
    """Return bytes as an address that holds them."""
    return f"data:{media_type};base64,{base64.b64encode(content).decode('ascii')}"


def png_of(figure: Figure, dpi: int = 110) -> bytes:
    """Return a figure as PNG; the same figure gives the same bytes."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure)
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=dpi, metadata={"Software": None})
    return stream.getvalue()


def picture(content: Figure | bytes, alternative: str, caption: str = "") -> Markup:
    """Return a picture with its caption.

    Parameters
    ----------
    content : Figure or bytes
        A figure of matplotlib, or a PNG file's bytes.
    alternative : str
        What there is to see, for those who cannot see it.
    caption : str, optional
        Below it.
    """
    png = content if isinstance(content, bytes) else png_of(content)
    image = Markup(
        element("img", src=data_address(png), alt=alternative, loading="lazy").removesuffix("</img>")
    )
    return element("figure", image, *([element("figcaption", caption)] if caption else []))
