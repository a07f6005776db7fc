"""Checks of parameters: errors that name the field, its value and what is allowed."""

from __future__ import annotations

from datetime import datetime, timedelta
from typing import Any

import numpy as np

from hcss_twin.core.errors import OptionError
from hcss_twin.providers import Array


class PayloadError(OptionError):
    """A parameter or file of camera, trajectory, attitude or jitter is not allowed."""


class NoStateAtTimeError(PayloadError):
    """A trajectory or attitude has no state at a time: its table ends, or the satellite has decayed."""


def require_within(field: str, value: float, low: float, high: float, unit: str = "") -> None:
    """Raise a :class:`PayloadError` with the closest valid choice unless ``low <= value <= high``."""
    if low <= value <= high:
        return
    unit = f" {unit}" if unit else ""
    closest = "" if np.isnan(value) else f"; closest valid choice is {(low if value < low else high):g}"
    raise PayloadError(f"{field}: {value:g}{unit}; allowed: {low:g} to {high:g}{unit}{closest}")


def require_utc(field: str, value: datetime) -> None:
    """Raise a :class:`PayloadError` unless a date and time is in UTC."""
    if value.utcoffset() != timedelta(0):
        raise PayloadError(f"{field}: {value.isoformat()}; allowed: a time in UTC, as datetime(..., tzinfo=UTC)")


def finite(field: str, value: Any, *shape: int | None) -> Array:
    """Return finite numbers as an array that cannot be changed; a None in the shape is any length."""
    array = np.array(value, dtype=np.float64)
    fits = array.ndim == len(shape) and all(want in (None, size) for want, size in zip(shape, array.shape, strict=True))
    if not fits:
        wanted = ", ".join("any" if size is None else str(size) for size in shape)
        raise PayloadError(f"{field}: shape {array.shape}; allowed: ({wanted})")
    if not np.all(np.isfinite(array)):
        raise PayloadError(f"{field}: a value that is not finite; allowed: finite numbers")
    array.setflags(write=False)
    return array


def ascending(field: str, value: Any) -> Array:
    """Return times (N,) in s that ascend, at least two."""
    times = finite(field, value, None)
    if times.size < 2 or np.any(np.diff(times) <= 0.0):
        raise PayloadError(f"{field}: {times.size} times; allowed: two or more, each later than the one before")
    return times


def unit_quaternion(field: str, value: Any, *lengths: int | None) -> Array:
    """Return quaternions (..., 4) as x, y, z, w with norm 1; norms other than 1 by more than 1e-3 are errors."""
    quaternion = finite(field, value, *lengths, 4)
    norm = np.linalg.norm(quaternion, axis=-1, keepdims=True)
    worst = float(norm.flat[np.argmax(np.abs(norm - 1.0))])
    if abs(worst - 1.0) > 1e-3:
        raise PayloadError(f"{field}: a quaternion with norm {worst:g}; allowed: norm 1 within 0.001, as (x, y, z, w)")
    unit: Array = quaternion / norm
    return unit


def require_inside(field: str, time_s: float, times_s: Array) -> None:
    """Raise a :class:`NoStateAtTimeError` if a table does not contain a time."""
    if not times_s[0] <= time_s <= times_s[-1]:
        raise NoStateAtTimeError(f"{field}: time {time_s:g} s; the table holds {times_s[0]:g} to {times_s[-1]:g} s")
