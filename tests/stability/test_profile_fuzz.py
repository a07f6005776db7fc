"""Any table of numbers becomes a sound profile or is refused on purpose."""

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scenario_space import inversions

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.band_model.absorber_density import level_state
from hcss_twin.models.atmosphere.band_model.absorption import read_coefficients
from hcss_twin.models.atmosphere.band_model.layers import LayeredAir
from hcss_twin.models.atmosphere.inversion import with_inversion
from hcss_twin.models.atmosphere.moist_air import relative_humidity, water_vapour_column_kg_m2
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.parameters import BandModelParameters
from hcss_twin.physics.paths import SPACE, Leg, Path
from hcss_twin.physics.profile import EARTH_RADIUS_M, GASES
from hcss_twin.scenario.atmosphere import InversionSection

COEFFICIENTS = read_coefficients(Catalog().find("lowtran7-band-model", "atmospheres", ".nc"))

HEADS = {
    "altitude_m": st.floats(-10, 130_000),
    "altitude_km": st.floats(0, 120),
    "geopotential_height_m": st.floats(0, 90_000),
    "pressure_hPa": st.one_of(st.floats(0, 1100), st.floats(1e-12, 1)),
    "temperature_K": st.floats(90, 1600),
    "temperature_C": st.floats(-90, 40),
    "relative_humidity_percent": st.floats(0, 130),
    "dewpoint_C": st.floats(-150, 60),
    "mixing_ratio_g_kg": st.floats(0, 250),
    "h2o": st.floats(0, 1.1),
    "o3_ppmv": st.floats(0, 20),
}


@st.composite
def tables(draw):
    heads = draw(st.lists(st.sampled_from(list(HEADS)), min_size=2, max_size=5, unique=True))
    size = draw(st.integers(1, 8))
    columns = []
    for head in heads:
        values = draw(st.lists(HEADS[head], min_size=size, max_size=size))
        # Mostly sorted, so that something gets past the first check.
        order = draw(st.sampled_from([None, "up", "down"]))
        if head.startswith(("altitude", "geopotential")) and order:
            values = sorted(values)
        if head.startswith(("pressure", "temperature", "dew")) and order:
            values = sorted(values, reverse=True)
        columns.append(values)
    rows = [",".join(repr(value) for value in row) for row in zip(*columns, strict=True)]
    return "\n".join([",".join(heads), *rows])


@st.composite
def dry_soundings(draw):
    """Levels that are sorted, dense and dry pass, so that what follows them is exercised."""
    levels = draw(st.lists(st.tuples(st.floats(1e-6, 0.5), st.floats(130, 330)), min_size=1, max_size=30))
    rows, pressure = ["1001,288,0"], 1001.0
    for step, temperature in levels:
        pressure *= float(np.exp(-step))
        rows.append(f"{pressure!r},{temperature!r},0")
    return "\n".join(["pressure_hPa,temperature_K,h2o", *rows])


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.one_of(tables(), dry_soundings(), st.text(max_size=80)))
def test_a_sound_profile_or_a_refusal(tmp_path, text):
    path = tmp_path / "any.csv"
    path.write_text(text, encoding="utf-8")
    try:
        profile = load_profile("any.csv", Catalog(base=tmp_path))
        refusal = None
    except CatalogError as error:
        refusal = str(error)
    if refusal is not None:
        assert "1001,288,0" not in text or "gap" in refusal or "does not" in refusal, refusal
        assert "any.csv" in refusal
        assert len(refusal) < 1000
        return
    assert profile.altitude_m[0] == 0
    assert profile.altitude_m[-1] >= 100_000
    assert np.all(np.diff(profile.altitude_m) > 0)
    assert np.all(np.diff(profile.pressure_Pa) < 0)
    assert set(profile.mixing_ratio) == set(GASES)
    for values in (profile.pressure_Pa, profile.temperature_K, *profile.mixing_ratio.values()):
        assert np.all(np.isfinite(values))
    humidity = relative_humidity(profile.mixing_ratio["h2o"], profile.pressure_Pa, profile.temperature_K)
    assert humidity.max() <= 1.06
    assert water_vapour_column_kg_m2(profile) >= 0
    check_amounts(profile)


def check_amounts(profile):
    """Every ray has amounts of 0 or more, and more the more it is inclined."""
    air = LayeredAir(level_state(profile, COEFFICIENTS, BandModelParameters()), EARTH_RADIUS_M)
    for lower in (0.0, 0.5 * float(profile.altitude_m[1])):
        amounts = air.amounts([Path((Leg(lower, SPACE, zenith),)) for zenith in (0.0, 60.0, 85.0, 89.9)])
        gases = amounts[:, : COEFFICIENTS.exponent.size]
        assert np.all(np.isfinite(amounts))
        assert np.all(gases >= 0.0)
        assert np.all(np.diff(gases, axis=0) >= 0.0)


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(Catalog().names("atmospheres", ".csv")), inversions())
def test_air_under_any_inversion_has_positive_absorber_amounts(name, given):
    section = InversionSection(**given)
    try:
        profile = with_inversion(load_profile(name, Catalog()), section, section.surface_temperature)
    except CatalogError:  # unstable above
        return
    check_amounts(profile)
