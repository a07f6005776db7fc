"""Colour scales: one scale for all frames of a quantity in a band, palette pictures, and the colour bar."""

from __future__ import annotations

import io
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.reports.page import Markup

if TYPE_CHECKING:
    import xarray as xr

LEVELS = 127
"""Number of colours of a scale, plus one for missing values; more would be indistinguishable."""

ENDS_PERCENT = (0.5, 99.5)
"""Percentiles of the shown pixels at the ends of a scale."""

MISSING = "#9dc3e6"
"""Colour of pixels without a value, distinct from grey."""

_STOPS = 17

_THERMAL_UM = 5.0
"""Bands beyond have hardly any sunlight."""


def colours_of(name: str, shortest_um: float = 0.0) -> str:
    """Return the colour map of a quantity: of thermal radiation, as in infrared satellite images, cold is white."""
    if name == "brightness_temperature" or (name == "radiance" and shortest_um >= _THERMAL_UM):
        return "gray_r"
    return "gray" if name.startswith("radiance") else "viridis"


def band_limits_um(dataset: xr.Dataset, data: xr.DataArray) -> list[tuple[float, float]]:
    """Return the limits of the bands of a variable of a cube; empty without bands."""
    if "band" not in data.dims or "wavelength_bounds" not in dataset:
        return []
    return [(float(low), float(high)) for low, high in dataset["wavelength_bounds"].to_numpy()]


@dataclass(frozen=True)
class ColourScale:
    """Colour scale between two values; values beyond have the colour of the nearer end.

    Attributes
    ----------
    low, high : float
    below, above : bool
        Whether pixels lie beyond the ends.
    missing : bool
        Whether any pixels have no value.
    colours : str
        Name of the colour map.
    flags : tuple of str
        Meanings of 0, 1, ... where the values are flags.
    """

    low: float
    high: float
    below: bool
    above: bool
    missing: bool
    colours: str
    flags: tuple[str, ...] = ()

    @classmethod
    def of(cls, planes: NDArray[Any], colours: str, flags: tuple[str, ...] = ()) -> ColourScale:
        """Return the common scale of all planes (frame, y, x) of a quantity."""
        known = planes[np.isfinite(planes)] if planes.dtype.kind == "f" else planes.ravel()
        missing = known.size < planes.size
        if flags:
            return cls(0.0, float(len(flags) - 1), False, False, missing, colours, flags)
        if not known.size:  # cloud tops of a cloudless scene
            return cls(0.0, 1.0, False, False, missing, colours)
        low, high = (float(value) for value in np.percentile(known, ENDS_PERCENT))
        least, most = float(known.min()), float(known.max())
        if not high > low:
            # nearly constant, such as the thickness of sparse clouds: use the extremes
            low, high = (least, most) if most > least else (low, low + max(abs(low), 1.0) * 1e-3)
        return cls(low, high, least < low, most > high, missing, colours)

    def png(self, plane: NDArray[Any]) -> bytes:
        """Return a plane (y, x), whose first row is the southernmost, as a PNG with north at the top."""
        from PIL import Image

        values = np.asarray(plane[::-1], dtype=np.float64)
        known = np.isfinite(values)
        share = np.clip((np.where(known, values, self.low) - self.low) / (self.high - self.low), 0.0, 1.0)
        level = np.where(known, np.rint(share * (LEVELS - 1)), LEVELS).astype(np.uint8)
        image = Image.fromarray(level)
        palette = [*self._colours(LEVELS), tuple(bytes.fromhex(MISSING[1:]))]
        image.putpalette([part for colour in palette for part in colour])
        stream = io.BytesIO()
        image.save(stream, "PNG", compress_level=9)
        return stream.getvalue()

    def _colours(self, count: int) -> list[tuple[int, int, int]]:
        from matplotlib import colormaps

        shades = colormaps[self.colours](np.linspace(0.0, 1.0, count), bytes=True)
        return [(int(red), int(green), int(blue)) for red, green, blue, _ in shades]

    def ticks(self) -> list[float]:
        """Return round values within the scale."""
        from matplotlib.ticker import MaxNLocator

        values = MaxNLocator(nbins=4, steps=[1, 2, 2.5, 5, 10]).tick_values(self.low, self.high)
        slack = 1e-9 * (self.high - self.low)
        return [float(value) for value in values if self.low - slack <= value <= self.high + slack]

    def bar(self, units: str) -> Markup:
        """Return the colour bar with values and units; for flags, their colours and meanings."""
        if self.flags:
            meanings = (
                Markup.joined([Markup.element("i", class_="flag", style=f"background:rgb{shade}"), word])
                for shade, word in zip(self._colours(len(self.flags)), self.flags, strict=True)
            )
            return Markup.element("div", Markup.joined(meanings, " "), class_="flags")
        stops = ", ".join(f"rgb{colour}" for colour in self._colours(_STOPS))
        ticks = self.ticks()
        marks = []
        for value, word in zip(ticks, tick_texts(ticks), strict=True):
            percent = 100.0 * (value - self.low) / (self.high - self.low)
            # keep the outermost labels within the width of the bar
            side = "first" if percent < 8 else "last" if percent > 92 else None
            marks.append(Markup.element("span", word, style=f"left:{percent:.2f}%", class_=side))
        notes: list[str] = [f"{self.low:.5g} to {self.high:.5g} {units}".strip()]
        if self.below or self.above:
            beyond = "beyond the ends" if self.below and self.above else "below" if self.below else "above"
            notes.append(f"the few pixels {beyond} have the colour of the end")
        if self.missing:
            notes.append(Markup('<i class="missing"></i>no value'))
        return Markup.joined(
            [
                Markup.element("div", class_="bar", style=f"background:linear-gradient(to right,{stops})"),
                Markup.element("div", *marks, class_="ticks"),
                Markup.element("div", Markup.joined(notes, "; "), class_="ends"),
            ]
        )


def tick_texts(values: list[float]) -> list[str]:
    """Format values with as many decimals as are needed to distinguish them."""
    if len(values) < 2:
        return [f"{value:.5g}" for value in values]
    step = min(abs(b - a) for a, b in pairwise(values))
    if step < 1e-4 or max(map(abs, values)) >= 1e6:
        return [f"{value:.4g}" for value in values]
    decimals = next((count for count in range(6) if abs(step - round(step, count)) < 1e-3 * step), 6)
    return [f"{value:.{decimals}f}" for value in values]
