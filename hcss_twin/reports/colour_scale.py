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
"""Percentiles of the shown pixels at the ends of a scale; of a stretched one, those of each class of pixels."""

SMALLEST_CLASS = 1e-3
"""Share of the pixels below which the warmer or colder class is taken for outliers, such as faulty detectors."""

_INTERVALS = 128
_EVEN = 0.4
"""Part of a stretched scale that is linear; the rest follows the values, each class of pixels with the same part."""

_CONTRAST = 16.0
"""Largest contrast over that of a linear scale between the same ends."""

MISSING = "#9dc3e6"
"""Colour of pixels without a value, distinct from grey."""

LEAST_NOISE_K = 0.05
"""Noise in kelvin that is assumed where an image has less: that of a good infrared camera."""

DARKEST = "#262626"
"""Colour of the dark end: warm in kelvin, clear in a mask."""

_STOPS = 17
_TICK_GAP = 0.11

_THERMAL_UM = 5.0
"""Bands beyond have hardly any sunlight."""


def colours_of(name: str, shortest_um: float = 0.0) -> str:
    """Return the colour map of a quantity: in kelvin, and of thermal radiation, cold is white, as from satellites."""
    if name == "brightness_temperature" or (name == "radiance" and shortest_um >= _THERMAL_UM):
        return "gray_r"
    return "gray" if name.startswith("radiance") or name.endswith("_mask") else "viridis"


def colour_map(name: str) -> Any:
    """Return a colour map of matplotlib; those in grey have no black, so that all their shades can be told apart."""
    from matplotlib import colormaps
    from matplotlib.colors import LinearSegmentedColormap

    greys = {"gray": [DARKEST, "#ffffff"], "gray_r": ["#ffffff", DARKEST]}
    return LinearSegmentedColormap.from_list(name, greys[name]) if name in greys else colormaps[name]


def band_limits_um(dataset: xr.Dataset, data: xr.DataArray) -> list[tuple[float, float]]:
    """Return the limits of the bands of a variable of a cube; empty without bands."""
    if "band" not in data.dims or "wavelength_bounds" not in dataset:
        return []
    return [(float(low), float(high)) for low, high in dataset["wavelength_bounds"].to_numpy()]


def is_stretched(name: str) -> bool:
    """Return whether the scale of a quantity gives frequent values more contrast: radiation, not truth."""
    return name.startswith(("brightness_temperature", "radiance"))


def sight_rank(shortest_um: float, plane: NDArray[Any]) -> tuple[bool, float]:
    """Return the key by which bands are ordered for the eye: most to see in kelvin first.

    Bands without sunlight come first, because the brightness temperature of reflected sunlight is no temperature; then
    the largest spread over noise, which is the median step between neighbours, at least ``LEAST_NOISE_K``.

    Parameters
    ----------
    shortest_um : float
        Lower limit of the band.
    plane : ndarray (Y, X)
        Brightness temperature of one frame, K.
    """
    known = plane[np.isfinite(plane)]
    if not known.size:
        return True, np.inf
    low, high = np.percentile(known, ENDS_PERCENT)
    steps = np.abs(np.diff(plane.astype(np.float64), axis=1))
    steps = steps[np.isfinite(steps)]
    noise = float(np.hypot(LEAST_NOISE_K, np.median(steps))) if steps.size else LEAST_NOISE_K
    return shortest_um < _THERMAL_UM, -float(high - low) / noise


