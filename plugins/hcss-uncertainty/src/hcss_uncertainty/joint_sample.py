"""Draws of posterior parameters, uncertain keys and seeds, in two independent samples and their mixtures.

The samples A and B are those of Saltelli et al., "Variance based sensitivity analysis of model output", Computer
Physics Communications 181 (2010) 259-270: each computed mixture takes every input from one or the other.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from hcss_evaluate.errors import PosteriorError
from hcss_evaluate.posterior.posterior_file import PARAMETERS, Posterior, read_posterior
from hcss_sweep.axis import axis_of
from numpy.typing import NDArray

from hcss_twin import Scenario
from hcss_twin.providers import Array

_OF_POPULATION = ("mean_", "spread_")


@dataclass(frozen=True)
class PosteriorDraws:
    """A posterior, with parameters as in scenarios.

    Attributes
    ----------
    names : tuple of str
        Free parameters, a subset of ``PARAMETERS`` in the same order; ``fixed`` has the values of the others.
    samples : ndarray (n, parameter)
        All draws, concatenated over images. A draw takes all parameters from one image.
    octaves : (int, int) or None
        First and last octave of the fractal sum to which the parameters refer; None if not in the file, or if each draw
        has its own: then the last column of ``samples`` is that of the last octave, from octave 0.
    file, sha256 : str
        Name and hash of the file.
    about : mapping
        Global attributes of the file.
    """

    names: tuple[str, ...]
    samples: Array
    fixed: Mapping[str, float]
    octaves: tuple[int, int] | None
    images: int
    file: str
    sha256: str
    about: Mapping[str, Any]

    @classmethod
    def read(cls, path: str | Path) -> PosteriorDraws:
        """Read the file of a posterior.

        Raises PosteriorError if it is missing, damaged, not a posterior or not converged, or if no scenario has its
        parameters.
        """
        path = Path(path)
        posterior = read_posterior(path)
        names, columns, images = _columns(posterior, path)
        if posterior.last_octave is not None:
            octave_column = posterior.last_octave.reshape(-1, images).T.ravel()
            columns = np.concatenate([columns, octave_column[:, None]], axis=1)
        fixed = {name: value for name, value in posterior.fixed.items() if name in PARAMETERS}
        if ("Lx" in (*names, *fixed)) != ("Ly" in (*names, *fixed)):
            raise PosteriorError(f"cannot use {path}: it has only one of Lx and Ly, allowed: both or none")
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        about = {name: value for name, value in posterior.attributes.items() if isinstance(value, str)}
        octaves = _octaves(posterior, path)
        return cls(names, columns, fixed, octaves, images, path.name, digest, about)

    def rows(self, count: int, seed: np.random.SeedSequence) -> Array:
        """Return independent, equally likely draws (count, parameter) of the posterior."""
        chosen = np.random.default_rng(seed).integers(self.samples.shape[0], size=count)
        return np.asarray(self.samples[chosen])

    def keys(self, layer: str) -> tuple[str, ...]:
        """Return the scenario keys that the posterior sets, in ``clouds`` or ``clouds.layers.0``."""
        return tuple(self.overrides(layer, np.zeros(self.samples.shape[1])))

    def overrides(self, layer: str, row: Array) -> dict[str, Any]:
        """Return scenario keys with the values of one draw (parameter,)."""
        count = len(self.names)
        value = {**self.fixed, **dict(zip(self.names, map(float, row[:count]), strict=True))}
        keys: dict[str, Any] = {f"{layer}.parameters.{name}": value[name] for name in ("H", "gamma") if name in value}
        if "Lx" in value:
            keys[f"{layer}.parameters.L"] = [value["Lx"], value["Ly"]]
        if self.octaves is not None:
            keys[f"{layer}.parameters.k"] = list(self.octaves)
        elif row.size > count:
            keys[f"{layer}.parameters.k"] = [0, int(row[count])]
        if "coverage" in value:
            keys[f"{layer}.coverage"] = value["coverage"]
        return keys


def _columns(posterior: Posterior, path: Path) -> tuple[tuple[str, ...], Array, int]:
    """Return the free parameters, their draws (n, parameter), and the number of images."""
    samples = {name: values for name, values in posterior.samples.items() if not name.startswith(_OF_POPULATION)}
    unknown = [name for name in samples if name not in PARAMETERS]
    if unknown or not samples:
        listed = ", ".join(unknown) or "none"
        raise PosteriorError(f"cannot use {path}: its free parameters are {listed}; allowed: {', '.join(PARAMETERS)}")
    names = tuple(name for name in PARAMETERS if name in samples)
    images = max(values.shape[1] if values.ndim == 2 else 1 for values in samples.values())
    wide = [np.broadcast_to(samples[name].reshape(samples[name].shape[0], -1).T, (images, samples[name].shape[0]))
            for name in names]  # fmt: skip
    return names, np.stack([values.ravel() for values in wide], axis=1), images


def _octaves(posterior: Posterior, path: Path) -> tuple[int, int] | None:
    given = posterior.attributes.get("octaves")
    if given is None:
        return None
    numbers = np.atleast_1d(given)
    if numbers.shape != (2,) or numbers.dtype.kind != "i":
        raise PosteriorError(f"cannot use {path}: octaves {given}, allowed: two whole numbers")
    return int(numbers[0]), int(numbers[1])


def notes_of(draws: PosteriorDraws, scenario: Scenario, layer: str, count: int) -> tuple[str, ...]:
    """Return notes for users of a posterior from which ``count`` draws are used."""
    notes = []
    number = int(layer.rpartition(".")[2]) if layer != "clouds" else 0
    if "coverage" in draws.names and scenario.clouds.layers[number].coverage_mode == "frame":
        notes.append(
            f"the posterior's coverage is that of the unbounded sky, but {layer}.coverage_mode is 'frame', where "
            "each frame has exactly that coverage: the spread by seed does not include that of coverage "
            f"(--set {layer}.coverage_mode=field)"
        )
    if draws.images > 1:
        notes.append(
            f"the posterior describes {draws.images} images: each draw takes all parameters from one, chosen at random"
        )
    if count > draws.samples.shape[0]:
        notes.append(f"{count} draws are taken from the {draws.samples.shape[0]} of the posterior, with repetitions")
    if draws.fixed or draws.octaves is not None:
        fixed = [f"{name} = {value:g}" for name, value in draws.fixed.items()]
        if draws.octaves is not None:
            fixed.append(f"octaves k = {draws.octaves[0]} to {draws.octaves[1]}")
        notes.append(f"fixed by the posterior, overriding the scenario: {', '.join(fixed)}")
    return tuple(notes)


@dataclass(frozen=True)
class UncertainKey:
    """A dotted key and the distribution of its values, as in ``[sweep]`` but without ``samples`` and ``seed``."""

    key: str
    distribution: Mapping[str, Any]

    def values(self, draws: int, seed: int) -> tuple[Any, ...]:
        """Return independent draws in the notation of a scenario file; keys with the same seed are independent.

        Raises ValueError if the distribution is invalid.
        """
        # The draws must not depend on the values of a swept key with the same seed.
        text = f"propagation {seed}".encode()
        key_seed = int.from_bytes(hashlib.sha256(text).digest()[:8], "big") >> 1
        return axis_of(self.key, {**self.distribution, "samples": draws, "seed": key_seed}).values


A, B = 0, 1

SEED = "seed"
"""Name of the input that sets the realisation of clouds, and of resolved waves."""

POSTERIOR = "posterior"
"""Name of the input that groups all free parameters of a posterior, which are correlated."""

DRAWS, OTHER_SEED, ALL_OTHERS = "draws", "other seed", "all others"
_SEED_KEY = {"posterior": 1, "scene": 2, "bootstrap": 3}


@dataclass(frozen=True)
class Mixture:
    """One scene per draw: independent inputs in ``exchanged`` come from B, the others from A."""

    name: str
    exchanged: frozenset[str]

    def source(self, name: str) -> int:
        """Return the sample, A or B, of an input."""
        return B if name in self.exchanged else A


@dataclass(frozen=True)
class JointSample:
    """Draws of all inputs.

    ``rows`` (2, draw, parameter) are the posterior draws in A and B, without columns if there is no posterior; the
    parameters belong to ``layer`` of the scenario. ``values`` has the values of A followed by those of B for each
    uncertain key, in the notation of a scenario file. ``seeds`` (2, draw) are the seeds of the scenes. ``mixtures`` are
    the draws, the same draws with other seeds, and the mixtures for pick-freeze.
    """

    posterior: PosteriorDraws | None
    layer: str
    rows: Array
    keys: tuple[UncertainKey, ...]
    values: Mapping[str, tuple[Any, ...]]
    seeds: NDArray[np.int64]
    mixtures: tuple[Mixture, ...]

    @property
    def count(self) -> int:
        """Number of draws."""
        return int(self.seeds.shape[1])

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the individual inputs: parameters of the posterior, then keys."""
        names = () if self.posterior is None else self.posterior.names
        return (*names, *(key.key for key in self.keys))

    def overrides(self, mixture: Mixture, draw: int) -> dict[str, Any]:
        """Return the scenario keys of one draw with their values."""
        keys: dict[str, Any] = {}
        if self.posterior is not None:
            row = self.rows[mixture.source(POSTERIOR), draw]
            keys.update(self.posterior.overrides(self.layer, row))
        for key in self.keys:
            keys[key.key] = self.values[key.key][mixture.source(key.key) * self.count + draw]
        keys[SEED] = int(self.seeds[mixture.source(SEED), draw])
        return keys


