"""How much brighter one pixel of a scene can be than another: the bound of whatever moves clouds about."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_twin.scene.building.assembly import Assembly
from hcss_twin.scene.ledger.few_columns import ROOM
from hcss_twin.scene.slant.sea_sun import sea_sun_terms

Array = NDArray[np.float64]


def largest_contrast(assembly: Assembly, known: Sequence[Mapping[str, Array]]) -> float:
    """Return the largest difference between two pixels of a frame in any band, relative to the darker one.

    Parameters
    ----------
    known : sequence of mapping of str to ndarray (C, B)
        Terms of the columns that bound the scene, the clear one first, under some suns.
    """
    largest = 0.0
    for terms in known:
        total = np.sum(list(terms.values()), axis=0)
        if assembly.slant.shadows and assembly.has_clear_sky:
            in_shadow = total[0] - np.sum([terms[name][0] for name in sea_sun_terms(assembly.model)], axis=0)
            total = np.concatenate((total, in_shadow[None]))
        darkest = np.min(total, axis=0)
        lit = darkest > 0.0
        largest = max(largest, float(np.max(np.max(total, axis=0)[lit] / darkest[lit] - 1.0, initial=0.0)))
    return ROOM * largest
