"""The committed ratios of the baseline scene can be read and are those that the benchmark measures."""

import sys
from pathlib import Path

import pytest

import hcss_twin

FOLDER = Path(hcss_twin.__file__).parents[1] / "benchmarks"
pytestmark = pytest.mark.skipif(not FOLDER.exists(), reason="not in an installed package")


@pytest.fixture
def benchmarks(monkeypatch):
    pytest.importorskip("hcss_bench", reason="plugins/hcss-bench has the timed stages")
    monkeypatch.syspath_prepend(str(FOLDER))
    import baseline_ratios
    import regression

    yield baseline_ratios.PARTS, regression
    for name in ("baseline_ratios", "regression"):
        sys.modules.pop(name)


def test_each_committed_ratio_belongs_to_a_part_and_each_part_has_one(benchmarks):
    parts, regression = benchmarks
    committed = regression.read_ratios(FOLDER / "baseline.json")
    assert {name.partition(":")[0] for name in committed} == set(parts)


def test_the_page_has_a_place_for_each_table_and_keeps_the_rest(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(FOLDER))
    import page

    copy = tmp_path / "page.md"
    for name in ("fronts", "baseline"):
        before = page.SPEED.read_text(encoding="utf-8")
        copy.write_text(before, encoding="utf-8")
        page.put(name, "| new |", copy)
        head, _, tail = before.partition(f"<!-- {name} -->")
        _, _, tail = tail.partition(f"<!-- end of {name} -->")
        assert copy.read_text() == f"{head}<!-- {name} -->\n| new |\n<!-- end of {name} -->{tail}"
    with pytest.raises(ValueError, match=r"page\.md"):
        page.put("nothing", "", copy)
