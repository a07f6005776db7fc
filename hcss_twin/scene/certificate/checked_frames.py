"""Which frames a certificate checks: random, and the same for every sequence of a length."""

from __future__ import annotations

import numpy as np

_SEED = 2**17


def checked_frames(parts: int, frames: int) -> list[int]:
    """Return one frame at random of each of equal parts of a sequence.

    They do not depend on the scenario's seed, so that what the tables solve for the sun of a checked frame serves the
    certificate as well.

    Parameters
    ----------
    parts, frames : int
        1 to ``frames`` parts.
    """
    ends = np.arange(parts + 1) * frames // parts
    chosen: list[int] = np.random.default_rng(_SEED).integers(ends[:-1], ends[1:]).tolist()
    return chosen
