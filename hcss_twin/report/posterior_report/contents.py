"""Density of a prior, from the way it is written in the file of a posterior.

What the page of a posterior needs of its file, beside the draws.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin.analysis.uncertainty.parameter_space import KINDS, Prior
from hcss_twin.analysis.uncertainty.posterior_file import Posterior, read_posterior
from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import PosteriorError


def prior_density(name: str, text: str, values: Array) -> Array | None:
    """Return the density of a parameter's prior at values (n,), cut off where the parameter ends.

    Parameters
    ----------
    name : str
        Of the parameter: ``H``, ``mean_H``, ``spread_H``, ...; one that is not known has no limits.
    text : str
        As :meth:`hcss_twin.analysis.uncertainty.parameter_space.Prior.parse` reads it.
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


_DIAGNOSTICS = ("autocorrelation_time_steps", "effective_sample_size", "split_r_hat")


@dataclass(frozen=True)
class Variogram:
    """Observed and predicted variogram.

    Attributes
    ----------
    lag : ndarray (lag,)
        Pixels.
    axes : tuple of str
        Directions of the lag.
    observed, error : ndarray (image, lag, axis)
    quantiles : ndarray (quantile,)
    predicted : ndarray (quantile, image, lag, axis)
    """

    lag: Array
    axes: tuple[str, ...]
    observed: Array
    error: Array
    quantiles: Array
    predicted: Array


@dataclass(frozen=True)
class Contents:
    """A posterior with what its file says beside the draws.

    Attributes
    ----------
    posterior : Posterior
    scalars : dict of str to ndarray (chain, draw)
        Parameters that are one number: of one image, or of the population of several.
    of_images : dict of str to ndarray (chain, draw, image)
        Parameters of each of several images.
    meanings, priors : mapping of str to str
        Of each variable.
    diagnostics : mapping of str to (float, float, float)
        Autocorrelation time in steps, effective sample size, split R-hat.
    traces : dict of str to ndarray (chain, step)
        All steps, burn-in included; empty where the file has none.
    variogram : Variogram or None
    """

    posterior: Posterior
    scalars: dict[str, Array]
    of_images: dict[str, Array]
    meanings: Mapping[str, str]
    priors: Mapping[str, str]
    diagnostics: Mapping[str, tuple[float, float, float]]
    traces: dict[str, Array]
    variogram: Variogram | None


def read_contents(path: Path) -> Contents:
    """Read a posterior.

    Raises
    ------
    PosteriorError
        If it is none, has not converged or is damaged.
    """
    import netCDF4

    posterior = read_posterior(path)
    chains = posterior.chains
    try:
        with netCDF4.Dataset(path) as file:
            file.set_auto_mask(False)
            attributes = {name: _attributes(file[name]) for name in chains}
            traces = _traces(file)
            variogram = _variogram(file)
    except (OSError, RuntimeError, IndexError) as error:
        raise PosteriorError(f"cannot read {path}: damaged: {error}") from error
    return Contents(
        posterior,
        {name: values for name, values in chains.items() if values.ndim == 2},
        {name: values for name, values in chains.items() if values.ndim == 3},
        {name: str(each.get("long_name", name)) for name, each in attributes.items()},
        {name: str(each.get("prior", "")) for name, each in attributes.items()},
        {
            name: (found[0], found[1], found[2])
            for name, each in attributes.items()
            if len(found := [float(each[key]) for key in _DIAGNOSTICS if key in each]) == len(_DIAGNOSTICS)
        },
        traces,
        variogram,
    )


def _attributes(variable: Any) -> dict[str, Any]:
    return {name: variable.getncattr(name) for name in variable.ncattrs()}


def _texts(variable: Any) -> list[str]:
    """Return labels, whether they are stored as text or as letters."""
    values = np.asarray(variable[...])
    if values.dtype.kind == "S" and values.ndim > 1 and values.dtype.itemsize == 1:
        return [b"".join(row).decode() for row in values]
    return [each.decode() if isinstance(each, bytes) else str(each) for each in values]


def _traces(file: Any) -> dict[str, Array]:
    if not {"trace", "parameter"} <= set(file.variables):
        return {}
    values = np.asarray(file["trace"][...], dtype=np.float64)
    names = [name.rstrip("\0 ") for name in _texts(file["parameter"])]
    return dict(zip(names, values, strict=True))


def _variogram(file: Any) -> Variogram | None:
    names = ("lag", "axis", "quantile", "variogram_observed", "variogram_error", "variogram_predicted")
    if not set(names) <= set(file.variables):
        return None
    lag, quantiles, observed, error, predicted = (
        np.asarray(file[name][...], dtype=np.float64) for name in names if name != "axis"
    )
    if observed.ndim == 2:  # one image
        observed, error, predicted = observed[None], error[None], predicted[:, None]
    return Variogram(lag, tuple(_texts(file["axis"])), observed, error, quantiles, predicted)
