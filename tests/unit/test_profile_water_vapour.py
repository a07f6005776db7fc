"""Column amount of water vapour and its scaling."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.moist_air import (
    BOLTZMANN_J_K,
    from_mixing_ratio,
    from_specific_humidity,
    largest_factor,
    relative_humidity,
    water_vapour_column_kg_m2,
    with_water_vapour,
)
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.physics.profile import Profile

STANDARD = load_profile("us-standard-1976", Catalog())
MODELS = Catalog().names("atmospheres", ".csv")


def test_column_of_an_exponential_layer_is_density_times_scale_height():
    altitude = np.array([0.0, 700.0, 1000.0, 5000.0, 40_000.0])
    density = 10.0 * np.exp(-altitude / 2000.0)  # g m-3
    temperature = np.full(5, 280.0)
    pressure = 1e5 * np.exp(-altitude / 8000.0)
    moles = density / 18.01528 * 6.02214076e23 * BOLTZMANN_J_K * temperature / pressure
    profile = Profile("test", altitude, pressure, temperature, {"h2o": moles})
    assert water_vapour_column_kg_m2(profile) == pytest.approx(20.0, rel=1e-6)


@given(factor=st.floats(0, 1.2))
def test_the_column_is_proportional_to_the_factor(factor):
    scaled = with_water_vapour(STANDARD, factor=factor)
    assert water_vapour_column_kg_m2(scaled) == pytest.approx(factor * water_vapour_column_kg_m2(STANDARD), abs=1e-9)
    assert scaled.mixing_ratio["co2"] is STANDARD.mixing_ratio["co2"]
    assert f"water vapour times {factor:.6g}" in scaled.notes[-1]


@pytest.mark.parametrize("name", MODELS)
def test_a_column_asked_for_is_the_column_had(name):
    profile = load_profile(name, Catalog())
    wanted = 0.8 * water_vapour_column_kg_m2(profile)
    assert water_vapour_column_kg_m2(with_water_vapour(profile, column_kg_m2=wanted)) == pytest.approx(wanted)


@pytest.mark.parametrize("name", MODELS)
def test_the_largest_factor_is_where_the_first_level_reaches_105_percent(name):
    profile = load_profile(name, Catalog())
    limit = largest_factor(profile)
    most = with_water_vapour(profile, factor=limit * (1 - 1e-12))
    humidity = relative_humidity(most.mixing_ratio["h2o"], most.pressure_Pa, most.temperature_K)
    assert humidity.max() == pytest.approx(1.05)
    with pytest.raises(CatalogError, match="closest valid choice"):
        with_water_vapour(profile, factor=limit * 1.001)


def test_what_a_refusal_suggests_is_accepted():
    with pytest.raises(CatalogError) as caught:
        with_water_vapour(STANDARD, column_kg_m2=60.0)
    words = str(caught.value).split()
    factor = float(words[words.index("factor") + 2].rstrip(","))
    column = float(words[-3])
    assert water_vapour_column_kg_m2(with_water_vapour(STANDARD, factor=factor)) < 30
    with_water_vapour(STANDARD, column_kg_m2=column)


def test_dry_air_cannot_be_scaled_to_a_column_and_a_negative_factor_is_refused():
    dry = with_water_vapour(STANDARD, factor=0.0)
    with pytest.raises(CatalogError, match="dry"):
        with_water_vapour(dry, column_kg_m2=10.0)
    with pytest.raises(CatalogError, match="-1"):
        with_water_vapour(STANDARD, factor=-1.0)
    with pytest.raises(ValueError, match="give one"):
        with_water_vapour(STANDARD)


@given(h2o=st.floats(0, 0.05))
def test_mass_and_mole_fractions_count_the_same_molecules(h2o):
    vapour, dry = 18.01528 * h2o, 28.9647 * (1 - h2o)
    assert float(from_mixing_ratio(np.array(vapour / dry))) == pytest.approx(h2o, abs=1e-15)
    assert float(from_specific_humidity(np.array(vapour / (vapour + dry)))) == pytest.approx(h2o, abs=1e-15)
