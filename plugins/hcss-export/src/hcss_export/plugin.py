"""Hook that registers the command. ``hcss --help`` imports this module, so it must import quickly."""

from hcss_twin.providers import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the command ``export``."""
    summary = "Write CUBE as FITS, ENVI, GeoTIFF or PNG."
    return [CommandSpec("export", "hcss_export.command:export_command", summary)]
