"""Posterior file: NetCDF-4 with chains over (chain, draw), version 2; version 1 is read."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.errors import PosteriorError
from hcss_evaluate.posterior.mixing import Mixing, mixing
from hcss_twin import __version__
from hcss_twin.core.arguments import checked
from hcss_twin.core.files import Writing
from hcss_twin.core.reading import Reading
from hcss_twin.providers import Array, NetcdfFile

VERSION_ATTRIBUTE = "hcss_posterior_version"
VERSION = 2

PARAMETERS = ("H", "gamma", "Lx", "Ly", "coverage")
"""Parameters of one image, in their standard order."""

SUSPICIOUS = 0.01
"""Threshold of the predictive p-value, below which the image is unlike any fractal field."""

_FIXED = "fixed_"
_LOG_PROBABILITY = "log_probability"
_LAST_OCTAVE = "last_octave"
_QUANTILES = "variogram_predicted"
_AXES = ("x", "y")


@dataclass(frozen=True)
class Diagnostic:
    """Attributes of a variable of the file.

    The prior is written as given, for example ``uniform:0.02:0.98``; the integrated autocorrelation time is in steps of
    the sampler. The file adds the :class:`~hcss_evaluate.posterior.mixing.Mixing` of the draws that it stores.
    """

    long_name: str
    prior: str
    autocorrelation_time_steps: float


@dataclass(frozen=True)
class VariogramCheck:
    """Observed and predicted variogram of normal scores at lags in pixels; NaN at lags an image does not have.

    Observed values and errors are along x and y (lag, 2), or (image, lag, 2) for several images; the error is one
    standard deviation of the estimate at the posterior mean. ``predicted`` (quantile, lag, 2) or (quantile, image, lag,
    2) has posterior predictive quantiles, including the scatter of an image.
    """

    lags: NDArray[np.int64]
    observed: Array
    error: Array
    quantiles: Array
    predicted: Array


@dataclass(frozen=True)
class Posterior:
    """Draws from a converged posterior.

    Attributes
    ----------
    chains : dict of str to ndarray (chain, draw) or (chain, draw, image)
        Free parameters; of several images also ``mean_NAME`` and ``spread_NAME`` (chain, draw).
    fixed : dict of str to float
        Fixed parameters.
    attributes : dict
        Global attributes of the file.
    diagnostics : dict of str to dict
        Attributes of each of ``chains``, as in :class:`Diagnostic` and
        :class:`~hcss_evaluate.posterior.mixing.Mixing`.
    last_octave : ndarray of int64 (chain, draw) or (chain, draw, image), optional
        Last octave of the fractal sum that belongs to each draw; None where one octave is assumed (``octaves`` in
        ``attributes``).
    """

    chains: dict[str, Array]
    fixed: dict[str, float]
    attributes: dict[str, Any] = field(default_factory=dict)
    diagnostics: dict[str, dict[str, Any]] = field(default_factory=dict)
    last_octave: NDArray[np.int64] | None = None

    @property
    def samples(self) -> dict[str, Array]:
        """Concatenated draws of all chains: (n,), or (n, image) for parameters of several images."""
        return {name: values.reshape(-1, *values.shape[2:]) for name, values in self.chains.items()}

    @property
    def doubts(self) -> list[dict[str, Any]]:
        """Reasons to doubt intervals: ``image``, ``parameters`` and ``reason`` of each; empty without any."""
        return list(json.loads(self.attributes.get("doubts", "[]")))

    @property
    def predictive_p_values(self) -> list[tuple[str, float]]:
        """Name and posterior predictive p-value of each image; empty without images.

        The p-value is the fraction of images drawn from the posterior whose variogram lies at least as far from the
        mean as the image's.
        """
        found = np.atleast_1d(self.attributes.get("predictive_p_value", [])).tolist()
        names = [str(source["name"]) for source in json.loads(self.attributes["inputs"])] if found else []
        return list(zip(names, found, strict=True))


def write_posterior(
    path: Path,
    *,
    title: str,
    inputs: Sequence[tuple[str, str]],
    chains: Mapping[str, Array],
    log_probability: Array,
    diagnostics: Mapping[str, Diagnostic],
    fixed: Mapping[str, float],
    priors: Mapping[str, str],
    seed: int,
    trace: tuple[Sequence[str], Array] | None = None,
    variogram: VariogramCheck | None = None,
    last_octave: NDArray[np.int64] | None = None,
    attributes: Mapping[str, Any] | None = None,
) -> None:
    """Write a posterior atomically: on failure, ``path`` is unchanged.

    The same arguments give the same bytes, as the file contains no date. Raises PosteriorError if it cannot be written.

    Parameters
    ----------
    inputs : sequence of (str, str)
        Name and SHA-256 of each input file; empty without input files.
    chains : mapping of str to ndarray (chain, draw) or (chain, draw, image)
        As in :attr:`Posterior.chains`, with an entry in ``diagnostics`` for each.
    log_probability : ndarray (chain, draw)
        Natural logarithm of the posterior density, up to a constant.
    fixed, priors : mapping
        Fixed parameters, and the priors of the free ones, as given.
    seed : int
        Seed of simulations and chains.
    trace : (sequence of str, ndarray (parameter, chain, step)), optional
        Names and values of all steps, burn-in included, perhaps thinned.
    variogram : VariogramCheck, optional
        Predictive check of the variogram.
    last_octave : ndarray of int64, optional
        As in :attr:`Posterior.last_octave`.
    attributes : mapping, optional
        Additional global attributes.
    """
    with Writing(path, PosteriorError, "NetCDF") as draft, NetcdfFile(draft, "w") as file:
        file.setncatts({"Conventions": "CF-1.11", VERSION_ATTRIBUTE: np.int32(VERSION), "title": title})
        file.setncatts(
            {
                "source": ", ".join(name for name, _ in inputs) or "no file",
                "inputs": json.dumps([{"name": name, "sha256": digest} for name, digest in inputs]),
                "priors": json.dumps(dict(priors)),
                "seed": np.int64(seed),
                "hcss_version": __version__,
                "converged": "true",
            }
        )
        file.setncatts({f"{_FIXED}{name}": float(value) for name, value in fixed.items()})
        file.setncatts(dict(attributes or {}))
        _write_chains(file, chains, diagnostics)
        _write(file, _LOG_PROBABILITY, ("chain", "draw"), log_probability, "logarithm of the posterior density")
        if last_octave is not None:
            dimensions = ("chain", "draw", "image")[: last_octave.ndim]
            _write(file, _LAST_OCTAVE, dimensions, last_octave, "last octave k of the fractal sum, from k = 0")
        if trace is not None:
            _write_trace(file, *trace)
        if variogram is not None:
            _write_variogram(file, variogram)


@checked
@Reading.argument(PosteriorError)
def read_posterior(path: str | os.PathLike[str]) -> Posterior:
    """Read the draws of a posterior.

    Raises PosteriorError if the file is missing, damaged, not a posterior, of another version, or not converged.
    """
    path = Path(path)
    if not path.is_file():
        raise PosteriorError(f"cannot read {path}: there is no such file")
    with Reading(path, PosteriorError, "not a NetCDF file, or damaged").netcdf() as dataset:
        attributes = {name: dataset.getncattr(name) for name in dataset.ncattrs()}
        _check_header(path, attributes)
        chains = {
            name: np.asarray(np.ma.getdata(variable[...]), dtype=np.float64)
            for name, variable in dataset.variables.items()
            if variable.dimensions[:2] == ("chain", "draw") and name not in (_LOG_PROBABILITY, _LAST_OCTAVE)
        }
        last_octave = None
        if _LAST_OCTAVE in dataset.variables:
            last_octave = np.asarray(np.ma.getdata(dataset[_LAST_OCTAVE][...]), dtype=np.int64)
        kept = fields(Diagnostic) + (fields(Mixing) if attributes[VERSION_ATTRIBUTE] == VERSION else ())
        diagnostics = {
            name: {statistic.name: dataset[name].getncattr(statistic.name) for statistic in kept} for name in chains
        }
    if not chains or not all(values.size and np.isfinite(values).all() for values in chains.values()):
        raise PosteriorError(f"cannot read {path}: damaged: no draws, or draws that are not finite")
    if attributes[VERSION_ATTRIBUTE] == 1:  # whose sizes were those of the chains before they were thinned
        diagnostics = {name: attributes | asdict(mixing(chains[name])) for name, attributes in diagnostics.items()}
    fixed = {name.removeprefix(_FIXED): float(value) for name, value in attributes.items() if name.startswith(_FIXED)}
    return Posterior(chains, fixed, attributes, diagnostics, last_octave)


def _check_header(path: Path, attributes: Mapping[str, Any]) -> None:
    version = attributes.get(VERSION_ATTRIBUTE)
    if version is None:
        raise PosteriorError(f"cannot read {path}: it is not a posterior of hcss fit")
    if version not in (1, VERSION):
        raise PosteriorError(f"cannot read {path}: {VERSION_ATTRIBUTE} {version}, allowed: 1 or {VERSION}")
    if attributes.get("converged") != "true":
        raise PosteriorError(f"cannot read {path}: its chains have not converged")


def _write_chains(file: Any, chains: Mapping[str, Array], diagnostics: Mapping[str, Diagnostic]) -> None:
    for name, values in chains.items():
        attributes = asdict(diagnostics[name]) | asdict(mixing(values))
        _write(file, name, ("chain", "draw", "image")[: values.ndim], values, attributes.pop("long_name"))
        file[name].setncatts(attributes)


def _write_trace(file: Any, names: Sequence[str], values: Array) -> None:
    width = max(len(name) for name in names)
    file.createDimension("parameter", len(names))
    file.createDimension("character", width)
    labels = file.createVariable("parameter", "S1", ("parameter", "character"))
    labels.long_name = "parameter"
    labels._Encoding = "ascii"
    labels[:] = np.array([name.encode() for name in names], dtype=f"S{width}")
    meaning = "all steps of all walkers, burn-in included, evenly thinned"
    _write(file, "trace", ("parameter", "chain", "step"), values.astype(np.float32), meaning)


def _write_variogram(file: Any, check: VariogramCheck) -> None:
    plane = ("image", "lag", "axis")[3 - check.observed.ndim :]
    file.createDimension("axis", len(_AXES))
    axis = file.createVariable("axis", "S1", ("axis",))
    axis.long_name = "direction of the lag"
    axis[:] = np.array([name.encode() for name in _AXES], dtype="S1")
    _write(file, "lag", ("lag",), check.lags, "distance in pixels")
    _write(file, "quantile", ("quantile",), check.quantiles, "probability")
    meaning = "semivariance of the normal scores of grey levels, clear pixels at the threshold"
    _write(file, "variogram_observed", plane, check.observed, meaning)
    _write(file, "variogram_error", plane, check.error, f"standard deviation of the {meaning}, of one image")
    _write(file, _QUANTILES, ("quantile", *plane), check.predicted, f"posterior predictive quantiles of the {meaning}")


def _write(file: Any, name: str, dimensions: tuple[str, ...], values: NDArray[Any], meaning: str) -> None:
    for dimension, size in zip(dimensions, values.shape, strict=True):
        if dimension not in file.dimensions:
            file.createDimension(dimension, size)
    variable = file.createVariable(name, values.dtype, dimensions, compression="zlib", shuffle=True, fill_value=False)
    variable.setncatts({"long_name": meaning, "units": "1"})
    variable[:] = values
