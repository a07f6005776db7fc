"""Light with sides on the volumes of hcss-skies, true cells of a large-eddy simulation, against Monte Carlo."""

import pytest
from hcss_light.comparison import compare
from light_scene import DAY, NIGHT, scene

pytest.importorskip("hcss_skies")

LAYERS = {
    "trade-cumulus": {"type": "cumulus", "base": 520.0, "top": 1600.0},
    "stratocumulus": {"type": "stratocumulus", "base": 525.0, "top": 867.0},
}


def volume(name, zenith, time, bands):
    clouds = LAYERS[name] | {"generator": "volume", "parameters": {"volume": name}}
    image = {"rows": 24, "columns": 24, "pixel_size": 50.0}
    view = {"zenith": zenith, "azimuth": 30.0}
    return scene("source", clouds=clouds, image=image, view=view, time=time, bands=bands)


@pytest.mark.parametrize(
    ("name", "zenith"),
    [
        ("trade-cumulus", 60.0),
        pytest.param("trade-cumulus", 45.0, marks=pytest.mark.campaign),
        pytest.param("stratocumulus", 45.0, marks=pytest.mark.campaign),
        pytest.param("stratocumulus", 60.0, marks=pytest.mark.campaign),
    ],
)
def test_sides_of_simulated_clouds_by_night_agree_with_monte_carlo(name, zenith):
    """At 10.8 um; cumulus as columns are several times as far off."""
    (band,) = compare(volume(name, zenith, NIGHT, [[10.5, 11.0]]), 24, 400, 0, 1)["bands"]
    errors, columns = band["errors"]["cube"], band["errors"]["columns"]
    assert abs(errors["bias"]) < 0.003
    assert errors["rms"] < 0.01
    if name == "trade-cumulus":
        assert errors["rms"] < 0.4 * columns["rms"]


@pytest.mark.campaign
@pytest.mark.parametrize("name", sorted(LAYERS))
@pytest.mark.parametrize("zenith", [45.0, 60.0])
def test_sides_of_simulated_clouds_by_day_agree_with_monte_carlo(name, zenith):
    """At 3.75 um, where sunlit and shaded sides matter."""
    (band,) = compare(volume(name, zenith, DAY, [[3.6, 3.9]]), 24, 3000, 0, 1)["bands"]
    errors, columns = band["errors"]["cube"], band["errors"]["columns"]
    assert abs(errors["bias"]) < 0.05 + 2.0 * band["noise"]
    assert errors["rms"] < 0.15
    if name == "trade-cumulus":
        assert errors["rms"] < 0.7 * columns["rms"]
