"""Effective sample sizes and R-hat of draws from several chains, by ranks.

A. Vehtari, A. Gelman, D. Simpson, B. Carpenter and P.-C. Buerkner, Bayesian Analysis 16, 667-718 (2021),
doi:10.1214/20-BA1221, whose equation numbers are given.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hcss_twin.providers import Array

_TAILS = (0.05, 0.95)

_FEWEST_DRAWS = 4


@dataclass(frozen=True)
class Mixing:
    """Diagnostics of the draws of one parameter; NaN if a chain has fewer than 4 draws, or if draws do not vary.

    The bulk effective sample size applies to the location of the distribution, the tail effective sample size to its 5
    and 95 % quantiles. R-hat is 1 if all chains, and both halves of each, have the same distribution.
    """

    bulk_effective_sample_size: float
    tail_effective_sample_size: float
    rank_normalized_split_r_hat: float

    @property
    def smallest_size(self) -> float:
        """The smaller of the two effective sample sizes."""
        return float(np.min([self.bulk_effective_sample_size, self.tail_effective_sample_size]))


def mixing(draws: Array) -> Mixing:
    """Return the diagnostics of draws (chain, draw), or the worst of draws (chain, draw, image) of several images."""
    if draws.ndim == 3:
        of_images = [mixing(draws[..., image]) for image in range(draws.shape[2])]
        return Mixing(
            float(np.min([one.bulk_effective_sample_size for one in of_images])),
            float(np.min([one.tail_effective_sample_size for one in of_images])),
            float(np.max([one.rank_normalized_split_r_hat for one in of_images])),
        )
    if draws.shape[1] < _FEWEST_DRAWS or not np.ptp(draws) > 0.0:
        return Mixing(math.nan, math.nan, math.nan)
    halves = _halves(np.ascontiguousarray(draws))  # sums, to the last bit, depend on the order in memory
    normal = _rank_normalized(halves)
    # Section 4.3: an effective sample size of the indicator I(theta <= quantile) for each tail.
    tails = [_effective_size((halves <= limit).astype(np.float64)) for limit in np.quantile(draws, _TAILS)]
    # Section 4.2, eq 15: folded draws show differences of scale.
    folded = _rank_normalized(np.abs(halves - np.median(halves)))
    return Mixing(_effective_size(normal), float(np.min(tails)), float(np.max([_r_hat(normal), _r_hat(folded)])))


def _halves(draws: Array) -> Array:
    """Split each chain into two; an odd number of draws loses the middle one."""
    half = draws.shape[1] // 2
    return np.concatenate([draws[:, :half], draws[:, -half:]])


def _rank_normalized(draws: Array) -> Array:
    """Return normal scores of the ranks over all chains; equal draws share their mean rank (eq 14).

    The fractional offset is Blom's: (rank - 3/8) / (size + 1/4).
    """
    from scipy.special import ndtri
    from scipy.stats import rankdata

    rank = rankdata(draws, method="average").reshape(draws.shape)
    return np.asarray(ndtri((rank - 0.375) / (draws.size + 0.25)))


def _variances(draws: Array) -> tuple[float, float]:
    """Return the variance within chains (eq 2) and the estimate of the total variance (eq 3)."""
    count = draws.shape[1]
    within = float(draws.var(axis=1, ddof=1).mean())
    return within, (count - 1) / count * within + float(draws.mean(axis=1).var(ddof=1))


def _r_hat(draws: Array) -> float:
    """Return the potential scale reduction factor (eq 4)."""
    within, total = _variances(draws)
    return math.sqrt(total / within) if within > 0.0 else math.nan


def _effective_size(draws: Array) -> float:
    """Return the effective sample size (eqs 10 to 13), with Geyer's initial monotone sequence."""
    chains, count = draws.shape
    within, total = _variances(draws)
    if not total > 0.0:
        return math.nan
    # Autocovariance of each chain at all lags, by the Fourier transform of the chain padded with zeros; eq 10.
    spectrum = np.abs(np.fft.rfft(draws - draws.mean(axis=1, keepdims=True), 2 * count, axis=1)) ** 2
    covariance = np.fft.irfft(spectrum, axis=1)[:, :count].mean(axis=0) / count
    correlation = 1.0 - (within - covariance) / total
    correlation[0] = 1.0
    # Sums over pairs of lags are positive and decrease for any reversible chain: the rest is noise.
    # The last lags, of which few draws know, are left out, as in Stan and ArviZ.
    pairs = correlation[: count // 2 * 2].reshape(-1, 2).sum(axis=1)
    known = pairs[: max((count - 3) // 2, 1)]
    positive = int(np.argmax(known <= 0.0)) if (known <= 0.0).any() else known.size
    time = -1.0 + 2.0 * float(np.minimum.accumulate(pairs[:positive]).sum())
    if positive < pairs.size:
        # The first even lag after them reduces the bias of antithetic chains.
        time += max(float(correlation[2 * positive]), 0.0)
    size = chains * count
    return float(size / max(time, 1.0 / math.log10(size)))
