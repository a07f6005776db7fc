"""Hook that registers the command. ``hcss --help`` imports this module, so it must import quickly."""

from hcss_twin.providers import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the command ``reference``."""
    summary = "Compare random pixels of a scene with Monte Carlo radiance of clouds with sides."
    return [CommandSpec("reference", "hcss_light.command:reference", summary)]
