"""Options of a fit, and a fit from its start or interruption to converged chains.

The state of an unfinished fit is a file next to its output.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.errors import PosteriorError, PosteriorOptionError
from hcss_evaluate.matching.dimension_range import type_parameters
from hcss_evaluate.posterior.chains import Convergence, MarkovChains, SingleModel, begin, converge, walkers_of
from hcss_evaluate.posterior.estimator_noise import EstimatorNoise
from hcss_evaluate.posterior.image_likelihood import ImageLikelihood
from hcss_evaluate.posterior.octaves import UNKNOWN
from hcss_evaluate.posterior.parameter_space import Space
from hcss_evaluate.posterior.population import PopulationModel
from hcss_evaluate.posterior.priors import KINDS, Prior
from hcss_twin import __version__
from hcss_twin.core.arguments import checked
from hcss_twin.core.files import Writing
from hcss_twin.core.reading import Reading
from hcss_twin.models.clouds.fractal.octaves import Octave
from hcss_twin.providers import Array, Catalog, HcssError


@checked
@dataclass(frozen=True)
class FitOptions:
    """How to fit.

    Attributes
    ----------
    fixed : mapping of str to float or "image"
        Fixed parameters among H, gamma, Lx, Ly (cells per 16 km) and coverage. Coverage may be fixed at "image", for
        scenes with exactly the image's coverage.
    priors : mapping of str to str
        ``kind:number:number`` for parameters, and for ``spread_NAME`` of several images; others have default priors.
    cloud_type : str, optional
        Cloud type of the catalogue. Unless they are given, octaves and gamma are the type's, and priors of Lx and Ly
        are lognormal about the type's, with a standard deviation of the logarithm of 0.5.
    octaves : (int, int), optional
        First and last octave; by default those of the cloud type, without one 0 and an unknown last one.
    smallest_lag : int
        Shortest lag used, pixels; increase it for blurred or noisy images.
    misfit : float
        Allowed model error: standard deviation of ln semivariance, independent at each lag.
    seed : int
        Seed of simulations and chains.
    samples : float
        Required bulk and tail effective sample size of the stored draws of every parameter.
    most_steps : int
        Maximum number of steps per walker.
    """

    fixed: Mapping[str, float | Literal["image"]] = field(default_factory=dict)
    priors: Mapping[str, str] = field(default_factory=dict)
    cloud_type: str | None = None
    octaves: tuple[int, int] | None = None
    smallest_lag: int = 1
    misfit: float = 0.0
    seed: int = 0
    samples: float = 1000.0
    most_steps: int = 50_000

    def check(self) -> None:
        """Check the numbers.

        Raises PosteriorOptionError if one is not allowed.
        """
        first, last = self.octaves or (0, 0)
        for name, value, is_allowed, allowed in (
            ("octaves", self.octaves, 0 <= first <= last <= 16, "0 <= first <= last <= 16"),
            ("smallest_lag", self.smallest_lag, self.smallest_lag >= 1, "1 or more pixels"),
            ("misfit", self.misfit, 0.0 <= self.misfit <= 2.0, "0 to 2"),
            ("seed", self.seed, 0 <= self.seed < 2**63, "0 or more"),
            ("samples", self.samples, 100.0 <= self.samples <= 1e6, "100 to 1000000"),
            ("most_steps", self.most_steps, 500 <= self.most_steps <= 10**7, "500 to 10000000"),
        ):
            if not is_allowed:
                raise PosteriorOptionError(f"{name}: {value} given, allowed: {allowed}")

    def of_type(self) -> FitOptions:
        """Return the options with those that the cloud type sets.

        Raises PosteriorOptionError if the catalogue has no fractal cloud type of this name.
        """
        if self.cloud_type is None:
            return self
        try:
            usual = type_parameters(self.cloud_type, Catalog())
        except HcssError as error:
            raise PosteriorOptionError(f"cloud_type: {error}") from error
        assert usual.gamma is not None
        assert usual.L is not None
        about = {name: f"lognormal:{size:g}:{_TYPE_SIZES}" for name, size in zip(("Lx", "Ly"), usual.L, strict=True)}
        fixed: dict[str, float | Literal["image"]] = {} if "gamma" in self.priors else {"gamma": usual.gamma}
        priors = {name: text for name, text in about.items() if name not in self.fixed}
        return replace(
            self, fixed={**fixed, **self.fixed}, priors={**priors, **self.priors}, octaves=self.octaves or usual.k
        )


SPREAD = "spread_"

# Standard deviation of ln L between images of one cloud type, our choice: a factor of 1.6.
_TYPE_SIZES = 0.5

# Limits of the prior of L: one cell per frame, and cells of this many pixels.
_SMALLEST_CELL_PIXELS = 4
_USUAL = {"H": "uniform:0.02:0.98", "gamma": "loguniform:1.5:5", "coverage": "uniform:0.01:0.99"}

# Default lower limit of a population's spread.
_MIN_SPREAD = 0.01


def space_of(
    options: FitOptions, coverage: float, frames: Sequence[tuple[int, int, float]], *, several: bool
) -> tuple[Space, tuple[Prior, ...]]:
    """Return the free parameters and the priors of spreads for images with a given coverage and given frames.

    Raises PosteriorOptionError if a parameter is fixed at text, or a prior is not allowed.
    """
    fixed = dict(options.fixed)
    if fixed.get("coverage") == "image":
        fixed["coverage"] = coverage
    numbers = {name: fixed_number(name, value) for name, value in fixed.items()}
    stated_priors = {name: text for name, text in options.priors.items() if not name.startswith(SPREAD)}
    space = Space.of(numbers, stated_priors, usual_priors(frames))
    return space, _spread_priors(space, options.priors, several)


def fixed_number(name: str, value: float | str) -> float:
    """Return the value at which a parameter is fixed.

    Raises PosteriorOptionError if it is text.
    """
    if isinstance(value, str):
        where = "a number, or 'image' of images" if name == "coverage" else "a number"
        raise PosteriorOptionError(f"{name}: fixed at '{value}', allowed: {where}")
    return float(value)


def usual_priors(frames: Sequence[tuple[int, int, float]]) -> dict[str, str]:
    """Return default priors of parameters without one, for frames given by rows, columns and pixel size."""
    usual = dict(_USUAL)
    for name, axis in (("Lx", 1), ("Ly", 0)):
        low = min(Octave.REFERENCE_LENGTH_M / (frame[axis] * frame[2]) for frame in frames)
        high = max(Octave.REFERENCE_LENGTH_M / (_SMALLEST_CELL_PIXELS * frame[2]) for frame in frames)
        usual[name] = f"loguniform:{low:.6g}:{high:.6g}"
    return usual


def _spread_priors(space: Space, priors: Mapping[str, str], several: bool) -> tuple[Prior, ...]:
    given = {name.removeprefix(SPREAD): text for name, text in priors.items() if name.startswith(SPREAD)}
    if not several:
        if given:
            raise PosteriorOptionError(f"prior of {SPREAD}{next(iter(given))}: one image has no spread; leave it out")
        return ()
    for name in given:
        if name not in space.names:
            raise PosteriorOptionError(f"prior of {SPREAD}{name}: {name} is not free; leave it out")
    usual = {name: f"uniform:{_MIN_SPREAD}:{KINDS[name].widest}" for name in space.names}
    return tuple(
        Prior.parse(f"{SPREAD}{name}", given.get(name, usual[name]), 0.0, float("inf")) for name in space.names
    )


SECONDS_APART = 5.0
"""Least time between states: those of long chains are large files, and not written after every block."""


@dataclass(frozen=True)
class FitState:
    """State of a fit: the noise of each image, and the chains."""

    noises: tuple[EstimatorNoise, ...]
    chains: MarkovChains


class Checkpoint:
    """The state file of one fit; ``fingerprint`` is a hash of everything that determines the chains."""

    def __init__(self, path: Path, fingerprint: str) -> None:
        self._path = path
        self._fingerprint = fingerprint
        self._written = 0.0

    def read(self) -> FitState | None:
        """Return the state, or None if there is none.

        Raises PosteriorError if the file is damaged or belongs to another fit.
        """
        if not self._path.exists():
            return None
        remedy = f"delete {self._path} to begin anew"
        with Reading(self._path, PosteriorError, f"damaged state of a fit; {remedy}") as reading:
            file: dict[str, Any] = dict(reading.arrays())
            if str(file["fingerprint"]) != self._fingerprint:
                raise PosteriorError(
                    f"{self._path}: state of another fit (images, options, seed or version differ); {remedy}"
                )
            noises = tuple(
                EstimatorNoise(**{f.name: file[f"noise_{i}_{f.name}"][()] for f in fields(EstimatorNoise)})
                for i in range(int(file["noises"]))
            )
            kind, position, has_gauss, cached = (file[f"random_{i}"][()] for i in (0, 2, 3, 4))
            random_state = (str(kind), file["random_1"], int(position), int(has_gauss), float(cached))
            return FitState(noises, MarkovChains(file["positions"], file["log_probability"], random_state))

    def write(self, state: FitState, now: bool = False) -> None:
        """Write the state, at most every few seconds unless ``now`` is true.

        Raises PosteriorError if the file cannot be written.
        """
        if not now and time.monotonic() - self._written < SECONDS_APART:
            return
        arrays: dict[str, NDArray[np.generic]] = {
            f"noise_{i}_{f.name}": np.asarray(getattr(noise, f.name))
            for i, noise in enumerate(state.noises)
            for f in fields(EstimatorNoise)
        }
        chains = state.chains
        arrays |= {f"random_{i}": np.asarray(part) for i, part in enumerate(chains.random_state)}
        arrays |= {"positions": chains.positions, "log_probability": chains.log_probability}
        arrays |= {"noises": np.asarray(len(state.noises)), "fingerprint": np.asarray(self._fingerprint)}
        Writing(self._path, PosteriorError).arrays(arrays)
        self._written = time.monotonic()

    def remove(self) -> None:
        """Delete the state after the posterior has been written."""
        self._path.unlink(missing_ok=True)


Progress = Callable[[str, float], None]
"""Called with the current task and the fraction completed."""


class FitRun:
    """One fit with its checkpoint, progress and description."""

    def __init__(
        self,
        output: Path,
        options: FitOptions,
        space: Space,
        spreads: tuple[Prior, ...],
        data: str,
        progress: Progress | None,
    ) -> None:
        Writing(output, PosteriorError, "NetCDF").check()
        if not output.absolute().parent.is_dir():
            raise PosteriorError(f"cannot write {output}: there is no folder {output.absolute().parent}")
        self._options, self._space, self._spreads = options, space, spreads
        self.progress: Progress = progress or (lambda _what, _part: None)
        text = json.dumps([__version__, data, self.about(), options.seed, sorted(space.fixed.items())])
        digest = hashlib.sha256(text.encode()).hexdigest()
        self.checkpoint = Checkpoint(output.with_name(f"{output.name}.state"), digest)

    def about(self) -> dict[str, Any]:
        """Return the file attributes that describe the options."""
        priors = {name: prior.text for name, prior in self._space.priors.items()}
        for name, prior in zip(self._space.names, self._spreads, strict=False):
            priors[f"{SPREAD}{name}"] = prior.text
        options = self._options
        return {
            "priors": json.dumps(priors),
            **({"cloud_type": options.cloud_type} if options.cloud_type else {}),
            **({"octaves": list(options.octaves)} if options.octaves else {"possible_last_octaves": list(UNKNOWN)}),
            "smallest_lag": options.smallest_lag,
            "misfit": options.misfit,
        }

    def sample(
        self,
        model: SingleModel | PopulationModel,
        likelihoods: tuple[ImageLikelihood, ...],
        pilots: Sequence[Array],
        state: FitState | None,
    ) -> tuple[MarkovChains, Convergence]:
        """Run the chains until they converge.

        Raises PosteriorError if they have not converged.
        """
        options = self._options
        noises = tuple(likelihood.noise for likelihood in likelihoods if likelihood.noise is not None)
        chains = self._start(model, pilots) if state is None else state.chains

        def after_block(chains: MarkovChains, convergence: Convergence | None) -> None:
            self.checkpoint.write(FitState(noises, chains))
            self.progress("sampling", 0.0 if convergence is None else min(convergence.fraction, 1.0))

        chains, convergence = converge(model, chains, options.samples, options.most_steps, after_block)
        if not convergence.has_converged:
            self.checkpoint.write(FitState(noises, chains), now=True)
            lines = "\n  ".join(convergence.complaints(model.names))
            raise PosteriorError(
                f"not converged after {chains.positions.shape[0]} steps; no posterior is written\n  {lines}\n"
                f"allow more steps (now {options.most_steps}; a new run continues these chains), fix a parameter that "
                "the data do not constrain (gamma), or give narrower priors"
            )
        return chains, convergence

    def _start(self, model: SingleModel | PopulationModel, pilots: Sequence[Array]) -> MarkovChains:
        rng = np.random.default_rng(np.random.SeedSequence([self._options.seed, 2]))
        walkers = walkers_of(len(model.names))
        drawn = [pilot[rng.permutation(pilot.shape[0])[:walkers]] for pilot in pilots]
        start = model.start(rng, drawn) if isinstance(model, PopulationModel) else drawn[0]
        return begin(model.log_probability, start, int(rng.integers(0, 2**31)))
