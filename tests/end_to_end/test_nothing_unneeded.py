"""A scene computes nothing that it does not need: counted, not timed."""

import sys
from pathlib import Path

import pytest

import hcss_twin

FOLDER = Path(hcss_twin.__file__).parents[1] / "benchmarks"
pytestmark = pytest.mark.skipif(not FOLDER.exists(), reason="not in an installed package")

CHEAP = {"image.rows": 16, "image.columns": 16, "bands": ["mwir-3.7"], "accuracy": 1e-2}


@pytest.fixture(scope="module")
def needed():
    pytest.importorskip("hcss_bench", reason="plugins/hcss-bench has the private cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(FOLDER))
        import needed

        yield needed
    for name in ("needed", "counts"):
        sys.modules.pop(name, None)


@pytest.fixture
def counts_of(needed, tmp_path, monkeypatch):
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path))  # nothing is kept from other tests
    return lambda changes: needed.counts_of(CHEAP | changes)


def test_by_night_nothing_is_solved_for_the_sun(needed, counts_of):
    night, day = counts_of(needed.NIGHT), counts_of({})
    assert night["sunlight"] == 0 < day["sunlight"]
    assert 0 < night["layers"] < day["layers"]


def test_under_clear_sky_no_field_of_clouds_is_computed_and_no_layer_solved(counts_of):
    clear = counts_of({"clouds.coverage": 0.0})
    assert clear["clouds"] == clear["layers"] == clear["sunlight"] == 0 < clear["spectra"]


def test_a_mask_alone_asks_for_no_radiance(needed, counts_of):
    mask = counts_of(needed.MASK)
    assert mask["spectra"] == mask["layers"] == mask["sunlight"] == 0 < mask["clouds"]


def test_overcast_asks_for_less_radiance_than_broken_clouds_and_solves_hardly_more(counts_of):
    overcast, broken = counts_of({"clouds.coverage": 1.0}), counts_of({})
    assert overcast["spectra"] < broken["spectra"]
    # Without clear columns the spectral grid and the bounds of omissions are tried on a few more clouds.
    assert overcast["layers"] < 1.2 * broken["layers"]
