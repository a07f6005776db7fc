"""Write converged chains to a posterior file, with a posterior predictive check of the variogram."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.matching.structure import CloudImage
from hcss_evaluate.posterior.batch_variogram import DimensionLikelihood
from hcss_evaluate.posterior.chains import Convergence, MarkovChains, SingleModel, stored
from hcss_evaluate.posterior.doubts import doubts, unlikeness
from hcss_evaluate.posterior.image_likelihood import ImageLikelihood, on_scales
from hcss_evaluate.posterior.parameter_space import SHAPE, Space
from hcss_evaluate.posterior.population import PopulationModel
from hcss_evaluate.posterior.posterior_file import Diagnostic, VariogramCheck, write_posterior
from hcss_evaluate.posterior.priors import KINDS
from hcss_twin.providers import Array

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)

_DRAWS = 2000


def predictive_check(
    likelihoods: Sequence[ImageLikelihood],
    values: Sequence[Array],
    lasts: Sequence[NDArray[np.int64]],
    rng: np.random.Generator,
) -> tuple[VariogramCheck, list[float]]:
    """Compare images with replicates drawn from the posterior.

    ``values`` are draws (N, 5) of all parameters of each image, ``lasts`` (N,) of its last octave. Returns the check,
    with an image axis if there are several images, and a p-value for each image: the fraction of replicates at least as
    far from the mean as the image (squared Mahalanobis distance; A. Gelman et al., Bayesian Data Analysis, 3rd ed.,
    section 6.3).
    """
    lags = np.unique(np.concatenate([likelihood.data.lags for likelihood in likelihoods]))
    count = len(likelihoods)
    observed = np.full((count, lags.size, 2), np.nan)
    error = np.full((count, lags.size, 2), np.nan)
    predicted = np.full((len(QUANTILES), count, lags.size, 2), np.nan)
    p_values = []
    for image, (likelihood, drawn, last) in enumerate(zip(likelihoods, values, lasts, strict=True)):
        chosen = rng.integers(0, drawn.shape[0], _DRAWS)
        drawn, last = drawn[chosen], last[chosen]
        rows = np.searchsorted(lags, likelihood.data.lags)
        shape = (-1, 2, rows.size)
        replicates = np.exp(likelihood.replicate(drawn[:, : len(SHAPE)], last, rng)).reshape(shape)
        centre = likelihood.replicate(_mean_shape(drawn, _DRAWS), last, rng)
        observed[image, rows] = likelihood.data.variogram.reshape(2, -1).T
        error[image, rows] = np.exp(centre).std(axis=0).reshape(2, -1).T
        predicted[:, image, rows] = np.moveaxis(np.quantile(replicates, QUANTILES, axis=0), 1, 2)
        p_values.append(_p_value(likelihood, drawn, last, rng))
    if count == 1:
        observed, error, predicted = observed[0], error[0], predicted[:, 0]
    return VariogramCheck(lags, observed, error, np.array(QUANTILES), predicted), p_values


def _mean_shape(drawn: Array, count: int) -> Array:
    position = on_scales(drawn[:, : len(SHAPE)]).mean(axis=0)
    shape = np.array([KINDS[name].scale.back(np.array(p)) for name, p in zip(SHAPE, position, strict=True)])
    return np.tile(shape, (count, 1))


def _p_value(likelihood: ImageLikelihood, drawn: Array, lasts: NDArray[np.int64], rng: np.random.Generator) -> float:
    noise = likelihood.noise
    assert noise is not None
    positions, residuals, _ = likelihood.residuals(drawn, lasts)
    distance = noise.square_distance(positions, residuals)
    replicated = rng.chisquare(noise.lower.shape[0], drawn.shape[0])
    return float(np.mean(replicated >= distance))


# Steps of the trace.
_LONGEST_TRACE = 500

_TITLE = "Posterior of the parameters of fractal clouds"
_ON_SCALE = {"value": "", "logarithm": " (of the natural logarithm)", "probit": " (of the normal quantile)"}


def write_result(
    path: Path,
    model: SingleModel | PopulationModel,
    space: Space,
    likelihoods: Sequence[ImageLikelihood | DimensionLikelihood],
    images: Sequence[CloudImage],
    chains: MarkovChains,
    convergence: Convergence,
    inputs: Sequence[tuple[str, str]],
    about: Mapping[str, Any],
    seed: int,
    notes: Sequence[str],
) -> None:
    """Thin chains to nearly independent draws, check them against the images, and write the file.

    Raises PosteriorError if the file cannot be written.
    """
    every = convergence.every
    draws = stored(chains.positions[chains.after_burn_in], every)
    density = stored(chains.log_probability[chains.after_burn_in], every)
    values = model.values(draws)
    priors = json.loads(about["priors"])
    more = {name: value for name, value in about.items() if name != "priors"}
    variogram = None
    rng = np.random.default_rng(np.random.SeedSequence([seed, 3]))
    drawn = [
        space.complete(_position(model, draws, image)).reshape(-1, len(KINDS)) for image in range(len(likelihoods))
    ]
    lasts = [likelihood.draw_lasts(draws, rng) for likelihood, draws in zip(likelihoods, drawn, strict=True)]
    of_images = [likelihood for likelihood in likelihoods if isinstance(likelihood, ImageLikelihood)]
    if of_images:
        variogram, p_values = predictive_check(of_images, drawn, lasts, rng)
        unlike = [unlikeness(*image_parts, rng) for image_parts in zip(images, of_images, drawn, lasts, strict=True)]
        more["predictive_p_value"] = p_values
        more["unlikeness"] = unlike
        more["image_coverage"] = [likelihood.data.coverage for likelihood in of_images]
        more["pixel_size_m"] = [likelihood.data.pixel_size_m for likelihood in of_images]
        names = [name for name, _ in inputs]
        each_image = zip(names, of_images, drawn, p_values, unlike, strict=True)
        found = [
            asdict(doubt)
            for name, likelihood, draws, p_value, ratio in each_image
            for doubt in doubts(name, likelihood, draws, space, p_value, ratio, about.get("cloud_type"))
        ]
        more["doubts"] = json.dumps(found)
    more["notes"] = "\n".join(notes)
    step = math.ceil(chains.positions.shape[0] / _LONGEST_TRACE)
    traced = model.values(chains.positions[::step].swapaxes(0, 1))
    names, rows = [], []
    for name, value in traced.items():
        several = value.ndim == 3
        names += [f"{name}[{image}]" for image in range(value.shape[2])] if several else [name]
        rows += [value[..., image] for image in range(value.shape[2])] if several else [value]
    write_posterior(
        path,
        title=_TITLE,
        inputs=inputs,
        chains=values,
        log_probability=density,
        diagnostics=_diagnostics(model, values, convergence, priors),
        fixed=space.fixed,
        priors=priors,
        seed=seed,
        trace=(names, np.stack(rows)),
        variogram=variogram,
        last_octave=_last_octaves(lasts, density.shape, likelihoods),
        attributes=more | {"thinned_steps": every, "burn_in_steps": chains.after_burn_in.start},
    )


def _last_octaves(
    lasts: Sequence[NDArray[np.int64]],
    shape: tuple[int, ...],
    likelihoods: Sequence[ImageLikelihood | DimensionLikelihood],
) -> NDArray[np.int64] | None:
    """Return the draws of unknown last octaves (chain, draw) or (chain, draw, image)."""
    if likelihoods[0].variogram.octaves.known:
        return None
    octaves = np.stack([last.reshape(shape) for last in lasts], axis=-1)
    return octaves if len(lasts) > 1 else octaves[..., 0]


def _position(model: SingleModel | PopulationModel, positions: Array, image: int) -> Array:
    """Return positions of one image's own parameters."""
    if isinstance(model, SingleModel):
        return positions
    count = len(model.space.names)
    return positions[..., (2 + image) * count : (3 + image) * count]


def _diagnostics(
    model: SingleModel | PopulationModel,
    values: Mapping[str, Array],
    convergence: Convergence,
    priors: Mapping[str, str],
) -> dict[str, Diagnostic]:
    """Return the attributes of each variable; for parameters of several images, the longest time of all images."""
    diagnostics = {}
    for name in values:
        columns = [
            i for i, column_name in enumerate(model.names) if column_name == name or column_name.startswith(f"{name}[")
        ]
        plain = name.removeprefix("mean_").removeprefix("spread_")
        kind = KINDS[plain]
        meaning, prior = kind.long_name, priors.get(name, priors[plain])
        if name.startswith("mean_"):
            meaning = f"location of the population{_ON_SCALE[kind.scale.kind]}, transformed back: {meaning}"
        elif name.startswith("spread_"):
            meaning = f"standard deviation in the population{_ON_SCALE[kind.scale.kind]}: {meaning}"
        elif len(columns) > 1 or isinstance(model, PopulationModel):
            prior = "the population"
        diagnostics[name] = Diagnostic(meaning, prior, float(np.max(convergence.autocorrelation_time[columns])))
    return diagnostics
