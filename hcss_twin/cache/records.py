"""Frozen dataclasses of numbers, text and arrays as files, without code in them."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_STRUCTURE = "structure"


def write_record(path: Path, record: Any, classes: Mapping[str, type]) -> None:
    """Write a tree of dataclasses, tuples, arrays, numbers, text and None.

    Parameters
    ----------
    path : Path
        An npz archive: every array under a number, and the tree as JSON.
    record : dataclass
    classes : mapping of str to type
        The dataclasses that may occur, by name.

    Raises
    ------
    TypeError
        If something else occurs in it.
    """
    arrays: dict[str, NDArray[Any]] = {}
    structure = json.dumps(_encode(record, {each: name for name, each in classes.items()}, arrays))
    with path.open("wb") as file:
        np.savez(file, allow_pickle=False, **{_STRUCTURE: np.array(structure)}, **arrays)


def read_record(path: Path, classes: Mapping[str, type]) -> Any:
    """Read what :func:`write_record` wrote.

    Raises
    ------
    Exception
        Of many kinds, if the file is not such a record.
    """
    with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
        return _decode(json.loads(str(archive[_STRUCTURE])), classes, archive)


def _encode(value: Any, names: Mapping[type, str], arrays: dict[str, NDArray[Any]]) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.ndarray):
        key = str(len(arrays))
        arrays[key] = value
        return {"array": key}
    if isinstance(value, tuple | list):
        return {"tuple": [_encode(each, names, arrays) for each in value]}
    if type(value) in names:
        fields = {
            each.name: _encode(getattr(value, each.name), names, arrays) for each in dataclasses.fields(value)
        }
        return {"class": names[type(value)], "fields": fields}
    raise TypeError(f"{type(value).__name__} cannot be kept in a record")


def _decode(value: Any, classes: Mapping[str, type], arrays: Mapping[str, NDArray[Any]]) -> Any:
    if not isinstance(value, dict):
        return value
    if "array" in value:
        return arrays[value["array"]]
    if "tuple" in value:
        return tuple(_decode(each, classes, arrays) for each in value["tuple"])
    made = {name: _decode(each, classes, arrays) for name, each in value["fields"].items()}
    return classes[value["class"]](**made)
