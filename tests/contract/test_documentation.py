"""Generated pages are current, and every page has a place."""

import importlib.util
import inspect
import json
import re
import runpy
import sys

import numpy as np
import pytest
from cheap import CHEAP
from distributions import has
from PIL import Image

import hcss_twin
from hcss_twin import Scenario, providers
from hcss_twin.core.catalog import catalog_root

ROOT = catalog_root().parent
DOCS = ROOT / "docs"


def module(path):
    spec = importlib.util.spec_from_file_location(f"docs_{path.stem}", path)
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


@pytest.fixture(scope="module")
def generator():
    """The script that writes the generated pages."""
    for plugin in (
        "hcss_author",
        "hcss_bench",
        "hcss_evaluate",
        "hcss_export",
        "hcss_modtran",
        "hcss_paper",
        "hcss_sweep",
        "hcss_uncertainty",
    ):
        pytest.importorskip(plugin, reason=f"{plugin} has a part of the generated pages")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(DOCS / "generate")
        yield module(DOCS / "generate" / "all.py")


def test_the_generated_pages_are_current(generator):
    for path, text in generator.pages().items():
        assert path.read_text(encoding="utf-8") == text, f"{path.name}: run python docs/generate/all.py"


def test_files_that_pages_for_developers_name_exist():
    folders = ("hcss_twin", "plugins", "tests", "benchmarks", "campaigns", "docs", "catalogs")
    known = [f"/{path.relative_to(ROOT).as_posix()}" for folder in folders for path in (ROOT / folder).rglob("*.py")]
    for page in (*(DOCS / "development").glob("*.md"), ROOT / "CONTRIBUTING.md"):
        for name in re.findall(r"`([\w./-]+\.py)", page.read_text(encoding="utf-8")):
            assert any(path.endswith(f"/{name}") for path in known), f"{page.name}: {name}"


def test_every_command_that_help_lists_has_a_place_in_the_reference(generator):
    words = [words for words, _ in generator.cli.commands()]
    page = (DOCS / "reference" / "cli.md").read_text(encoding="utf-8")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(words) == len(set(words)) >= 19
    for each in words:
        assert f"\n## `{each}`\n" in page
        assert f"hcss {each.split()[1]}" in readme


def test_every_name_that_plugins_import_and_each_method_has_a_place_in_the_reference():
    page = (DOCS / "reference" / "provider-reference.md").read_text(encoding="utf-8")
    for name in providers.__all__:
        found = getattr(providers, name)
        assert re.search(rf"\n### `{name}[`(]", page)
        if not inspect.isclass(found) or not found.__module__.startswith("hcss_twin"):
            continue
        for member, value in vars(found).items():
            if inspect.isfunction(value) and not member.startswith("_"):
                described = page.partition(f"\n### `{name}`")[2].partition("\n### ")[0]
                assert f"\n* `{member}(" in described
    for section in ("Attributes", "Parameters", "Returns", "Raises"):
        assert f"{section}\n---" not in page
    assert "``" not in page.replace("```", "")


def test_pages_for_users_do_not_grow():
    count = module(DOCS / "generate" / "words.py")
    for kind, pages in count.pages().items():
        assert 0 < sum(map(count.words, pages)) <= count.MOST[kind], f"{kind}: python docs/generate/words.py --pages"


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
    assert listed.index("gallery") < listed.index("tutorials/student") < listed.index("reference/scenario")


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


NEEDED = {"streets": ("hcss-skies",), "coast-from-two-orbits": ("hcss-payload", "hcss-examples")}


def test_every_scenario_of_the_gallery_can_be_loaded():
    for path in (DOCS / "gallery").glob("*.toml"):
        if not all(map(has, NEEDED.get(path.stem, ()))):
            continue
        assert json.loads(Scenario.load(path).to_json())["title"]


def test_a_picture_of_the_gallery_is_drawn_from_its_scenario(gallery, tmp_path):
    [entry] = [each for each in gallery["ENTRIES"] if each.name == "truth"]
    scenario = Scenario.load(DOCS / "gallery" / "truth.toml", {**CHEAP, "output.certificate": 0})
    cube = hcss_twin.simulate(scenario)
    gallery["draw"](entry, cube, folder=tmp_path)
    drawn, committed = (thumbnail(folder / "truth.png") for folder in (tmp_path, DOCS / "gallery"))
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
