"""Posterior of the parameters of fractal clouds, given images or a fractal dimension."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hcss_twin.clouds.fractal.octaves import REFERENCE_LENGTH_M
from hcss_twin.errors import PosteriorError
from hcss_twin.matching.target import ImageChoice, Target, read_target
from hcss_twin.uncertainty.batch_variogram import BatchVariogram
from hcss_twin.uncertainty.chains import Chains, begin, converge, walkers_of
from hcss_twin.uncertainty.checkpoint import Checkpoint, State
from hcss_twin.uncertainty.convergence import Convergence
from hcss_twin.uncertainty.dimension_likelihood import DimensionLikelihood
from hcss_twin.uncertainty.image_data import ImageData
from hcss_twin.uncertainty.image_likelihood import ImageLikelihood
from hcss_twin.uncertainty.posterior_file import Posterior, read_posterior
from hcss_twin.uncertainty.posterior_model import PopulationModel, SingleModel
from hcss_twin.uncertainty.prepare import SIMULATIONS, prepare
from hcss_twin.uncertainty.priors import Prior
from hcss_twin.uncertainty.result import write_result
from hcss_twin.uncertainty.scales import KINDS
from hcss_twin.uncertainty.space import Space
from hcss_twin.version import __version__

Array = NDArray[np.float64]

Progress = Callable[[str, float], None]
"""Is told what is being done, and which part of that is done."""

FRAME = (800, 800, 20.0)
"""Rows, columns and pixel size of an image of which only the dimension is given: the paper's."""

SPREAD = "spread_"

# Cells per frame that the priors of L allow: from one to one of so many pixels.
_SMALLEST_CELL_PIXELS = 4

_USUAL = {"H": "uniform:0.02:0.98", "gamma": "loguniform:1.5:4", "coverage": "uniform:0.01:0.99"}

# Of a population's spread, the least by default.
_LEAST_SPREAD = 0.01


@dataclass(frozen=True)
class FitOptions:
    """How to fit.

    Attributes
    ----------
    fixed : mapping of str to float or "image"
        Parameters among H, gamma, Lx, Ly (cells per 16 km), coverage that are not free. Coverage may be fixed at
        "image": scenes are to have exactly the image's.
    priors : mapping of str to str
        ``kind:number:number`` for parameters, and for ``spread_NAME`` of several images; the others have
        the usual ones.
    octaves : (int, int)
        First and last octave.
    smallest_lag : int
        Pixels; shorter ones are not looked at (blurred or noisy images).
    misfit : float
        Standard deviation of ln semivariance, independent at each lag, by which real clouds are allowed to
        differ from any fractal field.
    seed : int
        Of simulations and chains.
    samples : float
        Effective sample size that every parameter must have.
    most_steps : int
        Limit of steps per walker.
    """

    fixed: Mapping[str, float | Literal["image"]] = field(default_factory=dict)
    priors: Mapping[str, str] = field(default_factory=dict)
    octaves: tuple[int, int] = (0, 8)
    smallest_lag: int = 1
    misfit: float = 0.0
    seed: int = 0
    samples: float = 1000.0
    most_steps: int = 50_000

    def check(self) -> None:
        """Check the numbers.

        Raises
        ------
        PosteriorError
            If one is not allowed.
        """
        first, last = self.octaves
        for name, value, is_allowed, allowed in (
            ("octaves", self.octaves, 0 <= first <= last <= 16, "0 <= first <= last <= 16"),
            ("smallest_lag", self.smallest_lag, self.smallest_lag >= 1, "1 or more pixels"),
            ("misfit", self.misfit, 0.0 <= self.misfit <= 2.0, "0 to 2"),
            ("seed", self.seed, 0 <= self.seed < 2**63, "0 or more"),
            ("samples", self.samples, 100.0 <= self.samples <= 1e6, "100 to 1000000"),
            ("most_steps", self.most_steps, 500 <= self.most_steps <= 10**7, "500 to 10000000"),
        ):
            if not is_allowed:
                raise PosteriorError(f"{name}: {value} given, allowed: {allowed}")


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
    _space(chosen, 0.5, [FRAME], several=len(paths) > 1)
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
    space, spreads = _space(options, coverage, frames, several=several)
    likelihoods = [ImageLikelihood.of(each, options.octaves, not from_image, options.misfit) for each in data]
    digest = hashlib.sha256(repr(from_image).encode())
    for each in data:
        digest.update(repr((each.rows, each.columns, each.pixel_size_m, each.cloudy)).encode())
        digest.update(each.variogram.tobytes())
    run = _Run(output, options, space, spreads, digest.hexdigest(), progress)
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
    numbers = {name: _number(name, value) for name, value in chosen.fixed.items()}
    space = Space.of(numbers, chosen.priors, _usual_priors([(rows, columns, pixel_size_m)]))
    likelihood = DimensionLikelihood(
        dimension, error, rows, columns, pixel_size_m, BatchVariogram.of(chosen.octaves)
    )
    about = repr((dimension, error, rows, columns, pixel_size_m))
    run = _Run(Path(output), chosen, space, (), about, progress)
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


