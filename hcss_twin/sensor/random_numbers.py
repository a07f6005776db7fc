"""Random numbers that depend on what they are for, and not on what was drawn before."""

from __future__ import annotations

import hashlib

import numpy as np


def generator(seed: int, stage: str, band: str, frame: int = 0) -> np.random.Generator:
    """Return the generator of one stage, band and frame.

    Philox, a counter-based generator (Salmon et al., Parallel Random Numbers: As Easy as 1, 2, 3, SC11), under a key
    made of its arguments: frames may come in any order, and bands in any company.

    Parameters
    ----------
    seed : int
        0 or more.
    stage, band : str
        What draws, and for which band.
    frame : int
        Number of the frame, 0 or more; 0 for what stays the same in all frames.
    """
    return np.random.Generator(
        np.random.Philox(key=_sequence(seed, stage, band, frame).generate_state(2, np.uint64))
    )


def key_of(seed: int, stage: str, band: str, frame: int = 0) -> int:
    """Return 64 bits for the same arguments as :func:`generator`, for random numbers that are hashes."""
    return int(_sequence(seed, stage, band, frame).generate_state(1, np.uint64)[0])


def _sequence(seed: int, stage: str, band: str, frame: int) -> np.random.SeedSequence:
    digest = hashlib.sha256(f"{stage}/{band}".encode()).digest()
    words = [int.from_bytes(digest[start : start + 4], "little") for start in (0, 4, 8)]
    return np.random.SeedSequence(seed, spawn_key=(*words, frame))
