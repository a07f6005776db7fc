"""Records in files: trees of dataclasses, tuples, arrays, numbers and text, bit for bit and without code.

The files are NumPy archives with a checksum of all arrays.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_DIGEST = "digest"


def write_record(path: Path, record: Any, classes: tuple[type, ...]) -> None:
    """Write a tree of dataclasses, tuples, arrays, numbers, text and None as an npz archive: arrays, and JSON.

    Raises
    ------
    TypeError
        If the tree contains another type.
    """
    arrays: dict[str, NDArray[Any]] = {}
    arrays["structure"] = np.array(json.dumps(_encode(record, classes, arrays)))
    write_arrays(path, arrays)


def read_record(path: Path, classes: tuple[type, ...]) -> Any:
    """Read what :func:`write_record` wrote; raises exceptions of many kinds if the file is not such a record."""
    arrays = read_arrays(path)
    return _decode(json.loads(str(arrays["structure"])), {class_.__name__: class_ for class_ in classes}, arrays)


def _encode(value: Any, classes: tuple[type, ...], arrays: dict[str, NDArray[Any]]) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.ndarray):
        key = str(len(arrays))
        arrays[key] = value
        return {"array": key}
    if isinstance(value, tuple | list):
        return {"tuple": [_encode(item, classes, arrays) for item in value]}
    if type(value) in classes:
        fields = {
            field.name: _encode(getattr(value, field.name), classes, arrays) for field in dataclasses.fields(value)
        }
        return {"class": type(value).__name__, "fields": fields}
    raise TypeError(f"{type(value).__name__} cannot be stored in a record")


def _decode(value: Any, classes: Mapping[str, type], arrays: Mapping[str, NDArray[Any]]) -> Any:
    if not isinstance(value, dict):
        return value
    if "array" in value:
        return arrays[value["array"]]
    if "tuple" in value:
        return tuple(_decode(item, classes, arrays) for item in value["tuple"])
    fields = {name: _decode(encoded, classes, arrays) for name, encoded in value["fields"].items()}
    return classes[value["class"]](**fields)


def write_arrays(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write an archive of arrays of numbers or text, with a checksum of all.

    The checksums of the format itself detect flipped bytes, but not an archive that another program has written.
    """
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
