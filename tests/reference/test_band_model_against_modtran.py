"""Where the default coefficients changed, they are no further from MODTRAN than LOWTRAN7's."""

import sys
from pathlib import Path

from sample_data import sample_file

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import gas_modtran


def test_fitted_coefficients_are_no_further_from_modtran_than_those_of_lowtran7():
    sample_file("modtran/tape7-05")
    compared = list(gas_modtran.comparisons())
    assert len(compared) == 15
    for each in compared:
        before, now = (abs(each.ours[name] - each.modtran) for name in ("lowtran7", "rrtmgp"))
        assert now <= before + 1e-5, each
