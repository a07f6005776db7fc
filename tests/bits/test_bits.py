"""Results are those that were recorded: bit by bit in the environment of the record, within 1e-6 elsewhere."""

from __future__ import annotations

import numpy as np
import pytest
import record
from cases import CAMPAIGN, CASES, NEEDS, QUICK, RANDOM_WALKS
from distributions import need


def test_every_case_is_recorded():
    assert list(record.recorded()["cases"]) == list(CASES)


def test_a_last_bit_is_found_where_bits_are_compared():
    values = np.array([1.0, 2.0])
    one, other = (
        {"cube": {"variables": {"radiance": record.of_array(each)}, "numbers": {"error": float(each[1])}}}
        for each in (values, np.nextafter(values, 3.0))
    )
    assert record.compare(one, one, exact=True) == []
    assert len(record.compare(one, other, exact=True)) == 2
    assert record.compare(one, other, exact=False) == []
    other["cube"]["variables"]["radiance"]["max"] *= 1.0 + 3e-6
    assert len(record.compare(one, other, exact=False)) == 1


def marks(name):
    if name in QUICK:
        return []
    return pytest.mark.campaign if name in CAMPAIGN else pytest.mark.long


@pytest.mark.xdist_group("bits")
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("name", [pytest.param(name, marks=marks(name)) for name in CASES])
def test_results_are_those_recorded(name, tmp_path):
    content = record.recorded()
    other = record.differences_of_environment(content["environment"])
    if other and name in RANDOM_WALKS:
        pytest.skip(f"no tolerance holds for this case, and bits are those of another environment: {other}")
    if name in NEEDS:
        need(NEEDS[name].replace("_", "-"))
    found = record.compare(content["cases"][name], record.numbers_of(CASES[name], tmp_path / name), not other)
    how = f"smallest, mean and largest values within {record.TOLERANCE:g}, because {other}" if other else "bits"
    assert not found, "\n".join((f"compared were {how}", *found))
