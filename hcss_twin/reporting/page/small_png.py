"""Pictures with few bytes, for pages that hold many of them."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

from hcss_twin.reporting.page.pictures import png_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
