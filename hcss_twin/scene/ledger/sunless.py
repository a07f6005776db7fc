"""Whether sunlight matters at all: by day, too, some scenes can do without."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import Sun
from hcss_twin.scene.building.assembly import Assembly
from hcss_twin.scene.ledger.few_columns import ROOM, FewColumns, few_columns
from hcss_twin.scene.ledger.sun_frames import SunFrames

Array = NDArray[np.float64]

_PER_BAND = 16
_THICKNESSES = 3
"""Clouds of each layer from its thinnest to its thickest."""


def negligible_sunlight(assembly: Assembly, sun: SunFrames, limit: float) -> float | None:
    """Return the largest share of sunlight in any band of any column, where it is below a limit.

    A band costs little less without sunlight while another needs it, so that it is left out of all or none.

    Parameters
    ----------
    sun : SunFrames
    limit : float
        Relative to the total of a band.

    Returns
    -------
    float or None
        None where sunlight matters, or is below the horizon anyway.
    """
    suns = [position for _, position in sun.telling(assembly.view) if position is not None]
    if not suns:
        return None
    largest = 0.0
    columns = few_columns(assembly, _PER_BAND)
    cloudy = replace(columns, clear=False, thickness_m=_thicknesses(assembly))
    # Clear sky is computed in no time and settles most scenes.
    for part in (replace(columns, thickness_m=cloudy.thickness_m[:0]), cloudy):
        if not (part.clear or part.thickness_m.size):
            continue
        for each in suns:
            largest = max(largest, ROOM * _share(assembly, part, each))
            if largest > limit:
                return None
    return largest


def _share(assembly: Assembly, columns: FewColumns, sun: Sun) -> float:
    terms = columns.terms(assembly.model, sun)
    total = np.sum(list(terms.values()), axis=0)
    sunlight = sum((terms[name] for name in assembly.model.solar_terms), np.zeros_like(total))
    return float(np.max(sunlight[total > 0] / total[total > 0], initial=0.0))


def _thicknesses(assembly: Assembly) -> Array:
    """Columns (N, L): the extreme ones, and each layer alone between its limits."""
    rows = [assembly.extreme_thicknesses_m]
    for index, (layer, cloudy) in enumerate(zip(assembly.layers, assembly.cloudy_layers, strict=True)):
        if cloudy and layer.thickness_min_m < layer.thickness_max_m:
            between = np.geomspace(layer.thickness_min_m, layer.thickness_max_m, _THICKNESSES)[1:-1]
            alone = np.zeros((between.size, len(assembly.layers)))
            alone[:, index] = between
            rows.append(alone)
    return np.concatenate(rows)
