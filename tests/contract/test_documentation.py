"""Generated pages are current, every page has a place, and the table of equations is true."""

import importlib.util
import inspect
import json
import re
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest
from cheap import CHEAP
from PIL import Image

import hcss_twin
from hcss_twin import Scenario, providers
from hcss_twin.cli_reference import commands
from hcss_twin.cli_reference import markdown as command_line
from hcss_twin.core.catalog import catalog_root
from hcss_twin.paper.equations.document import markdown as equations
from hcss_twin.paper.equations.engine import ENGINE
from hcss_twin.paper.equations.entry import find, summary
from hcss_twin.paper.equations.paper import PAPER
from hcss_twin.provider_reference import markdown as provider_reference

ROOT = catalog_root().parent
DOCS = ROOT / "docs"
ALL = [*PAPER, *(equation for part in ENGINE.values() for equation in part)]


def module(path):
    spec = importlib.util.spec_from_file_location(f"docs_{path.stem}", path)
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


@pytest.mark.parametrize(
    ("name", "text", "command"),
    [
        ("cli", command_line, "hcss_twin.cli_reference"),
        ("equations", equations, "hcss_twin.paper.equations.document"),
        ("provider-reference", provider_reference, "hcss_twin.provider_reference"),
    ],
)
def test_a_generated_page_is_current(name, text, command):
    assert (DOCS / f"{name}.md").read_text(encoding="utf-8") == text(), f"run python -m {command}"


def test_every_command_that_help_lists_has_a_place_in_the_reference():
    words = [words for words, _ in commands()]
    page = (DOCS / "cli.md").read_text(encoding="utf-8")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(words) == len(set(words)) >= 19
    for each in words:
        assert f"\n## `{each}`\n" in page
        assert f"hcss {each.split()[1]}" in readme


def test_every_class_of_the_provider_api_and_each_of_its_methods_has_a_place_in_the_reference():
    page = provider_reference()
    for name in providers.__all__:
        found = getattr(providers, name)
        if not inspect.isclass(found):
            continue
        assert f"\n### `{name}`" in page
        for member, value in vars(found).items():
            if inspect.isfunction(value) and not member.startswith("_"):
                assert f"\n#### `{name}.{member}`\n" in page
                assert f"\ndef {member}(self" in page
    for section in ("Attributes", "Parameters", "Returns", "Raises"):
        assert f"{section}\n---" not in page
    assert "``" not in page.replace("```", "")


def test_every_page_has_one_place_in_the_navigation():
    listed = [
        page.split("<")[1].rstrip(">")
        for _, pages in module(DOCS / "site" / "navigation.py").parts((DOCS / "index.md").read_text(encoding="utf-8"))
        for page in pages
    ]
    assert len(listed) == len(set(listed))
    own = {str(path.relative_to(DOCS).with_suffix("")) for path in DOCS.rglob("*.md")} - {"index"}
    assert {page for page in listed if not page.startswith("../")} == own
    assert all((DOCS / f"{page}.md").is_file() for page in listed)
    # what a newcomer needs comes before what there is to look up
    assert listed[0] == "first-run"
    assert listed.index("gallery") < listed.index("tutorials/student") < listed.index("scenario")


# --- equations


def test_no_numbered_equation_of_the_paper_is_missing():
    assert [equation.paper for equation in PAPER] == list(range(1, 25))


@pytest.mark.parametrize("equation", ALL, ids=lambda equation: equation.name.replace(" ", "-"))
def test_the_functions_of_an_equation_exist_and_say_what_they_do(equation):
    assert equation.functions
    for dotted in equation.functions:
        assert callable(find(dotted)) or isinstance(find(dotted), property)
        assert len(summary(dotted)) > 10
    assert (equation.paper is None) == bool(equation.source)


