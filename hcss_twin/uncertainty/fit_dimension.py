"""Posterior of the parameters of fractal clouds, given only a fractal dimension."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin.errors import PosteriorError
from hcss_twin.uncertainty.batch_variogram import BatchVariogram
from hcss_twin.uncertainty.chains import walkers_of
from hcss_twin.uncertainty.dimension_likelihood import DimensionLikelihood
from hcss_twin.uncertainty.fit_options import FitOptions
from hcss_twin.uncertainty.fit_run import FitRun, Progress
from hcss_twin.uncertainty.posterior_file import Posterior, read_posterior
from hcss_twin.uncertainty.posterior_model import SingleModel
from hcss_twin.uncertainty.result import write_result
from hcss_twin.uncertainty.space import Space
from hcss_twin.uncertainty.usual_priors import fixed_number, usual_priors

FRAME = (800, 800, 20.0)
"""Rows, columns and pixel size of an image of which only the dimension is given: the paper's."""


def fit_dimension(
    dimension: float,
    error: float,
    output: str | os.PathLike[str],
    *,
    rows: int = FRAME[0],
    columns: int = FRAME[1],
    pixel_size_m: float = FRAME[2],
    progress: Progress | None = None,
    **options: Any,
) -> Posterior:
    """Sample the posterior given nothing but the fractal dimension of grey levels, by the variogram.

    Parameters
    ----------
    dimension, error : float
        D, as ``variogram_dimension`` measures it, and its standard deviation.
    output : path
        As of :func:`fit`.
    rows, columns, pixel_size_m
        Of the image in which it was measured.
    progress, **options
        As of :func:`fit`.

    Raises
    ------
    PosteriorError
        As of :func:`fit`.
    """
    chosen = FitOptions(**options)
    chosen.check()
    if min(rows, columns) < 32 or not 0.0 < pixel_size_m < float("inf"):
        raise PosteriorError(
            f"frame: {rows} x {columns} pixels of {pixel_size_m:g} m given, allowed: 32 or more along each axis, of "
            "a size greater than 0"
        )
    numbers = {name: fixed_number(name, value) for name, value in chosen.fixed.items()}
    space = Space.of(numbers, chosen.priors, usual_priors([(rows, columns, pixel_size_m)]))
    likelihood = DimensionLikelihood(
        dimension, error, rows, columns, pixel_size_m, BatchVariogram.of(chosen.octaves)
    )
    about = repr((dimension, error, rows, columns, pixel_size_m))
    run = FitRun(Path(output), chosen, space, (), about, progress)
    model = SingleModel(space, likelihood)
    state = run.resume()
    rng = np.random.default_rng(np.random.SeedSequence([chosen.seed, 1]))
    candidates = space.draw(rng, 64 * walkers_of(len(space.names)))
    best = np.argsort(-model.log_probability(candidates), kind="stable")
    pilot = candidates[best[: candidates.shape[0] // 8]]
    chains, convergence = run.sample(model, (), [pilot], state)
    more = run.about() | {"fractal_dimension": dimension, "fractal_dimension_error": error}
    notes = [
        f"A fractal dimension of {dimension:g} +- {error:g} in {rows} rows x {columns} columns of {pixel_size_m:g} m."
    ]
    write_result(Path(output), model, space, [], chains, convergence, [], more, chosen.seed, notes)
    run.done()
    return read_posterior(Path(output))
