"""Compiled tables of scenes, kept between runs under a name that says all they depend on."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from functools import partial
from typing import Any

from hcss_twin.cache.kinds import TABLES
from hcss_twin.cube.variables import TERM_PREFIX
from hcss_twin.radiance.spectral_nodes import SpectralNodes
from hcss_twin.registry.kinds import Kind
from hcss_twin.scene.budget import Budget
from hcss_twin.scene.compile import compile_tables
from hcss_twin.scene.kept_results import KeptResults, key_of
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.tables.layer_pair import LayerPair
from hcss_twin.scene.tables.radiance_tables import (
    InstantTable,
    Quantities,
    RadianceTables,
    ShadowTables,
    WaveTables,
)
from hcss_twin.scene.tables.spectrum import Spectrum
from hcss_twin.scene.tables.thickness_axis import ThicknessAxis
from hcss_twin.scene.views.tables_over_views import tables_over_views

_INDEPENDENT = ("title", "seed", "image", "clouds", "output")
"""Sections of a scenario that tables do not depend on, but for what is taken from the plan."""


_PARTS = (
    Budget,
    Quantities,
    ThicknessAxis,
    LayerPair,
    InstantTable,
    ShadowTables,
    WaveTables,
    Spectrum,
    SpectralNodes,
)


def tables_of(plan: Plan, compiler: Callable[[Plan], RadianceTables] | None = None) -> RadianceTables:
    """Return the tables of a plan: those kept from an earlier run, or new ones, which are kept.

    They are the same to the bit. What an earlier run read is recorded again and must not have changed.

    Parameters
    ----------
    compiler : callable, optional
        Makes new ones; who counts them gives another.
    """
    if plan.views is not None:
        return tables_over_views(plan, partial(tables_of, compiler=compiler))
    results = KeptResults(TABLES, plan.catalog, RadianceTables, _PARTS)
    key, before = table_key(plan), plan.catalog.used
    tables = results.find(key)
    if tables is None:
        tables = (compiler or compile_tables)(plan)
        results.keep(key, tables, before)
    return tables


def table_key(plan: Plan) -> str:
    """Return a hash of everything the tables of a plan depend on."""
    scenario = json.loads(plan.scenario.to_json())
    parts: dict[str, Any] = {
        "scenario": {name: value for name, value in scenario.items() if name not in _INDEPENDENT},
        "accuracy": plan.accuracy.relative,
        "view": [plan.view.zenith_deg, plan.view.azimuth_deg],
        "files": dict(plan.catalog.used),
        "terms": [spec.name for spec in plan.variables if spec.name.startswith(TERM_PREFIX)],
        "sunlight": [plan.sun_matters, plan.faint_sunlight],
        "layers": [
            dataclasses.asdict(dataclasses.replace(layer, coverage=float(cloudy), edge_taper=0.0, name=""))
            for layer, cloudy in zip(plan.layers, plan.cloudy_layers, strict=True)
        ],
    }
    if plan.waves is not None or plan.slant.shadows:
        # A window of an image has the tables of the whole.
        parts["image"] = {name: value for name, value in scenario["image"].items() if name != "window"}
    entries = plan.assembly.entries.items()
    return key_of(parts, plan.assembly.code, [name for name, entry in entries if entry.kind is Kind.CLOUDS])
