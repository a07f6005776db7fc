"""What light crosses on its way to the sensor: composite paths, kept as whatever the provider adds up.

Legs are summed, never multiplied. A provider whose legs add as amounts of absorbers is asked for the amounts of each
leg once, and sums of amounts stand for paths from then on; for others a path stays the list of its legs.

Columns that differ in the heights of their clouds are computed together
(:mod:`hcss_twin.models.radiance.physical.columns`): a row is a path in each of them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.physics.paths import Path
from hcss_twin.providers import TransmittanceProvider

Rows = NDArray[np.intp]


class PathAmounts(ABC):
    """P composite paths through the air of each of C columns."""

    @abstractmethod
    def __len__(self) -> int: ...

    @abstractmethod
    def take(self, rows: Rows) -> Self:
        """Return the paths of some rows, in their order."""

    @abstractmethod
    def __add__(self, other: Self) -> Self:
        """Join paths row by row; a single row is joined to all."""

    @abstractmethod
    def beside(self, others: Sequence[Self]) -> Self:
        """Put the columns of others, with as many paths, beside its own."""

    @property
    @abstractmethod
    def key(self) -> Hashable:
        """Equal for equal paths of one provider."""


@dataclass(frozen=True)
class CrossedAmounts(PathAmounts):
    """Paths as amounts of absorbers (P, C, K)."""

    amounts: Array

    def __len__(self) -> int:
        return int(self.amounts.shape[0])

    def take(self, rows: Rows) -> Self:
        """Return the paths of some rows, in their order."""
        return type(self)(self.amounts[rows])

    def __add__(self, other: Self) -> Self:
        """Join paths row by row; a single row is joined to all."""
        return type(self)(self.amounts + other.amounts)

    def beside(self, others: Sequence[Self]) -> Self:
        """Put the columns of others, with as many paths, beside its own."""
        return type(self)(np.concatenate((self.amounts, *(other.amounts for other in others)), axis=1))

    @property
    def key(self) -> Hashable:
        """Equal for equal paths of one provider."""
        return self.amounts.tobytes()


@dataclass(frozen=True)
class CrossedPaths(PathAmounts):
    """Paths (P, C) as lists of legs."""

    paths: tuple[tuple[Path, ...], ...]

    def __len__(self) -> int:
        return len(self.paths)

    def take(self, rows: Rows) -> Self:
        """Return the paths of some rows, in their order."""
        return type(self)(tuple(self.paths[row] for row in rows))

    def __add__(self, other: Self) -> Self:
        """Join paths row by row; a single row is joined to all."""
        count = max(len(self.paths), len(other.paths))
        mine, others = (each * count if len(each) == 1 else each for each in (self.paths, other.paths))
        return type(self)(
            tuple(
                tuple(a + b for a, b in zip(row, added, strict=True)) for row, added in zip(mine, others, strict=True)
            )
        )

    def beside(self, others: Sequence[Self]) -> Self:
        """Put the columns of others, with as many paths, beside its own."""
        every = zip(self.paths, *(other.paths for other in others), strict=True)
        return type(self)(tuple(sum(rows, ()) for rows in every))

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

    def of(self, paths: Sequence[Sequence[Path]]) -> PathAmounts:
        """Return paths (P, C) as this provider adds them."""
        if self._amounts is None or self._of_amounts is None:
            return CrossedPaths(tuple(tuple(row) for row in paths))
        amounts = self._amounts([path for row in paths for path in row])
        return CrossedAmounts(amounts.reshape(len(paths), -1, amounts.shape[1]))

    def transmittance(self, crossed: PathAmounts) -> Array:
        """Return transmittance (P, C x V): that of all wavenumbers of the first column, of the second, ..."""
        if isinstance(crossed, CrossedAmounts) and self._of_amounts is not None:
            amounts = crossed.amounts.reshape(-1, crossed.amounts.shape[2])
            result: Array = self._of_amounts(self._wavenumber, amounts)
        else:
            assert isinstance(crossed, CrossedPaths)
            paths = [path for row in crossed.paths for path in row]
            result = self._provider.transmittance(self._wavenumber, paths)
        return result.reshape(len(crossed), -1)
