"""Noise: shot noise of counted electrons, Gaussian noise, and fixed-pattern noise of the detectors.

Every random number is a hash of its purpose (a key), row, column and number of the draw. The noise of a pixel therefore
does not depend on which part of the image is computed, nor on the brightness of other pixels. With numpy's generators
it would, because the number of draws depends on the values.
"""

from __future__ import annotations

import hashlib
import math
from typing import Any, ClassVar

import numpy as np
from scipy.special import ndtri

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError
from hcss_twin.core.kernels import kernel
from hcss_twin.models.sensor.philox import fill_normals

__all__ = ["Noise"]

MAX_COUNTED = 1e12
"""Maximum expected number of electrons; above it, rounding would distort the distribution."""

_SMALL_MEAN = 10.0
"""Mean above which transformed rejection is valid; below it, uniform numbers are multiplied."""


def too_many_electrons(most: float) -> ProviderError:
    """Return the error of a pixel in which more electrons are expected than can be drawn."""
    return ProviderError(
        f"{most:.3g} electrons are expected in a pixel; allowed: up to {MAX_COUNTED:g} (aperture_diameter, "
        "pixel_angle, integration_time)"
    )


@kernel()
def _mixed(state: Any) -> Any:
    """Finaliser of splitmix64 (Steele et al., OOPSLA 2014)."""
    state = np.uint64((state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9))
    state = np.uint64((state ^ (state >> np.uint64(27))) * np.uint64(0x94D049BB133111EB))
    return np.uint64(state ^ (state >> np.uint64(31)))


@kernel()
def row_key(key: Any, row: Any) -> Any:
    """Return the key of a row of the image, which may be negative."""
    return _mixed(np.uint64(key + np.uint64(np.uint64(row) * np.uint64(0xD1B54A32D192ED03))))


@kernel()
def pixel_key(row_key: Any, column: Any) -> Any:
    """Return the key of a pixel of a row."""
    return _mixed(np.uint64(row_key + np.uint64(np.uint64(column) * np.uint64(0xDB4F0B9175AE2165))))


@kernel()
def _uniform(pixel_key: Any, draw: Any) -> float:
    """Return the draw, from 0, of a pixel: a number between 0 and 1, both excluded."""
    step = np.uint64(np.uint64(draw + 1) * np.uint64(0x9E3779B97F4A7C15))
    # 52 bits: with one more, half a step could be rounded away, and 1 returned.
    bits = _mixed(np.uint64(pixel_key + step)) >> np.uint64(12)
    return (float(bits) + 0.5) * 2.0**-52


@kernel()
def _fill_uniform(numbers: Array, key: Any, first_row: Any, first_column: Any) -> None:
    for y in range(numbers.shape[0]):
        own_row = row_key(key, np.int64(first_row + y))
        for x in range(numbers.shape[1]):
            numbers[y, x] = _uniform(pixel_key(own_row, np.int64(first_column + x)), 0)


@kernel()
def draw_poisson(mean: float, pixel_key: Any) -> Any:
    """Return a Poisson number with a mean of 0 to 1e12.

    Means from 10 on by transformed rejection (W. Hoermann, Insurance: Mathematics and Economics 12, 39 (1993),
    algorithm PTRS), smaller ones by multiplying uniform numbers until the product falls below exp(-mean).
    """
    if mean <= 0.0:
        return 0.0
    return _multiplied(mean, pixel_key) if mean < _SMALL_MEAN else _rejected(mean, pixel_key)


@kernel()
def _multiplied(mean: float, pixel_key: Any) -> float:
    least, product, count = math.exp(-mean), 1.0, -1
    while product > least or count < 0:
        count += 1
        product *= _uniform(pixel_key, count)
    return float(count)


@kernel()
def _rejected(mean: float, pixel_key: Any) -> float:
    log_mean = math.log(mean)
    b = 0.931 + 2.53 * math.sqrt(mean)
    a = -0.059 + 0.02483 * b
    inverse_alpha = 1.1239 + 1.1328 / (b - 3.4)
    squeeze = 0.9277 - 3.6224 / (b - 2.0)
    draw = 0
    while True:
        u, v = _uniform(pixel_key, draw) - 0.5, _uniform(pixel_key, draw + 1)
        draw += 2
        us = 0.5 - abs(u)
        k = math.floor((2.0 * a / us + b) * u + mean + 0.43)
        if us >= 0.07 and v <= squeeze:
            return float(k)
        if k < 0 or (us < 0.013 and v > us):
            continue
        log_accepted = math.log(v * inverse_alpha / (a / (us * us) + b))
        if log_accepted <= k * log_mean - mean - math.lgamma(k + 1.0):
            return float(k)


class Noise:
    """Random numbers of pixels, each a hash of its purpose and place.

    Attributes
    ----------
    fill_normals
        Compiled: fills ``numbers`` (N,) of float32, N a multiple of 64, with standard normal numbers for the pixels of
        a ``row`` from a ``block`` of columns on, with a ``key``.
    """

    fill_normals: ClassVar = fill_normals

    @staticmethod
    def key_of(seed: int, stage: str, band: str, frame: int = 0) -> int:
        """Return the key, 64 bits, of the random numbers of one stage, band and frame.

        ``seed`` and ``frame`` are 0 or more; ``frame`` is 0 for the fixed pattern, the same in all frames.
        """
        digest = hashlib.sha256(f"{stage}/{band}".encode()).digest()
        words = [int.from_bytes(digest[start : start + 4], "little") for start in (0, 4, 8)]
        sequence = np.random.SeedSequence(seed, spawn_key=(*words, frame))
        return int(sequence.generate_state(1, np.uint64)[0])

    @staticmethod
    def standard_normal(key: int, shape: tuple[int, int], corner: tuple[int, int]) -> Array:
        """Return standard normal numbers (Y, X) for the pixels from ``corner`` on, which may be negative."""
        numbers = np.empty(shape)
        _fill_uniform(numbers, np.uint64(key), np.int64(corner[0]), np.int64(corner[1]))
        normals: Array = ndtri(numbers, out=numbers)
        return normals
