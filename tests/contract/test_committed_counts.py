"""A fresh run needs as many solutions, calls, wavenumbers and bytes as committed: the gate of regressions in speed."""

import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import hcss_twin

FOLDER = Path(hcss_twin.__file__).parents[1] / "benchmarks"
pytestmark = pytest.mark.skipif(not FOLDER.exists(), reason="not in an installed package")


@pytest.fixture
def counts(monkeypatch):
    pytest.importorskip("hcss_bench", reason="plugins/hcss-bench has the private cache")
    monkeypatch.syspath_prepend(str(FOLDER))
    import counts

    yield counts
    sys.modules.pop("counts")


def test_a_fresh_run_costs_what_is_committed(counts):
    assert counts.differences(counts.committed_counts()[counts.QUICK], counts.counts_of(counts.QUICK)) == []


def test_every_scene_has_committed_counts_of_solutions_calls_wavenumbers_and_bytes(counts):
    committed = counts.committed_counts()
    assert set(committed) == set(counts.SCENES)
    for name, each in committed.items():
        assert {"radiance, columns: calls", "tables: wavenumbers", "cube: bytes"} <= set(each)
        assert ("layers solved" in each) == ("as-printed" not in name)


@pytest.mark.parametrize(("now", "told"), [(109, 0), (111, 1), (91, 0), (89, 1)])
def test_a_count_that_rose_or_fell_by_more_than_a_tenth_is_told(counts, now, told):
    assert len(counts.differences({"calls": 100}, {"calls": now})) == told


def test_a_count_that_is_new_or_gone_is_told(counts):
    assert len(counts.differences({"old": 1}, {"new": 1})) == 2


def test_the_check_fails_if_one_more_call_in_five_is_made(counts, tmp_path, monkeypatch, capsys):
    committed = counts.committed_counts()
    more = {name: count * 6 // 5 if name.endswith("calls") else count for name, count in committed["stratus"].items()}
    monkeypatch.setattr(counts, "counts_of", lambda name: more)
    monkeypatch.setattr(sys, "argv", ["counts.py", "--check", "--scenes", "stratus"])
    assert counts.main() == 1
    assert "(+20 %" in capsys.readouterr().out
    monkeypatch.setattr(counts, "counts_of", lambda name: committed["stratus"])
    assert counts.main() == 0


def test_what_is_counted_is_what_was_called(counts):
    from hcss_twin.models.radiance.physical import slab_operators

    found = Counter()
    for times in (1, 3):
        with counts.counting(found):
            for _ in range(times):
                slab_operators.solve_layers(
                    np.ones((2, 3)), np.full(3, 0.5), np.array([[1.0] * 3, [0.8] * 3]), [0.5], 4
                )
        assert found["layers solved"] == 6 * times
        assert found["layers solved, times streams"] == 24 * times
        found.clear()
