"""Chains that run until they have converged: emcee, in blocks, which can be stopped and gone on with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.uncertainty.convergence import BURN_IN, Convergence, judge
from hcss_twin.uncertainty.posterior_model import Model

Array = NDArray[np.float64]

# Steps before the first judgement; then each time the chain has grown by this part of itself.
_FIRST, _GROWTH = 500, 4

# Walkers per dimension, and the fewest.
_PER_DIMENSION, _FEWEST_WALKERS = 4, 32


@dataclass(frozen=True)
class Chains:
    """What has been sampled so far.

    Attributes
    ----------
    positions : ndarray (steps, walkers, D)
        All steps.
    log_probability : ndarray (steps, walkers)
        Of them.
    random_state : tuple
        Of numpy's Mersenne twister after the last step.
    """

    positions: Array
    log_probability: Array
    random_state: tuple[Any, ...]

    @property
    def kept(self) -> slice:
        """Steps after the burn-in."""
        return slice(int(BURN_IN * self.positions.shape[0]), None)

    def judge(self, wanted: float) -> Convergence:
        """Measure their convergence."""
        return judge(self.positions[self.kept], wanted)


def walkers_of(dimensions: int) -> int:
    """Return how many walkers a space of so many dimensions gets, an even number."""
    return max(_FEWEST_WALKERS, _PER_DIMENSION * dimensions)


def begin(log_probability: Callable[[Array], Array], start: Array, seed: int) -> Chains:
    """Put walkers at ``start`` (walkers, D)."""
    state = np.random.RandomState(seed).get_state()
    return Chains(start[None], log_probability(start)[None], tuple(state))


def extend(model: Model, chains: Chains, steps: int) -> Chains:
    """Go on for some steps; where a chain is interrupted between calls does not change it."""
    import emcee

    _, walkers, dimensions = chains.positions.shape
    sampler = emcee.EnsembleSampler(
        walkers, dimensions, model.log_probability, moves=model.moves(), vectorize=True
    )
    # Without emcee's wrapper, which prints all positions where Ctrl-C comes.
    sampler.log_prob_fn = model.log_probability
    state = emcee.State(
        chains.positions[-1],
        log_prob=chains.log_probability[-1],
        random_state=chains.random_state,
    )
    last = sampler.run_mcmc(state, steps, skip_initial_state_check=True)
    return Chains(
        np.concatenate([chains.positions, sampler.get_chain()]),
        np.concatenate([chains.log_probability, sampler.get_log_prob()]),
        tuple(last.random_state),
    )


def converge(
    model: Model,
    chains: Chains,
    wanted: float,
    most_steps: int,
    told: Callable[[Chains, Convergence | None], None],
) -> tuple[Chains, Convergence]:
    """Go on until chains have converged, or to the limit.

    Parameters
    ----------
    model : Model
        Of which the density and the moves are taken.
    chains : Chains
        From :func:`begin`, or from an earlier run.
    wanted : float
        Effective sample size of every parameter.
    most_steps : int
        Limit, steps per walker.
    told : callable
        Is told of the chains after each block.
    """
    while True:
        done = chains.positions.shape[0]
        found = chains.judge(wanted) if done >= _FIRST else None
        told(chains, found)
        if found is not None and (found.has_converged or done >= most_steps):
            return chains, found
        block = _FIRST - done if done < _FIRST else max(_FIRST, done // _GROWTH)
        chains = extend(model, chains, max(1, min(block, most_steps - done)))
