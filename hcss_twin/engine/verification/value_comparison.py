"""Comparison of the values of one variable, frame by frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.variables import VariableSpec
from hcss_twin.engine.recorded import TOLERANCE, Place, VariableCheck

Values = NDArray[Any]

_CALLED = {"time": "frame", "y": "row", "x": "column"}


class ValueComparison:
    """Gathers how a variable differs from its recomputation.

    Radiance and brightness temperature differ relative to the larger of both values. Truth and coordinates go
    through zero, so that they differ relative to the largest magnitude the array has. Whole numbers, and which
    values are missing, must be the same.

    Parameters
    ----------
    spec : VariableSpec
        Of the recomputed variable.
    labels : mapping
        Names along dimensions that have any, ``band`` and ``layer``.
    """

    def __init__(self, spec: VariableSpec, labels: Mapping[str, Sequence[str]]) -> None:
        self._name = spec.name
        self._labels = labels
        if np.dtype(spec.dtype).kind != "f":
            self._relative_to = "exact"
        else:
            self._relative_to = "value" if spec.needs_radiance else "largest"
        self._values = self._unequal = self._beyond = 0
        self._largest = 0.0
        self._largest_at: Place | None = None
        self._first: Place | None = None
        self._first_beyond: Place | None = None

    def add(
        self,
        cube: Values,
        recomputed: Values,
        dims: Sequence[str],
        frame: int | None = None,
        corner: tuple[int, int] = (0, 0),
    ) -> None:
        """Compare two arrays of one shape with the dimensions ``dims``, those of a ``frame`` where they have one.

        Those of a part of it begin at its row and column ``corner``.
        """
        self._values += recomputed.size
        unequal = _unequal(cube, recomputed)
        if not unequal.any():
            return
        difference = self._difference(cube, recomputed)
        beyond = unequal & (difference > (0.0 if self._relative_to == "exact" else TOLERANCE))

        offsets = dict(zip(("y", "x"), corner, strict=True))

        def place(flat: int) -> Place:
            index = np.unravel_index(flat, recomputed.shape)
            position: dict[str, int | str] = {} if frame is None else {"frame": frame}
            for dim, along in zip(dims, index, strict=True):
                number = int(along) + offsets.get(dim, 0)
                position[_CALLED.get(dim, dim)] = self._labels[dim][number] if dim in self._labels else number
            return Place(position, float(cube[index]), float(recomputed[index]))

        self._unequal += int(unequal.sum())
        self._beyond += int(beyond.sum())
        if self._first is None:
            self._first = place(int(np.argmax(unequal)))
        if self._first_beyond is None and beyond.any():
            self._first_beyond = place(int(np.argmax(beyond)))
        at = int(np.argmax(difference))
        if self._largest_at is None or difference.flat[at] > self._largest:
            self._largest, self._largest_at = float(difference.flat[at]), place(at)

    def result(self) -> VariableCheck:
        """Return what was found so far."""
        return VariableCheck(
            self._name,
            self._relative_to,
            self._values,
            self._unequal,
            self._beyond,
            self._largest,
            self._largest_at,
            self._first_beyond or self._first,
        )

    def _difference(self, cube: Values, recomputed: Values) -> NDArray[np.float64]:
        """Relative difference; infinite where only one of both is a finite number."""
        a, b = cube.astype(np.float64), recomputed.astype(np.float64)
        finite = np.isfinite(a) & np.isfinite(b)
        scale = np.maximum(np.abs(a), np.abs(b))
        if self._relative_to == "largest":
            known = np.abs(b[np.isfinite(b)])
            largest = float(known.max()) if known.size else 0.0
            scale = np.full_like(b, largest) if largest > 0 else scale
        apart = np.where(finite, 0.0, np.inf)
        apart[np.isnan(a) & np.isnan(b)] = 0.0
        np.divide(
            np.abs(np.subtract(a, b, where=finite, out=np.zeros_like(a))), scale, out=apart, where=finite & (scale > 0)
        )
        return apart


def _unequal(cube: Values, recomputed: Values) -> NDArray[np.bool_]:
    """Where two arrays differ in any bit; of arrays of different types, where their values differ."""
    if cube.dtype != recomputed.dtype:
        different: NDArray[np.bool_] = (cube != recomputed) & ~(np.isnan(cube) & np.isnan(recomputed))
        return different
    bits = f"u{recomputed.dtype.itemsize}"
    one, other = (np.ascontiguousarray(each).reshape(each.shape).view(bits) for each in (cube, recomputed))
    return np.asarray(one != other)
