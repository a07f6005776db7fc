"""Soundings and reanalyses as their archives hand them out: the same ascent from every form, and faults by name."""

import numpy as np
import pytest
import sounding_corpus as corpus

from hcss_twin import Scenario, make_plan
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.profile_field import ProfileField
from hcss_twin.models.atmosphere.profile_file import load_profiles


def profile_of(case, folder):
    (folder / case.file).write_bytes(case.content)
    found = load_profiles(case.file, Catalog(base=folder), time=corpus.TIME)
    return found.with_levels_near(*corpus.PLACE).at(*corpus.PLACE) if isinstance(found, ProfileField) else found


@pytest.mark.parametrize("case", corpus.good(), ids=lambda case: case.name)
def test_an_ascent_is_the_same_in_every_form_and_what_is_unusual_is_told(case, tmp_path):
    """Without geopotential the first level of a reanalysis, here at 110 m, counts as the sea."""
    profile = profile_of(case, tmp_path)
    heights = np.array([500.0, 1500.0, 3000.0, *([] if "heights that repeat" in case.name else [10e3, 15e3])])
    geopotential = heights / (1.0 + heights / 6.356e6)
    shifted = "no geopotential" in case.name
    np.testing.assert_allclose(
        profile.temperature_at(heights), corpus.temperature_K(geopotential), atol=0.8 if shifted else 0.35
    )
    vapour = np.log(profile.mixing_ratio["h2o"] / (1.0 + profile.mixing_ratio["h2o"]) * profile.pressure_Pa + 1e-300)
    found = np.interp(heights[:3], profile.altitude_m, vapour)
    np.testing.assert_allclose(found, np.log(corpus.vapour_Pa(heights[:3])), atol=0.1 if shifted else 0.06)
    assert not case.words or any(case.words in note for note in profile.notes)


@pytest.mark.parametrize("case", corpus.bad(), ids=lambda case: case.name)
def test_a_fault_is_named_with_its_level_its_value_and_what_is_allowed(case, tmp_path):
    with pytest.raises(CatalogError, match=case.words):
        profile_of(case, tmp_path)


def test_repeated_levels_that_contradict_each_other_are_an_error(tmp_path):
    def warmer(number, values):
        if number == 5:
            values["temperature_C"] = f"{float(values['temperature_C']) + 6.0:.1f}"

    lines = corpus.wyoming(np.sort(np.append(corpus.HEIGHTS, corpus.HEIGHTS[4])), edit=warmer)
    with pytest.raises(CatalogError, match=r"line 7: temperature .* in line 6; allowed: one temperature of each"):
        profile_of(corpus.Case("", "ascent.csv", "\n".join(lines).encode()), tmp_path)


def test_of_several_times_without_one_to_choose_by_none_is_guessed(tmp_path):
    (tmp_path / "era5.nc").write_bytes(corpus.era5(times=(0.0, 6.0)))
    with pytest.raises(CatalogError, match="'valid_time' has 2 times; allowed: one"):
        load_profiles("era5.nc", Catalog(base=tmp_path))


def test_the_plan_tells_which_time_of_a_reanalysis_it_uses(tmp_path):
    (tmp_path / "era5.nc").write_bytes(corpus.era5(times=(-6.0, 0.0, 6.0)))
    scenario = Scenario.from_dict(
        {
            "time": "2024-04-20T12:30:00+10:00", "place": {"latitude": 35.0, "longitude": 150.0},
            "clouds": {"coverage": 0.0}, "image": {"rows": 8, "columns": 8, "pixel_size": 100.0}, "bands": ["mwir"],
            "frames": {"count": 1}, "atmosphere": {"profile": "era5.nc"},
        },
        base=tmp_path,
    )  # fmt: skip
    notes = make_plan(scenario).notes
    assert any("time 2024-04-20 02:00 UTC of the file, 0.5 h before the scenario's" in note for note in notes)
