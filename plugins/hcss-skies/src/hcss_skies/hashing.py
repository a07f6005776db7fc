"""Random numbers that depend on integer indices alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from hcss_twin.core.kernels import kernel

_STEP = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)


@kernel(inner=True)
def hashed(state: Any, index: int) -> Any:
    """Return a new state for an index (SplitMix64: G. Steele et al., OOPSLA 2014, p. 453)."""
    value = (state ^ (np.uint64(index) * _STEP)) + _STEP
    value = (value ^ (value >> np.uint64(30))) * _FIRST
    value = (value ^ (value >> np.uint64(27))) * _SECOND
    return value ^ (value >> np.uint64(31))


@kernel(inner=True)
def uniform(state: Any) -> float:
    """Return a number in [0, 1) of a state: its upper 53 bits."""
    return float(state >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@kernel(inner=True)
def normal(state: Any) -> float:
    """Return a number of a state with mean 0 and variance 1: the sum of four uniform ones of 16 bits."""
    mask = np.uint64(0xFFFF)
    total = (
        float(state & mask) + float((state >> np.uint64(16)) & mask)
        + float((state >> np.uint64(32)) & mask) + float(state >> np.uint64(48))
    )  # fmt: skip
    return (total / 65536.0 - 2.0 + 2.0 / 65536.0) * 1.7320508075688772
