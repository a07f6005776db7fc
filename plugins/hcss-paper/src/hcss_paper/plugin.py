"""Hook that registers the command. ``hcss --help`` imports this module, so it must import quickly."""

from hcss_twin.providers import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the command ``reproduce``."""
    return [CommandSpec("reproduce", "hcss_paper.command:reproduce", "Recompute the HCSS paper's tables and figures.")]
