"""Density of a prior, from the way it is written in the file of a posterior."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import PosteriorError
from hcss_twin.uncertainty.priors import Prior
from hcss_twin.uncertainty.scales import KINDS

Array = NDArray[np.float64]


def prior_density(name: str, text: str, values: Array) -> Array | None:
    """Return the density of a parameter's prior at values (n,), cut off where the parameter ends.

    Parameters
    ----------
    name : str
        Of the parameter: ``H``, ``mean_H``, ``spread_H``, ...; one that is not known has no limits.
    text : str
        As :meth:`hcss_twin.uncertainty.priors.Prior.parse` reads it.
    values : ndarray (n,)

    Returns
    -------
    ndarray (n,) or None
        None where it is written in another way.
    """
    low, high = -math.inf, math.inf
    kind = KINDS.get(name.removeprefix("mean_"))
    if name.startswith("spread_"):
        low = 0.0
    elif kind is not None:
        low, high = kind.low, kind.high
    try:
        return Prior.parse(name, text, low, high).density(values)
    except PosteriorError:
        return None
