"""Laws of transmittance, and smoothness, of the band model with coefficients fitted to RRTMGP.

``python tests/physics/test_laws_of_fitted_band_model.py`` tests 2 million random cases.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog, catalog_root
from hcss_twin.models.atmosphere.band_model.absorption import read_coefficients
from hcss_twin.models.atmosphere.band_model.provider import BandModelTransmittance
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.parameters import COEFFICIENTS, BandModelParameters
from hcss_twin.physics.paths import Leg, to_space
from hcss_twin.physics.paths import Path as AirPath
from hcss_twin.physics.profile import Profile
from hcss_twin.providers import AtmosphereInputs

CATALOG = Catalog()
PROFILES = {name: load_profile(name, CATALOG) for name in ("tropical", "us-standard-1976", "subarctic-winter")}
CHANNELS = read_coefficients(catalog_root() / "atmospheres" / f"{COEFFICIENTS['rrtmgp']}.nc").exponent.size
LAYERS_M = (0.0, 500.0, 1000.0, 3000.0, 6000.0, 10_000.0, 20_000.0, 50_000.0)


def provider(profile: Profile, coefficients: str = "rrtmgp", aerosol: str = "none") -> BandModelTransmittance:
    parameters = BandModelParameters(file=COEFFICIENTS[coefficients], aerosol=aerosol)  # type: ignore[arg-type]
    return BandModelTransmittance(AtmosphereInputs(profile, CATALOG), parameters)


@pytest.fixture(scope="module", params=sorted(PROFILES))
def air(request: pytest.FixtureRequest) -> tuple[BandModelTransmittance, Array]:
    gas = provider(PROFILES[request.param])
    return gas, gas.declares.native_grid_cm1


def random_cases(gas: BandModelTransmittance, wavenumber: Array, random: np.random.Generator) -> tuple[int, float]:
    """Return how many cases were tried, and the largest rise of transmittance.

    To a random path of one to three legs a leg, a piece of a leg or an amount is added; each wavenumber is a case.
    """

    def leg() -> Leg:
        low, high = np.sort(random.uniform(0.0, random.choice((1e3, 12e3, 60e3)), 2)).tolist()
        return Leg(low, high, float(random.uniform(0.0, 85.0)))

    legs = [leg() for _ in range(random.integers(1, 4))]
    first = legs[0]
    lower = Leg(float(random.uniform(0.0, first.lower_m)), first.upper_m, first.zenith_deg)
    seen = gas.transmittance(wavenumber, [AirPath(tuple(each)) for each in (legs, [*legs, leg()], [lower, *legs[1:]])])
    amounts = np.repeat(gas.absorber_amounts([AirPath(tuple(legs))]), 4, axis=0)
    # of channels only: the continuum of O2 has terms of both signs, as in LOWTRAN7
    columns = random.integers(0, CHANNELS, 3)
    amounts[[1, 2, 3], columns] *= random.uniform(1.0, 5.0, 3)
    scaled = gas.transmittance_of_amounts(wavenumber, amounts)
    assert np.all((seen >= 0.0) & (seen <= 1.0))
    return 5 * wavenumber.size, float(max(np.max(seen[1:] - seen[0]), np.max(scaled[1:] - scaled[0])))


def test_transmittance_never_rises_with_legs_levels_or_amounts(air):
    gas, wavenumber = air
    random = np.random.default_rng(5)
    assert max(random_cases(gas, wavenumber, random)[1] for _ in range(8)) <= 1e-15


def test_the_largest_step_between_wavenumbers_is_not_larger_than_that_of_lowtran7():
    steps = dict.fromkeys(COEFFICIENTS, 0.0)
    for coefficients, profile in product(COEFFICIENTS, PROFILES.values()):
        gas = provider(profile, coefficients)
        seen = gas.transmittance(gas.declares.native_grid_cm1, [to_space(low, 30.0) for low in LAYERS_M[:6]])
        steps[coefficients] = max(steps[coefficients], float(np.max(np.abs(np.diff(seen, axis=1)))))
    assert steps["rrtmgp"] <= steps["lowtran7"]


if __name__ == "__main__":
    dice = np.random.default_rng(1)
    airs = [(each := provider(profile), each.declares.native_grid_cm1) for profile in PROFILES.values()]
    tried, largest = 0, -np.inf
    while tried < 2_000_000:
        number, rise = random_cases(*airs[dice.integers(len(airs))], dice)
        tried, largest = tried + number, max(largest, rise)
    print(f"{tried} cases; largest rise of transmittance {largest:.1e}")
