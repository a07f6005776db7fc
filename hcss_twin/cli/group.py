"""The command group: commands of the package by topic, and commands of installed plugins."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from hcss_twin.core.commands import PluginCommand
    from hcss_twin.core.plugins import BrokenPlugin, Remark

TOPICS = {
    "Simulate": ("run", "plan", "validate", "sweep", "sense"),
    "Look at cubes": ("preview", "report", "volume", "export", "verify"),
    "Clouds from images": ("import", "clouds", "match", "fit", "evaluate"),
    "Inputs": ("scenarios", "schema", "atmosphere", "atmosphere import", "atmosphere plot"),
    "Plugins": ("plugins", "new-plugin", "check"),
    "This machine": ("doctor", "cache"),
}
"""Headings of ``hcss --help`` and their commands, installed plugins' included; others go under "Other"."""


class CommandGroup(click.Group):
    """Commands of the package and of plugins.

    Plugins are searched only for names unknown to the package, and for the help. Their code is imported when one of
    their commands runs.
    """

    def plugin_commands(self) -> tuple[dict[str, PluginCommand], list[BrokenPlugin], list[Remark]]:
        """Return the commands of plugins by name, the broken plugins, and remarks on the others."""
        from hcss_twin.core.plugins import installed

        plugins = list(installed("hcss_twin.commands"))
        if not plugins:
            return {}, [], []
        from hcss_twin.core.commands import collect

        groups = {name: group for name, group in self.commands.items() if isinstance(group, ExtensibleGroup)}
        return collect(plugins, self.commands, groups)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command by name; import it if it belongs to a plugin."""
        return super().get_command(ctx, cmd_name) or self.command_of_plugin(ctx, cmd_name)

    def command_of_plugin(self, ctx: click.Context, name: str) -> click.Command | None:
        """Import the command of this full name, such as ``atmosphere import``, from the plugin that has it."""
        commands, broken, _ = self.plugin_commands()
        if name in commands:
            loaded: click.Command = commands[name].load()
            return loaded
        if broken:
            listed = "; ".join(map(str, broken))
            ctx.fail(f"No such command '{name}'. It might come from an installed plugin that is broken: {listed}")
        from hcss_twin.core.own_packages import COMMANDS, comes_with

        if package := comes_with(COMMANDS, name):
            ctx.fail(f"No such command '{name}'. {package}")
        return None

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands by topic; summaries of plugin commands come from their specs."""
        plugins, broken, _ = self.plugin_commands()
        width = max(map(len, (*self.commands, *plugins)))
        limit = formatter.width - 6 - width
        summaries = {name: command.spec.summary for name, command in plugins.items()}
        summaries |= {name: command.get_short_help_str(limit) for name, command in self.commands.items()}
        named = {name for names in TOPICS.values() for name in names}
        for topic, names in {**TOPICS, "Other": tuple(sorted(set(summaries) - named))}.items():
            rows = [(f"{name:<{width}}", summaries[name]) for name in names if name in summaries]
            if rows:
                with formatter.section(topic):
                    formatter.write_dl(rows)
        if broken:
            formatter.write(f"\n{len(broken)} broken: see hcss plugins\n")


class ExtensibleGroup(click.Group):
    """A group of ``hcss`` to which plugins add commands."""

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command by name; import it if it belongs to a plugin."""
        command, root = super().get_command(ctx, cmd_name), ctx.find_root().command
        if command is None and isinstance(root, CommandGroup):
            return root.command_of_plugin(ctx, f"{self.name} {cmd_name}")
        return command

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the commands, those of plugins included."""
        root, prefix = ctx.find_root().command, f"{self.name} "
        plugins = root.plugin_commands()[0] if isinstance(root, CommandGroup) else {}
        return sorted({*self.commands, *(name.removeprefix(prefix) for name in plugins if name.startswith(prefix))})
