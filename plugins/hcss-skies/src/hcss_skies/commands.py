"""Hook that registers the commands. ``hcss --help`` imports this module, so it must import quickly."""

from hcss_twin.providers import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the command ``skies``."""
    return [
        CommandSpec(
            "skies",
            "hcss_skies.command:skies",
            "List skies, make an example from an image, simulate clouds, or pack a simulation as a film.",
        )
    ]
