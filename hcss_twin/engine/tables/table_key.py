"""What the tables of a plan depend on, as the key under which the cache keeps them."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

from hcss_twin.core.cache import result_key
from hcss_twin.cube.variables import TERM_PREFIX
from hcss_twin.plan.air_over_field import AirOverField
from hcss_twin.plan.plan import Plan
from hcss_twin.providers.registry.specs import Kind

INDEPENDENT = ("title", "seed", "image", "clouds", "elements", "surfaces", "output", "sensor")
"""Sections of a scenario that do not affect tables, except through the plan."""


def table_key(plan: Plan) -> str:
    """Return a hash of everything the tables of a plan depend on."""
    scenario, assembly = json.loads(plan.scenario.to_json()), plan.assembly
    of_generators = _of_generators(plan)
    independent = (*INDEPENDENT, *plan.scenario.sections)
    for key in ("light", "light_profile", "light_accuracy"):  # what is added to the tables
        scenario["radiance"].pop(key)
    parts: dict[str, Any] = {
        "scenario": {name: value for name, value in scenario.items() if name not in independent},
        "accuracy": plan.accuracy.relative,
        "numerics": [
            plan.assembly.numerical_level,
            plan.numerics.sunlight_steps,
            plan.numerics.error,
            dataclasses.astuple(plan.grid_refinement),
        ],
        "view": [plan.view.zenith_deg, plan.view.azimuth_deg],
        "files": {name: digest for name, digest in plan.catalog.used.items() if name not in of_generators},
        "terms": [spec.name for spec in plan.computed if spec.name.startswith(TERM_PREFIX)],
        "sunlight": [plan.sun_matters, *dataclasses.astuple(plan.sunlight)],
        "layers": [
            dataclasses.asdict(dataclasses.replace(layer, coverage=float(cloudy), edge_taper=0.0, name=""))
            for layer, cloudy in zip(plan.layers, assembly.cloudy_layers, strict=True)
        ],
        "code": {
            name: code
            for name, code in assembly.code.items()
            if assembly.entries[name].kind not in (Kind.CLOUDS, Kind.ELEMENTS, Kind.SURFACES, Kind.VARIABLES)
        },
    }
    if assembly.family is not None:
        parts["family"] = assembly.family.key
    for effect in plan.effects:
        parts |= effect.key(scenario, assembly)
    if isinstance(plan.view, AirOverField.PlacedView):
        parts["place"] = [plan.view.latitude_deg, plan.view.longitude_deg]
    if assembly.air_over_field.is_of_place:
        parts["air"] = assembly.air_over_field.centre_deg
    if assembly.alterations:
        sections = json.loads(plan.scenario.to_json())
        parts["altered"] = [[e.name, e.code, value, sections[e.name]] for e, value in assembly.alterations]
    surface = assembly.surface
    if surface is not None:
        parts["surface"] = [surface.name, surface.temperature_K]
        if surface.boundary is not None:  # it may depend on all inputs of the provider
            parts["surfaces"] = [scenario["surfaces"], scenario["image"], assembly.code[str(Kind.SURFACES)]]
    layer_optics = [layer.get("optics") for layer in scenario["clouds"]["layers"]]
    if any(layer_optics):
        parts["optics"] = [[layer[key] for key in ("type", "base", "top")] for layer in scenario["clouds"]["layers"]]
        parts["optics"] += layer_optics
    return result_key(parts, plan.catalog.shelf)


def _of_generators(plan: Plan) -> frozenset[str]:
    """Return the files that parameters of the clouds' generators alone name: they decide where clouds are."""
    scenario = json.loads(plan.scenario.to_json())
    given = [layer.pop("parameters", None) or {} for layer in scenario["clouds"]["layers"]]
    elsewhere = json.dumps(scenario)
    named = {value for values in given for value in values.values() if isinstance(value, str)}
    return frozenset(str((plan.catalog.base / name).resolve()) for name in named if json.dumps(name) not in elsewhere)
