"""The scenario and its changes on the command line, the same for all commands that take one."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import click


def set_option(command: Any) -> Any:
    """Add ``--set``, which may be given again and again."""
    return click.option(
        "--set",
        "assignments",
        multiple=True,
        metavar="KEY=VALUE",
        help="Replace one key, for example view.zenith=40.",
    )(command)


def scenario_options(command: Any) -> Any:
    """Add the scenario and ``--set``."""
    return click.argument("scenario")(set_option(command))


def load(scenario: str, assignments: Iterable[str]) -> Any:
    """Read a scenario with its changes; raises ScenarioError and click's BadParameter."""
    from hcss_twin.scenario.overrides import parse_assignment
    from hcss_twin.scenario.scenario import Scenario

    try:
        overrides = dict(parse_assignment(text) for text in assignments)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--set") from error
    return Scenario.load(scenario, overrides)
