"""Radiance of tables against the model that they are made from."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.stream import stream
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.plan.plan import Plan

ROUNDING = 3e-7
"""What float32 rounding of the result and of the thickness adds."""

Draw = Callable[[np.random.Generator, NDArray[np.float32]], NDArray[np.intp]]


def assert_tables_agree_with_the_reference_path(plan: Plan, draw: Draw, of_estimate: float = 1.0) -> None:
    """Compare pixels of every frame with columns of the model: within the budget, and within the estimated error.

    Parameters
    ----------
    draw : callable
        Draws pixels from the thickness (N, L) of their layers.
    of_estimate : float
        Largest error in parts of the estimate.
    """
    tables, rows, columns = compile_tables(plan), slice(0, plan.image.rows), slice(0, plan.image.columns)
    random = np.random.default_rng(0)
    for time_s, frame in zip(plan.frame_times_s.tolist(), stream(plan, tables), strict=True):
        layers = [each.thickness_m(time_s, rows, columns).ravel() for each in plan.assembly.generators]
        thickness = np.stack(layers, axis=1)
        chosen, sun = draw(random, thickness), plan.sun_track.at(time_s)
        setting = plan.assembly.setting(sun if sun.is_up else None)
        exact = SpectralGrid.reference_radiance(plan.assembly.model, setting, plan.spectral_grid, thickness[chosen])
        found = frame["radiance"].reshape(len(plan.bands), -1)[:, chosen].T
        np.testing.assert_allclose(found, exact, rtol=plan.budget.total + ROUNDING)
        np.testing.assert_allclose(found, exact, rtol=of_estimate * tables.estimated_error + ROUNDING)
