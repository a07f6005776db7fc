"""What is drawn: two independent samples of all inputs, and the mixtures of them that are computed.

The samples A and B are those of Saltelli et al., "Variance based sensitivity analysis of model output", Computer
Physics Communications 181 (2010) 259-270: whatever is computed has each input from the one or the other.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.propagation.posterior_draws import PosteriorDraws
from hcss_twin.propagation.uncertain import UncertainKey

Array = NDArray[np.float64]

A, B = 0, 1

SEED = "seed"
"""Name of the input that chooses the realisation of clouds, and of waves where they are drawn."""

POSTERIOR = "posterior"
"""Name of the input that all free parameters of a posterior are together: they depend on each other."""

DRAWS, OTHER_SEED, ALL_OTHERS = "draws", "other seed", "all others"

_SEED_KEY = {"posterior": 1, "scene": 2, "bootstrap": 3}


@dataclass(frozen=True)
class Mixture:
    """What is computed for each draw.

    Attributes
    ----------
    name : str
    exchanged : frozenset of str
        Independent inputs that come from B; the others come from A.
    """

    name: str
    exchanged: frozenset[str]

    def source(self, name: str) -> int:
        """Return the sample, A or B, that an input comes from."""
        return B if name in self.exchanged else A


@dataclass(frozen=True)
class JointSample:
    """Draws of all inputs.

    Attributes
    ----------
    posterior : PosteriorDraws or None
    layer : str
        Part of the scenario that the posterior's parameters belong to.
    rows : ndarray (2, draw, parameter)
        Of the posterior, in A and B; no columns without one.
    keys : tuple of UncertainKey
    values : mapping of str to tuple
        Of each uncertain key, those of A followed by those of B, as a scenario file has them.
    seeds : ndarray of int64 (2, draw)
        Of the scene.
    mixtures : tuple of Mixture
        In the order in which they are kept: the draws, the same with other seeds, and what pick-freeze needs.
    """

    posterior: PosteriorDraws | None
    layer: str
    rows: Array
    keys: tuple[UncertainKey, ...]
    values: Mapping[str, tuple[Any, ...]]
    seeds: NDArray[np.int64]
    mixtures: tuple[Mixture, ...] = field(default=())

    @property
    def count(self) -> int:
        """Number of draws."""
        return int(self.seeds.shape[1])

    @property
    def groups(self) -> tuple[str, ...]:
        """Inputs that are independent of each other, but for the seed."""
        return (*((POSTERIOR,) if self.posterior is not None else ()), *(each.key for each in self.keys))

    @property
    def inputs(self) -> tuple[str, ...]:
        """Inputs one by one: parameters of the posterior, then keys."""
        names = () if self.posterior is None else self.posterior.names
        return (*names, *(each.key for each in self.keys))

    def overrides(self, mixture: Mixture, draw: int) -> dict[str, Any]:
        """Return the keys of the scenario of one draw, with their values."""
        found: dict[str, Any] = {}
        if self.posterior is not None:
            row = self.rows[mixture.source(POSTERIOR), draw]
            found.update(self.posterior.overrides(self.layer, row))
        for each in self.keys:
            found[each.key] = self.values[each.key][mixture.source(each.key) * self.count + draw]
        found[SEED] = int(self.seeds[mixture.source(SEED), draw])
        return found


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

    The first draws are the same whatever else is uncertain, and whether or not more is computed for them.

    Parameters
    ----------
    seed : int
        Of the scenario: it fixes all draws.
    pick_freeze : bool
        Whether also what has one input exchanged is computed.
    """
    rows = np.empty((2, count, 0))
    if posterior is not None:
        rows = np.stack([posterior.rows(count, source) for source in _sources(seed, "posterior")])
    seeds = np.stack(
        [np.random.default_rng(each).integers(2**63 - 1, size=count) for each in _sources(seed, "scene")]
    )
    sample = JointSample(
        posterior,
        layer,
        rows,
        tuple(keys),
        {each.key: each.values(2 * count, seed) for each in keys},
        seeds,
    )
    mixtures = [Mixture(DRAWS, frozenset()), Mixture(OTHER_SEED, frozenset({SEED}))]
    if pick_freeze:
        mixtures.append(Mixture(ALL_OTHERS, frozenset({SEED, *sample.groups})))
        mixtures += [Mixture(f"other {name}", frozenset({name})) for name in sample.groups]
    return JointSample(posterior, layer, rows, sample.keys, sample.values, sample.seeds, tuple(mixtures))


def _sources(seed: int, what: str) -> list[np.random.SeedSequence]:
    return [np.random.SeedSequence(seed, spawn_key=(_FAMILY, _SEED_KEY[what], which)) for which in (A, B)]


def bootstrap_seed(seed: int) -> np.random.SeedSequence:
    """Return the seed of the errors of a propagation."""
    return np.random.SeedSequence(seed, spawn_key=(_FAMILY, _SEED_KEY["bootstrap"]))


_FAMILY = 2**18
"""Keeps these draws apart from the seeds of clouds, waves and certificates."""
