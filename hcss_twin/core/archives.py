"""NumPy archives with a checksum of all arrays, for results that a later run reads without computing them again.

The checksums of the format itself detect flipped bytes, but not an archive that another program has written.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_DIGEST = "digest"


def write_arrays(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays of numbers or text, with their checksum."""
    with path.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays, **{_DIGEST: np.array(_digest(arrays))})


def read_arrays(path: Path) -> dict[str, NDArray[Any]]:
    """Read what :func:`write_arrays` wrote; raises exceptions of many kinds if the file is anything else."""
    with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
        arrays = dict(archive)
    if str(arrays.pop(_DIGEST)) != _digest(arrays):
        raise ValueError("the checksum differs")
    return arrays


def _digest(arrays: Mapping[str, NDArray[Any]]) -> str:
    digest = hashlib.sha256()
    for name, array in sorted(arrays.items()):
        digest.update(f"{name} {array.dtype} {array.shape}\n".encode())
        digest.update(np.ascontiguousarray(array).view(np.uint8).data if array.size else b"")
    return digest.hexdigest()