@pytest.mark.parametrize("equation", PAPER, ids=lambda equation: f"eq{equation.paper}")
def test_the_code_of_an_equation_of_the_paper_names_its_number(equation):
    numbers = set()
    for dotted in equation.functions:
        found = find(dotted)
        found = found.fget if isinstance(found, property) else found
        text = Path(sys.modules[found.__module__].__file__).read_text(encoding="utf-8")
        for first, last, second in re.findall(r"[Ee](?:q|quation)s? (\d+)(?:-(\d+))?(?: and (\d+))?", text):
            numbers |= set(range(int(first), int(last or first) + 1)) | {int(second or first)}
    assert equation.paper in numbers


def test_a_wrong_name_of_a_function_is_found():
    with pytest.raises(LookupError, match="no_such"):
        find("physics.planck.no_such")
    with pytest.raises(LookupError, match="no such module"):
        find("phisics.planck.planck")


def test_every_formula_can_be_shown_without_a_script():
    convert = pytest.importorskip("latex2mathml.converter").convert
    for equation in ALL:
        shown = convert(equation.formula, display="block")
        assert shown.startswith("<math"), equation.name
        assert "\\" not in shown, equation.name


# --- gallery


@pytest.fixture(scope="module")
def gallery():
    folder = DOCS / "gallery"
    sys.path.insert(0, str(folder))
    try:
        yield runpy.run_path(str(folder / "make.py"))
    finally:
        sys.path.remove(str(folder))


def test_the_gallery_page_is_current_and_small(gallery):
    assert (DOCS / "gallery.md").read_text(encoding="utf-8") == gallery["page"]()
    names = [entry.name for entry in gallery["ENTRIES"]]
    assert sorted(names) == sorted(path.stem for path in (DOCS / "gallery").glob("*.toml"))
    pictures = {path.stem: path for path in (DOCS / "gallery").glob("*.png")}
    assert set(pictures) == {*names, "streets-template"}
    assert sum(path.stat().st_size for path in pictures.values()) < 2_000_000
    for name in names:
        with Image.open(pictures[name]) as picture:
            assert 800 < picture.width < 1200


def test_every_scenario_of_the_gallery_can_be_loaded():
    for path in (DOCS / "gallery").glob("*.toml"):
        assert json.loads(Scenario.load(path).to_json())["title"]


def test_a_picture_of_the_gallery_is_drawn_from_its_scenario(gallery, tmp_path):
    [entry] = [each for each in gallery["ENTRIES"] if each.name == "push-broom"]
    scenario = Scenario.load(DOCS / "gallery" / "push-broom.toml", {**CHEAP, "output.certificate": 0})
    cube = hcss_twin.simulate(scenario)
    gallery["draw"](entry, cube, tmp_path)
    drawn, committed = (thumbnail(folder / "push-broom.png") for folder in (tmp_path, DOCS / "gallery"))
    # The same clouds, whatever models, fonts and margins a version of the drawing library has.
    assert np.corrcoef(drawn.ravel(), committed.ravel())[0, 1] > 0.9


def thumbnail(path):
    with Image.open(path) as picture:
        return np.asarray(picture.convert("L").resize((80, 40)), dtype=float)


# --- site


def test_what_a_page_would_load_from_elsewhere_is_found(tmp_path):
    outside = module(DOCS / "site" / "only_local_files.py").outside
    (tmp_path / "good.html").write_text('<script src="a.js"></script><a href="https://example.org">read on</a>')
    (tmp_path / "good.css").write_text("body { background: url(a.png) }")
    assert not list(outside(tmp_path))
    bad = {
        "script.html": '<script async src="https://cdn.example.org/a.js">',
        "link.html": "<link rel='stylesheet' href='//fonts.example.org/a.css'>",
        "image.html": '<img alt="" src="http://example.org/a.png">',
        "style.css": '@import "https://example.org/a.css";',
        "font.css": "@font-face { src: url(https://example.org/a.woff2) }",
    }
    for name, text in bad.items():
        (tmp_path / name).write_text(text)
    assert sorted(name for name, _ in outside(tmp_path)) == sorted(bad)
