"""Random valid scenarios: pixels recomputed without tables are within the requested accuracy."""

import numpy as np
import pytest
import random_scenario_checks as checks
from random_scenario_reference import two_sets
from random_scenario_rows import ROUNDING

EACH_TIME = (1, 2, 8, 14)
"""Over sunset, of a tabulated atmosphere, at a slant, of two layers by day."""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A place for files of bands and for kept tables, which are removed between accuracies."""
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path


def require_kept(rows):
    for row in rows:
        assert row.exceeding == 0, row
        assert row.achieved <= row.accuracy + ROUNDING, row
        assert row.certificate_passed, row
        assert row.agrees, row


@pytest.mark.long
@pytest.mark.parametrize("number", EACH_TIME)
def test_cheap_scenarios_keep_a_thousandth(number, folder):
    rows, _ = checks.check(number, [1e-3], folder, most_pixels=100, finer_grid=True)
    assert rows[0].model == "as-printed"
    require_kept(rows)


@pytest.mark.long
def test_an_error_in_the_tables_is_seen(folder, monkeypatch):
    """What recomputes the pixels is not what made them."""
    from dataclasses import replace

    from hcss_twin.engine import compile as compilation

    original = compilation.tables_of

    def cloudier(_, values):
        return np.concatenate((values[:1], 1.003 * values[1:]))

    def wrong(plan):
        tables = original(plan)
        changed = (replace(each, columns=each.columns.each(cloudier)) for each in tables.tables)
        return replace(tables, tables=tuple(changed))

    monkeypatch.setattr("hcss_twin.engine.compile.tables_of", wrong)
    ((row,), _) = checks.check(2, [1e-3], folder, most_pixels=100)
    assert row.achieved == pytest.approx(3e-3, rel=0.05)
    assert row.exceeding > 0
    assert not row.certificate_passed
    assert row.agrees


def test_both_sets_of_few_wavenumbers_sum_a_spectrum_like_those_they_were_made_for():
    wavenumber = np.linspace(2500.0, 3000.0, 400)
    place = np.linspace(-1.0, 1.0, 400)
    gas = np.exp(-np.abs(np.sin(0.4 * wavenumber)) * np.arange(1, 5)[:, None])
    sets, factors = two_sets(gas, wavenumber)
    assert not set(sets[0]) & set(sets[1])
    other = gas[1] * (0.7 - 0.4 * place) + 0.3 * gas[2] * place**2
    for some, factor in zip(sets, factors, strict=True):
        assert some.size <= 9
        assert np.sum(other[some] * factor) == pytest.approx(np.sum(other), rel=0.01)
