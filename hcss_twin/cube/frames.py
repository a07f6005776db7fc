"""Checks of the arrays of one frame before anything of it is written."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.header import CubeHeader
from hcss_twin.cube.variables import VariableSpec
from hcss_twin.errors import CubeError


def check_frame(header: CubeHeader, index: int, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Check that a frame has exactly the header's variables and that each array obeys its spec.

    Raises
    ------
    CubeError
        Naming the frame, the variable, what was given and what is allowed.
    """
    expected = {spec.name for spec in header.variables}
    missing, unknown = sorted(expected - set(arrays)), sorted(set(arrays) - expected)
    if missing or unknown:
        raise CubeError(
            f"frame {index}: missing variables: {', '.join(missing) or 'none'}; "
            f"variables the cube does not have: {', '.join(unknown) or 'none'}"
        )
    for spec in header.variables:
        _check_array(f"frame {index}, {spec.name}", spec, frame_shape(header, spec), arrays[spec.name])


def frame_shape(header: CubeHeader, spec: VariableSpec) -> tuple[int, ...]:
    """Return the shape of one frame of a variable."""
    return tuple(header.sizes[dim] for dim in spec.dims if dim != "time")


def _check_array(where: str, spec: VariableSpec, shape: tuple[int, ...], array: NDArray[Any]) -> None:
    # a masked array is refused: the library would fill what is masked
    if not isinstance(array, np.ndarray) or isinstance(array, np.ma.MaskedArray):
        raise CubeError(f"{where}: {type(array).__name__}; a plain numpy array is needed")
    if array.shape != shape:
        raise CubeError(f"{where}: shape {array.shape}; {shape} is needed")
    if array.dtype != np.dtype(spec.dtype):
        raise CubeError(f"{where}: type {array.dtype}; {spec.dtype} is needed")
    # fmin and fmax skip NaN; an infinity shows in either
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
