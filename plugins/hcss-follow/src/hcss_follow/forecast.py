"""Forecast of a followed sky in the frame that moves with it: regression by scale, and members of an ensemble.

The image and its tendency (what changed since the image before, moved along) are split into bands of scale. The
forecast is their sum with coefficients that depend on band and lead. How much of a band stays depends on the place:
q = E / (E + B), with the local energies of the tendency E and of the image B, is large where the last image was moved
badly.

What the forecast does not know has, by band and place, a variance that is a sum of E and B, times a factor that depends
on how far the pixel is below the clear sky. A member of an ensemble fills it with the image's own bands from a place
that its seed chooses, with their local energy set to 1: edges, streets and cells stay together. Their sum is u times
its standard deviation; u |u|^(1/4), with the same variance for normal u, takes the place of u: errors are small in
most pixels and large in few.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.ndimage import maximum_filter

from hcss_follow.bands import bands_of, local_energy
from hcss_follow.coefficients import DEPTHS_K, PER_S, Coefficients, read_coefficients
from hcss_follow.state import Field, State
from hcss_twin.core.kernels import kernel

LEAST_K2 = 0.01
"""Energy of bands below which they are noise."""

PEAK = math.sqrt(math.sqrt(math.pi) / (2.0**1.25 * math.gamma(1.75)))
"""Inverse of the standard deviation of u |u|^(1/4) for normal u."""

_WARM_WINDOW = 9
"""Side in pixels of the surroundings, the warmest of which limits how warm a forecast is."""


class Forecast:
    """Brightness temperature at the pixels of a state, where they will have moved to.

    Parameters
    ----------
    state : State
    seed : int or None
        Of the member; None: the mean.
    coefficients : Coefficients, optional
        Default: those of the package.
    """

    def __init__(self, state: State, seed: int | None, coefficients: Coefficients | None = None) -> None:
        self._of = coefficients or read_coefficients()
        self._parts = parts = _parts_of(state)
        image = parts.predictors[0]
        self._texture = np.empty((0, 0, 0), np.float32) if seed is None else displaced(image, parts.energy, seed)

    def kelvin(self, lead_s: float) -> Field:
        """Return the forecast (rows, columns); the image itself at lead 0."""
        if lead_s == 0.0:
            return self._parts.kelvin
        mean, variance, factors = self._of.at(abs(lead_s))
        out, parts = np.empty(self._parts.kelvin.shape, np.float32), self._parts
        _combine(
            out, np.float32(parts.level_K), parts.predictors, parts.changes, parts.energy, self._texture, parts.warmest,
            np.interp(parts.depth_K, DEPTHS_K, np.sqrt(factors)).astype(np.float32), mean.astype(np.float32),
            np.maximum(variance, 0.0).astype(np.float32), np.float32(PEAK),
        )  # fmt: skip
        return out


@dataclass(frozen=True)
class _Parts:
    """What all members of a state share: image, its mean, predictors (4, 7, y, x), local energies, and limits."""

    kelvin: Field
    level_K: float
    predictors: Field
    changes: Field
    energy: Field
    warmest: Field
    depth_K: Field


@lru_cache(maxsize=4)
def _parts_of(state: State) -> _Parts:
    scale = 0.0 if state.number < 2 else PER_S / state.interval_s
    level = float(state.kelvin.mean(dtype=np.float64))
    image, tendency = bands_of(state.kelvin - np.float32(level)), np.float32(scale) * bands_of(state.tendency_K)
    changes, energy = local_energy(tendency), local_energy(image)
    uncertain = changes / (changes + energy + np.float32(LEAST_K2))
    predictors = np.stack([image, tendency, image * uncertain, tendency * uncertain])
    nearby = maximum_filter(state.kelvin, _WARM_WINDOW, mode="nearest")
    return _Parts(
        state.kelvin,
        level,
        predictors,
        changes,
        energy,
        np.maximum(state.clear_K, nearby),
        state.clear_K - state.kelvin,
    )


def displaced(image: Field, energy: Field, seed: int) -> Field:
    """Return bands (7, rows, columns) of local energy 1 from another place of the mirrored image."""
    rng = np.random.default_rng([seed, 0xF0110])
    rows, columns = image.shape[1:]
    ratio = image / np.sqrt(energy + np.float32(LEAST_K2))
    ratio[-1] -= ratio[-1].mean()
    ratio[-1] /= max(float(ratio[-1].std()), 1e-6)
    sides = rows, columns
    shifts = rng.integers(0, (2 * rows, 2 * columns))
    places = [np.mod(np.arange(side) - shift, 2 * side) for side, shift in zip(sides, shifts, strict=True)]
    y, x = (np.minimum(place, 2 * side - 1 - place) for side, place in zip(sides, places, strict=True))
    return np.ascontiguousarray(ratio[:, y[:, None], x])


@kernel(fastmath={"contract"})
def _combine(
    out: Any,
    level: Any,
    predictors: Any,
    changes: Any,
    energy: Any,
    texture: Any,
    warmest: Any,
    factor: Any,
    mean: Any,
    variance: Any,
    peak: Any,
) -> None:
    zero = np.float32(0.0)
    drawn, total = np.empty(out.shape[1], np.float32), np.empty(out.shape[1], np.float32)
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            out[i, j] = level
        for k in range(mean.shape[1]):
            for p in range(mean.shape[0]):
                part = mean[p, k]
                if part != zero:
                    for j in range(out.shape[1]):
                        out[i, j] += part * predictors[p, k, i, j]
        if texture.shape[0]:
            drawn[:] = total[:] = zero
            for k in range(mean.shape[1]):
                for j in range(out.shape[1]):
                    unknown = variance[0, k] * changes[k, i, j] + variance[1, k] * energy[k, i, j]
                    total[j] += unknown
                    drawn[j] += np.sqrt(unknown) * texture[k, i, j]
            for j in range(out.shape[1]):
                if total[j] > zero:
                    size = np.sqrt(np.sqrt(np.abs(drawn[j]) / np.sqrt(total[j])))
                    out[i, j] += factor[i, j] * drawn[j] * peak * size
        for j in range(out.shape[1]):
            out[i, j] = min(out[i, j], warmest[i, j])
