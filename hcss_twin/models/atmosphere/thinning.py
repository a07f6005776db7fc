"""Thinning of profiles: levels that interpolation reproduces are removed."""

from __future__ import annotations

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.atmosphere.moist_air import saturation_pressure_Pa

FEW_LEVELS = 150
"""Profiles with at most this many levels are not thinned."""

TOLERANCES = {"temperature": 0.2, "relative_humidity": 0.02, "ln_pressure": 2e-4}
"""Maximum deviation (K, 1, 1) of a dropped level from the line between the remaining levels."""


def thinned(columns: dict[str, Array], name: str, notes: list[str]) -> dict[str, Array]:
    """Drop levels that interpolation between other levels reproduces, and add a note.

    The method keeps the level farthest from the line and repeats on both halves (D. H. Douglas and T. K. Peucker,
    Cartographica 10, 112 (1973)); temperature, relative humidity and the logarithm of pressure are linear in altitude
    between levels.

    Parameters
    ----------
    columns : dict of str to ndarray (L,)
        Including altitude, pressure, temperature and h2o.
    name : str
        Name of the profile, for the note.
    notes : list of str
        Receives a note if levels are dropped.

    Returns
    -------
    dict of str to ndarray (K,)
    """
    altitude = columns["altitude"]
    if altitude.size <= FEW_LEVELS:
        return columns
    # Above 332 K the saturation formula is not valid, and there is no humidity to preserve.
    saturation = saturation_pressure_Pa(np.clip(columns["temperature"], 123.0, 332.0))
    scaled = np.stack(
        (
            columns["temperature"] / TOLERANCES["temperature"],
            columns["h2o"] * columns["pressure"] / saturation / TOLERANCES["relative_humidity"],
            np.log(columns["pressure"]) / TOLERANCES["ln_pressure"],
        )
    )
    keep = np.zeros(altitude.size, dtype=bool)
    keep[[0, -1]] = True
    pending = [(0, altitude.size - 1)]
    while pending:
        low, high = pending.pop()
        if high - low < 2:
            continue
        share = (altitude[low : high + 1] - altitude[low]) / (altitude[high] - altitude[low])
        line = scaled[:, [low]] + share * (scaled[:, [high]] - scaled[:, [low]])
        away = np.max(np.abs(scaled[:, low : high + 1] - line), axis=0)
        farthest = int(np.argmax(away))
        if away[farthest] > 1.0:
            middle = low + farthest
            keep[middle] = True
            pending += [(low, middle), (middle, high)]
    if keep.all():
        return columns
    notes.append(
        f"profile '{name}': {int(keep.sum())} of {altitude.size} levels kept; the others lie within "
        f"{TOLERANCES['temperature']:g} K and {100 * TOLERANCES['relative_humidity']:g} % relative humidity of the "
        "lines between them"
    )
    return {column: values[keep] for column, values in columns.items()}
