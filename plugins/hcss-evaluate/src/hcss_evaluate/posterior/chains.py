"""Markov chains with emcee: posterior density for one image, resumable sampling in blocks, and convergence."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from hcss_evaluate.posterior.mixing import Mixing, mixing
from hcss_evaluate.posterior.parameter_space import Space
from hcss_evaluate.posterior.priors import KINDS
from hcss_twin.providers import Array

Likelihood = Callable[[Array], Array]
"""Log-likelihood (N,) as a function of H, gamma, Lx, Ly, coverage (N, 5)."""


class PosteriorModel(Protocol):
    """Interface of a posterior density that chains can sample."""

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each dimension."""

    def log_probability(self, position: Array) -> Array:
        """Return the log posterior density (N,) of positions (N, D)."""

    def moves(self) -> list[tuple[Any, float]]:
        """Return emcee's moves and their weights."""

    def values(self, position: Array) -> dict[str, Array]:
        """Return the parameters (...) or (..., image) at positions (..., D)."""


@dataclass(frozen=True)
class SingleModel:
    """Parameters of one image."""

    space: Space
    likelihood: Likelihood

    @property
    def names(self) -> tuple[str, ...]:
        """Free parameters."""
        return self.space.names

    def log_probability(self, position: Array) -> Array:
        """Return the log posterior density (N,) of positions (N, D)."""
        total = self.space.log_prior(position)
        possible = np.isfinite(total)
        total[~possible] = -np.inf
        if possible.any():
            likelihood = self.likelihood(self.space.complete(position[possible]))
            total[possible] += np.where(np.isnan(likelihood), -np.inf, likelihood)
        return total

    def moves(self) -> list[tuple[Any, float]]:
        """Return differential-evolution moves with occasional full jumps between modes.

        Their autocorrelation time is half that of the stretch move here.
        """
        from emcee.moves import DEMove

        return [(DEMove(), 0.9), (DEMove(gamma0=1.0), 0.1)]

    def values(self, position: Array) -> dict[str, Array]:
        """Return the free parameters (...) at positions (..., D)."""
        return {name: KINDS[name].scale.back(position[..., i]) for i, name in enumerate(self.names)}


BURN_IN = 0.2
"""Fraction of the steps discarded as burn-in."""

LONGEST = 50.0
"""Minimum chain length after burn-in in autocorrelation times, for a reliable estimate of that time."""

LARGEST_R_HAT = 1.01
"""Recommended by Vehtari et al. (2021). Halves of stationary walkers with 25 nearly independent draws, of the shortest
chains allowed, have 1.006 +- 0.005; stuck walkers give far larger values."""


@dataclass(frozen=True)
class Convergence:
    """Convergence diagnostics of chains with ``steps`` per walker after burn-in.

    The integrated autocorrelation time (D,) is in steps (J. Goodman and J. Weare, Commun. Appl. Math. Comput. Sci. 5,
    65 (2010)). ``mixing`` has the diagnostics of the draws that would be stored, by parameter: every ``every``-th step
    of each walker. Both effective sample sizes must reach ``wanted``.

    Each walker is a chain. Walkers propose moves from the positions of others, but are independent of them at any one
    step once they are stationary, as the ensemble samples the product of their densities. Any pooling of walkers would
    hide one that is stuck.
    """

    autocorrelation_time: Array
    mixing: dict[str, Mixing]
    steps: int
    wanted: float

    @property
    def fraction(self) -> float:
        """Approximate progress toward convergence; 1 or more if the chains have converged."""
        parts = [
            self.steps / (LONGEST * float(np.max(self.autocorrelation_time))),
            float(np.min([mixing.smallest_size for mixing in self.mixing.values()])) / self.wanted,
            # The excess of R-hat above 1 of a stationary chain is inversely proportional to its length.
            (LARGEST_R_HAT - 1.0) / max(float(np.max(self._r_hat)) - 1.0, 1e-9),
        ]
        least = float(np.min(parts))
        return least if math.isfinite(least) else 0.0

    @property
    def has_converged(self) -> bool:
        """Whether all three criteria are met."""
        return self.fraction >= 1.0

    def complaints(self, names: tuple[str, ...]) -> list[str]:
        """Describe the criteria that are not met, each with the worst parameter."""
        tau, parameters = self.autocorrelation_time, list(self.mixing)
        worst = int(np.argmax(np.nan_to_num(tau, nan=math.inf)))
        lines = []
        if not self.steps >= LONGEST * tau[worst]:
            lines.append(
                f"{self.steps} steps after burn-in are {self.steps / tau[worst]:.0f} autocorrelation times of "
                f"{names[worst]} ({tau[worst]:.0f} steps), needed: {LONGEST:g}"
            )
        for kind in ("bulk", "tail"):
            size = [getattr(mixing, f"{kind}_effective_sample_size") for mixing in self.mixing.values()]
            worst = int(np.argmin(np.nan_to_num(size, nan=-math.inf)))
            if not size[worst] >= self.wanted:
                found = f"{kind} effective sample size of {parameters[worst]} {size[worst]:.0f}"
                lines.append(f"{found}, needed: {self.wanted:g}")
        worst = int(np.argmax(np.nan_to_num(self._r_hat, nan=math.inf)))
        if not self._r_hat[worst] <= LARGEST_R_HAT:
            lines.append(
                f"rank-normalized split R-hat of {parameters[worst]} {self._r_hat[worst]:.3f}, "
                f"needed: {LARGEST_R_HAT} or less"
            )
        return lines

    @property
    def every(self) -> int:
        """Steps between stored draws: the longest autocorrelation time; 1 where it is unknown."""
        longest = float(np.max(self.autocorrelation_time))
        return math.ceil(longest) if math.isfinite(longest) else 1

    @property
    def _r_hat(self) -> list[float]:
        return [mixing.rank_normalized_split_r_hat for mixing in self.mixing.values()]


