"""The ``hcss`` command."""

from hcss_twin.cli.main import cli, main

__all__ = ["cli", "main"]
