"""What is known about one point of a sweep."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal

State = Literal["pending", "done", "failed"]


@dataclass(frozen=True)
class PointRecord:
    """One row of the index.

    Attributes
    ----------
    point : int
        Number, from 0.
    values : mapping
        The swept keys with their values, SI numbers or what JSON has for others.
    state : str
        ``pending``, ``done`` or ``failed``.
    file : str or None
        Name of the cube in the sweep's folder; one whose certificate failed is kept.
    bytes, sha256 : int, str or None
        Of the cube.
    seconds : float or None
        That computing took.
    error : str or None
        Why it failed.
    """

    point: int
    values: Mapping[str, Any]
    state: State = "pending"
    file: str | None = None
    bytes: int | None = None
    sha256: str | None = None
    seconds: float | None = None
    error: str | None = None

    @property
    def is_settled(self) -> bool:
        """Whether computing it again would give the same: it is done, or its cube misses its accuracy."""
        return self.state != "pending" and self.file is not None

    def as_dict(self) -> dict[str, Any]:
        """Return plain values."""
        return {**asdict(self), "values": dict(self.values)}

    def with_outcome(self, outcome: Outcome) -> PointRecord:
        """Return it with what came of computing it."""
        return replace(
            self,
            state="failed" if outcome.error else "done",
            file=outcome.file,
            bytes=outcome.bytes,
            sha256=outcome.sha256,
            seconds=outcome.seconds,
            error=outcome.error,
        )


@dataclass(frozen=True)
class Outcome:
    """What came of computing one point; fields as in :class:`PointRecord`."""

    point: int
    file: str | None = None
    bytes: int | None = None
    sha256: str | None = None
    seconds: float | None = None
    error: str | None = None


def sha256_of(path: Path) -> str:
    """Return the hash of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
