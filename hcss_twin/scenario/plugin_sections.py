"""Sections of a scenario that plugins own: their keys are checked by the plugin's models."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pydantic import BaseModel, ValidationError

from hcss_twin.core.errors import Problem
from hcss_twin.core.own_packages import SECTIONS, how_to_install
from hcss_twin.core.sections import plugin_sections
from hcss_twin.scenario.models import ScenarioModel
from hcss_twin.scenario.problems import problems_from


def take_owned(data: dict[str, Any]) -> tuple[dict[str, BaseModel], list[Problem]]:
    """Remove the sections of plugins from a raw scenario; return them validated, and all problems."""
    sections: dict[str, BaseModel] = {}
    problems: list[Problem] = []
    owners = plugin_sections()
    for name in [name for name in data if name not in ScenarioModel.model_fields]:
        if name in owners:
            raw, model = data.pop(name), owners[name].load(owners[name].spec.model)
            try:
                sections[name] = model.model_validate(raw)
            except ValidationError as error:
                problems += problems_from(error, model, prefix=name, raw=raw)
        elif package := SECTIONS.get(name):
            del data[name]
            message = f"is a section of {package}, which is not installed: {how_to_install(package)}"
            problems.append(Problem(name, message))
    return sections, problems


def bring_rays(names: Iterable[str]) -> bool:
    """Whether a section of a plugin brings another image geometry than the grid on the ground."""
    owners = plugin_sections()
    return any(owners[name].spec.rays is not None for name in names)


def owned_schemas() -> dict[str, Any]:
    """Return the JSON schemas of the sections of installed plugins, by name."""
    return {
        name: owner.load(owner.spec.model).model_json_schema() | {"description": owner.spec.summary}
        for name, owner in plugin_sections().items()
    }
