"""Aircraft and ship: the kit, closed forms of areas and motion, and a scene with both."""

import shutil
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from hcss_author import ElementContract, KnownElement, PlainScene, assert_registered, sample_element_inputs
from hcss_examples.aircraft import Aircraft
from hcss_examples.aircraft import Parameters as AircraftParameters
from hcss_examples.ship import Parameters as ShipParameters
from hcss_examples.ship import Ship, shared_area

from hcss_twin import Scenario, simulate
from hcss_twin.providers import ProviderError

SCENARIO = Path(__file__).parents[1] / "scenarios" / "aircraft-and-ship.toml"
CHEAP = {"radiance.model": "as-printed", "sea.model": "cox-munk", "optics.provider": "mie", "output.certificate": 0}
WHOLE = slice(0, 48), slice(0, 64)


class TestAircraft(ElementContract):
    def make_provider(self, inputs):
        return Aircraft(inputs, AircraftParameters(x=-900.0, climb=-8.0, plume={"mid": 300.0}))

    def known(self, inputs, time_s):
        skin = 150.0 * inputs.black_body(245.0)
        return KnownElement(-900.0 + 240.0 * time_s, 0.0, 1e4 - 8.0 * time_s, skin + np.array([300.0, 0.0]))


class TestShip(ElementContract):
    def make_provider(self, inputs):
        return Ship(inputs, ShipParameters(length=500.0, width=100.0, speed=50.0))

    def known(self, inputs, time_s):
        deck = 0.9 * 5e4 * np.cos(np.radians(inputs.view.zenith_deg)) * inputs.black_body(305.0)
        way = 50.0 * time_s
        return KnownElement(way * np.sin(np.pi / 3), way * np.cos(np.pi / 3), 15.0, deck)


@pytest.mark.parametrize("name", ["aircraft", "ship"])
def test_is_found_when_installed(name):
    assert_registered("elements", name, distribution="hcss-examples")


@pytest.mark.parametrize("heading", [0.0, 30.0, 45.0, 217.0])
@pytest.mark.parametrize("x", [0.0, 71.3])
def test_the_pixels_of_a_ship_cover_its_deck_and_have_its_centre(heading, x):
    inputs = sample_element_inputs()
    of = ShipParameters(x=x, y=-33.0, length=480.0, width=90.0, heading=heading, speed=20.0)
    (found,) = Ship(inputs, of).pixels(30.0, *WHOLE, PlainScene(inputs))
    assert found.share.sum() * 200.0**2 == pytest.approx(480.0 * 90.0, rel=1e-9)
    way = 600.0 * np.array([np.cos(np.radians(heading)), np.sin(np.radians(heading))])
    expected = (np.array([-33.0, x]) + way) / 200.0 + (24, 32)
    # The mean of pixel centres differs from the deck's by less than a pixel.
    centre = np.array([found.share @ (found.rows + 0.5), found.share @ (found.columns + 0.5)]) / found.share.sum()
    np.testing.assert_allclose(centre, expected, atol=0.5)


def test_a_pixel_within_a_polygon_is_covered_and_one_outside_is_not():
    square = np.array([[0.0, 0.0], [0.0, 3.0], [3.0, 3.0], [3.0, 0.0]])
    diamond = np.array([[1.5, 0.5], [2.5, 1.5], [1.5, 2.5], [0.5, 1.5]])
    assert shared_area(square, 1, 1) == 1.0
    assert shared_area(square, 3, 0) == 0.0
    assert shared_area(diamond, 1, 1) == pytest.approx(1.0)
    assert shared_area(diamond, 0, 1) == pytest.approx(0.25)
    assert shared_area(diamond, 0, 0) == 0.0


def test_an_aircraft_climbs_along_its_heading():
    inputs = sample_element_inputs()
    of = AircraftParameters(heading=210.0, speed=200.0, climb=5.0, area=100.0)
    (skin,) = Aircraft(inputs, of).pixels(9.0, *WHOLE, PlainScene(inputs))
    assert (skin.x_m, skin.y_m) == pytest.approx((-900.0, -900.0 * np.sqrt(3.0)))
    assert skin.velocity_m_s == pytest.approx((-100.0, -100.0 * np.sqrt(3.0), 5.0))
    assert skin.altitude_m == skin.truth["altitude"] == 10_045.0
    assert skin.area_m2 == 100.0


@pytest.mark.parametrize(
    ("parameters", "message"),
    [({"plume": {"medium": 1.0}}, "plume names 'medium', which is no band; allowed: long, mid")],
)
def test_wrong_parameters_name_what_is_allowed(parameters, message):
    with pytest.raises(ProviderError, match=message):
        Aircraft(sample_element_inputs(), AircraftParameters(**parameters))


def test_the_scenario_shows_both_and_their_truth(tmp_path):
    shutil.copy(SCENARIO, tmp_path)
    simulate(Scenario.load(tmp_path / SCENARIO.name, CHEAP), tmp_path / "c.nc").close()
    with netCDF4.Dataset(tmp_path / "c.nc") as cube:
        element, added = cube["element"][:], cube["element_radiance"][:]
        skin, deck = cube["element_skin"][:], cube["element_temperature"][:]
    assert set(np.unique(element)) == {0, 1, 2}
    assert np.all(np.isnan(skin) == (element != 2))
    assert np.all(np.isnan(deck) == (element != 1))
    assert np.all(added[np.broadcast_to((element == 0)[:, None], added.shape)] == 0.0)
    mwir, lwir = (added[:, band][element == 2] for band in range(2))
    # The plume is brighter than the sea in the mid infrared; in the long only the cold skin is seen.
    assert np.all(mwir > 0.0)
    assert np.all(lwir < 0.0)
    assert np.all(added[:, 1][element == 1] > 0.0)
