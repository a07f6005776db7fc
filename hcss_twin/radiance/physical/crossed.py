"""What light crosses on its way to the sensor: composite paths, kept as whatever the provider adds up.

Legs are summed, never multiplied. A provider whose legs add as amounts of absorbers is asked for the amounts of each
leg once, and sums of amounts stand for paths from then on; for others a path stays the list of its legs.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from hcss_twin.physics.paths import Path
from hcss_twin.providers import TransmittanceProvider

Array = NDArray[np.float64]
Rows = NDArray[np.intp]


class Crossed(ABC):
    """P composite paths through the air."""

    @abstractmethod
    def __len__(self) -> int: ...

    @abstractmethod
    def take(self, rows: Rows) -> Self:
        """Return the paths of some rows, in their order."""

    @abstractmethod
    def __add__(self, other: Self) -> Self:
        """Join paths row by row; a single one is joined to all."""

    @property
    @abstractmethod
    def key(self) -> Hashable:
        """Equal for equal paths of one provider."""


@dataclass(frozen=True)
class CrossedAmounts(Crossed):
    """Paths as amounts of absorbers (P, K)."""

    amounts: Array

    def __len__(self) -> int:
        return int(self.amounts.shape[0])

    def take(self, rows: Rows) -> Self:
        """Return the paths of some rows, in their order."""
        return type(self)(self.amounts[rows])

    def __add__(self, other: Self) -> Self:
        """Join paths row by row; a single one is joined to all."""
        return type(self)(self.amounts + other.amounts)

    @property
    def key(self) -> Hashable:
        """Equal for equal paths of one provider."""
        return self.amounts.tobytes()


@dataclass(frozen=True)
class CrossedPaths(Crossed):
    """Paths as lists of legs."""

    paths: tuple[Path, ...]

    def __len__(self) -> int:
        return len(self.paths)

    def take(self, rows: Rows) -> Self:
        """Return the paths of some rows, in their order."""
        return type(self)(tuple(self.paths[row] for row in rows))

    def __add__(self, other: Self) -> Self:
        """Join paths row by row; a single one is joined to all."""
        mine, others = self.paths, other.paths
        if len(mine) == 1:
            return type(self)(tuple(mine[0] + path for path in others))
        if len(others) == 1:
            return type(self)(tuple(path + others[0] for path in mine))
        return type(self)(tuple(a + b for a, b in zip(mine, others, strict=True)))

    @property
    def key(self) -> Hashable:
        """Equal for equal paths of one provider."""
        return self.paths


class Crossing:
    """Paths of one provider, and their transmittance.

    Parameters
    ----------
    provider : TransmittanceProvider
        May have ``absorber_amounts`` and ``transmittance_of_amounts``.
    wavenumber_cm1 : ndarray (V,)
    """

    def __init__(self, provider: TransmittanceProvider, wavenumber_cm1: Array) -> None:
        self._provider = provider
        self._wavenumber = wavenumber_cm1
        self._amounts = getattr(provider, "absorber_amounts", None)
        self._of_amounts = getattr(provider, "transmittance_of_amounts", None)

    def of(self, paths: Sequence[Path]) -> Crossed:
        """Return paths as this provider adds them."""
        if self._amounts is None or self._of_amounts is None:
            return CrossedPaths(tuple(paths))
        return CrossedAmounts(self._amounts(paths))

    def transmittance(self, crossed: Crossed) -> Array:
        """Return transmittance (P, V)."""
        if isinstance(crossed, CrossedAmounts) and self._of_amounts is not None:
            result: Array = self._of_amounts(self._wavenumber, crossed.amounts)
            return result
        assert isinstance(crossed, CrossedPaths)
        return self._provider.transmittance(self._wavenumber, crossed.paths)
