"""Where the default coefficients changed, they are no further from MODTRAN than LOWTRAN7's."""

import sys
from pathlib import Path

import pytest
from sample_data import sample_file

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import gas_modtran


def test_fitted_coefficients_are_no_further_from_modtran_than_those_of_lowtran7():
    sample_file("modtran/tape7-05")
    compared = list(gas_modtran.comparisons())
    assert len(compared) == 17
    for each in compared:
        before, now = (abs(each.ours[name] - each.modtran) for name in ("lowtran7", "rrtmgp"))
        assert now <= before + 1e-5, each


def test_aerosol_emits_what_it_absorbs_as_in_modtran_with_multiple_scattering():
    sample_file("modtran/tape7-05b")
    compared = [each for each in gas_modtran.comparisons() if "does not emit" in each.what]
    assert len(compared) == 2
    for each in compared:
        assert each.ours["rrtmgp"] == pytest.approx(each.modtran, rel=0.03)
        assert each.ours["lowtran7"] == 0.0
