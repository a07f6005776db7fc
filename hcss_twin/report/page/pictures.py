"""Pictures within a page: nothing is fetched from elsewhere.

Pictures with few bytes, for pages that hold many of them.
"""

from __future__ import annotations

import base64
import io
from typing import TYPE_CHECKING

from hcss_twin.report.page.page import Markup, element

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


def drawing(figure: Figure, alternative: str, caption: str = "", wide: bool = False) -> Markup:
    """Return a figure of lines, sharp at any size, with its caption; the same figure gives the same bytes.

    Parameters
    ----------
    figure : Figure
        Of matplotlib.
    alternative, caption : str
        As for :func:`picture`.
    wide : bool
        Keep its size on narrow screens, where it scrolls.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    FigureCanvasSVG(figure)
    stream = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": "hcss", "svg.fonttype": "path"}):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    address = data_address(stream.getvalue(), "image/svg+xml")
    return _figure(address, alternative, caption, wide)


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
    return _figure(data_address(png), alternative, caption)


def _figure(address: str, alternative: str, caption: str, wide: bool = False) -> Markup:
    image = Markup(element("img", src=address, alt=alternative, loading="lazy").removesuffix("</img>"))
    shown = element("div", image, class_="scroll keeps-size") if wide else image
    return element("figure", shown, *([element("figcaption", caption)] if caption else []))


COLOURS = 256
"""As many as a palette holds."""


def small_png(figure: Figure, dpi: int = 110) -> bytes:
    """Return a figure as PNG of at most 256 colours, which takes a quarter to a half off pictures of clouds.

    The same figure gives the same bytes. Without dithering: what is of one colour stays so. A figure that is smaller in
    all its colours keeps them.
    """
    from PIL import Image

    whole = png_of(figure, dpi)
    stream = io.BytesIO()
    with Image.open(io.BytesIO(whole)) as image:
        # On white: a palette has no room for transparency, and figures have a white ground.
        opaque = Image.alpha_composite(Image.new("RGBA", image.size, "white"), image.convert("RGBA"))
        palette = opaque.convert("RGB").quantize(COLOURS, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
        palette.save(stream, "PNG", optimize=True)
    reduced = stream.getvalue()
    return reduced if len(reduced) < len(whole) else whole
