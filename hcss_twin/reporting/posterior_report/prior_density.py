"""Density of a prior, from the way it is written."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def prior_density(text: str, values: Array) -> Array | None:
    """Return the density of a prior at values (n,), or None where it is written in another way.

    Parameters
    ----------
    text : str
        ``uniform:LOW:HIGH``, ``loguniform:LOW:HIGH``, ``normal:MEAN:DEVIATION``, or ``lognormal:MEDIAN:DEVIATION`` with
        the standard deviation of the logarithm. Limits of the parameter that cut a normal one off are not in the text
        and not in the density.
    values : ndarray (n,)
    """
    kind, *rest = text.split(":")
    try:
        first, second = (float(each) for each in rest)
    except ValueError:
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        if kind == "uniform":
            density = np.full_like(values, 1.0 / (second - first))
        elif kind == "loguniform":
            density = 1.0 / (values * np.log(second / first))
        elif kind == "normal":
            return np.asarray(np.exp(-0.5 * ((values - first) / second) ** 2) / (second * np.sqrt(2 * np.pi)))
        elif kind == "lognormal":
            away = np.log(values / first) / second
            found = np.exp(-0.5 * away**2) / (values * second * np.sqrt(2 * np.pi))
            return np.where(values > 0.0, found, 0.0)
        else:
            return None
    return np.where((values >= first) & (values <= second), density, 0.0)
