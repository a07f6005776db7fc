"""``hcss atmosphere``: a group whose commands packages bring."""

import click

from hcss_twin.cli.group import ExtensibleGroup


@click.group(cls=ExtensibleGroup)
def atmosphere() -> None:
    """Draw and import atmospheres, with hcss-modtran.

    Its commands come with: pip install ./plugins/hcss-modtran in a checkout of hcss_twin.
    """
