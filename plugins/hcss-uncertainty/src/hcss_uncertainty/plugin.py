"""Hook that registers the command. ``hcss --help`` imports this module, so it must import quickly."""

from hcss_twin.providers import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the command ``propagate``."""
    summary = "Propagate uncertain inputs of a scenario to radiance."
    return [CommandSpec("propagate", "hcss_uncertainty.command:propagate_command", summary)]
