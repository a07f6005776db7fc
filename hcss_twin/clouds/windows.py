"""Windows of a scene."""

from __future__ import annotations


def window_inside(name: str, window: slice, size: int) -> slice:
    """Check that a window lies within a scene axis, and fill in open ends.

    Raises
    ------
    ValueError
        If it has a step or reaches outside 0 to ``size``.
    """
    start = 0 if window.start is None else window.start
    stop = size if window.stop is None else window.stop
    if window.step not in (None, 1) or not 0 <= start <= stop <= size:
        raise ValueError(f"{name}: {window} given, allowed: a window without step inside 0 to {size}")
    return slice(start, stop)
