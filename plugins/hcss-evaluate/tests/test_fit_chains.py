"""Chains: their measures against closed forms, and that an interruption does not change them."""

from types import SimpleNamespace

import numpy as np
import pytest
from hcss_evaluate.errors import PosteriorError
from hcss_evaluate.posterior.chains import MarkovChains, SingleModel, begin, converge, extend, judge, stored, walkers_of
from hcss_evaluate.posterior.fit import pilot_draws
from hcss_evaluate.posterior.fit_run import Checkpoint, FitState
from hcss_evaluate.posterior.mixing import mixing

MEAN, COVARIANCE = np.array([1.0, -2.0]), np.array([[1.0, 0.9], [0.9, 2.0]])
PRECISION = np.linalg.inv(COVARIANCE)


def normal(position):
    away = position - MEAN
    return -0.5 * np.einsum("ni,ij,nj->n", away, PRECISION, away)


NORMAL = SimpleNamespace(
    names=("H", "gamma"),
    log_probability=normal,
    moves=lambda: SingleModel.moves(None),
    values=lambda position: {"H": position[..., 0], "gamma": position[..., 1]},
)
ONE = SimpleNamespace(names=("H",), values=lambda position: {"H": position[..., 0]})


def start(seed=0):
    return begin(normal, np.random.default_rng(seed).standard_normal((walkers_of(2), 2)), seed)


def autoregressive(coefficient, steps, walkers, seed=0):
    noise = np.random.default_rng(seed).standard_normal((steps, walkers, 1))
    chain = np.empty_like(noise)
    chain[0] = noise[0] / np.sqrt(1 - coefficient**2)
    for step in range(1, steps):
        chain[step] = coefficient * chain[step - 1] + noise[step]
    return chain


@pytest.mark.parametrize("coefficient", [0.0, 0.5, 0.9])
def test_autocorrelation_time_is_that_of_an_autoregressive_process(coefficient):
    chain = autoregressive(coefficient, 4000, 32)
    found = judge(ONE, chain, 1000)
    assert found.autocorrelation_time[0] == pytest.approx((1 + coefficient) / (1 - coefficient), rel=0.06)
    # The effective sample size is that of the thinned draws.
    draws = stored(chain, found.every)[..., 0]
    assert found.mixing == {"H": mixing(draws)}
    rest = coefficient**found.every
    assert found.mixing["H"].bulk_effective_sample_size == pytest.approx(draws.size * (1 - rest) / (1 + rest), rel=0.1)


def test_a_walker_that_is_stuck_is_seen():
    chain = autoregressive(0.5, 4000, 32)
    assert judge(ONE, chain, 1000).has_converged
    chain[:, 5] = 9.0 + 0.1 * chain[:, 5]
    found = judge(ONE, chain, 1000)
    assert not found.has_converged
    assert any("rank-normalized split R-hat of H" in line for line in found.complaints(("H",)))


def test_a_chain_that_is_too_short_or_does_not_move_has_not_converged():
    for chain in (autoregressive(0.5, 3, 32), np.ones((600, 32, 1)), np.tile(np.arange(32.0)[:, None], (600, 1, 1))):
        assert judge(ONE, chain, 100).fraction < 1.0


def test_chains_have_mean_and_covariance_of_their_target():
    chains, found = converge(NORMAL, start(), 2000, 20_000, lambda *_: None)
    assert found.has_converged
    drawn = stored(chains.positions[chains.after_burn_in], found.every).reshape(-1, 2)
    size = [found.mixing[name].bulk_effective_sample_size for name in NORMAL.names]
    error = np.sqrt(np.diag(COVARIANCE) / size)
    assert np.all(np.abs(drawn.mean(axis=0) - MEAN) < 4 * error)
    np.testing.assert_allclose(np.cov(drawn.T), COVARIANCE, rtol=0.1)


def test_chains_end_at_their_limit():
    chains, found = converge(NORMAL, start(), 1e6, 700, lambda *_: None)
    assert chains.positions.shape[0] == 700
    assert not found.has_converged


def test_interrupted_chains_go_on_as_if_they_had_not_been(tmp_path):
    whole = extend(NORMAL, extend(NORMAL, start(), 300), 200)
    checkpoint = Checkpoint(tmp_path / "state", "mine")
    checkpoint.write(FitState((), extend(NORMAL, start(), 300)))
    resumed = checkpoint.read()
    assert resumed is not None
    again = extend(NORMAL, resumed.chains, 200)
    np.testing.assert_array_equal(again.positions, whole.positions)
    np.testing.assert_array_equal(again.log_probability, whole.log_probability)


def test_states_of_other_fits_and_damaged_ones_are_refused(tmp_path):
    path = tmp_path / "state"
    Checkpoint(path, "mine").write(FitState((), start()))
    with pytest.raises(PosteriorError, match=r"state of another fit.*delete"):
        Checkpoint(path, "yours").read()
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(PosteriorError, match="damaged"):
        Checkpoint(path, "mine").read()


def test_states_are_not_written_all_the_time(tmp_path):
    path = tmp_path / "state"
    checkpoint = Checkpoint(path, "mine")
    checkpoint.write(FitState((), start()))
    longer: MarkovChains = extend(NORMAL, start(), 5)
    checkpoint.write(FitState((), longer))
    assert checkpoint.read().chains.positions.shape[0] == 1
    checkpoint.write(FitState((), longer), now=True)
    assert checkpoint.read().chains.positions.shape[0] == 6
    checkpoint.remove()
    assert checkpoint.read() is None


def test_a_pilot_leaves_a_point_that_most_of_its_candidates_are():
    """Walkers that all begin at one point have no differences to jump by, and looked converged."""
    candidates = np.concatenate([np.tile(MEAN, (500, 1)), np.random.default_rng(0).standard_normal((200, 2))])
    drawn = pilot_draws(NORMAL, candidates, np.random.default_rng(1))
    np.testing.assert_allclose(np.cov(drawn.T), COVARIANCE, rtol=0.3)
