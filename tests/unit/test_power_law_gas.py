"""Paths of any kind from a table of paths to space."""

import numpy as np
import pytest

from hcss_twin.atmosphere.parameters import TableParameters
from hcss_twin.atmosphere.profile_file import load_profile
from hcss_twin.atmosphere.table import TableTransmittance
from hcss_twin.catalog import Catalog
from hcss_twin.errors import ProviderError
from hcss_twin.physics.paths import SPACE, Leg, Path, to_space
from hcss_twin.providers import AtmosphereInputs
from hcss_twin.radiance.physical.power_law_gas import PowerLawGas

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


def test_suns_beyond_the_angles_of_the_table_follow_the_law(gas, table):
    low = to_space(0.0, 20.0) + to_space(0.0, 89.5)
    with pytest.raises(ProviderError, match="air mass"):
        table.transmittance(WAVENUMBER, [low])
    found, higher = gas.transmittance(WAVENUMBER, [low, to_space(0.0, 20.0)])
    assert np.all(np.isfinite(found))
    assert np.all(found <= higher)
