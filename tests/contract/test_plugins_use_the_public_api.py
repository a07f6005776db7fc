"""The packages in plugins/ and the templates of new ones import only what is promised to plugins of others.

Packages of ``LISTING`` name the other modules that they use in their READMEs. The tests of hcss-lowtran7 read a
standard atmosphere of this package for comparison.
"""

import ast
import re
from pathlib import Path

import hcss_author
import pytest
from hcss_author.new_plugin.write import package_files

import hcss_twin
from hcss_twin import providers

PLUGINS = Path(__file__).parents[2] / "plugins"
PACKAGE = Path(hcss_twin.__file__).parents[1]
PUBLIC = {
    "hcss_twin": set(hcss_twin.__all__),
    "hcss_twin.providers": set(providers.__all__),
    "hcss_author": set(hcss_author.__all__),
    "hcss_twin.plan.rays": {"Rays"},  # public, but not frozen
}
LISTING = (
    "hcss-author", "hcss-bench", "hcss-evaluate", "hcss-export", "hcss-light", "hcss-modtran", "hcss-paper",
    "hcss-payload", "hcss-skies", "hcss-sweep", "hcss-uncertainty"
)  # fmt: skip
"""Plugins whose README lists other modules."""

PROMISED = {"hcss_twin", "hcss_twin.providers", "hcss_twin.physics.paths", "hcss_twin.physics.planck"}
"""The last two define names that are public in hcss_twin.providers."""
FOLDERS = sorted(
    path for name in ("src", "tests") for path in PLUGINS.glob(f"*/{name}") if path.parent.name not in LISTING
)


def private_imports(text):
    """Yield what a module imports of hcss_twin beyond the public names."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (
                each.name for each in node.names if each.name.startswith("hcss_twin.") and each.name not in PUBLIC
            )
        elif isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] in ("hcss_twin", "hcss_author"):
            known = PUBLIC.get(node.module, set())
            yield from (f"{node.module}.{each.name}" for each in node.names if each.name not in known)


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda path: f"{path.parent.name}-{path.name}")
def test_a_plugin_imports_public_names_only(folder):
    found = {name for path in folder.rglob("*.py") for name in private_imports(path.read_text(encoding="utf-8"))}
    allowed = {"hcss_twin.models.atmosphere.profile_file.load_profile"}
    assert found <= (allowed if (folder.parent.name, folder.name) == ("hcss-lowtran7", "tests") else set())


@pytest.mark.parametrize("kind", providers.Kind)
def test_a_new_package_imports_public_names_only(kind):
    sources = [text for path, text in package_files(kind, "my-own").items() if path.endswith(".py")]
    assert len(sources) == 3
    assert not [name for text in sources for name in private_imports(text)]


def imported_modules(folder):
    for path in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                yield from (each.name for each in node.names)
            elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("hcss_twin"):
                for name in (f"{node.module}.{each.name}" for each in node.names):
                    is_module = (PACKAGE / f"{name.replace('.', '/')}.py").exists()
                    yield name if is_module and node.module not in PROMISED else node.module


@pytest.mark.parametrize("plugin", LISTING)
def test_a_readme_lists_the_other_modules_that_a_plugin_imports(plugin):
    section = (PLUGINS / plugin / "README.md").read_text(encoding="utf-8").partition("## What it uses of hcss_twin")[2]
    listed = {
        f"hcss_twin.{name}"
        for row in section.splitlines()
        if row.startswith("| `")
        for name in re.findall(r"`([\w.]+)`", row.split("|")[1])
    }
    used = {name for name in imported_modules(PLUGINS / plugin / "src") if name.partition(".")[0] == "hcss_twin"}
    assert used - PROMISED == listed


def test_private_imports_are_seen():
    text = (
        "import hcss_twin.plan.plan\nfrom hcss_twin.core.files import atomic_write\nfrom hcss_twin import Plan, sense"
    )
    assert set(private_imports(text)) == {"hcss_twin.plan.plan", "hcss_twin.core.files.atomic_write", "hcss_twin.Plan"}
