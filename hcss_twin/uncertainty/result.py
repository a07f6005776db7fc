"""From chains that have converged to the file of the posterior."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.uncertainty.chains import Chains
from hcss_twin.uncertainty.convergence import Convergence
from hcss_twin.uncertainty.image_likelihood import ImageLikelihood, on_scales
from hcss_twin.uncertainty.population_model import PopulationModel
from hcss_twin.uncertainty.posterior_file import Diagnostic, write_posterior
from hcss_twin.uncertainty.posterior_model import SingleModel
from hcss_twin.uncertainty.predictive import SUSPICIOUS, predictive_check
from hcss_twin.uncertainty.scales import KINDS, SHAPE
from hcss_twin.uncertainty.space import Space

Array = NDArray[np.float64]

# Steps of the trace.
_LONGEST_TRACE = 500

# Draws in these outer parts of the half-width of the range are at its edge; more of them than this are a crowd. Even
# draws have a part of _EDGE there.
_EDGE, _CROWDED = 0.02, 0.06

_TITLE = "Posterior of the parameters of fractal clouds"

_ON_SCALE = {"value": "", "logarithm": " (of the natural logarithm)", "probit": " (of the normal quantile)"}


def write_result(
    path: Path,
    model: SingleModel | PopulationModel,
    space: Space,
    likelihoods: Sequence[ImageLikelihood],
    chains: Chains,
    convergence: Convergence,
    inputs: Sequence[tuple[str, str]],
    about: Mapping[str, Any],
    seed: int,
    notes: Sequence[str],
) -> None:
    """Thin chains to independent draws, check them against the images, and write all.

    Raises
    ------
    PosteriorError
        If the file cannot be written.
    """
    import json

    every = math.ceil(float(np.max(convergence.autocorrelation_time)))
    kept = chains.positions[chains.kept][::every].swapaxes(0, 1)
    density = chains.log_probability[chains.kept][::every].T
    values = model.values(kept)
    priors = json.loads(about["priors"])
    more = {name: value for name, value in about.items() if name != "priors"}
    told = list(notes)
    variogram = None
    if likelihoods:
        rng = np.random.default_rng(np.random.SeedSequence([seed, 3]))
        drawn = [
            space.complete(_position(model, kept, image)).reshape(-1, len(KINDS))
            for image in range(len(likelihoods))
        ]
        variogram, p_values = predictive_check(likelihoods, drawn, rng)
        more["predictive_p_value"] = p_values
        more["image_coverage"] = [each.data.coverage for each in likelihoods]
        more["pixel_size_m"] = [each.data.pixel_size_m for each in likelihoods]
        for (name, _), likelihood, each in zip(inputs, likelihoods, drawn, strict=True):
            told += _at_edges(name, likelihood, each, space)
        told += [_suspicion(name, p) for (name, _), p in zip(inputs, p_values, strict=True) if p < SUSPICIOUS]
    more["notes"] = "\n".join(told)
    step = math.ceil(chains.positions.shape[0] / _LONGEST_TRACE)
    traced = model.values(chains.positions[::step].swapaxes(0, 1))
    names, rows = [], []
    for name, value in traced.items():
        if value.ndim == 2:
            names.append(name)
            rows.append(value)
        else:
            names += [f"{name}[{image}]" for image in range(value.shape[2])]
            rows += [value[..., image] for image in range(value.shape[2])]
    write_posterior(
        path,
        title=_TITLE,
        inputs=inputs,
        chains=values,
        log_probability=density,
        diagnostics=_diagnostics(model, values, convergence, priors),
        fixed={} if not space.fixed else space.fixed,
        priors=priors,
        seed=seed,
        trace=(names, np.stack(rows)),
        variogram=variogram,
        attributes=more | {"thinned_steps": every, "burn_in_steps": chains.kept.start},
    )


def _position(model: SingleModel | PopulationModel, kept: Array, image: int) -> Array:
    """Return positions of one image's own parameters."""
    if isinstance(model, SingleModel):
        return kept
    count = len(model.space.names)
    return kept[..., (2 + image) * count : (3 + image) * count]


def _diagnostics(
    model: SingleModel | PopulationModel,
    values: Mapping[str, Array],
    convergence: Convergence,
    priors: Mapping[str, str],
) -> dict[str, Diagnostic]:
    """Return what each variable says; of the parameters of several images, the worst image's."""
    found = {}
    for name in values:
        columns = [i for i, each in enumerate(model.names) if each == name or each.startswith(f"{name}[")]
        plain = name.removeprefix("mean_").removeprefix("spread_")
        kind = KINDS[plain]
        meaning, prior = kind.long_name, priors.get(name, priors[plain])
        if name.startswith("mean_"):
            meaning = f"location of the population{_ON_SCALE[kind.scale.kind]}, taken back: {meaning}"
        elif name.startswith("spread_"):
            meaning = f"standard deviation in the population{_ON_SCALE[kind.scale.kind]}: {meaning}"
        elif len(columns) > 1 or isinstance(model, PopulationModel):
            prior = "the population"
        found[name] = Diagnostic(
            meaning,
            prior,
            float(np.max(convergence.autocorrelation_time[columns])),
            float(np.min(convergence.effective_size[columns])),
            float(np.max(convergence.split_r_hat[columns])),
        )
    return found


def _at_edges(name: str, likelihood: ImageLikelihood, values: Array, space: Space) -> list[str]:
    """Say which parameters crowd at the edge of the prior, or of where the scatter was learned."""
    noise = likelihood.noise
    assert noise is not None
    lines = []
    position = on_scales(values[:, : len(SHAPE)])
    for column, parameter in enumerate(SHAPE):
        if parameter in space.fixed:
            continue
        away = np.abs(position[:, column] - noise.centre[column]) / noise.width[column]
        part = float(np.mean(away > 1.0 - _EDGE))
        if part > _CROWDED:
            lines.append(
                f"{name}: {part:.0%} of the draws of {parameter} lie at the edge of the prior, or of what was "
                "simulated: it is a limit and not a result."
            )
    return lines


def _suspicion(name: str, p_value: float) -> str:
    return (
        f"{name}: no fractal field has such a variogram (posterior predictive p = {p_value:.2g}): intervals are too "
        "narrow; a misfit greater than 0 or a larger smallest lag allows for that."
    )
