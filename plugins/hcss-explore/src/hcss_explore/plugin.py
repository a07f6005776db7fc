"""Hook that registers the command. ``hcss --help`` imports this module, so it must import quickly."""

from hcss_twin.providers import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the command ``explore``."""
    return [CommandSpec("explore", "hcss_explore.command:explore", "Explore a scene on a page in the browser.")]