class _Run:
    """One fit: its checkpoint, its progress, and what it is about."""

    def __init__(
        self,
        output: Path,
        options: FitOptions,
        space: Space,
        spreads: tuple[Prior, ...],
        data: str,
        progress: Progress | None,
    ) -> None:
        if not output.absolute().parent.is_dir():
            raise PosteriorError(f"cannot write {output}: there is no folder {output.absolute().parent}")
        self._options = options
        self._space = space
        self._spreads = spreads
        self.told: Progress = progress or (lambda _what, _part: None)
        text = json.dumps([__version__, data, self.about(), options.seed, sorted(space.fixed.items())])
        digest = hashlib.sha256(text.encode()).hexdigest()
        self._checkpoint = Checkpoint(output.with_name(f"{output.name}.state"), digest)

    def about(self) -> dict[str, Any]:
        """Return attributes of the file that say what was asked."""
        priors = {name: prior.text for name, prior in self._space.priors.items()}
        for name, prior in zip(self._space.names, self._spreads, strict=False):
            priors[f"{SPREAD}{name}"] = prior.text
        chosen = asdict(self._options)
        return {
            "priors": json.dumps(priors),
            "octaves": list(chosen["octaves"]),
            "smallest_lag": chosen["smallest_lag"],
            "misfit": chosen["misfit"],
        }

    def resume(self) -> State | None:
        """Return what an earlier run left."""
        return self._checkpoint.read()

    def sample(
        self,
        model: SingleModel | PopulationModel,
        likelihoods: tuple[ImageLikelihood, ...],
        pilots: Sequence[Array],
        state: State | None,
    ) -> tuple[Chains, Convergence]:
        """Run chains to their end.

        Raises
        ------
        PosteriorError
            If they have not converged.
        """
        options = self._options
        noises = tuple(each.noise for each in likelihoods if each.noise is not None)
        chains = self._start(model, pilots) if state is None else state.chains

        def told(chains: Chains, found: Convergence | None) -> None:
            self._checkpoint.write(State(noises, chains))
            self.told("sampling", 0.0 if found is None else min(found.fraction, 1.0))

        chains, found = converge(model.log_probability, chains, options.samples, options.most_steps, told)
        if not found.has_converged:
            self._checkpoint.write(State(noises, chains), now=True)
            raise PosteriorError(_refusal(found, model.names, options, chains))
        return chains, found

    def done(self) -> None:
        """Forget the state: the posterior has been written."""
        self._checkpoint.remove()

    def _start(self, model: SingleModel | PopulationModel, pilots: Sequence[Array]) -> Chains:
        rng = np.random.default_rng(np.random.SeedSequence([self._options.seed, 2]))
        walkers = walkers_of(len(model.names))
        drawn = [pilot[rng.permutation(pilot.shape[0])[:walkers]] for pilot in pilots]
        start = model.start(rng, drawn) if isinstance(model, PopulationModel) else drawn[0]
        return begin(model.log_probability, start, int(rng.integers(0, 2**31)))


def _prepare(
    likelihood: ImageLikelihood, space: Space, seed: int, index: int, count: int, told: Progress
) -> tuple[ImageLikelihood, Array]:
    total, done = count * sum(SIMULATIONS), index * sum(SIMULATIONS)

    def simulated(number: int) -> None:
        nonlocal done
        done += number
        told("simulating", done / total)

    return prepare(likelihood, space, np.random.SeedSequence([seed, 0, index]), simulated)


def _space(
    options: FitOptions, coverage: float, frames: Sequence[tuple[int, int, float]], *, several: bool
) -> tuple[Space, tuple[Prior, ...]]:
    """Return what is free, and the priors of spreads, for images of this coverage and these frames."""
    fixed = dict(options.fixed)
    if fixed.get("coverage") == "image":
        fixed["coverage"] = coverage
    numbers = {name: _number(name, value) for name, value in fixed.items()}
    own = {name: text for name, text in options.priors.items() if not name.startswith(SPREAD)}
    space = Space.of(numbers, own, _usual_priors(frames))
    return space, _spread_priors(space, options.priors, several)


def _number(name: str, value: float | str) -> float:
    if isinstance(value, str):
        where = "a number, or 'image' of images" if name == "coverage" else "a number"
        raise PosteriorError(f"{name}: fixed at '{value}', allowed: {where}")
    return float(value)


def _usual_priors(frames: Sequence[tuple[int, int, float]]) -> dict[str, str]:
    """Return the priors of what is not given, for frames of rows, columns and pixel size."""
    usual = dict(_USUAL)
    for name, axis in (("Lx", 1), ("Ly", 0)):
        low = min(REFERENCE_LENGTH_M / (frame[axis] * frame[2]) for frame in frames)
        high = max(REFERENCE_LENGTH_M / (_SMALLEST_CELL_PIXELS * frame[2]) for frame in frames)
        usual[name] = f"loguniform:{low:.6g}:{high:.6g}"
    return usual


def _spread_priors(space: Space, priors: Mapping[str, str], several: bool) -> tuple[Prior, ...]:
    given = {name.removeprefix(SPREAD): text for name, text in priors.items() if name.startswith(SPREAD)}
    if not several:
        if given:
            raise PosteriorError(
                f"prior of {SPREAD}{next(iter(given))}: one image has no spread; leave it out"
            )
        return ()
    for name in given:
        if name not in space.names:
            raise PosteriorError(f"prior of {SPREAD}{name}: {name} is not free; leave it out")
    return tuple(
        Prior.parse(
            f"{SPREAD}{name}",
            given.get(name, f"uniform:{_LEAST_SPREAD}:{KINDS[name].widest}"),
            0.0,
            float("inf"),
        )
        for name in space.names
    )


def _refusal(found: Convergence, names: tuple[str, ...], options: FitOptions, chains: Chains) -> str:
    lines = "\n  ".join(found.complaints(names))
    return (
        f"not converged after {chains.positions.shape[0]} steps; no posterior is written\n  {lines}\n"
        f"allow more steps (now {options.most_steps}; the chains so far are kept and gone on with), fix a parameter "
        "that the data do not tell (gamma), or give narrower priors"
    )
