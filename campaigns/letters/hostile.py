"""Messages and letters that no honest client sends, each with the field that the error must name."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from typing import Any

import numpy as np

Case = tuple[str, list[bytes], str]
"""Kind, parts of the message, and the field."""

TARGET = {"latitude_deg": 30.0, "longitude_deg": 150.0, "altitude_m": 2e3, "intensity": [1e5]}
TARGET |= {"velocity_m_s": [10.0, 0.0, 0.0]}

WRONG = ("text", "", True, {}, [], [[]], {"a": 1}, [None], "1.0", ["1", "2", "3", "4"])
"""Values that are no number, no vector and no list of targets."""

NOT_FINITE = ("NaN", "Infinity", "-Infinity", "1e999", "-1e999")

BYTES = 24
"""Random messages of each length."""


def pose_message(values: np.ndarray, targets: bool = True) -> dict[str, Any]:
    """Return a good message of time, position and quaternion (8,)."""
    numbers = values.tolist()
    message = {"command": "pose", "time_s": numbers[0], "position_m": numbers[1:4], "quaternion": numbers[4:]}
    return message | ({"pose_number": 7, "targets": [TARGET]} if targets else {})


def hostile_messages(values: np.ndarray) -> Iterator[Case]:
    """Yield them, about a good pose."""
    good = pose_message(values)
    elements = {"command": "elements", "targets": [TARGET]}
    yield from _no_json(good)
    for name in ("", "Pose", "poses", "stop ", "exec", "__class__", None, 3, True, ["stop"], {"stop": 1}, "x" * 5000):
        yield "unknown command", [_json({**good, "command": name})], "command"
    yield "unknown command", [_json({key: good[key] for key in good if key != "command"})], "command"
    for message in (good, elements):
        for path in _paths(message):
            yield from _changed(message, path)
    for extra in ("timeS", "pose", "__proto__", "", "x" * 3000):
        yield "extra key", [_json({**good, extra: 1})], extra[:50]
        yield "extra key", [_json({**elements, "targets": [{**TARGET, extra: 1}]})], extra[:50]
    for command in ("describe", "stop"):
        yield "extra key", [_json({"command": command, "force": True})], "force"
    for path in ("", 3, None, ["/"], "x" * 5000):
        yield "file to assimilate", [_json({"command": "assimilate", "file": path})], "file"
    yield "file to assimilate", [_json({"command": "assimilate"})], "file"
    yield from _out_of_range(good, values)


def _no_json(good: dict[str, Any]) -> Iterator[Case]:
    whole = _json(good)
    rng = np.random.default_rng(51)
    for length in (1, 3, 17, 256):
        for _ in range(BYTES):
            yield "random bytes", [rng.integers(0, 256, length, np.uint8).tobytes()], "message"
    for end in range(1, len(whole), 13):
        yield "truncated", [whole[:end]], "message"
    yield "encoding", [whole.decode().encode("utf-16")], "message"
    yield "encoding", [b"\xff" + whole], "message"
    for text in (b"", b" ", b"\0", b"[" * 5000, b'{"a":' * 5000, b"1" * 6000, b"{}{}", b"{'command': 'stop'}"):
        yield "no JSON", [text], "message"
    for text in (b"null", b"3", b'"stop"', b"[]", b'["stop"]', b"true", b"NaN"):
        yield "no object", [text], "message"
    for size in (65537, 300_000, 700_000):
        yield "too long", [whole + b" " * (size - len(whole))], "message"
        yield "too long", [_json({**good, "targets": [TARGET] * (size // 100)})], "message"
    for parts in ([whole, whole], [whole] * 100, [whole, b""], [b"x", whole]):
        yield "several parts", parts, "message"


def _changed(message: dict[str, Any], path: tuple[Any, ...]) -> Iterator[Case]:
    """Yield messages in which the value of a path is another one, or missing."""
    field = next(part for part in reversed(path) if isinstance(part, str))
    old = _at(message, path)
    for wrong in WRONG:
        if wrong == [] and path == ("targets",):
            continue  # no targets are allowed
        yield "wrong type", [_json(_with(message, path, wrong))], field
    if path != ("targets",):
        yield "null", [_json(_with(message, path, None))], field
    if isinstance(old, float):
        for text in NOT_FINITE:
            changed = _json(_with(message, path, "@")).replace(b'"@"', text.encode())
            yield "not finite", [changed], field
        yield "huge", [_json(_with(message, path, "@")).replace(b'"@"', b"1" + b"0" * 400)], field
    if isinstance(path[-1], str) and path[-1] not in ("pose_number", "targets", "velocity_m_s"):
        changed = copy.deepcopy(message)
        del _at(changed, path[:-1])[path[-1]]
        yield "missing key", [_json(changed)], field


def _out_of_range(good: dict[str, Any], values: np.ndarray) -> Iterator[Case]:
    yield "out of range", [_json({**good, "targets": [TARGET] * 65})], "targets"
    for number in (-1, 2**64, 1.5):
        yield "out of range", [_json({**good, "pose_number": number})], "pose_number"
    for time_s in (-1e-3, 1e9, -1e300):
        yield "out of range", [_json({**good, "time_s": time_s})], "time_s"
    for scale in (0.0, 0.5, -0.5, 1e-300):
        changed = (scale * values[1:4]).tolist()
        yield "out of range", [_json({**good, "position_m": changed})], "position_m"
    for scale in (0.0, 0.9, 1.1, 1e300):
        changed = (scale * values[4:]).tolist()
        yield "out of range", [_json({**good, "quaternion": changed})], "quaternion"
    for size in (2, 4, 1000):
        yield "wrong length", [_json({**good, "position_m": [7e6] * size})], "position_m"
    for size in (3, 5):
        yield "wrong length", [_json({**good, "quaternion": [0.5] * size})], "quaternion"
    wrong = {
        "latitude_deg": (91.0, -91.0, 1e300),
        "longitude_deg": (361.0, -1e9),
        "altitude_m": (-1.0, 1e6, 1e300),
        "intensity": ([-1.0], [1e13], [1.0, 2.0], [1.0] * 17),
        "velocity_m_s": ([0.0, 0.0], [0.0] * 4),
    }
    for key, outside in wrong.items():
        for value in outside:
            yield "out of range", [_json({**good, "targets": [{**TARGET, key: value}]})], key.split("_")[0]
    away = [*(-values[4:7]).tolist()[::-1], values[7]]
    yield "looks elsewhere", [_json({**good, "quaternion": away})], "pose"
    yield "looks elsewhere", [_json({**good, "position_m": (-values[1:4]).tolist()})], "pose"
    yield "looks elsewhere", [_json({**good, "position_m": (1e4 * values[1:4]).tolist()})], "pose"


def hostile_letters(values: np.ndarray, count: int) -> Iterator[tuple[np.ndarray, int]]:
    """Yield poses (8,) and numbers of targets that a letter box may hold and that are none."""
    rng = np.random.default_rng(52)
    for number in range(count):
        letter, kind = values.copy(), number % 5
        if kind == 0:
            letter[rng.integers(8)] = rng.choice([np.nan, np.inf, -np.inf, 1e300, -1e300])
        elif kind == 1:
            letter[1:4] *= rng.uniform(-0.9, 0.9)
        elif kind == 2:
            letter[4:] *= rng.choice([0.0, 0.5, 2.0, 1e200])
        elif kind == 3:
            letter[0] = rng.choice([-1.0, 1e6, -1e300])
        yield letter, int(rng.integers(65, 2**62)) if kind == 4 else -1


def _json(message: dict[str, Any]) -> bytes:
    return json.dumps(message).encode()


def _paths(value: Any, before: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the paths to all values but the command."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inside in items:
        if key != "command":
            yield (*before, key)
            yield from _paths(inside, (*before, key))


def _at(message: Any, path: tuple[Any, ...]) -> Any:
    for part in path:
        message = message[part]
    return message


def _with(message: dict[str, Any], path: tuple[Any, ...], value: Any) -> dict[str, Any]:
    changed = copy.deepcopy(message)
    _at(changed, path[:-1])[path[-1]] = value
    return changed
