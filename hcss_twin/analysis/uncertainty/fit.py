"""Posterior of the parameters of fractal clouds, given one image or several.

Posterior of the parameters of fractal clouds, given only a fractal dimension.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin.analysis.matching.target import ImageChoice, Target, read_target
from hcss_twin.analysis.uncertainty.batch_variogram import BatchVariogram
from hcss_twin.analysis.uncertainty.chains import walkers_of
from hcss_twin.analysis.uncertainty.fit_options import FitOptions, fixed_number, space_of, usual_priors
from hcss_twin.analysis.uncertainty.fit_run import FitRun, Progress
from hcss_twin.analysis.uncertainty.image_data import ImageData
from hcss_twin.analysis.uncertainty.image_likelihood import ImageLikelihood
from hcss_twin.analysis.uncertainty.population import PopulationModel
from hcss_twin.analysis.uncertainty.posterior_file import Posterior, read_posterior
from hcss_twin.analysis.uncertainty.posterior_model import DimensionLikelihood, SingleModel
from hcss_twin.analysis.uncertainty.prepare import SIMULATIONS, prepare
from hcss_twin.analysis.uncertainty.result import write_result
from hcss_twin.analysis.uncertainty.space import Space
from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import PosteriorError

# With it priors are checked before an image is read.
_ANY_FRAME = (800, 800, 20.0)


def fit(
    images: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    output: str | os.PathLike[str],
    *,
    choice: ImageChoice | None = None,
    progress: Progress | None = None,
    **options: Any,
) -> Posterior:
    """Sample the posterior of cloud parameters given one image, or several of one kind, and write it.

    Parameters
    ----------
    images : path, or sequence of paths
        What ``hcss match`` reads. Several images have a population, of which mean and spread are sampled with the
        parameters of each.
    output : path
        NetCDF file to write; nothing is written where chains have not converged. Beside it
        ``OUTPUT.state`` is kept until they have: a fit that was interrupted goes on from there.
    choice : ImageChoice, optional
        Part of the images, and what in them is cloud.
    progress : callable, optional
        Is told what is being done, and which part of that.
    **options
        Of :class:`FitOptions`.

    Returns
    -------
    Posterior

    Raises
    ------
    PosteriorError
        If an option is not allowed, chains have not converged, or the file cannot be written.
    ImageError, CatalogError, ScenarioError
        If an image cannot be used.
    """
    chosen = FitOptions(**options)
    chosen.check()
    paths = [Path(images)] if isinstance(images, str | os.PathLike) else [Path(each) for each in images]
    if not paths:
        raise PosteriorError("images: none given, allowed: one or more")
    # Images take long to read, and what is wrong with them is not to hide what is wrong here.
    space_of(chosen, 0.5, [_ANY_FRAME], several=len(paths) > 1)
    targets = [read_target(path, choice) for path in paths]
    digests = [hashlib.sha256(path.read_bytes()).hexdigest() for path in paths]
    inputs = [(target.source, digest) for target, digest in zip(targets, digests, strict=True)]
    return fit_targets(targets, Path(output), inputs, chosen, progress)


def fit_targets(
    targets: Sequence[Target],
    output: Path,
    inputs: Sequence[tuple[str, str]],
    options: FitOptions,
    progress: Progress | None = None,
) -> Posterior:
    """As :func:`fit`, for images that have been read; ``inputs`` are names and SHA-256 of their files."""
    options.check()
    data = [ImageData.of(target.image, options.smallest_lag) for target in targets]
    several = len(data) > 1
    from_image = options.fixed.get("coverage") == "image"
    coverage = float(np.mean([each.coverage for each in data]))
    frames = [(each.rows, each.columns, each.pixel_size_m) for each in data]
    space, spreads = space_of(options, coverage, frames, several=several)
    likelihoods = [ImageLikelihood.of(each, options.octaves, not from_image, options.misfit) for each in data]
    digest = hashlib.sha256(repr(from_image).encode())
    for each in data:
        digest.update(repr((each.rows, each.columns, each.pixel_size_m, each.cloudy)).encode())
        digest.update(each.variogram.tobytes())
    run = FitRun(output, options, space, spreads, digest.hexdigest(), progress)
    state = run.resume()
    if state is None:
        prepared = [
            _prepare(likelihood, space, options.seed, index, len(likelihoods), run.told)
            for index, likelihood in enumerate(likelihoods)
        ]
        likelihoods = [likelihood for likelihood, _ in prepared]
        pilots = [pilot for _, pilot in prepared]
    else:
        likelihoods = [
            likelihood.with_noise(noise) for likelihood, noise in zip(likelihoods, state.noises, strict=True)
        ]
        pilots = []
    model: SingleModel | PopulationModel = (
        PopulationModel(space, tuple(likelihoods), spreads) if several else SingleModel(space, likelihoods[0])
    )
    chains, convergence = run.sample(model, tuple(likelihoods), pilots, state)
    notes = [note for target in targets for note in target.notes]
    write_result(output, model, space, likelihoods, chains, convergence, inputs, run.about(), options.seed, notes)
    run.done()
    return read_posterior(output)


def _prepare(
    likelihood: ImageLikelihood, space: Space, seed: int, index: int, count: int, told: Progress
) -> tuple[ImageLikelihood, Array]:
    total, done = count * sum(SIMULATIONS), index * sum(SIMULATIONS)

    def simulated(number: int) -> None:
        nonlocal done
        done += number
        told("simulating", done / total)

    return prepare(likelihood, space, np.random.SeedSequence([seed, 0, index]), simulated)


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
    likelihood = DimensionLikelihood(dimension, error, rows, columns, pixel_size_m, BatchVariogram.of(chosen.octaves))
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
