"""The one reference of all benchmarks: band radiance of a few columns, with the finest of what the engine offers.

Errors of a run relative to its own radiance model say nothing about that model. Here every run, of whichever model, is
compared with the same numbers.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin import Scenario, make_plan
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array

CLOSURE_ORDER, STEP_CM1 = 2, 1.0
"""The finest closure order and spectral step of the model ``physical``."""

COARSE_LEVEL = 3
"""Level of the spectra at all wavenumbers: 16 streams for sunlight, a few percent off at most."""

FACTOR_LEVEL = 1
"""Level of the factor; the coarsest interpolates clouds of dense spectra in wavenumber with errors up to 2e-3."""

NODES_TOLERANCE = 1e-4
"""Error of the coarse columns at the chosen wavenumbers, of their radiance.

The change to the finest level has another spectrum: it leaves 4.5e-5 in ``cirrus`` in 2.7-3.0 um.
"""

PHYSICAL: Mapping[str, Any] = {"radiance.model": "physical", "radiance.parameters": {}}
"""Overrides for multiple scattering with streams chosen by error."""


def with_streams(streams: int, **others: Any) -> dict[str, Any]:
    """Return the overrides that select the model ``physical`` with so many streams for all light, and 2 N moments."""
    parameters = {"streams": streams, "sun_streams": streams, "azimuth_modes": 2 * streams}
    return {"radiance.model": "physical", "radiance.parameters": parameters | others}


MODELS: dict[str, dict[str, Any]] = {
    "as-printed": {"radiance.model": "as-printed", "radiance.parameters": {}},
    "physical-two-stream": {"radiance.model": "physical-two-stream", "radiance.parameters": {}},
    "physical, 8 streams": with_streams(8),
    "physical": dict(PHYSICAL),
}
"""Overrides of each radiance model to compare, from fast to accurate."""


def changed(scenario: Scenario, overrides: Mapping[str, Any]) -> Scenario:
    """Return a scenario with other values of some keys."""
    return Scenario.from_dict(json.loads(scenario.to_json()), dict(overrides), scenario.base, scenario.origin)


@dataclass(frozen=True)
class Reference:
    """Columns of a scene and their band radiance.

    Attributes
    ----------
    columns : ndarray (N, L)
        Thickness of each layer, m.
    radiance : ndarray (N, B)
        W m-2 sr-1.
    bands : tuple of str (B,)
    text : str
        How the radiance was computed.
    level_change : ndarray (N, B)
        Relative change of the radiance from the next coarser numerical level; 0 at the coarsest.
    """

    columns: Array
    radiance: Array
    bands: tuple[str, ...]
    text: str
    level_change: Array

    def errors(self, radiance: Array, among: NDArray[np.bool_] | None = None) -> dict[str, float]:
        """Return the largest relative error in each band, of radiance (N, B): of any column, or of those ``among``."""
        apart = np.abs(radiance / self.radiance - 1.0)
        largest = np.max(apart if among is None else apart[among], axis=0)
        return dict(zip(self.bands, largest.tolist(), strict=True))


REFERENCE_STEPS = 4
"""Number of steps that :func:`reference_of` tells."""


def reference_of(
    scenario: Scenario, columns: Array, level: int | None = None, say: Callable[[str], None] = lambda text: None
) -> Reference:
    """Compute the reference for the columns (N, L) of a scene.

    As in the certificate: spectra at all wavenumbers and a coarse numerical level, plus their change to the level
    asked for, by default the finest (64 streams), at wavenumbers chosen for these columns. A finer spectral grid and a
    higher closure order multiply the result by a factor of a coarse level: it differs from 1 by some 1e-4, and that
    of the streams by some 1e-2, so that their product is accurate to some 1e-6.
    Atmosphere, sea and particles are those of the scenario. ``say`` is called with each step.
    """
    say(f"plans, and effect of a finer spectral grid on {columns.shape[0]} pixels")
    plan = make_plan(changed(scenario, PHYSICAL), keeps_results=False)
    last = plan.assembly.model.declares.numerical_levels - 1
    level = last if level is None else min(level, last)
    low = min(FACTOR_LEVEL, last)
    lowest, grid = plan.at_level(low), plan.spectral_grid
    parameters = {"closure_order": CLOSURE_ORDER}
    most = make_plan(changed(scenario, {**PHYSICAL, "radiance.parameters": parameters}), keeps_results=False).at_level(
        low
    )
    factor = column_radiance(most, _finer(plan), columns) / column_radiance(lowest, grid, columns)
    assembly, sun, coarse = plan.assembly, plan.sun_at(float(plan.frame_times_s[0])), min(COARSE_LEVEL, level)
    say("all wavenumbers")
    setting = assembly.setting(sun)
    known = SpectralGrid.reference_spectra(
        assembly.at_level(coarse).model, setting, grid.wavenumber_cm1, columns, len(columns)
    )
    radiance = np.sum(known, axis=1) @ grid.weights_cm1.T
    nodes = grid.choose_nodes(known, NODES_TOLERANCE)
    changes = []
    for numerical_level in (level, max(level - 1, 0)):
        say(f"numerical level {numerical_level}")
        finer = SpectralGrid.reference_spectra(
            assembly.at_level(numerical_level).model, setting, nodes.wavenumber_cm1, columns, len(columns)
        )
        change = finer - known[..., np.searchsorted(grid.wavenumber_cm1, nodes.wavenumber_cm1)]
        changes.append(np.sum(change, axis=1) @ nodes.weights_cm1.T)
    radiance += changes[0]
    text = (
        f"physical at numerical level {level} of {last} ({nodes.wavenumber_cm1.size} of {grid.wavenumber_cm1.size} "
        f"wavenumbers; the others at level {coarse}), times the effect of steps of {STEP_CM1:g} cm-1 and closure order "
        f"{CLOSURE_ORDER}"
    )
    relative = (changes[0] - changes[1]) / radiance
    return Reference(columns, radiance * factor, tuple(band.name for band in plan.bands), text, relative)


def _finer(plan: Plan) -> SpectralGrid:
    given = plan.spectral_grid.wavenumber_cm1
    return SpectralGrid.dense(plan.bands, np.unique(np.concatenate((given, np.arange(given[0], given[-1], STEP_CM1)))))


def column_radiance(plan: Plan, grid: SpectralGrid, columns: Array, together: int = 24) -> Array:
    """Band radiance (N, B) of columns (N, L) in the first frame, without tables; so many cloudy ones at once."""
    sun = plan.sun_at(float(plan.frame_times_s[0]))
    return SpectralGrid.reference_radiance(plan.assembly.model, plan.assembly.setting(sun), grid, columns, together)


def table_radiance(plan: Plan, tables: RadianceTables, columns: Array) -> Array | None:
    """Band radiance (N, B) that a run looks up for columns (N, L) in its first frame.

    None where tables depend on the place in the image: with views or surfaces of single pixels.
    """
    if plan.views.varies or plan.surfaces:
        return None
    look_up = LookUp.at(tables, float(plan.frame_times_s[0]))
    radiance = np.empty((look_up.table.clear.size, 1, columns.shape[0]), dtype=np.float32)
    thickness = [np.ascontiguousarray(column[np.newaxis], dtype=np.float32) for column in columns.T]
    look_up.fill(radiance, thickness)
    return radiance[: len(plan.bands), 0].T.astype(np.float64)
