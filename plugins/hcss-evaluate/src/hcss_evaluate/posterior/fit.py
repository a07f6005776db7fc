"""Posterior of fractal cloud parameters given one image, several images, or a fractal dimension (``hcss fit``).

Before the chains run, simulations measure the scatter of the image statistics in the region of the posterior.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from hcss_evaluate.errors import PosteriorError
from hcss_evaluate.matching.dimension_range import PIXEL_SIZE_M, SIDE
from hcss_evaluate.matching.target import ImageChoice, Target, read_target
from hcss_evaluate.measures.images import SMALLEST_SIDE
from hcss_evaluate.posterior.batch_variogram import BatchVariogram, DimensionLikelihood
from hcss_evaluate.posterior.chains import SingleModel, begin, extend, walkers_of
from hcss_evaluate.posterior.fit_run import FitOptions, FitRun, Progress, fixed_number, space_of, usual_priors
from hcss_evaluate.posterior.image_data import ImageData
from hcss_evaluate.posterior.image_likelihood import ImageLikelihood
from hcss_evaluate.posterior.octaves import Octaves
from hcss_evaluate.posterior.parameter_space import SHAPE, Space
from hcss_evaluate.posterior.population import PopulationModel
from hcss_evaluate.posterior.posterior_file import Posterior, read_posterior
from hcss_evaluate.posterior.result import write_result
from hcss_twin.core.arguments import checked
from hcss_twin.core.files import Writing
from hcss_twin.providers import Array

FRAME = (SIDE, SIDE, PIXEL_SIZE_M)
"""Rows, columns and pixel size of the paper's images; also used to check priors before any image is read."""