def judge(model: PosteriorModel, chain: Array, wanted: float) -> Convergence:
    """Compute the diagnostics of chains (steps, walkers, D) without burn-in."""
    from emcee.autocorr import integrated_time

    # A walker that never moved has no autocorrelation time: NaN, which counts as not converged.
    with np.errstate(invalid="ignore", divide="ignore"):
        tau = np.asarray(integrated_time(chain, tol=0), dtype=np.float64)
    # Times below one step are not resolved.
    tau = np.maximum(tau, 1.0)
    found = Convergence(tau, {}, chain.shape[0], wanted)
    draws = model.values(stored(chain, found.every))
    return replace(found, mixing={name: mixing(values) for name, values in draws.items()})


def stored(chain: Array, every: int) -> Array:
    """Return the draws (walkers, draw, ...) that are stored of steps after burn-in (steps, walkers, ...)."""
    return chain[::every].swapaxes(0, 1)


# Steps before the first convergence check, after which a check follows each growth by 1 / _GROWTH.
_FIRST, _GROWTH = 500, 4

# Walkers per dimension, and their minimum number.
_PER_DIMENSION, _FEWEST_WALKERS = 4, 32


@dataclass(frozen=True)
class MarkovChains:
    """All steps so far: positions (steps, walkers, D) and log densities (steps, walkers).

    ``random_state`` is the state of numpy's Mersenne twister after the last step.
    """

    positions: Array
    log_probability: Array
    random_state: tuple[Any, ...]

    @property
    def after_burn_in(self) -> slice:
        """Steps after burn-in."""
        return slice(int(BURN_IN * self.positions.shape[0]), None)


def walkers_of(dimensions: int) -> int:
    """Return the (even) number of walkers for a number of dimensions."""
    return max(_FEWEST_WALKERS, _PER_DIMENSION * dimensions)


def begin(log_probability: Callable[[Array], Array], start: Array, seed: int) -> MarkovChains:
    """Initialise walkers at ``start`` (walkers, D)."""
    state = np.random.RandomState(seed).get_state()
    return MarkovChains(start[None], log_probability(start)[None], tuple(state))


def extend(model: PosteriorModel, chains: MarkovChains, steps: int) -> MarkovChains:
    """Continue for a number of steps; interruptions between calls do not change the chain."""
    import emcee

    _, walkers, dimensions = chains.positions.shape
    sampler = emcee.EnsembleSampler(walkers, dimensions, model.log_probability, moves=model.moves(), vectorize=True)
    # Bypasses emcee's wrapper, which prints all positions on Ctrl-C.
    sampler.log_prob_fn = model.log_probability
    state = emcee.State(chains.positions[-1], log_prob=chains.log_probability[-1], random_state=chains.random_state)
    last = sampler.run_mcmc(state, steps, skip_initial_state_check=True)
    return MarkovChains(
        np.concatenate([chains.positions, sampler.get_chain()]),
        np.concatenate([chains.log_probability, sampler.get_log_prob()]),
        tuple(last.random_state),
    )


def converge(
    model: PosteriorModel,
    chains: MarkovChains,
    wanted: float,
    most_steps: int,
    after_block: Callable[[MarkovChains, Convergence | None], None],
) -> tuple[MarkovChains, Convergence]:
    """Sample until every parameter has the effective sample size ``wanted``, or up to the limit of steps per walker.

    ``after_block`` is called after each block with the chains and their latest diagnostics.
    """
    while True:
        done = chains.positions.shape[0]
        convergence = judge(model, chains.positions[chains.after_burn_in], wanted) if done >= _FIRST else None
        after_block(chains, convergence)
        if convergence is not None and (convergence.has_converged or done >= most_steps):
            return chains, convergence
        block = _FIRST - done if done < _FIRST else max(_FIRST, done // _GROWTH)
        chains = extend(model, chains, max(1, min(block, most_steps - done)))
