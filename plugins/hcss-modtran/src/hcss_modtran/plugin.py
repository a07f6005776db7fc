"""Hook that registers the command. ``hcss --help`` imports this module, so it must import quickly."""

from hcss_twin.core.commands import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the command ``atmosphere import``."""
    summary = "Combine output of MODTRAN or libRadtran into one table."
    return [CommandSpec("atmosphere import", "hcss_modtran.command:atmosphere_import", summary)]
