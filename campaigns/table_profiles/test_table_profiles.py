"""A table computed for one profile is not used with other air, and is with the same air written in another way."""

from dataclasses import replace

import numpy as np
import pytest
from profiles import bad, good
from run import verdict

from hcss_twin import Scenario, make_plan
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ScenarioError
from hcss_twin.models.atmosphere.table_file import AtmosphereTable

SCENE = {
    "time": "2024-04-20T12:30:00+10:00",
    "place": {"latitude": 35.0, "longitude": 150.0},
    "bands": [[10.0, 10.2]],
    "image": {"rows": 4, "columns": 4},
    "radiance": {"model": "as-printed"},
}


@pytest.mark.parametrize("number", range(10))
def test_a_sample_is_right(number, tmp_path):
    assert verdict(good(number), tmp_path) == ""
    assert verdict(bad(number), tmp_path) != ""


def planned(folder, **atmosphere):
    scene = SCENE | {"atmosphere": {"provider": "table", **atmosphere}}
    return make_plan(Scenario.from_dict(scene, base=folder))


def test_a_scenario_with_other_humidity_than_its_table_is_refused_by_key_and_gas(tmp_path):
    (tmp_path / "same.csv").write_text(good(0))
    (tmp_path / "moist.csv").write_text(bad(0))
    assert not [note for note in planned(tmp_path, profile="same.csv").notes if "does not state" in note]
    with pytest.raises(ScenarioError, match=r"atmosphere.profile: .*H2O differs by .* at 0 m"):
        planned(tmp_path, profile="moist.csv")


def test_a_table_without_gases_is_questioned_and_one_with_gases_is_held_to_them(tmp_path):
    shipped = AtmosphereTable.read(Catalog().find("us-standard-1976-lowtran7", "atmospheres", ".nc"))
    small = replace(
        shipped,
        wavenumber_cm1=shipped.wavenumber_cm1[(shipped.wavenumber_cm1 > 950) & (shipped.wavenumber_cm1 < 1050)],
        transmittance=shipped.transmittance[..., (shipped.wavenumber_cm1 > 950) & (shipped.wavenumber_cm1 < 1050)],
        path_radiance=shipped.path_radiance[..., (shipped.wavenumber_cm1 > 950) & (shipped.wavenumber_cm1 < 1050)],
    )
    (tmp_path / "moist.csv").write_text(bad(1))
    small.write(tmp_path / "silent.nc", {})
    parameters = {"file": str(tmp_path / "silent.nc")}
    notes = planned(tmp_path, profile="moist.csv", parameters=parameters).notes
    assert [note for note in notes if "does not state its H2O" in note]
    assert not [note for note in planned(tmp_path, parameters=parameters).notes if "does not state" in note]
    gases = {"h2o": np.full(small.profile.altitude_m.size, 1e-3)}
    replace(small, profile=replace(small.profile, mixing_ratio=gases)).write(tmp_path / "dry.nc", {})
    for name in "moist.csv", "us-standard-1976":
        with pytest.raises(ScenarioError, match=r"atmosphere.profile: .*H2O differs"):
            planned(tmp_path, profile=name, parameters={"file": str(tmp_path / "dry.nc")})