@checked
def fit(
    images: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    output: str | os.PathLike[str],
    *,
    choice: ImageChoice | None = None,
    progress: Progress | None = None,
    **options: Any,
) -> Posterior:
    """Sample the posterior of cloud parameters given one image or several similar ones, and write it.

    Parameters
    ----------
    images : path, or sequence of paths
        Any image that ``hcss match`` reads. Several images form a population: its mean and spread are sampled together
        with the parameters of each image.
    output : path
        NetCDF file to write, only if the chains converge. Until then ``OUTPUT.state`` next to it holds the state, from
        which an interrupted fit resumes.
    choice : ImageChoice, optional
        Selection of the part of the images and of the cloud detection.
    progress : callable, optional
        Called with the current task and the fraction completed.
    **options
        Fields of :class:`FitOptions`.

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
    chosen = FitOptions(**options).of_type()
    chosen.check()
    paths = [Path(images)] if isinstance(images, str | os.PathLike) else [Path(image) for image in images]
    if not paths:
        raise PosteriorError("images: none given, allowed: one or more")
    # Check options before reading the images, which is slow and may fail for other reasons.
    space_of(chosen, 0.5, [FRAME], several=len(paths) > 1)
    targets = [read_target(path, choice) for path in paths]
    Writing(Path(output), PosteriorError, read=paths).check()
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
    """Same as :func:`fit` for images in memory; ``inputs`` are the names and SHA-256 of their files."""
    options = options.of_type()
    options.check()
    data = [ImageData.of(target.image, options.smallest_lag) for target in targets]
    several = len(data) > 1
    from_image = options.fixed.get("coverage") == "image"
    coverage = float(np.mean([image.coverage for image in data]))
    frames = [(image.rows, image.columns, image.pixel_size_m) for image in data]
    space, spreads = space_of(options, coverage, frames, several=several)
    octaves = Octaves.of(options.octaves)
    likelihoods = [ImageLikelihood.of(image, octaves, not from_image, options.misfit) for image in data]
    digest = hashlib.sha256(repr(from_image).encode())
    for image in data:
        digest.update(repr((image.rows, image.columns, image.pixel_size_m, image.cloudy)).encode())
        digest.update(image.variogram.tobytes())
    run = FitRun(output, options, space, spreads, digest.hexdigest(), progress)
    state = run.checkpoint.read()
    if state is None:
        prepared = [
            _prepare(likelihood, space, options.seed, index, len(likelihoods), run.progress)
            for index, likelihood in enumerate(likelihoods)
        ]
        likelihoods = [likelihood for likelihood, _ in prepared]
        pilots = [pilot for _, pilot in prepared]
    else:
        likelihoods = [
            replace(likelihood, noise=noise) for likelihood, noise in zip(likelihoods, state.noises, strict=True)
        ]
        pilots = []
    model: SingleModel | PopulationModel = (
        PopulationModel(space, tuple(likelihoods), spreads) if several else SingleModel(space, likelihoods[0])
    )
    chains, convergence = run.sample(model, tuple(likelihoods), pilots, state)
    notes = [*(note for target in targets for note in target.notes), octaves.text]
    images = [target.image for target in targets]
    write_result(
        output, model, space, likelihoods, images, chains, convergence, inputs, run.about(), options.seed, notes
    )
    run.checkpoint.remove()
    return read_posterior(output)


def _prepare(
    likelihood: ImageLikelihood, space: Space, seed: int, index: int, count: int, progress: Progress
) -> tuple[ImageLikelihood, Array]:
    total, done = count * sum(SIMULATIONS), index * sum(SIMULATIONS)

    def simulated(number: int) -> None:
        nonlocal done
        done += number
        progress("simulating", done / total)

    return prepare(likelihood, space, np.random.SeedSequence([seed, 0, index]), simulated)


@checked
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
    """Sample the posterior given only the fractal dimension of grey levels by the variogram.

    Raises PosteriorError as :func:`fit` does.

    Parameters
    ----------
    dimension, error : float
        D as measured by ``variogram_dimension``, and its standard deviation.
    output : path
        As for :func:`fit`.
    rows, columns, pixel_size_m
        Size and pixel size of the measured image.
    progress, **options
        As for :func:`fit`.
    """
    chosen = FitOptions(**options).of_type()
    chosen.check()
    if min(rows, columns) < SMALLEST_SIDE or not 0.0 < pixel_size_m < float("inf"):
        raise PosteriorError(
            f"frame: {rows} x {columns} pixels of {pixel_size_m:g} m given, allowed: {SMALLEST_SIDE} or more along "
            "each axis, of a size greater than 0"
        )
    numbers = {name: fixed_number(name, value) for name, value in chosen.fixed.items()}
    space = Space.of(numbers, chosen.priors, usual_priors([(rows, columns, pixel_size_m)]))
    octaves = Octaves.of(chosen.octaves)
    likelihood = DimensionLikelihood(dimension, error, rows, columns, pixel_size_m, BatchVariogram.of(octaves))
    about = repr((dimension, error, rows, columns, pixel_size_m))
    run = FitRun(Path(output), chosen, space, (), about, progress)
    model = SingleModel(space, likelihood)
    state = run.checkpoint.read()
    rng = np.random.default_rng(np.random.SeedSequence([chosen.seed, 1]))
    candidates = space.draw(rng, 64 * walkers_of(len(space.names)))
    best = np.argsort(-model.log_probability(candidates), kind="stable")
    pilot = candidates[best[: candidates.shape[0] // 8]]
    chains, convergence = run.sample(model, (), [pilot], state)
    more = run.about() | {"fractal_dimension": dimension, "fractal_dimension_error": error}
    notes = [
        f"A fractal dimension of {dimension:g} +- {error:g} in {rows} rows x {columns} columns of {pixel_size_m:g} m.",
        octaves.text,
    ]
    write_result(Path(output), model, space, [likelihood], [], chains, convergence, [], more, chosen.seed, notes)
    run.checkpoint.remove()
    return read_posterior(Path(output))


SIMULATIONS = (150, 150, 700)
"""Numbers of simulations: over the prior, near the resulting posterior, and near the posterior from the second set."""

# Steps of a pilot chain, and its burn-in.
_PILOT, _SETTLED = 400, 200

# Prior draws per walker from which the pilot's start is selected, and the number retained.
_CANDIDATES, _CHOSEN = 64, 4

# Exponents of the likelihood in pilot chains, below 1 because the noise model from the prior is rough; and the ratio of
# the simulations' spread to that of the pilot's draws.
_POWERS, _WIDER = (0.25, 0.7), 1.3

# Minimum distance from a limit, as a fraction of the range to it.
_INSIDE = 1e-4


def prepare(
    likelihood: ImageLikelihood, space: Space, seed: np.random.SeedSequence, progress: Callable[[int], None]
) -> tuple[ImageLikelihood, Array]:
    """Estimate the scatter of the statistics, first over the prior and then twice near the posterior.

    The returned likelihood is 0 outside the region of the last simulations, which extends beyond four standard
    deviations of the posterior, so nothing is extrapolated. Also returned are start positions of walkers (N, free): the
    likelier half of the draws from the pilot posterior. ``progress`` is called with the number of additional
    simulations completed. Raises PosteriorError if simulated images do not vary.
    """
    rng = np.random.default_rng(seed)
    broad, *near = SIMULATIONS
    drawn = space.complete(space.draw(rng, broad))
    likelihood = likelihood.learn(drawn[:, : len(SHAPE)], likelihood.draw_lasts(drawn, rng), rng, progress)
    candidates = space.draw(rng, _CANDIDATES * walkers_of(len(space.names)))
    for count, power in zip(near, _POWERS, strict=True):
        pilot = candidates = pilot_draws(_flattened(space, likelihood, power), candidates, rng)
        centre = pilot.mean(axis=0)
        low, high = _limits(space, pilot)
        drawn = pilot[rng.permutation(pilot.shape[0])[:count]]
        lasts = likelihood.draw_lasts(space.complete(drawn), rng)
        drawn = np.clip(centre + _WIDER * (drawn - centre), low, high)
        likelihood = likelihood.learn(space.complete(drawn)[:, : len(SHAPE)], lasts, rng, progress)
    density = SingleModel(space, likelihood).log_probability(pilot)
    return likelihood, pilot[np.argsort(-density, kind="stable")[: pilot.shape[0] // 2]]


def _flattened(space: Space, likelihood: ImageLikelihood, power: float) -> SingleModel:
    return SingleModel(space, lambda values: power * likelihood(values))


def pilot_draws(model: SingleModel, candidates: Array, rng: np.random.Generator) -> Array:
    """Sample the posterior of a provisional likelihood: where it is large, simulations measure the scatter.

    Parameters
    ----------
    model : SingleModel
        Posterior with that likelihood.
    candidates : ndarray (N, free)
        Positions of which the likeliest are where walkers start; they may be repeated.

    Returns
    -------
    ndarray (draws, free)
        Positions of all walkers after the burn-in.
    """
    walkers = walkers_of(len(model.names))
    # Candidates may be repeated steps of a chain; walkers at identical points could never separate.
    candidates = np.unique(candidates, axis=0)
    density = model.log_probability(candidates)
    best = candidates[np.argsort(-density, kind="stable")[: _CHOSEN * walkers]]
    start = best[rng.permutation(best.shape[0])[:walkers]]
    chains = begin(model.log_probability, start, int(rng.integers(0, 2**31)))
    chains = extend(model, chains, _PILOT)
    return np.asarray(chains.positions[_SETTLED:].reshape(-1, len(model.names)))


def _limits(space: Space, pilot: Array) -> tuple[Array, Array]:
    """Return the limits for simulations: those of the priors, exclusive."""
    low, high = space.limits
    width = np.where(np.isfinite(high - low), high - low, np.ptp(pilot, axis=0))
    return low + _INSIDE * width, high - _INSIDE * width