def joint_sample(
    posterior: PosteriorDraws | None,
    layer: str,
    keys: Sequence[UncertainKey],
    count: int,
    seed: int,
    *,
    pick_freeze: bool,
) -> JointSample:
    """Draw all inputs, independently of each other; parameters of a posterior are drawn together.

    The first draws of an input do not depend on the other inputs, the number of draws or the mixtures. ``seed`` is that
    of the scenario and determines all draws; ``pick_freeze`` adds mixtures with one input exchanged.
    """
    rows = np.empty((2, count, 0))
    if posterior is not None:
        rows = np.stack([posterior.rows(count, source) for source in _sources(seed, "posterior")])
    seeds = np.stack(
        [np.random.default_rng(source).integers(2**63 - 1, size=count) for source in _sources(seed, "scene")]
    )
    # Independent inputs, without the seed.
    groups = (*((POSTERIOR,) if posterior is not None else ()), *(key.key for key in keys))
    mixtures = [Mixture(DRAWS, frozenset()), Mixture(OTHER_SEED, frozenset({SEED}))]
    if pick_freeze:
        mixtures.append(Mixture(ALL_OTHERS, frozenset({SEED, *groups})))
        mixtures += [Mixture(f"other {name}", frozenset({name})) for name in groups]
    values = {key.key: key.values(2 * count, seed) for key in keys}
    return JointSample(posterior, layer, rows, tuple(keys), values, seeds, tuple(mixtures))


def _sources(seed: int, what: str) -> list[np.random.SeedSequence]:
    return [np.random.SeedSequence(seed, spawn_key=(_FAMILY, _SEED_KEY[what], which)) for which in (A, B)]


def bootstrap_seed(seed: int) -> np.random.SeedSequence:
    """Return the seed for the standard errors of a propagation."""
    return np.random.SeedSequence(seed, spawn_key=(_FAMILY, _SEED_KEY["bootstrap"]))


_FAMILY = 2**18
"""Separates these draws from the seeds of clouds, waves and certificates."""
