"""The table of the packages in ``plugins/`` says of each command, provider, section, page and light who brings it."""

import pytest

from hcss_twin.cli.main import cli
from hcss_twin.core import own_packages
from hcss_twin.core.environment import installed_version
from hcss_twin.core.plugins import installed
from hcss_twin.core.sections import plugin_sections
from hcss_twin.plan.choose_light import GROUP as LIGHT
from hcss_twin.plan.choose_light import GROUP_OF_LAYERS
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.reports.report import GROUP as PAGES
from hcss_twin.reports.report import GROUP_OF_FOLDERS


def entries(*groups):
    return {entry.name: origin.distribution for group in groups for origin, entry in installed(group)}


def commands():
    return {name: command.origin.distribution for name, command in cli.plugin_commands()[0].items()}


def providers():
    return {entry.name: entry.distribution for entry in Registry.discover().entries()}


def sections():
    return {name: section.origin.distribution for name, section in plugin_sections().items()}


@pytest.mark.parametrize(
    ("table", "found"),
    [
        (own_packages.COMMANDS, commands),
        (own_packages.PROVIDERS, providers),
        (own_packages.SECTIONS, sections),
        (own_packages.PAGES, lambda: entries(PAGES)),
        (own_packages.PAGES_OF_FOLDERS, lambda: entries(GROUP_OF_FOLDERS)),
        (own_packages.LIGHT, lambda: entries(LIGHT, GROUP_OF_LAYERS)),
    ],
    ids=["commands", "providers", "sections", "pages", "pages of folders", "light"],
)
def test_the_table_names_the_package_that_brings_each_name(table, found):
    present = {package for package in table.values() if installed_version(package) != "not installed"}
    if not present:
        pytest.skip(f"none is installed: {', '.join(sorted(set(table.values())))}")
    brought = {name: package for name, package in found().items() if package in present}
    assert brought == {name: package for name, package in table.items() if package in present}
