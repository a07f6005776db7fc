"""Composite paths from sun, sea and clouds to the sensor, in the additive form of the transmittance provider.

Legs are summed, never multiplied. A provider that adds absorber amounts computes the amounts of each leg once, and
paths are represented by sums of amounts; for other providers a path is the list of its legs.

A row is one path in each of several columns (:mod:`hcss_twin.models.radiance.physical.columns`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.physics.paths import Leg, Path
from hcss_twin.providers import TransmittanceProvider

Rows = NDArray[np.intp]

LayerAmounts = dict[tuple[tuple[float, ...], tuple[tuple[float, float], ...]], Array]
"""Absorber amounts (Z, parts, K) by zenith angles (Z,) and the ends of the parts."""

_MAX_LAYERS = 8192
"""Layers in memory, of some kB each: columns share those between levels."""


class CompositePaths(ABC):
    """P composite paths through the air of each of C columns."""

    @abstractmethod
    def __len__(self) -> int: ...

    @abstractmethod
    def take(self, rows: Rows) -> Self:
        """Return the paths of given rows, in that order."""

    @abstractmethod
    def __add__(self, other: Self) -> Self:
        """Join paths row by row; a single row is joined to all."""

    @abstractmethod
    def beside(self, others: Sequence[Self]) -> Self:
        """Append the columns of others with the same number of paths."""

    def through_each(self, legs: Self, rows: Rows) -> Self:
        """Return paths (P x N,): each path joined to each of the N legs of its row, of legs (Z x N,) and rows (P,)."""
        count = len(legs) // (int(rows.max()) + 1)
        leg_rows = (rows[:, None] * count + np.arange(count)).reshape(-1)
        return self.take(np.repeat(np.arange(len(self)), count)) + legs.take(leg_rows)

    @abstractmethod
    def column(self, number: int) -> Self:
        """Return the paths of one column."""

    @property
    @abstractmethod
    def key(self) -> Hashable:
        """Hashable key, equal for equal paths of one provider."""


@dataclass(frozen=True)
class AbsorberPaths(CompositePaths):
    """Paths as amounts of absorbers (P, C, K)."""

    amounts: Array

    def __len__(self) -> int:
        return int(self.amounts.shape[0])

    def take(self, rows: Rows) -> Self:
        """Return the paths of given rows."""
        return type(self)(self.amounts[rows])

    def __add__(self, other: Self) -> Self:
        return type(self)(self.amounts + other.amounts)

    def through_each(self, legs: Self, rows: Rows) -> Self:
        """Return each path joined to each leg of its row, without copies of either."""
        by_row = legs.amounts.reshape(int(rows.max()) + 1, -1, *legs.amounts.shape[1:])
        leg_amounts = by_row if np.array_equal(rows, np.arange(len(by_row))) else by_row[rows]
        return type(self)((self.amounts[:, None] + leg_amounts).reshape(-1, *legs.amounts.shape[1:]))

    def beside(self, others: Sequence[Self]) -> Self:
        """Append columns."""
        if not others:
            return self
        return type(self)(np.concatenate((self.amounts, *(other.amounts for other in others)), axis=1))

    def column(self, number: int) -> Self:
        """Return the paths of one column."""
        return type(self)(self.amounts[:, number : number + 1])

    def steps(self) -> Self:
        """Return what each path has more than the one before."""
        return type(self)(np.maximum(np.diff(self.amounts, axis=0, prepend=0.0), 0.0))

    @property
    def key(self) -> bytes:
        """All amounts."""
        return self.amounts.tobytes()


@dataclass(frozen=True)
class _LegPaths(CompositePaths):
    """Paths (P, C) as lists of legs."""

    paths: tuple[tuple[Path, ...], ...]

    def __len__(self) -> int:
        return len(self.paths)

    def take(self, rows: Rows) -> Self:
        return type(self)(tuple(self.paths[row] for row in rows))

    def __add__(self, other: Self) -> Self:
        count = max(len(self.paths), len(other.paths))
        mine, others = (paths * count if len(paths) == 1 else paths for paths in (self.paths, other.paths))
        return type(self)(
            tuple(
                tuple(a + b for a, b in zip(row, added, strict=True)) for row, added in zip(mine, others, strict=True)
            )
        )

    def beside(self, others: Sequence[Self]) -> Self:
        every = zip(self.paths, *(other.paths for other in others), strict=True)
        return type(self)(tuple(sum(rows, ()) for rows in every))

    def column(self, number: int) -> Self:
        return type(self)(tuple((row[number],) for row in self.paths))

    @property
    def key(self) -> Hashable:
        return self.paths


class PathTransmittance:
    """Paths of one provider, and their transmittance.

    Parameters
    ----------
    provider : TransmittanceProvider
        May have ``absorber_amounts`` and ``transmittance_of_amounts``, and with them ``scattering_of_amounts``.
    wavenumber_cm1 : ndarray (V,)
    layers : dict
        Amounts of single layers that were computed before, for the same provider at any wavenumbers.
    """

    def __init__(self, provider: TransmittanceProvider, wavenumber_cm1: Array, layers: LayerAmounts) -> None:
        self._layers = layers
        self._provider = provider
        self._wavenumber = wavenumber_cm1
        self._amounts = getattr(provider, "absorber_amounts", None)
        self._of_amounts = getattr(provider, "transmittance_of_amounts", None)
        self._scattering = getattr(provider, "scattering_of_amounts", None)

    def of(self, paths: Sequence[Sequence[Path]]) -> CompositePaths:
        """Return paths (P, C) in the additive form of this provider."""
        if self._amounts is None or self._of_amounts is None:
            return _LegPaths(tuple(tuple(row) for row in paths))
        amounts = self._amounts([path for row in paths for path in row])
        return AbsorberPaths(amounts.reshape(len(paths), -1, amounts.shape[1]))

    def nested(
        self, legs_m: Sequence[tuple[float, float]], zenith_deg: tuple[float, ...], parts: int
    ) -> CompositePaths:
        """Return paths (Z x N, 1) in one column, from the near end of a row of legs (N,) to the far end of each leg.

        Each leg begins at the near end of its layer, and every ``parts``-th leg crosses its layer. Columns share the
        amounts of layers between the same levels. The amounts of parts of a layer do not add up to those of the layer.

        Parameters
        ----------
        legs_m : sequence of (float, float) (N,)
            Lower and upper end.
        zenith_deg : tuple of float (Z,)
        """
        if self._amounts is None or self._of_amounts is None:
            near_low, near_high = legs_m[0]
            return _LegPaths(
                tuple(
                    (Path((Leg(min(near_low, low), max(near_high, high), zenith),)),)
                    for zenith in zenith_deg
                    for low, high in legs_m
                )
            )
        layers = [tuple(legs_m[first : first + parts]) for first in range(0, len(legs_m), parts)]
        known = self._layers
        if len(known) > _MAX_LAYERS:
            known.clear()
        new = [layer for layer in layers if (zenith_deg, layer) not in known]
        if new:
            legs = [Leg(low, high, zenith) for layer in new for zenith in zenith_deg for low, high in layer]
            amounts = self._amounts([Path((leg,)) for leg in legs])
            amounts = amounts.reshape(len(new), len(zenith_deg), parts, -1)
            known |= {(zenith_deg, layer): amount for layer, amount in zip(new, amounts, strict=True)}
        by_layer = np.stack([known[zenith_deg, layer] for layer in layers], axis=1)
        crossed = np.cumsum(by_layer[:, :, -1], axis=1)
        by_layer[:, 1:] += crossed[:, :-1, None]
        return AbsorberPaths(by_layer.reshape(-1, 1, by_layer.shape[3]))

    def scattering(self, crossed: CompositePaths) -> tuple[Array, Array] | None:
        """Return optical depths of scattering (P, C x V), and the same times asymmetry; None if nothing scatters."""
        if self._scattering is None or not isinstance(crossed, AbsorberPaths):
            return None
        amounts = crossed.amounts.reshape(-1, crossed.amounts.shape[2])
        depth, forward = self._scattering(self._wavenumber, amounts)
        return depth.reshape(len(crossed), -1), forward.reshape(len(crossed), -1)

    def transmittance(self, crossed: CompositePaths) -> Array:
        """Return transmittance (P, C x V): all wavenumbers of the first column, then of the second, ..."""
        if isinstance(crossed, AbsorberPaths) and self._of_amounts is not None:
            amounts = crossed.amounts.reshape(-1, crossed.amounts.shape[2])
            result: Array = self._of_amounts(self._wavenumber, amounts)
        else:
            assert isinstance(crossed, _LegPaths)
            paths = [path for row in crossed.paths for path in row]
            result = self._provider.transmittance(self._wavenumber, paths)
        return result.reshape(len(crossed), -1)
