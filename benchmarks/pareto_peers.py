"""Peers of the whole pipeline: classes of pixels, and every pixel at fewer wavenumbers."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from hcss_bench.benchmark import every_nth, points_of_scene
from hcss_bench.reference import Reference, column_radiance

from hcss_twin.plan.plan import Plan
from hcss_twin.providers.registry.registry import Registry

CLASSES = (2, 8, 32, 128)
STEPS = (1, 4, 16)


def has_lowtran() -> bool:
    """Whether the plugin is installed."""
    return any(entry.name == "lowtran7" for entry in Registry.discover().entries())


def pixel_classes(plan: Plan, reference: Reference) -> list[dict[str, Any]]:
    """One column for each class of pixels of one layer, spaced by factors of thickness, in place of tables.

    Cost is that of the calls and of putting the classes' radiance into the frames; making clouds and writing come on
    top as in any other way.
    """
    low, high = plan.layers[0].thickness_min_m, plan.layers[0].thickness_max_m
    frames, whole = plan.frame_times_s.size, (slice(0, plan.grid.rows), slice(0, plan.grid.columns))
    thickness = plan.assembly.generators[0].thickness_m(0.0, *whole)
    found = []
    for count in CLASSES:
        edges = np.geomspace(low, high, count + 1)
        middle = np.concatenate(([0.0], np.sqrt(edges[:-1] * edges[1:])))
        inner = edges[1:-1]

        def classes(values: np.ndarray, inner: np.ndarray = inner) -> np.ndarray:
            return np.where(values > 0, 1 + np.searchsorted(inner, values, side="right"), 0)

        start = time.process_time()
        of_class = column_radiance(plan, plan.spectral_grid, middle[:, None])
        called = time.process_time() - start
        start = time.process_time()
        of_class.T.astype(np.float32)[:, classes(thickness)]
        placed = time.process_time() - start
        by_band = reference.errors(of_class[classes(reference.columns[:, 0])])
        found.append({"classes": count, "seconds": called + frames * placed, "by_band": by_band})
    return found


def fewer_wavenumbers(plan: Plan, reference: Reference) -> list[dict[str, Any]]:
    """Every pixel integrated, at all wavenumbers of the plan and at fewer: seconds of all points, and errors.

    As many pixels as the reference has are computed at once.
    """
    found = []
    for step in STEPS:
        grid = every_nth(plan, step)
        start = time.process_time()
        by_band = reference.errors(column_radiance(plan, grid, reference.columns))
        seconds = (time.process_time() - start) / reference.columns.shape[0] * points_of_scene(plan)
        found.append({"wavenumbers": grid.wavenumber_cm1.size, "seconds": seconds, "by_band": by_band})
    return found
