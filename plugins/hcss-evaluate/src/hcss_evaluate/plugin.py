"""Hook that registers the command. ``hcss --help`` imports this module, so it must import quickly."""

from hcss_twin.core.commands import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the command ``evaluate``."""
    return [CommandSpec("evaluate", "hcss_evaluate.command:evaluate_command", "Compare simulated with real images.")]
