"""The command ``hcss`` in the process of the tests."""

from __future__ import annotations

from click.testing import CliRunner, Result

from hcss_twin.cli.main import cli


def hcss(*arguments: object, catch: bool = False) -> Result:
    """Run the command; errors that are not told on purpose are raised, unless they are caught."""
    return CliRunner().invoke(cli, [str(argument) for argument in arguments], catch_exceptions=catch)
