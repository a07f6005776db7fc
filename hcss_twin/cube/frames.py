"""Checks of the arrays of one frame before any of them is written."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError
from hcss_twin.cube.geometry import Window
from hcss_twin.cube.header import CubeHeader
from hcss_twin.cube.variables import VariableSpec


class WrittenFrames:
    """Record of the parts of frames that have been written."""

    def __init__(self, header: CubeHeader) -> None:
        self._header = header
        self._complete: set[int] = set()
        self._begun: dict[int, list[Window]] = {}

    def room_for(self, index: int, region: Window | None) -> Window:
        """Return rows and columns of a part (all if ``region`` is None) after checking that it is not yet written.

        Raises
        ------
        CubeError
            If there is no such part, or it is partly written already.
        """
        header = self._header
        if not 0 <= index < header.frames:
            raise CubeError(f"frame {index}: 0 to {header.frames - 1} is allowed")
        wanted = (slice(0, header.rows), slice(0, header.columns)) if region is None else region
        for name, part, size in zip(("rows", "columns"), wanted, (header.rows, header.columns), strict=True):
            if part.step not in (None, 1) or not 0 <= part.start < part.stop <= size:
                raise CubeError(f"frame {index}, {name} {part}: slices inside 0 to {size} are allowed")
        written = self._begun.get(index, ())
        if index in self._complete or any(_meet(wanted, earlier) for earlier in written):
            raise CubeError(f"frame {index}: already written{'' if region is None else ' in part'}")
        return wanted

    def add(self, index: int, region: Window) -> None:
        """Record a part as written."""
        parts = [*self._begun.pop(index, []), region]
        # parts do not overlap, so their areas add up to the frame
        area = sum((rows.stop - rows.start) * (columns.stop - columns.start) for rows, columns in parts)
        if area == self._header.rows * self._header.columns:
            self._complete.add(index)
        else:
            self._begun[index] = parts

    def require_all(self, path: object) -> None:
        """Raise CubeError if a frame of the cube is incomplete."""
        missing = sorted(set(range(self._header.frames)) - self._complete)
        if missing:
            listed = ", ".join(map(str, missing[:10])) + (", ..." if len(missing) > 10 else "")
            raise CubeError(f"{path}: {len(missing)} of {self._header.frames} frames were not written: {listed}")


def _meet(one: Window, other: Window) -> bool:
    return all(a.start < b.stop and b.start < a.stop for a, b in zip(one, other, strict=True))


def check_frame(
    header: CubeHeader, index: int, arrays: Mapping[str, NDArray[Any]], region: Window | None = None
) -> None:
    """Check that a frame, or a part of it, has exactly the header's variables and that each array matches its spec.

    Raises
    ------
    CubeError
        With frame, variable, given value and allowed values.
    """
    expected = {spec.name for spec in header.variables}
    missing, unknown = sorted(expected - set(arrays)), sorted(set(arrays) - expected)
    if missing or unknown:
        raise CubeError(
            f"frame {index}: missing variables: {', '.join(missing) or 'none'}; "
            f"variables the cube does not have: {', '.join(unknown) or 'none'}"
        )
    for spec in header.variables:
        shape = frame_shape(header, spec, region)
        _check_array(f"frame {index}, {spec.name}", spec, shape, arrays[spec.name])


def frame_shape(header: CubeHeader, spec: VariableSpec, region: Window | None = None) -> tuple[int, ...]:
    """Return the shape of one frame of a variable, or of a part of it."""
    sizes = header.sizes
    if region is not None:
        sizes |= {dim: part.stop - part.start for dim, part in zip(("y", "x"), region, strict=True)}
    return tuple(sizes[dim] for dim in spec.dims if dim != "time")


def plain_bytes(header: CubeHeader) -> int:
    """Return the uncompressed size of all frames."""
    return sum(
        (header.frames if "time" in spec.dims else 1)
        * math.prod(frame_shape(header, spec))
        * np.dtype(spec.stored_dtype).itemsize
        for spec in (*header.variables, *header.geometry)
    )


def _check_array(where: str, spec: VariableSpec, shape: tuple[int, ...], array: NDArray[Any]) -> None:
    # a masked array is rejected: the library would fill masked values
    if not isinstance(array, np.ndarray) or isinstance(array, np.ma.MaskedArray):
        raise CubeError(f"{where}: {type(array).__name__}; a plain numpy array is needed")
    if array.shape != shape:
        raise CubeError(f"{where}: shape {array.shape}; {shape} is needed")
    if array.dtype != np.dtype(spec.dtype):
        raise CubeError(f"{where}: type {array.dtype}; {spec.dtype} is needed")
    # fmin and fmax ignore NaN, but return an infinity
    low, high = float(np.fmin.reduce(array, axis=None)), float(np.fmax.reduce(array, axis=None))
    has_nan = bool(np.isnan(array).any()) if array.dtype.kind == "f" else False
    if has_nan and not spec.may_be_missing:
        raise CubeError(f"{where}: {int(np.isnan(array).sum())} values are not a number (NaN)")
    if np.isinf(low) or np.isinf(high):
        raise CubeError(f"{where}: {int(np.isinf(array).sum())} values are infinite")
    if spec.lowest is not None and low < spec.lowest:
        raise CubeError(f"{where}: the smallest value is {low:g}; at least {spec.lowest:g} is allowed")
    if spec.highest is not None and high > spec.highest:
        raise CubeError(f"{where}: the largest value is {high:g}; at most {spec.highest:g} is allowed")
