"""Summary of all draws: moments, quantiles, and each input's Sobol indices."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import Array
from hcss_uncertainty import estimators
from hcss_uncertainty.estimators import bootstrap_error, terms_of
from hcss_uncertainty.joint_sample import POSTERIOR, SEED, bootstrap_seed

if TYPE_CHECKING:
    import xarray as xr


QUANTILES = (0.025, 0.05, 0.16, 0.25, 0.5, 0.75, 0.84, 0.95, 0.975)

OUTPUTS = (
    "radiance",
    "brightness_temperature",
    "radiance_spread",
    "brightness_temperature_spread",
    "class_fraction",
    "metric",
)
"""Summarised variables of every propagation, which have a value for each draw."""

PAYLOAD = (
    "measured_radiance",
    "digital_number",
    "noise_radiance",
    "signal_to_noise",
    "nedt",
    "saturated_fraction",
    "measured_radiance_spread",
    "digital_number_spread",
)
"""Those of a propagation with a sensor; the digital number and saturation only if the sensor has them."""

IN_CLASSES = ("radiance", "brightness_temperature", "measured_radiance", "digital_number")
"""Variables with statistics over the pixels of a class."""


def outputs_of(drawn: xr.Dataset) -> list[str]:
    """Return the summarised variables that a propagation has."""
    return [name for name in (*OUTPUTS, *PAYLOAD) if name in drawn]


REST = "all but the seed"
NO_ESTIMATE, REGRESSION, PICK_FREEZE = "none", "regression", "pick-freeze"
_OfDraws = Callable[[NDArray[np.intp]], Array]


@dataclass(frozen=True)
class VarianceRow:
    """One row of the variance table: an input, or a group of inputs.

    A regression uses the columns ``inputs``, if any; ``mixture`` is the one with the inputs exchanged, if there is one.
    """

    name: str
    inputs: tuple[int, ...] = ()
    mixture: int | None = None


def rows_of(inputs: Sequence[str], keys: Sequence[str], mixtures: Sequence[str]) -> tuple[VarianceRow, ...]:
    """Return the rows of the variance table for inputs (parameters of the posterior, then uncertain keys).

    ``mixtures`` are the names of the computed mixtures.
    """
    exchanged = {name.removeprefix("other "): number for number, name in enumerate(mixtures)}
    parameters = tuple(number for number, name in enumerate(inputs) if name not in keys)
    rows = [VarianceRow(REST), VarianceRow(SEED, mixture=1)]
    if parameters:
        rows.append(VarianceRow(POSTERIOR, parameters, exchanged.get(POSTERIOR)))
    rows += [
        VarianceRow(name, (number,), exchanged.get(name) if name in keys else None)
        for number, name in enumerate(inputs)
    ]
    return tuple(rows)


def estimator_names(rows: Sequence[VarianceRow], mixtures: int) -> tuple[list[str], list[str]]:
    """Return the estimators of the first-order and total-effect Sobol index of each row."""
    full = mixtures > 2
    first = [
        PICK_FREEZE
        if row.name == REST or (full and row.mixture is not None)
        else (REGRESSION if row.inputs else NO_ESTIMATE)
        for row in rows
    ]
    total = [PICK_FREEZE if row.name == SEED or (full and row.mixture is not None) else NO_ESTIMATE for row in rows]
    return first, total


def summarise(drawn: xr.Dataset) -> xr.Dataset:
    """Return mean, standard deviation, quantiles and shares of each of :func:`outputs_of`, with standard errors.

    Some scenes may lack an output (a class without pixels, morphology without clouds). Its moments and quantiles then
    use the ``..._scenes`` scenes of both seeds that have it. Shares compare scenes of the same draw, so they use the
    ``..._draws`` draws that have it in all mixtures.
    """
    import xarray as xr

    outputs = outputs_of(drawn)
    shapes = {name: drawn[name].shape[2:] for name in outputs}
    values = np.concatenate(
        [drawn[name].values.reshape(*drawn[name].shape[:2], -1) for name in outputs], axis=2
    ).astype(np.float64)
    mixtures = [str(name) for name in drawn["mixture"].values]
    inputs = [str(name) for name in drawn["input"].values]
    keys = [name for name, kind in zip(inputs, drawn["input_kind"].values, strict=True) if kind == "key"]
    rows = rows_of(inputs, keys, mixtures)
    seed = bootstrap_seed(int(drawn.attrs["seed"]))
    estimates = _estimates(values, drawn["input_value"].values, rows, seed)
    first, total = estimator_names(rows, len(mixtures))
    summary = xr.Dataset(
        coords={
            "quantile": ("quantile", list(QUANTILES), {"long_name": "share of scenes below", "units": "1"}),
            "source": ("source", [row.name for row in rows], {"long_name": "input, or several together"}),
            "first_order_estimator": ("source", first, {"long_name": "how first-order shares are estimated"}),
            "total_estimator": ("source", total, {"long_name": "how total shares are estimated"}),
        }
    )
    begin = 0
    for name in outputs:
        size = int(np.prod(shapes[name]))
        about, dims = drawn[name].attrs, drawn[name].dims[2:]
        for statistic, (values_of, front) in estimates.items():
            block = values_of[..., begin : begin + size]
            array = block.reshape(*block.shape[:-1], *shapes[name])
            summary[f"{name}_{statistic}"] = (
                (*front, *dims),
                array,
                {"long_name": _meaning(statistic, about["long_name"]), "units": _units(statistic, about["units"])},
            )
        begin += size
    return summary


def _estimates(
    values: Array, inputs: Array, rows: Sequence[VarianceRow], seed: np.random.SeedSequence
) -> dict[str, tuple[NDArray[Any], tuple[str, ...]]]:
    """Return each statistic (front, output) with the names of its leading dimensions."""
    width, sources = values.shape[2], len(rows)
    fronts: dict[str, tuple[str, ...]] = {
        "mean": (),
        "standard_deviation": (),
        "quantile": ("quantile",),
        "first_order": ("source",),
        "total": ("source",),
    }
    sizes = {"quantile": (len(QUANTILES),), "first_order": (sources,), "total": (sources,)}
    estimates: dict[str, tuple[NDArray[Any], tuple[str, ...]]] = {}
    for name, front in fronts.items():
        for suffix in ("", "_error"):
            estimates[f"{name}{suffix}"] = np.full((*sizes.get(name, ()), width), np.nan), front
    known = np.isfinite(values)
    estimates["scenes"] = known[:2].sum(axis=(0, 1)).astype(np.int32), ()
    estimates["draws"] = np.all(known, axis=0).sum(axis=0).astype(np.int32), ()

    def keep(names: Sequence[str], columns: NDArray[np.intp], estimate: _OfDraws, count: int) -> None:
        ends = np.cumsum([sizes.get(name, (1,))[0] for name in names])[:-1]
        every, error = estimate(np.arange(count)), bootstrap_error(estimate, count, seed)
        for suffix, stacked in (("", every), ("_error", error)):
            for name, block in zip(names, np.split(stacked, ends), strict=True):
                estimates[f"{name}{suffix}"][0][..., columns] = block if name in sizes else block[0]

    # Columns that are present in the same scenes are summarised together.
    patterns, pattern_of = np.unique(known.reshape(-1, width), axis=1, return_inverse=True)
    for number in range(patterns.shape[1]):
        columns = np.flatnonzero(pattern_of.ravel() == number)
        pattern = patterns[:, number].reshape(known.shape[:2])
        some, every = np.flatnonzero(pattern[:2].any(axis=0)), np.flatnonzero(pattern.all(axis=0))
        if some.size >= 2:
            present = np.ascontiguousarray(values[:2, some][:, :, columns])
            keep(("mean", "standard_deviation", "quantile"), columns, partial(_moments, present), some.size)
        if every.size >= 2:
            present = np.ascontiguousarray(values[:, every][:, :, columns])
            terms = [terms_of(inputs[every][:, row.inputs], every.size) if row.inputs else None for row in rows]
            keep(("first_order", "total"), columns, partial(_shares, present, terms, rows), every.size)
    return estimates


def _moments(y: Array, draws: NDArray[np.intp]) -> Array:
    """Return stacked mean, standard deviation and quantiles of some draws, (statistic, output)."""
    drawn = y[:, draws]
    several = estimators.quantiles(drawn, QUANTILES)
    return np.concatenate([estimators.mean(drawn)[None], estimators.standard_deviation(drawn)[None], several])


def _shares(y: Array, terms: Sequence[Array | None], rows: Sequence[VarianceRow], draws: NDArray[np.intp]) -> Array:
    """Return stacked first-order and total-effect Sobol indices of some draws, (share, output)."""
    drawn = y[:, draws]
    blank = np.full(drawn.shape[2], np.nan)
    full = drawn.shape[0] > 2
    first, total = [], []
    for row, basis in zip(rows, terms, strict=True):
        if row.name == REST:
            first.append(estimators.first_by_rest(drawn))
        elif full and row.mixture is not None:
            first.append(estimators.first_by_pick_freeze(drawn, 2, row.mixture))
        elif basis is not None:
            first.append(estimators.first_by_regression(basis[draws], drawn))
        else:
            first.append(blank)
        if row.name == SEED:
            total.append(estimators.total_by_seed(drawn))
        elif full and row.mixture is not None:
            total.append(estimators.total_by_pick_freeze(drawn, 2, row.mixture))
        else:
            total.append(blank)
    return np.concatenate([np.stack(first), np.stack(total)])


def pooled_pixels(drawn: xr.Dataset) -> Iterator[tuple[str, tuple[tuple[str, ...], Array, Mapping[str, str]]]]:
    """Yield statistics of the pixels of a class over all draws, each pixel with equal weight.

    These are the mean, standard deviation and quantiles of the variables of ``IN_CLASSES`` in the first mixture.
    """
    weight = drawn["class_pixels"].values[0].astype(np.float64)  # draw, class
    for name in filter(drawn.__contains__, IN_CLASSES):
        about = drawn[name].attrs
        mean, spread = drawn[name].values[0], drawn[f"{name}_spread"].values[0]
        weights = np.broadcast_to(weight[:, None], mean.shape)
        total = weights.sum(axis=0)
        with np.errstate(invalid="ignore"):
            level = np.where(weights > 0, weights * mean, 0.0).sum(axis=0) / total
            square = np.where(weights > 0, weights * (spread**2 + (mean - level) ** 2), 0.0).sum(axis=0) / total
        quantile = np.full((len(QUANTILES), *level.shape), np.nan)
        for band in range(level.shape[0]):
            for kind in range(level.shape[1]):
                atoms = drawn[f"{name}_level"].values[:, band, kind]
                quantile[:, band, kind] = _weighted_quantiles(atoms, weight[:, kind])
        for statistic, front, array in (
            ("mean", (), level),
            ("standard_deviation", (), np.sqrt(square)),
            ("quantile", ("quantile",), quantile),
        ):
            label = f"{statistic.replace('_', ' ')} over the pixels of all draws together, of {name.replace('_', ' ')}"
            units = _units(statistic, about["units"])
            yield (
                f"{name}_pixel_{statistic}",
                ((*front, "band", "class"), array, {"long_name": label, "units": units}),
            )


def _weighted_quantiles(atoms: Array, weight: Array) -> Array:
    """Quantiles of levels (draw, level), weighted by the number of pixels in each draw."""
    present = weight > 0
    if not np.any(present):
        return np.full(len(QUANTILES), np.nan)
    values = atoms[present].astype(np.float64)
    weights = np.repeat(weight[present] / values.shape[1], values.shape[1])
    order = np.argsort(values, axis=None, kind="stable")
    share = (np.cumsum(weights[order]) - 0.5 * weights[order]) / weights.sum()
    return np.interp(QUANTILES, share, values.ravel()[order])


def _meaning(statistic: str, output: str) -> str:
    words = {
        "mean": "mean over scenes that have it",
        "standard_deviation": "standard deviation over scenes that have it",
        "quantile": "quantile over scenes that have it",
        "first_order": "first-order share of the variance over draws that have it in all mixtures",
        "total": "total share of the variance over draws that have it in all mixtures",
    }
    if statistic == "scenes":
        return f"scenes of the draws with both seeds that have it, for moments and quantiles: {output}"
    if statistic == "draws":
        return f"draws that have it in all mixtures, for shares: {output}"
    base = statistic.removesuffix("_error")
    error = "standard error of the " if statistic.endswith("_error") else ""
    return f"{error}{words[base]}: {output}"


def _units(statistic: str, units: str) -> str:
    shares = statistic.startswith(("first_order", "total", "scenes", "draws"))
    return "1" if shares else units
