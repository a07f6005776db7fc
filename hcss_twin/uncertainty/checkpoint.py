"""The state of a fit that has not ended, in a file beside its output."""

from __future__ import annotations

import time
import zipfile
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hcss_twin.drafts import draft_of
from hcss_twin.errors import PosteriorError
from hcss_twin.uncertainty.chains import Chains
from hcss_twin.uncertainty.estimator_noise import EstimatorNoise

Array = NDArray[np.float64]

# Long chains are large files: not after every block.
_SECONDS_APART = 5.0

_DAMAGED = (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile)


@dataclass(frozen=True)
class State:
    """What has been computed: the noise of each image, and chains."""

    noises: tuple[EstimatorNoise, ...]
    chains: Chains


class Checkpoint:
    """Writes and reads states of one fit.

    Parameters
    ----------
    path : Path or None
        File; None keeps nothing.
    fingerprint : str
        Of all that the chains depend on.
    """

    def __init__(self, path: Path | None, fingerprint: str) -> None:
        self._path = path
        self._fingerprint = fingerprint
        self._written = 0.0

    def read(self) -> State | None:
        """Return the state, or None where there is none.

        Raises
        ------
        PosteriorError
            If the file is damaged or is of another fit.
        """
        if self._path is None or not self._path.exists():
            return None
        remedy = f"delete {self._path} to begin anew"
        try:
            with self._path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
                if str(file["fingerprint"]) != self._fingerprint:
                    raise PosteriorError(
                        f"{self._path}: state of another fit (images, options, seed or version differ); {remedy}"
                    )
                noises = tuple(
                    EstimatorNoise(
                        **{f.name: file[f"noise_{i}_{f.name}"][()] for f in fields(EstimatorNoise)}
                    )
                    for i in range(int(file["noises"]))
                )
                kind, position, has_gauss, cached = (file[f"random_{i}"][()] for i in (0, 2, 3, 4))
                random_state = (str(kind), file["random_1"], int(position), int(has_gauss), float(cached))
                return State(noises, Chains(file["positions"], file["log_probability"], random_state))
        except _DAMAGED as error:
            raise PosteriorError(f"{self._path}: damaged state of a fit: {error}; {remedy}") from error

    def write(self, state: State, now: bool = False) -> None:
        """Write a state, not more often than every few seconds unless told to.

        Raises
        ------
        PosteriorError
            If the file cannot be written.
        """
        if self._path is None or (not now and time.monotonic() - self._written < _SECONDS_APART):
            return
        arrays: dict[str, NDArray[np.generic]] = {
            f"noise_{i}_{f.name}": np.asarray(getattr(noise, f.name))
            for i, noise in enumerate(state.noises)
            for f in fields(EstimatorNoise)
        }
        chains = state.chains
        arrays |= {f"random_{i}": np.asarray(part) for i, part in enumerate(chains.random_state)}
        arrays |= {"positions": chains.positions, "log_probability": chains.log_probability}
        arrays |= {
            "noises": np.asarray(len(state.noises)),
            "fingerprint": np.asarray(self._fingerprint),
        }
        with draft_of(self._path, PosteriorError) as draft, draft.open("wb") as file:
            np.savez(file, allow_pickle=False, **arrays)
        self._written = time.monotonic()

    def remove(self) -> None:
        """Forget the state."""
        if self._path is not None:
            self._path.unlink(missing_ok=True)
