"""Sea emissivity against the published values of Wu and Smith, whose source stands in the data file.

Tables of Masuda et al. (1988) were not to be had.

They are printed with a rounding of 5e-5, but the index of water is another one: at nadir, where neither wind nor angle
matters, it makes up to 5e-4 (12 um), and it counts more at larger angles. ``TOLERANCE`` is twice that. Wavelengths are
printed with one decimal: ``ROUNDED_UM`` of wavelength changes the emissivity by up to .0019 (12 um, 60.5 deg), on the
flank of an absorption band.

No published table at other temperatures could be had. The dependence on temperature comes from two laboratories: 273 K
(Rowe et al. 2020) and 298 K (Hale and Querry 1973). Tests below hold it to the dependence that the first one alone
measured between 263 and 273 K.
"""

from pathlib import Path

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.parameters import CoxMunkParameters, RoughSeaParameters
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.models.sea.cox_munk import CoxMunkSea
from hcss_twin.models.sea.rough_sea import RoughSea
from hcss_twin.models.sea.sea_water import SALINE_N_PER_PSU, load_sea_water
from hcss_twin.physics.fresnel import unpolarised_reflectance
from hcss_twin.physics.planck import planck
from hcss_twin.providers import SeaInputs

ZENITH_DEG = (0.5, 30.5, 60.5)
TABLE = np.loadtxt(Path(__file__).parents[1] / "data" / "wu-smith-1997-emissivity.csv", delimiter=",", skiprows=5)
PUBLISHED = {(wavelength_um, wind): tuple(values) for wavelength_um, wind, *values in TABLE.tolist()}
"""Emissivity at ``ZENITH_DEG``, by wavelength in um and wind speed in m/s."""

WARM_K = 298.15
TOLERANCE = 1e-3
ROUNDED_UM = 0.05
BETWEEN_TEMPERATURES = 3e-3


def rough_sea(wind: float, temperature_K: float = WARM_K) -> RoughSea:
    return RoughSea(SeaInputs(wind, 0.0, temperature_K, Catalog()), RoughSeaParameters(foam=False))


def emissivity(model: RoughSea | CoxMunkSea, wavelength_um: float) -> np.ndarray:
    return model.emissivity(np.array([1e4 / wavelength_um]), np.cos(np.radians(ZENITH_DEG)))[:, 0]


@pytest.mark.parametrize(("wavelength_um", "wind"), list(PUBLISHED))
def test_emissivity_of_warm_water_agrees_with_the_published_values(wavelength_um: float, wind: float) -> None:
    sea = rough_sea(wind)
    found, shorter, longer = (emissivity(sea, wavelength_um + off) for off in (0.0, -ROUNDED_UM, ROUNDED_UM))
    allowed = TOLERANCE + np.maximum(np.abs(shorter - found), np.abs(longer - found))
    assert np.all(np.abs(found - PUBLISHED[wavelength_um, wind]) <= allowed)


IN_BANDS_UM = np.concatenate([np.arange(3.5, 4.21, 0.1), np.arange(8.0, 13.01, 0.25)])


def emissivity_by_slope(temperature_K: float, anchor: str, anchor_K: float) -> np.ndarray:
    """Of a flat sea, from one table and the change per kelvin of supercooled water, 263 to 273 K."""
    wavenumber = 1e4 / IN_BANDS_UM
    colder, cold, at = (load_refractive_index(Catalog(), each).at(wavenumber) for each in (*SUPERCOOLED, anchor))
    steps = (temperature_K - anchor_K) / 10.0
    n = at.real + steps * (cold.real - colder.real) + 35.0 * SALINE_N_PER_PSU
    index = n + 1j * at.imag * (cold.imag / colder.imag) ** steps
    return 1.0 - unpolarised_reflectance(index, TO_60_DEG[:, None])


TO_60_DEG = np.cos(np.radians([0.0, 30.0, 60.0]))


SUPERCOOLED = ("water-263K", "water-273K")


@pytest.mark.parametrize(
    ("temperature_K", "anchor", "anchor_K"),
    [(275.0, "water-273K", 273.15), (285.0, "water-273K", 273.15), (285.0, "water", 298.15), (295.0, "water", 298.15)],
)
def test_emissivity_between_two_laboratories_agrees_with_either_and_the_slope_of_one(
    temperature_K: float, anchor: str, anchor_K: float
) -> None:
    """Within .003 to 60 deg, in 3.5-4.2 and 8-13 um; without any dependence 275 K would be off by .013."""
    water = load_sea_water(Catalog(), "water", temperature_K, 35.0, by_temperature=True)
    found = 1.0 - unpolarised_reflectance(water.at(1e4 / IN_BANDS_UM), TO_60_DEG[:, None])
    np.testing.assert_allclose(
        found, emissivity_by_slope(temperature_K, anchor, anchor_K), rtol=0.0, atol=BETWEEN_TEMPERATURES
    )


def test_neglecting_the_temperature_of_water_costs_what_newman_et_al_found() -> None:
    """Up to 0.6 K of sea temperature in 770-1230 cm-1 (Q. J. R. Meteorol. Soc. 131, 2539-2557, 2005, abstract)."""
    wavenumber = np.linspace(770.0, 1230.0, 47)
    nadir = np.array([1.0])
    cold, warm = (rough_sea(0.0, kelvin).emissivity(wavenumber, nadir)[0] for kelvin in (273.15, WARM_K))
    black = planck(wavenumber, 273.15)
    per_kelvin = (planck(wavenumber, 273.65) - planck(wavenumber, 272.65)) / black
    # The sky that is reflected instead has at least a tenth of the sea's radiance even in a dry window.
    largest = float(np.max(np.abs(cold - warm) / per_kelvin))
    assert 0.2 < 0.9 * largest < 0.6


@pytest.mark.parametrize(("wind", "tolerance"), [(5.0, 2e-4), (15.0, 6e-4)])
def test_effect_of_wind_agrees_where_the_index_of_water_cancels(wind: float, tolerance: float) -> None:
    """At 60.5 deg, 5 m/s lower emissivity by .0025 and 15 m/s raise it by .0006."""
    published = np.subtract(PUBLISHED[10.8, wind], PUBLISHED[10.8, 0.0])
    found = emissivity(rough_sea(wind), 10.8) - emissivity(rough_sea(0.0), 10.8)
    np.testing.assert_allclose(found, published, atol=tolerance)


def test_the_index_that_closes_the_gap_at_nadir_closes_it_at_60_degrees() -> None:
    """At 12 um: no wind, slope or reflection matters at nadir, so that the surface is not what differs."""
    published = PUBLISHED[12.0, 5.0]
    as_printed, shorter = (emissivity(rough_sea(5.0), 12.0 - off) - published for off in (0.0, ROUNDED_UM))
    assert as_printed[0] < -4e-4
    assert as_printed[2] < -1.8e-3
    np.testing.assert_allclose(shorter, 0.0, atol=4e-4)


def test_without_the_second_reflection_the_published_value_of_a_windy_sea_is_missed() -> None:
    model = CoxMunkSea(SeaInputs(15.0, 0.0, WARM_K, Catalog()), CoxMunkParameters())
    assert emissivity(model, 10.8)[2] == pytest.approx(PUBLISHED[10.8, 15.0][2] - 0.0087, abs=5e-4)
