"""Generators for which a pixel depends on its whole frame, and how large such frames may be."""

from __future__ import annotations

import math

from hcss_twin.errors import Problem, ScenarioError
from hcss_twin.providers import CloudGenerator, CloudLayer, Grid

MOST_POINTS = 2**26
"""Points of one frame (8192 x 8192) for generators that only make whole ones."""

MOST_PIXELS_AT_ONCE = 2**28
"""The same (16384 x 16384) with one point per pixel."""


def sums_up(generator: CloudGenerator) -> bool:
    """Whether a generator of whole frames can make windows of them, given a summary of the frame."""
    return hasattr(generator, "frame_summary") and hasattr(generator, "thickness_in_frame_m")


def require_few_points(points: Grid, samples: int, layer: CloudLayer, field: str) -> None:
    """Refuse frames that are too large for a generator that only makes whole ones.

    Raises
    ------
    ScenarioError
        Naming ``image.samples_per_pixel`` or ``image.rows``.
    """
    count = points.rows * points.columns
    # One point per pixel is as large as the image itself, which is the user's choice as far as memory may go.
    allowed = MOST_POINTS if samples > 1 else MOST_PIXELS_AT_ONCE
    if count <= allowed:
        return
    remedy = f'; or {field}.coverage_mode = "field", which needs no whole frames'
    whole = f"which the cloud generator of '{layer.name}' makes at once"
    if samples > 1:
        key, fitting = "image.samples_per_pixel", max(1, math.floor(samples * math.sqrt(allowed / count)))
        message = (
            f"{samples} makes {points.rows} x {points.columns} points of each frame, {whole}; "
            f"allowed: {allowed} points, so that the closest valid choice is {fitting}"
        )
    else:
        key = "image.rows"
        message = (
            f"{points.rows} rows of {points.columns} columns are {count} points, {whole}; allowed: {allowed}, so that "
            f"the closest valid choice is {max(1, allowed // points.columns)}"
        )
    raise ScenarioError([Problem(key, f"{message}{remedy if layer.coverage_mode == 'frame' else ''}")])
