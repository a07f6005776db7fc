"""Levels of measured ascents that a profile can use: complete, above the sea, and of falling pressure."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError

SWING_PA, SWING_M, SWING_K = 200.0, 30.0, 2.0
"""By how much a level may be below the one before and still count as the same: sondes swing, and values are rounded."""

_Levels = NDArray[np.intp]


def usable_levels(
    name: str, where: tuple[str, ...], columns: dict[str, Array]
) -> tuple[tuple[str, ...], dict[str, Array], list[str]]:
    """Return the levels from the sea upwards that a profile can use, and notes on those left out.

    Parameters
    ----------
    name : str
        Of the file, for messages.
    where : tuple of str (L,)
        Position of each level in the file.
    columns : mapping of str to ndarray (L,)
        Values in SI units; missing ones are NaN.

    Raises
    ------
    CatalogError
        If the levels are not sorted, contradict each other, or fewer than two remain.
    """
    told = []
    pressure = columns["pressure"]
    if pressure.size > 1 and np.nanargmin(pressure) < np.nanargmax(pressure):  # from space down
        columns, where = {key: values[::-1] for key, values in columns.items()}, where[::-1]
    levels = np.arange(len(where))
    for reason, left in (
        ("without a value", _incomplete), ("below the sea", _below_the_sea), ("that repeat a pressure", _repeated)
    ):  # fmt: skip
        out = left(name, where, {key: values[levels] for key, values in columns.items()}, levels)
        if out.size:
            shown = ", ".join(where[level] for level in out[:3].tolist()) + (", ..." if out.size > 3 else "")
            told.append(f"profile '{name}': {out.size} levels {reason} not used ({shown})")
            levels = np.setdiff1d(levels, out)
    if levels.size < 2:
        raise CatalogError(f"{name}: {levels.size} levels; at least 2 are needed")
    kept = {key: values[levels] for key, values in columns.items()}
    return tuple(where[level] for level in levels.tolist()), kept, told


def _incomplete(name: str, where: tuple[str, ...], columns: dict[str, Array], levels: _Levels) -> _Levels:
    """Return the levels that lack a value."""
    return levels[np.any(np.isnan(list(columns.values())), axis=0)]


def _below_the_sea(name: str, where: tuple[str, ...], columns: dict[str, Array], levels: _Levels) -> _Levels:
    """Return the levels below the sea, as reanalyses have where the air pressure is low."""
    heights = [columns[height] for height in ("altitude", "geopotential_height") if height in columns]
    return levels[heights[0] < 0.0] if heights else levels[:0]


def _repeated(name: str, where: tuple[str, ...], columns: dict[str, Array], levels: _Levels) -> _Levels:
    """Return the levels whose pressure is not below that of the level before, or whose height is not above it.

    Sondes report every second, and their values are rounded and swing somewhat. Levels that are farther apart than that
    are an error.
    """
    pressure, temperature = columns["pressure"], columns["temperature"]
    label = next((height for height in ("altitude", "geopotential_height") if height in columns), "")
    height = columns[label] if label else -np.log(np.maximum(pressure, 1e-9))
    out, last = [], 0
    for level in range(1, levels.size):
        if pressure[level] < pressure[last] and height[level] > height[last]:
            last = level
            continue
        here, before = where[levels[level]], where[levels[last]]
        if pressure[level] > pressure[last] + SWING_PA:
            raise CatalogError(
                f"{name}, {here}: pressure {pressure[level] / 100:g} hPa does not fall below the "
                f"{pressure[last] / 100:g} hPa of {before}; allowed: levels sorted by pressure"
            )
        if height[level] < height[last] - SWING_M or pressure[level] < pressure[last] - SWING_PA:
            raise CatalogError(
                f"{name}, {here}: {label} {height[level]:g} m does not exceed the {height[last]:g} m of {before}"
            )
        if abs(temperature[level] - temperature[last]) > SWING_K:
            raise CatalogError(
                f"{name}, {here}: temperature {temperature[level]:g} K at {pressure[level] / 100:g} hPa, and "
                f"{temperature[last]:g} K at {pressure[last] / 100:g} hPa in {before}; allowed: one temperature of "
                f"each pressure, within {SWING_K:g} K"
            )
        out.append(level)
    return levels[np.array(out, dtype=np.intp)]
