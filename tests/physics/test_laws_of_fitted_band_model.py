"""Laws of the band model with coefficients fitted to RRTMGP: those of any transmittance, and LOWTRAN7's smoothness."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.band_model.provider import BandModelTransmittance
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.parameters import COEFFICIENTS, BandModelParameters
from hcss_twin.physics.paths import Leg, Path, to_space
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import Profile
from hcss_twin.providers import AtmosphereInputs

CATALOG = Catalog()
PROFILES = {name: load_profile(name, CATALOG) for name in ("tropical", "us-standard-1976", "subarctic-winter")}
LAYERS_M = (0.0, 500.0, 1000.0, 3000.0, 6000.0, 10_000.0, 20_000.0, 50_000.0)


def provider(profile: Profile, coefficients: str = "rrtmgp", aerosol: str = "none") -> BandModelTransmittance:
    parameters = BandModelParameters(file=COEFFICIENTS[coefficients], aerosol=aerosol)  # type: ignore[arg-type]
    return BandModelTransmittance(AtmosphereInputs(profile, CATALOG), parameters)


@pytest.fixture(scope="module", params=sorted(PROFILES))
def air(request: pytest.FixtureRequest) -> tuple[BandModelTransmittance, Array]:
    gas = provider(PROFILES[request.param])
    return gas, gas.declares.native_grid_cm1


def test_nothing_absorbs_nothing(air):
    gas, wavenumber = air
    nothing = [Path(), Path((Leg(3000.0, 3000.0, 40.0),))]
    np.testing.assert_array_equal(gas.transmittance(wavenumber, nothing), 1.0)


def test_transmittance_never_rises_with_legs_levels_or_amounts(air):
    """About 2 million cases: every layer, added at random zenith angles to random paths, at every wavenumber."""
    gas, wavenumber = air
    random = np.random.default_rng(5)
    before = np.ones((1, wavenumber.size))
    path = Path()
    for _ in range(30):
        number = int(random.integers(len(LAYERS_M) - 1))
        path = path + Path((Leg(LAYERS_M[number], LAYERS_M[number + 1], float(random.uniform(0.0, 85.0))),))
        after = gas.transmittance(wavenumber, [path])
        assert np.all(after <= before)
        assert np.all((after >= 0.0) & (after <= 1.0))
        before = after
    amounts = np.vstack([gas.absorber_amounts([to_space(low, 60.0)]) for low in (0.0, 8000.0)])
    some = gas.transmittance_of_amounts(wavenumber, amounts)
    first = gas._absorption._exponent.size  # channels; the continuum of O2 has terms of both signs, as in LOWTRAN7
    for column in range(first):
        more = amounts.copy()
        more[:, column] *= random.uniform(1.0, 3.0)
        assert np.all(gas.transmittance_of_amounts(wavenumber, more) <= some + 1e-15)


def test_transmittance_to_space_rises_with_the_target_and_falls_with_the_zenith_angle(air):
    gas, wavenumber = air
    heights = gas.transmittance(wavenumber, [to_space(low, 50.0) for low in LAYERS_M])
    assert np.all(np.diff(heights, axis=0) >= -1e-15)
    angles = gas.transmittance(wavenumber, [to_space(1000.0, angle) for angle in (0.0, 20.0, 45.0, 60.0, 75.0, 85.0)])
    assert np.all(np.diff(angles, axis=0) <= 1e-15)


def test_isothermal_air_emits_what_it_does_not_transmit():
    profile = replace(PROFILES["tropical"], temperature_K=np.full(PROFILES["tropical"].altitude_m.size, 280.0))
    gas = provider(profile)
    wavenumber = gas.declares.native_grid_cm1[:600]
    paths = [to_space(0.0, 0.0), to_space(3000.0, 70.0)]
    black = planck(wavenumber, 280.0)
    emitted = gas.path_radiance(wavenumber, paths) / black
    np.testing.assert_allclose(emitted, 1.0 - gas.transmittance(wavenumber, paths), rtol=0.0, atol=1e-10)


def test_the_largest_step_between_wavenumbers_is_not_larger_than_that_of_lowtran7():
    steps = dict.fromkeys(COEFFICIENTS, 0.0)
    for coefficients, profile in product(COEFFICIENTS, PROFILES.values()):
        gas = provider(profile, coefficients)
        seen = gas.transmittance(gas.declares.native_grid_cm1, [to_space(low, 30.0) for low in LAYERS_M[:6]])
        steps[coefficients] = max(steps[coefficients], float(np.max(np.abs(np.diff(seen, axis=1)))))
    assert steps["rrtmgp"] <= steps["lowtran7"]