@dataclass(frozen=True)
class ColourScale:
    """Colour scale between two values; values beyond have the colour of the nearer end.

    A stretched scale is piecewise linear and gives frequent values more contrast, clear sky and cloud each its own, so
    that both show their structure; its ticks stand where their values are.

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
    knots : tuple of (float, float)
        Values and their shares of the scale, both ascending; empty if it is linear.
    """

    low: float
    high: float
    below: bool
    above: bool
    missing: bool
    colours: str
    flags: tuple[str, ...] = ()
    knots: tuple[tuple[float, float], ...] = ()

    @classmethod
    def of(
        cls, planes: NDArray[Any], colours: str, flags: tuple[str, ...] = (), stretched: bool = False
    ) -> ColourScale:
        """Return the common scale of all planes (frame, y, x) of a quantity."""
        known = planes[np.isfinite(planes)] if planes.dtype.kind == "f" else planes.ravel()
        missing = known.size < planes.size
        if flags:
            return cls(0.0, float(len(flags) - 1), False, False, missing, colours, flags)
        if not known.size:  # cloud tops of a cloudless scene
            return cls(0.0, 1.0, False, False, missing, colours)
        classes = _classes(known) if stretched else (known,)
        ends = np.array([np.percentile(values, ENDS_PERCENT) for values in classes])
        low, high = float(ends[:, 0].min()), float(ends[:, 1].max())
        least, most = float(known.min()), float(known.max())
        if not high > low:
            # nearly constant, such as the thickness of sparse clouds: use the extremes
            low, high = (least, most) if most > least else (low, low + max(abs(low), 1.0) * 1e-3)
        knots = _knots(classes, low, high) if stretched and most > least else ()
        return cls(low, high, least < low, most > high, missing, colours, knots=knots)

    def share_of(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return where values are on the scale, 0 to 1; NaN for missing ones."""
        if self.knots:
            return np.asarray(np.interp(values, *np.transpose(self.knots)))
        return np.clip((values - self.low) / (self.high - self.low), 0.0, 1.0)

    def value_at(self, share: NDArray[Any]) -> NDArray[Any]:
        """Return the values at shares of the scale, the inverse of :meth:`share_of`."""
        values, shares = np.transpose(self.knots or ((self.low, 0.0), (self.high, 1.0)))
        return np.asarray(np.interp(share, shares, values))

    def png(self, plane: NDArray[Any]) -> bytes:
        """Return a plane (y, x), whose first row is the southernmost, as a PNG with north at the top."""
        from PIL import Image

        values = np.asarray(plane[::-1], dtype=np.float64)
        known = np.isfinite(values)
        share = self.share_of(np.where(known, values, self.low))
        level = np.where(known, np.rint(share * (LEVELS - 1)), LEVELS).astype(np.uint8)
        image = Image.fromarray(level)
        palette = [*self._colours(LEVELS), tuple(bytes.fromhex(MISSING[1:]))]
        image.putpalette([part for colour in palette for part in colour])
        stream = io.BytesIO()
        image.save(stream, "PNG", compress_level=9)
        return stream.getvalue()

    def _colours(self, count: int) -> list[tuple[int, int, int]]:
        shades = colour_map(self.colours)(np.linspace(0.0, 1.0, count), bytes=True)
        return [(int(red), int(green), int(blue)) for red, green, blue, _ in shades]

    def ticks(self) -> list[float]:
        """Return round values within the scale whose labels do not touch."""
        from matplotlib.ticker import MaxNLocator

        values = MaxNLocator(nbins=7, steps=[1, 2, 2.5, 5, 10]).tick_values(self.low, self.high)
        slack = 1e-9 * (self.high - self.low)
        within = [float(value) for value in values if self.low - slack <= value <= self.high + slack]
        apart: list[float] = []
        for value, share in zip(within, self.share_of(np.array(within)), strict=True):
            if not apart or share - self.share_of(np.array(apart[-1])) >= _TICK_GAP:
                apart.append(value)
        return apart

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
            percent = 100.0 * float(self.share_of(np.array(value)))
            # keep the outermost labels within the width of the bar
            side = "first" if percent < 8 else "last" if percent > 92 else None
            marks.append(Markup.element("span", word, style=f"left:{percent:.2f}%", class_=side))
        notes: list[str] = [f"{self.low:.5g} to {self.high:.5g} {units}".strip()]
        if self.below or self.above:
            beyond = "beyond the ends" if self.below and self.above else "below" if self.below else "above"
            notes.append(f"the few pixels {beyond} have the colour of the end")
        if self.knots:
            notes.append("frequent values have more contrast")
        if self.missing:
            notes.append(Markup('<i class="missing"></i>no value'))
        return Markup.joined(
            [
                Markup.element("div", class_="bar", style=f"background:linear-gradient(to right,{stops})"),
                Markup.element("div", *marks, class_="ticks"),
                Markup.element("div", Markup.joined(notes, "; "), class_="ends"),
            ]
        )


def _classes(known: NDArray[Any]) -> tuple[NDArray[Any], ...]:
    """Return the colder and the warmer pixels, clear sky and cloud as a rule, parted where their variance is least."""
    counts, edges = np.histogram(known, 2 * _INTERVALS)
    middle = (edges[1:] + edges[:-1]) / 2
    below, total = np.cumsum(counts), np.cumsum(counts * middle)
    above = known.size - below
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = below * above * (total / below - (total[-1] - total) / above) ** 2  # of Otsu
    threshold = edges[1 + int(np.argmax(np.nan_to_num(apart)))]
    cold = known < threshold
    parts = tuple(part for part in (known[cold], known[~cold]) if part.size > SMALLEST_CLASS * known.size)
    return parts or (known,)


def _knots(classes: tuple[NDArray[Any], ...], low: float, high: float) -> tuple[tuple[float, float], ...]:
    """Return a scale on which the frequent values of each class have more contrast, at most ``_CONTRAST`` times."""
    edges = np.linspace(low, high, _INTERVALS + 1)
    frequent = sum(np.histogram(values, edges)[0] / values.size for values in classes) / len(classes)
    room = np.minimum(_EVEN / _INTERVALS + (1.0 - _EVEN) * frequent, _CONTRAST / _INTERVALS)
    shares = np.concatenate([[0.0], np.cumsum(room) / room.sum()])
    return tuple(zip(edges.tolist(), shares.tolist(), strict=True))


def tick_texts(values: list[float]) -> list[str]:
    """Format values with as many decimals as are needed to distinguish them."""
    if len(values) < 2:
        return [f"{value:.5g}" for value in values]
    step = min(abs(b - a) for a, b in pairwise(values))
    if step < 1e-4 or max(map(abs, values)) >= 1e6:
        return [f"{value:.4g}" for value in values]
    decimals = next((count for count in range(6) if abs(step - round(step, count)) < 1e-3 * step), 6)
    return [f"{value:.{decimals}f}" for value in values]
