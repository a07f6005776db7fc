"""The packages in plugins/ and the templates of new ones import public names only.

The public names are those of the page that docs/generate/public_names.py writes. The tests of hcss-lowtran7 read a
standard atmosphere for comparison.
"""

import ast
import importlib.util
import inspect
from importlib import import_module
from pathlib import Path

import hcss_author
import pytest
from hcss_author.extension_entries import Extension
from hcss_author.new_plugin.write import package_files

import hcss_twin
from hcss_twin import providers

PLUGINS = Path(__file__).parents[2] / "plugins"


def page():
    """The script that writes the page of public names."""
    spec = importlib.util.spec_from_file_location(
        "docs_public_names", PLUGINS.parent / "docs" / "generate" / "public_names.py"
    )
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


PAGE = page()
FROZEN = {
    "hcss_twin": set(hcss_twin.__all__),
    "hcss_twin.providers": set(providers.__all__),
    "hcss_author": set(hcss_author.__all__),
}
PUBLIC = {name: set(names) for name, names in PAGE.public().items()} | FROZEN
FROM_OUTSIDE = ("hcss-examples", "hcss-grey-atmosphere", "hcss-lowtran7", "hcss-pyxel")
"""Packages whose tests, too, are those that others could write."""

FOLDERS = sorted(PLUGINS.glob("*/src"))
FOLDERS += [path for name in FROM_OUTSIDE if (path := PLUGINS / name / "tests").is_dir()]


def private_imports(text, public=PUBLIC):
    """Yield what a module imports of hcss_twin beyond the public names."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (
                each.name for each in node.names if each.name.startswith("hcss_twin.") and each.name not in public
            )
        elif isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] in ("hcss_twin", "hcss_author"):
            known = public.get(node.module, set())
            names = {each.name: f"{node.module}.{each.name}" for each in node.names}
            yield from (whole for name, whole in names.items() if name not in known and whole not in public)


def private_imports_of(folder):
    """Return what the modules of a folder import of hcss_twin beyond the public names; packages import themselves."""
    texts = [path.read_text(encoding="utf-8") for path in folder.rglob("*.py") if "templates" not in path.parts]
    found = {name for text in texts for name in private_imports(text)}
    return {name for name in found if name.partition(".")[0] != folder.parent.name.replace("-", "_")}


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda path: f"{path.parent.name}-{path.name}")
def test_a_plugin_imports_public_names_only(folder):
    assert not private_imports_of(folder)


@pytest.mark.parametrize("kind", Extension)
def test_a_new_extension_imports_public_names_only(kind):
    sources = [text for path, text in package_files(kind, "my-own").items() if path.endswith(".py")]
    assert len(sources) == 3
    assert not [name for text in sources for name in private_imports(text)]


@pytest.mark.parametrize("kind", providers.Kind)
def test_a_new_package_imports_frozen_names_only(kind):
    sources = [text for path, text in package_files(kind, "my-own").items() if path.endswith(".py")]
    assert len(sources) == 3
    assert not [name for text in sources for name in private_imports(text, FROZEN)]


def names_of(module):
    """Return ``__all__`` of a module of hcss-sweep, read and not imported."""
    name = module.partition(".")[2] or "__init__"
    path = PLUGINS / "hcss-sweep" / "src" / "hcss_sweep" / f"{name}.py"
    lists = (node for node in ast.parse(path.read_text(encoding="utf-8")).body if isinstance(node, ast.Assign))
    return next((ast.literal_eval(node.value) for node in lists if ast.unparse(node.targets[0]) == "__all__"), [])


def test_packages_import_of_hcss_sweep_what_its_modules_list():
    found = {}
    for path in PLUGINS.glob("*/src/**/*.py"):
        if path.relative_to(PLUGINS).parts[0] == "hcss-sweep":
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "hcss_sweep":
                found.setdefault(node.module, set()).update(each.name for each in node.names)
    assert {"hcss_sweep.axis", "hcss_sweep.design"} <= found.keys()
    assert not {f"{module}.{name}" for module, names in found.items() for name in names - set(names_of(module))}


def test_private_imports_are_seen():
    text = (
        "import hcss_twin.plan.windows\nfrom hcss_twin.core.files import Writing, flush\n"
        "from hcss_twin import Plan, sense\nfrom hcss_twin.plan import windows\n"
    )
    assert set(private_imports(text)) == {
        "hcss_twin.plan.windows", "hcss_twin.core.files.flush", "hcss_twin.Plan"
    }  # fmt: skip


def test_the_page_has_at_most_180_names_each_with_a_description():
    assert PAGE.count() <= PAGE.MOST == 180
    for module, names in PAGE.public().items():
        assert not [name for name in names if not PAGE.described(module, name)[0]], module


def test_units_are_those_of_names_arguments_and_docstrings():
    assert PAGE.described("hcss_twin.providers", "Sun")[1] == "deg, s, au"
    assert "W m-2 sr-1" in PAGE.described("hcss_twin.providers", "planck")[1]
    assert PAGE.described("hcss_twin.core.units", "WaterContent")[1] == "g m-3"
    assert PAGE.described("hcss_twin.core.kernels", "kernel")[1] == ""


def test_public_names_are_defined_by_the_module_that_lists_them():
    for module in PAGE.public().keys() - FROZEN.keys():
        loaded = import_module(module)
        body = ast.parse(inspect.getsource(loaded)).body
        defined = {node.name for node in body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
        targets = [target for node in body if isinstance(node, ast.Assign) for target in node.targets]
        defined |= {target.id for target in targets if isinstance(target, ast.Name)}
        assert set(loaded.__all__) <= defined, module
