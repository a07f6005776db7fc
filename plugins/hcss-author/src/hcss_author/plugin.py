"""Hook that registers the commands. ``hcss --help`` imports this module, so it must import quickly."""

from hcss_twin.providers import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the commands ``new-plugin`` and ``check``."""
    return [
        CommandSpec("new-plugin", "hcss_author.commands:new_plugin", "Write a package with a provider of your own."),
        CommandSpec("check", "hcss_author.commands:check", "Hold a provider to the conformance kit."),
    ]
