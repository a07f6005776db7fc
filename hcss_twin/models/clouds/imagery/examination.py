"""What the values of an image show, and which of its pixels show nothing although the file does not say so.

Fill values that a file does not declare would be the brightest or coldest cloud of all. They are recognised by their
distance from the rest, and treated as missing; what cannot be decided from the values is a question to the user.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import product
from types import MappingProxyType

import numpy as np

from hcss_twin.core.arrays import Array

CELSIUS_ZERO_K = 273.15

_KELVIN = re.compile(r"(deg(rees?)?[ _]?)?(k|kelvins?)", re.IGNORECASE)
_CELSIUS = re.compile(r"(\u00b0|deg(rees?)?[ _]?)?c(elsius)?|deg(rees?)?[ _]?celsius", re.IGNORECASE)

_FAHRENHEIT = re.compile(r"(\u00b0|deg(rees?)?[ _]?)f(ahrenheit)?|fahrenheit", re.IGNORECASE)
_PARTS_OF_KELVIN = MappingProxyType({"mK": 1e-3, "cK": 1e-2, "dK": 1e-1})

KELVIN_LIMITS = 100.0, 500.0
"""Brightness temperatures of the Earth and its fires, K; others are no measurements."""

LIKE_KELVIN, LIKE_CELSIUS = (150.0, 350.0), (-110.0, 70.0)
"""Ranges of values that are questioned if a file states no unit; the median of temperatures is within the first."""

HOTTEST_K, HOTTEST_PERCENTILE = 400.0, 99.0
"""No image of brightness temperature has more than a few pixels above: fires."""

LEAST_SPAN_K = 2.0
"""Images of less contrast, such as reflectances, are not read as temperatures in another unit."""

READINGS = ("K", "dK", "cK", "mK", "degC", "degF")
"""Units in which temperatures are stored by mistake, or without saying so."""

FAR = 10.0
"""Gap between a value and the rest, in ranges of the rest, beyond which the value belongs to no image."""

MOST_FILLS = 4
"""Most fill values at either end of the range."""

_FEW_LEVELS = 16
"""Images of fewer levels are masks and classes, whose ranges say nothing about gaps."""

_FILL = re.compile(r"-?9+(\.9+)?|-?327(67|68)|65535|-?214748364[78]|-1")
"""Usual fill values that need only be beyond the range of the rest, or negative where the rest is not."""

_BORDER_SHARE = 1e-3
"""Share of the inner pixels that may have the value of a border by chance."""

_UNITLESS = ("", "1", "none", "unknown", "dn", "count", "counts")


def in_kelvin(values: Array, units: str) -> Array | None:
    """Return temperatures in K, whatever the spelling of their unit; None if it is none of temperature."""
    units = units.strip()
    if _KELVIN.fullmatch(units):
        return values
    if _CELSIUS.fullmatch(units):
        return values + CELSIUS_ZERO_K
    if _FAHRENHEIT.fullmatch(units):
        return (values - 32.0) / 1.8 + CELSIUS_ZERO_K
    if units in _PARTS_OF_KELVIN:
        return values * _PARTS_OF_KELVIN[units]
    return None


def doubted_kelvin(values: Array, stored: Array, units: str) -> str:
    """Return why values of any shape cannot be brightness temperatures in kelvin; empty if they can.

    They were converted from those that are ``stored`` in ``units``, which are stated or assumed.
    """
    median, hottest = np.percentile(values[np.isfinite(values)], (50.0, HOTTEST_PERCENTILE))
    if LIKE_KELVIN[0] <= median <= LIKE_KELVIN[1] and hottest <= HOTTEST_K:
        return ""
    low, high = LIKE_KELVIN
    return (
        f"a median of {median:.5g} K, and {100.0 - HOTTEST_PERCENTILE:g} % of the pixels above {hottest:.5g} K; "
        f"allowed: brightness temperatures with a median of {low:g} to {high:g} K, and few above {HOTTEST_K:g} K"
        f"{closest_reading(stored, units)}"
    )


def closest_reading(stored: Array, units: str) -> str:
    """Return, as the end of a message, the other unit in which values would be temperatures; empty if none."""
    finite = stored[np.isfinite(stored)]
    as_stated = in_kelvin(finite, units)
    for unit in READINGS if finite.size else ():
        kelvin = in_kelvin(finite, unit)
        if kelvin is None or np.array_equal(kelvin, finite if as_stated is None else as_stated):
            continue
        coldest, median, hottest = np.percentile(kelvin, (100.0 - HOTTEST_PERCENTILE, 50.0, HOTTEST_PERCENTILE))
        if LIKE_KELVIN[0] <= median <= LIKE_KELVIN[1] and coldest + LEAST_SPAN_K <= hottest <= HOTTEST_K:
            return f"; closest is the unit {unit}: {coldest:.5g} to {hottest:.5g} K"
    return ""


def fill_values(values: Array, units: str) -> list[float]:
    """Return the values of an image of any quantity that are fill values; the fewest first that explain a gap."""
    unitless = units.casefold() in _UNITLESS
    lows, highs = _ends(values)
    has_levels = _has_levels(values)
    counts = sorted(product(range(len(lows)), range(len(highs))), key=sum)
    for at_low, at_high in counts[1:]:
        low, high = lows[at_low], highs[-1 - at_high]
        if not low < high:
            continue
        below, above = lows[:at_low], highs[len(highs) - at_high :]
        gaps = [low - value for value in below[-1:]] + [value - high for value in above[:1]]
        cut = [*below, *above]
        if unitless and like_kelvin(low, high, values) and not any(_is_kelvin(value) for value in cut):
            return cut
        # The second form is that of a value in single precision.
        usual = all(_FILL.fullmatch(f"{value:.10g}") or _FILL.fullmatch(f"{value:.6g}") for value in cut)
        if usual and (all(gap > high - low for gap in gaps) or (low >= 0.0 and not above)):
            return cut
        # Black is no fill value: it may be a calm sea.
        if has_levels and 0.0 not in cut and all(gap > FAR * (high - low) for gap in gaps):
            return cut
    return []


def _is_kelvin(value: float) -> bool:
    return KELVIN_LIMITS[0] <= value <= KELVIN_LIMITS[1]


def like_kelvin(low: float, high: float, values: Array) -> bool:
    """Whether values from ``low`` to ``high`` may be kelvin; grey levels of 8 bits are none."""
    return LIKE_KELVIN[0] <= low <= high <= LIKE_KELVIN[1] and not (high <= 255.0 and _has_8_bits(values))


def _like_part_of_kelvin(values: Array) -> str:
    """Return dK or cK if values, zero left out, may be brightness temperatures times 10 or 100; else nothing."""
    stored = values[np.isfinite(values) & (values > 0.0)]
    if not stored.size:
        return ""
    low, high = np.percentile(stored, (1.0, 99.0))
    found = (unit for unit, factor in (("dK", 0.1), ("cK", 0.01)) if like_kelvin(factor * low, factor * high, values))
    return next(found, "")


def _has_8_bits(values: Array) -> bool:
    finite = values[np.isfinite(values)]
    return bool(np.all((finite >= 0.0) & (finite <= 255.0) & (finite == np.rint(finite))))


def _ends(values: Array) -> tuple[list[float], list[float]]:
    """Return the least and the greatest different values, ascending; one more than there can be fills at each end."""
    ends = []
    for sign in (1.0, -1.0):
        rest = sign * values[np.isfinite(values)]
        found: list[float] = []
        while rest.size and len(found) <= MOST_FILLS:
            found.append(float(rest.min()))
            rest = rest[rest > found[-1]]
        ends.append([sign * value for value in found][:: int(sign)])
    return ends[0], ends[1]


def questions(values: Array, units: str, bright: bool, stated: bool) -> Iterator[str]:
    """Yield what cannot be decided from the values of an examined image, whose cloud is ``bright``, as ``stated``."""
    finite = values[np.isfinite(values)]
    low, high = (float(percentile) for percentile in np.percentile(finite, (1.0, 99.0)))
    if not stated and units.casefold() in _UNITLESS:
        if like_kelvin(low, high, values):
            yield (
                f"Are the values, {low:.5g} to {high:.5g}, brightness temperatures in kelvin? Then cold is cloud: "
                "state cloud_is, or the unit K in the file."
            )
        elif low < -10.0 and LIKE_CELSIUS[0] <= float(finite.min()) and float(finite.max()) <= LIKE_CELSIUS[1]:
            yield (
                f"Are the values, {low:.5g} to {high:.5g}, temperatures in degrees Celsius? Then cold is cloud: state "
                "cloud_is, or the unit degC in the file."
            )
        elif part := _like_part_of_kelvin(values):
            yield (
                f"Are the values, {low:.5g} to {high:.5g}, brightness temperatures in {part}? Then cold is cloud: "
                f"state cloud_is, or the unit {part} in the file."
            )
    if not _has_levels(values):
        return
    lows, highs = _ends(values)
    extreme, rest = (highs[-1], highs[:-1] or lows[:1]) if bright else (lows[0], lows[1:] or highs[-1:])
    full = extreme == (255.0 if bright else 0.0)
    span = rest[-1] - lows[0] if bright else highs[-1] - rest[0]
    if full and abs(extreme - (rest[-1] if bright else rest[0])) > (span if bright else 0.0):
        count = np.count_nonzero(values == extreme)
        yield f"{extreme:g} ({count} pixels) is far from the rest and counts as the thickest cloud. Is it a fill value?"
    edge = _border(values)
    if edge is not None and edge == extreme:
        yield f"The image has a border of {edge:g}, which counts as the thickest cloud. Does it show anything?"


def _has_levels(values: Array) -> bool:
    """Whether an image has more levels than masks and classes, whose ranges say nothing about gaps."""
    sample = values.ravel()[:: max(1, values.size // 100_000)]
    return bool(np.unique(sample[np.isfinite(sample)]).size >= _FEW_LEVELS)


def _depths(values: Array, value: float, tolerance: float) -> tuple[int, int, int, int]:
    """Return how many rows and columns at the top, bottom, left and right have one value."""
    same = np.abs(values - value) <= tolerance
    rows, columns = (np.flatnonzero(~np.all(same, axis=axis)) for axis in (1, 0))
    if not rows.size:
        return 0, 0, 0, 0
    last_row, last_column = (size - 1 for size in values.shape)
    return int(rows[0]), last_row - int(rows[-1]), int(columns[0]), last_column - int(columns[-1])


def _border(values: Array) -> float | None:
    """Return the value of a border of at least two rows or columns; None without one."""
    for corner in (values[0, 0], values[-1, -1], values[0, -1], values[-1, 0]):
        if max(_depths(values, float(corner), _tolerance(values, float(corner)))) >= 2:
            return float(corner)
    return None


def _tolerance(values: Array, edge: float) -> float:
    """Return by how much pixels of a border differ: black and white ones by two levels in compressed pictures.

    Other colours must be exact: a smooth sea differs as little.
    """
    of_picture = float(np.nanmin(values)) >= 0.0 and 64.0 < float(np.nanmax(values)) <= 255.0
    return 2.0 if of_picture and not 2.0 < edge < 253.0 else 0.0


def without_border(values: Array) -> list[str]:
    """Make a border missing whose value the inner pixels do not have, and name it."""
    edge = _border(values)
    if edge is None:
        return []
    tolerance = _tolerance(values, edge)
    top, bottom, left, right = _depths(values, edge, tolerance)
    rows, columns = values.shape
    inner = values[top : rows - bottom, left : columns - right]
    if not _has_levels(inner) or np.count_nonzero(np.abs(inner - edge) <= tolerance) > _BORDER_SHARE * inner.size:
        return []
    kept = np.full(values.shape, np.nan)
    kept[top : rows - bottom, left : columns - right] = inner
    values[...] = kept
    return [
        f"A border of the value {edge:g} ({top}, {bottom}, {left} and {right} pixels at top, bottom, left and right) "
        "is taken for missing."
    ]
