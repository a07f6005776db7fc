"""Every file, command and snippet of the tutorials works, and what they show is what is printed."""

import importlib.util
import sys

import pytest

from hcss_twin.core.catalog import catalog_root

FOLDER = catalog_root().parent / "docs" / "tutorials"


def load():
    spec = importlib.util.spec_from_file_location("tutorial_run", FOLDER / "run.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


tutorials = load()
PAGES = sorted(path.name for path in FOLDER.glob("*.md"))


@pytest.mark.long
@pytest.mark.parametrize("name", PAGES)
def test_a_tutorial_does_what_it_shows(name, tmp_path):
    page = (FOLDER / name).read_text(encoding="utf-8")
    if "pip install" in page:
        pytest.importorskip("hatchling")
    (tmp_path / "work").mkdir()
    ran = list(tutorials.run(page, tmp_path / "work", tutorials.environment(tmp_path)))
    wrong = [
        (each.shown.text, each.printed)
        for each in ran
        if each.shown and not tutorials.same(each.shown.text, each.printed)
    ]
    assert not wrong, f"run python docs/tutorials/run.py {name} --write"


@pytest.mark.parametrize("name", PAGES)
def test_all_fences_of_a_tutorial_are_run_written_or_shown(name):
    page = (FOLDER / name).read_text(encoding="utf-8")
    every = tutorials.blocks(page)
    assert len(every) == page.count("\n```") / 2
    assert any(block.runs for block in every)
    for before, block in zip([None, *every], every, strict=False):
        output = block.language == "text" and before is not None and before.runs
        assert block.file or block.runs or output, block.text
        assert not output or block.text.strip(), f"no output shown: {before.text}"


@pytest.mark.parametrize(
    ("shown", "printed", "expected"),
    [
        ("radiance 8.087 K", "radiance  8.088 K", True),
        ("radiance 8.087 K", "radiance 8.2 K", False),
        ("error 1.0e-04 found", "error 1.004e-4 found", True),
        ("0.0 and 1", "0 and 2", False),
        ("0.0 of 2", "0.1 of 2", False),
        ("computed as specified: 12", "NOT as specified: 12", False),
        ("one 1", "one 1 1", False),
        ("mwir-3.7 is lwir-10.8", "mwir-3.7 is lwir-12.0", False),
    ],
)
def test_outputs_agree_if_words_are_the_same_and_numbers_nearly(shown, printed, expected):
    assert tutorials.same(shown, printed) is expected


def test_a_command_that_fails_is_told_with_what_it_said(tmp_path):
    page = "```sh\necho too late >&2; exit 3\n```\n"
    with pytest.raises(RuntimeError, match=r"exit code 3 of\n(.|\n)*too late"):
        list(tutorials.run(page, tmp_path, {"PATH": "/usr/bin:/bin"}))


def test_real_output_takes_the_place_of_what_was_shown(tmp_path):
    file, first = "`a.txt`:\n\n```text\n5\n```\n\n", "```sh\ncat a.txt\n```\n\n```text\nold\n```\n\n"
    page = file + first + "and\n\n```sh\necho 6\n```\n\n```text\n```\n"
    ran = list(tutorials.run(page, tmp_path, {"PATH": "/usr/bin:/bin"}))
    assert tutorials.refreshed(page, ran) == page.replace("old\n", "5\n").replace("text\n```", "text\n6\n```")
