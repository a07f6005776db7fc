"""What an image shows, and which of its pixels show nothing although the file does not say so.

Fill values that a file does not declare would be the brightest or coldest cloud of all. They are recognised by their
distance from the rest, and treated as missing; what cannot be decided from the values is a question to the user.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.clouds.imagery.image import SatelliteImage, in_kelvin

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


def examined(path: Path, image: SatelliteImage) -> SatelliteImage:
    """Return an image without the pixels that show nothing: NaN, with notes that name them.

    Parameters
    ----------
    path : Path
        The file, for messages.
    image : SatelliteImage
        As read; NaN where the file states that there is no value. Temperatures are converted to K.

    Raises
    ------
    CatalogError
        If the image has a side of one pixel, no two different values, or temperatures that are none.
    """
    rows, columns = image.values.shape
    if min(rows, columns) < 2:
        raise CatalogError(f"{path}: an image of {rows} x {columns} pixels; allowed: 2 or more rows and columns")
    notes = []
    stored, image = image, in_kelvin(image)
    values = np.where(np.isfinite(image.values), image.values, np.nan)
    infinite = np.count_nonzero(np.isinf(image.values))
    if infinite:
        notes.append(f"Infinite values ({infinite} pixels) are taken for missing.")
    _require_contrast(path, values)
    while fills := _impossible(path, image, stored, values) if image.is_temperature else _fills(image, values):
        counts = [int(np.count_nonzero(values == value)) for value in fills]
        values[np.isin(values, fills)] = np.nan
        rest = f"{np.nanmin(values):.5g} to {np.nanmax(values):.5g}"
        notes += [
            f"{value:g} ({count} pixels) is far from the rest, {rest}: taken for missing."
            for value, count in zip(fills, counts, strict=True)
        ]
    notes += _without_border(values)
    _require_contrast(path, values)
    if image.is_temperature:
        doubt = doubted_kelvin(values, stored)
        if doubt:
            raise CatalogError(f"{path}: {image.variable or image.long_name} (stated unit: {stored.units}): {doubt}")
    return replace(image, values=values, notes=(*image.notes, *notes))


def _require_contrast(path: Path, values: Array) -> None:
    finite = values[np.isfinite(values)]
    if finite.size == 0:
        raise CatalogError(f"{path}: all {values.size} pixels are missing")
    if finite.min() == finite.max():
        raise CatalogError(f"{path}: all pixels have the value {finite[0]:g}; clouds need a contrast")


def _impossible(path: Path, image: SatelliteImage, stored: SatelliteImage, values: Array) -> list[float]:
    """Return the values, at most a few, that are no brightness temperatures; raises CatalogError if there are many."""
    low, high = KELVIN_LIMITS
    wrong = values[(values < low) | (values > high)]
    different = np.unique(wrong)
    if different.size > 2 * MOST_FILLS or 2 * wrong.size > np.count_nonzero(np.isfinite(values)):
        raise CatalogError(
            f"{path}: {wrong.size} pixels of {image.variable or image.long_name} have values from {wrong.min():.5g} to "
            f"{wrong.max():.5g} K (stated unit: {stored.units}); allowed: brightness temperatures "
            f"of {low:g} to {high:g} K{closest_reading(stored) or '; are scale_factor and add_offset missing?'}"
        )
    return [float(value) for value in different]


def doubted_kelvin(values: Array, stored: SatelliteImage) -> str:
    """Return why values of any shape cannot be brightness temperatures in kelvin; empty if they can.

    ``stored`` has the values, and the unit that is stated or assumed, from which they were converted.
    """
    median, hottest = np.percentile(values[np.isfinite(values)], (50.0, HOTTEST_PERCENTILE))
    if LIKE_KELVIN[0] <= median <= LIKE_KELVIN[1] and hottest <= HOTTEST_K:
        return ""
    low, high = LIKE_KELVIN
    return (
        f"a median of {median:.5g} K, and {100.0 - HOTTEST_PERCENTILE:g} % of the pixels above {hottest:.5g} K; "
        f"allowed: brightness temperatures with a median of {low:g} to {high:g} K, and few above {HOTTEST_K:g} K"
        f"{closest_reading(stored)}"
    )


def assumed_kelvin(values: Array) -> SatelliteImage:
    """Return values without a stated unit as the image of temperature for which they are taken."""
    return SatelliteImage(values, None, False, "K", "", "")


def closest_reading(stored: SatelliteImage) -> str:
    """Return, as the end of a message, the other unit in which values would be temperatures; empty if none."""
    finite = stored.values[np.isfinite(stored.values)]
    as_stated = in_kelvin(replace(stored, values=finite)).values
    for unit in READINGS if finite.size else ():
        kelvin = in_kelvin(replace(stored, values=finite, units=unit)).values
        if np.array_equal(kelvin, as_stated):
            continue
        coldest, median, hottest = np.percentile(kelvin, (100.0 - HOTTEST_PERCENTILE, 50.0, HOTTEST_PERCENTILE))
        if LIKE_KELVIN[0] <= median <= LIKE_KELVIN[1] and coldest + LEAST_SPAN_K <= hottest <= HOTTEST_K:
            return f"; closest is the unit {unit}: {coldest:.5g} to {hottest:.5g} K"
    return ""


def _fills(image: SatelliteImage, values: Array) -> list[float]:
    """Return the values of an image of any quantity that are fill values; the fewest first that explain a gap."""
    unitless = image.units.casefold() in _UNITLESS
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


def questions(image: SatelliteImage, bright: bool, stated: bool) -> Iterator[str]:
    """Yield what cannot be decided from the values of an examined image, whose cloud is ``bright``, as ``stated``."""
    values = image.values
    finite = values[np.isfinite(values)]
    low, high = (float(percentile) for percentile in np.percentile(finite, (1.0, 99.0)))
    if not stated and image.units.casefold() in _UNITLESS:
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


def _without_border(values: Array) -> list[str]:
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
