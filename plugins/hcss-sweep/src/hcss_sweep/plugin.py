"""Hook that registers the command. ``hcss --help`` imports this module, so it must import quickly."""

from hcss_twin.providers import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the command ``sweep``."""
    return [CommandSpec("sweep", "hcss_sweep.command:sweep_command", "Simulate many scenes from one file.")]
