"""Hook that registers the command. ``hcss --help`` imports this module, so it must import quickly."""

from hcss_twin.providers import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the command ``bench``."""
    return [CommandSpec("bench", "hcss_bench.command:bench", "Measure run time against error on this machine.")]
