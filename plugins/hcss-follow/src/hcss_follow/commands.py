"""Hook that registers the commands. ``hcss --help`` imports this module, so it must import quickly."""

from hcss_twin.providers import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the command ``follow``."""
    return [CommandSpec("follow", "hcss_follow.command:follow", "Make a scenario with the sky of measured images.")]
