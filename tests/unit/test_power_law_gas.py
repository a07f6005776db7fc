"""Paths of any kind from a table of paths to space."""

import numpy as np
import pytest
from scipy.optimize import brentq

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ProviderError
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.atmosphere.table import TableTransmittance
from hcss_twin.models.parameters import TableParameters
from hcss_twin.models.radiance.physical.air import Air
from hcss_twin.models.radiance.physical.power_law_gas import PowerLawGas
from hcss_twin.physics.paths import SPACE, Leg, Path, to_space
from hcss_twin.physics.planck import planck
from hcss_twin.providers import AtmosphereInputs

CATALOG = Catalog()
PROFILE = load_profile("us-standard-1976", CATALOG)
WAVENUMBER = np.linspace(2000.0, 2500.0, 11)
SUNLIT = to_space(1300.0, 20.0) + to_space(1300.0, 50.0)
PATHS = (
    Path(),
    to_space(0.0, 30.0),
    Path((Leg(700.0, 2300.0, 60.0),)),
    SUNLIT,
    Path((Leg(1300.0, 4000.0, 20.0), Leg(1300.0, SPACE, 50.0), Leg(4000.0, SPACE, 20.0))),
    SUNLIT + Path((Leg(0.0, 1300.0, 20.0),)),
)


@pytest.fixture(scope="module")
def table():
    return TableTransmittance(AtmosphereInputs(PROFILE, CATALOG), TableParameters())


@pytest.fixture
def gas(table):
    return PowerLawGas(table, PROFILE)


def test_paths_are_the_same_alone_and_together_and_again(gas, table):
    together = gas.transmittance(WAVENUMBER, PATHS)
    np.testing.assert_array_equal(gas.transmittance(WAVENUMBER, PATHS), together)
    for path, expected in zip(PATHS, together, strict=True):
        fresh = PowerLawGas(table, PROFILE)
        np.testing.assert_allclose(fresh.transmittance(WAVENUMBER, [path])[0], expected, rtol=1e-12)


def test_other_wavenumbers_are_not_mistaken_for_those_known(gas, table):
    gas.transmittance(WAVENUMBER, PATHS)
    np.testing.assert_allclose(
        gas.transmittance(WAVENUMBER[3:5], PATHS),
        PowerLawGas(table, PROFILE).transmittance(WAVENUMBER[3:5], PATHS),
        rtol=1e-12,
    )


def test_down_to_a_target_and_up_again_is_what_the_table_says_however_it_is_cut(gas, table):
    expected = table.transmittance(WAVENUMBER, [SUNLIT])[0]
    whole, cut = gas.transmittance(WAVENUMBER, [PATHS[3], PATHS[4]])
    np.testing.assert_array_equal(whole, expected)
    np.testing.assert_array_equal(cut, expected)


def test_nothing_is_crossed_without_legs_and_more_absorbs_more(gas):
    nothing, *_, sunlit, _, longer = gas.transmittance(WAVENUMBER, PATHS)
    np.testing.assert_array_equal(nothing, 1.0)
    # The former by the law, the latter from the table.
    assert np.all(longer < sunlit + 0.01)
    assert np.any(longer < sunlit)


def mass(height, *zeniths):
    return float(np.sum(PROFILE.mean_airmass(height, np.array(zeniths))))


@pytest.mark.parametrize(("view", "sun"), [(0.0, 87.6), (20.0, 87.5), (60.0, 87.3)])
def test_light_of_a_low_sun_does_not_jump_where_clouds_rise_out_of_the_reach_of_the_table(gas, table, view, sun):
    longest = table.declares.valid["view_zenith"][1]
    height = brentq(lambda z: mass(z, view, sun) - mass(z, longest), 0.0, 10e3)
    paths = [to_space(z, view) + to_space(z, sun) for z in height + np.array([-6.0, -2.0, 2.0, 6.0])]
    table.transmittance(WAVENUMBER, paths[:2])
    for path in paths[2:]:
        with pytest.raises(ProviderError, match="air mass"):
            table.transmittance(WAVENUMBER, [path])
    # By 4 m it changes about as much above that height, below it, and across it.
    below, across, above = np.diff(gas.transmittance(WAVENUMBER, paths), axis=0)
    np.testing.assert_allclose(across, 0.5 * (below + above), rtol=0.2, atol=1e-6)


def test_suns_beyond_the_angles_of_the_table_continue_its_longest_paths(gas, table):
    zeniths = (85.0, 87.0, 88.0, 89.0, 89.9)
    paths = [to_space(0.0, 20.0) + to_space(0.0, sun) for sun in zeniths]
    with pytest.raises(ProviderError, match="air mass"):
        table.transmittance(WAVENUMBER, paths[-2:-1])
    found = gas.transmittance(WAVENUMBER, paths)
    assert np.all(np.diff(found, axis=0) < 1e-30)  # at which the table ends
    assert np.all(found > 0.0)
    # ln(-ln T) rises with ln(air mass) by the exponent, which is that of a power of at most 1 (weak absorption).
    slope = np.log(np.log(found[4]) / np.log(found[3])) / np.log(mass(0.0, 20.0, 89.9) / mass(0.0, 20.0, 89.0))
    assert np.all((slope > 0.2 - 1e-9) & (slope < 1.0 + 1e-9))


def test_what_a_provider_refuses_for_another_reason_follows_the_fit(table):
    class SingleLegs:
        declares = table.declares

        def transmittance(self, wavenumber_cm1, paths):
            if any(len(path.legs) > 1 for path in paths):
                raise ProviderError("single legs only")
            return table.transmittance(wavenumber_cm1, paths)

    found = PowerLawGas(SingleLegs(), PROFILE).transmittance(WAVENUMBER, [SUNLIT])
    # A few percent from what the table says.
    np.testing.assert_allclose(found, table.transmittance(WAVENUMBER, [SUNLIT]), rtol=0, atol=0.05)
    assert np.all(found != table.transmittance(WAVENUMBER, [SUNLIT]))


@pytest.mark.parametrize("zenith", [30.0, 62.5, 88.0])
def test_light_of_the_air_below_a_path_is_not_that_of_the_thermosphere(gas, zenith):
    # The highest layer has 360 K and no gas: at 1.7 um, 1e-3 of its emission would be most of the radiance.
    wavenumber = np.array([5575.0, 5855.0, 6120.0])
    air = Air(gas, PROFILE, wavenumber)
    front = air.crossed([[to_space(0.0, 62.5)]])
    seen = air.leg(front, air.transmittance(front), (zenith,), (0.0,), (SPACE,), downward=False)
    lowest = planck(wavenumber, float(PROFILE.temperature_K[0]))
    assert np.all(seen.emission[0] <= (air.transmittance(front) - seen.transmittance)[0] * lowest)
