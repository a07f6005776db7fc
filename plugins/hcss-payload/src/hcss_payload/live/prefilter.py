"""Contrast of live pixels: how much of the field's variance a pixel's radiance must show.

A live pixel has one value of the field, the mean over its footprint, and the radiance averaged over what varies inside.
That average is the same for all pixels with one mean, whereas true pixels differ by the gaps and edges that they happen
to hold: alone it shows up to 15 % too little contrast between neighbours. So each band averages over less than what the
footprint removes, and the field is widened to keep its variance of 1: the mean radiance stays exact, and the share that
the field keeps follows from the contrast of true pixels.

For two normal values of variance 1 and covariance r the radiance has the covariance g(r), which is the variance of the
radiance averaged over a share 1 - r of the field's variance. Averaging g over all pairs of points of two footprints
gives the covariance of true pixels; g of the covariance of the interpolated field that of live ones.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hcss_payload.live.octaves import SeenOctaves, separations
from hcss_twin.providers import Array

_HALF, _CELLS = 16.0, 6400
"""Range of the field, and cells in it, for averages of the radiance; beyond 8 nothing matters, the rest is padding."""

_BLUR = np.linspace(0.0, 1.0, 33)
"""Roots of 1 - r at which g(r) is computed: in these it is smooth even for a step."""


@dataclass(frozen=True, eq=False)
class Sharpness:
    """How much of the field each band shows; the variance of the scaled field and of what is averaged is 1.

    Attributes
    ----------
    sigma : ndarray (B,)
        Standard deviation of the field over which the radiance is averaged.
    scale : ndarray (B,)
        Factor of the field of tiles.
    """

    sigma: Array
    scale: Array


def radiance_covariance(radiance: Callable[[Array], Array], edge: float) -> Array:
    """Return g (B, 33) at the covariances 1 - ``_BLUR`` ** 2, for the radiance (B, N) of values (N,) of the field."""
    cell = 2.0 * _HALF / _CELLS
    # The edge of clouds lies between two cells.
    value = (np.arange(_CELLS) - _CELLS // 2 + 0.5) * cell + edge
    spectrum = np.fft.rfft(radiance(np.asarray(value, dtype=np.float64)))
    frequency = 2.0 * np.pi * np.fft.rfftfreq(_CELLS, cell)
    result = np.zeros((len(spectrum), _BLUR.size))
    for index, blur in enumerate(_BLUR[:-1]):  # g(0) is 0
        averaged = np.fft.irfft(spectrum * np.exp(-0.5 * (blur * frequency) ** 2), _CELLS)
        weight = np.exp(-0.5 * value**2 / (1.0 - blur**2))
        weight /= weight.sum()
        mean = averaged @ weight
        result[:, index] = (averaged - mean[:, None]) ** 2 @ weight
    return result


def sharpness(radiance: Callable[[Array], Array], edge: float, seen: SeenOctaves) -> Sharpness:
    """Return how much the bands average, so that neighbours differ as much as those of true pixels.

    Parameters
    ----------
    radiance : callable
        Radiance (B, N) of values (N,) of the field, which may jump at ``edge``.
    """
    along, down = seen.footprint
    result = []
    pairs = [seen.true_covariance(separations(seen.footprint, lag)[0]) for lag in (0.0 * along, along, down)]
    weight = separations(seen.footprint, along)[1]
    kept, *beside = (seen.kept_covariance(lag) for lag in (0.0 * along, along, down))
    for band_covariance in radiance_covariance(radiance, edge):

        def g(covariance: Array, band_covariance: Array = band_covariance) -> Array:
            falling = np.minimum(covariance, 0.0) * (band_covariance[-2] / (1.0 - _BLUR[-2] ** 2))
            values: Array = np.interp(np.sqrt(1.0 - np.clip(covariance, 0.0, 1.0)), _BLUR, band_covariance) + falling
            return values

        same, *others = (float(g(pair) @ weight) for pair in pairs)
        share = 1.0 - (1.0 - 0.5 * kept) * np.linspace(1.0, 0.0, 257) ** 2
        shown = g(share) - 0.5 * sum(g(share * neighbour / kept) for neighbour in beside)
        result.append(float(np.interp(same - 0.5 * sum(others), np.maximum.accumulate(shown), share)))
    shares = np.array(result)
    return Sharpness(np.sqrt(1.0 - shares), np.sqrt(shares / kept))
