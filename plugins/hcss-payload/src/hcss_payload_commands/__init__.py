"""Hook that registers the commands. ``hcss --help`` imports this package, so it must import quickly."""

from hcss_twin.core.commands import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the command ``serve``."""
    return [CommandSpec("serve", "hcss_payload.live.command:serve", "Serve live frames of a camera in shared memory.")]
