"""The error budget of a pixel: which approximations add up, and which exclude each other."""

from itertools import permutations

import pytest

from hcss_twin.plan.accuracy import Budget, share_out

ADDED = ("numerics", "spectral_grid", "wavenumbers", "views", "shadows", "time", "other_instants", "faint_sunlight")
EXCLUSIVE = ("thickness", "layers", "waves")


def test_errors_add_up_but_of_those_that_exclude_each_other_the_largest_counts():
    # Powers of two: every subset has a sum of its own.
    errors = {name: 2.0**number for number, name in enumerate(ADDED)}
    assert Budget(**errors).total == 255.0
    for values in permutations((256.0, 512.0, 1024.0)):
        exclusive = dict(zip(EXCLUSIVE, values, strict=True))
        assert Budget(**errors, **exclusive).total == 255.0 + 1024.0


def test_all_shares_of_a_pixel_stay_within_the_accuracy_asked_for():
    # 0.28 + 0.25 + 0.15 + 0.1 + 0.05 + 0.03 + 0.07 + 0.02 + 0.05, as docs and certificate state them.
    assert share_out(1e-3).total == pytest.approx(1e-3, rel=1e-12)
