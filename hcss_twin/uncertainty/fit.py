"""Posterior of the parameters of fractal clouds, given one image or several."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import PosteriorError
from hcss_twin.matching.target import ImageChoice, Target, read_target
from hcss_twin.uncertainty.fit_options import FitOptions
from hcss_twin.uncertainty.fit_run import FitRun, Progress
from hcss_twin.uncertainty.image_data import ImageData
from hcss_twin.uncertainty.image_likelihood import ImageLikelihood
from hcss_twin.uncertainty.population_model import PopulationModel
from hcss_twin.uncertainty.posterior_file import Posterior, read_posterior
from hcss_twin.uncertainty.posterior_model import SingleModel
from hcss_twin.uncertainty.prepare import SIMULATIONS, prepare
from hcss_twin.uncertainty.result import write_result
from hcss_twin.uncertainty.space import Space
from hcss_twin.uncertainty.usual_priors import space_of

Array = NDArray[np.float64]

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
    write_result(
        output, model, space, likelihoods, chains, convergence, inputs, run.about(), options.seed, notes
    )
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
