"""Against the shipped table (made through another wrapper), LOWTRAN7's own listings, and closed forms."""

import dataclasses

import netCDF4
import numpy as np
import pytest
from hcss_author import sample_profile
from hcss_lowtran7.build import build
from hcss_lowtran7.deck import SLANT, SOLAR_RADIANCE, TO_SPACE, Air, Haze, Ray, SunGeometry, deck
from hcss_lowtran7.model_air import BUILT_IN, agrees, built_in
from hcss_lowtran7.program import AS_IT_IS, Job, run
from hcss_lowtran7.source import find_source
from hcss_lowtran7.tape7 import read_tape7

from hcss_twin.providers import (
    SPACE,
    AtmosphereInputs,
    Catalog,
    Leg,
    Path,
    ProviderError,
    local_zenith_deg,
    planck,
    to_space,
)

pytestmark = pytest.mark.usefixtures("compiler")

INFRARED_CM1 = np.arange(700.0, 3800.0, 5.0)


@pytest.fixture(scope="module")
def table():
    path = Catalog().find("us-standard-1976-lowtran7", "atmospheres", ".nc")
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        return {name: variable[:].astype(float) for name, variable in file.variables.items()}


def nodes(table):
    heights, angles = table["target_altitude_m"][::4], table["zenith_deg"][::2]
    paths = [to_space(float(height), float(angle)) for height in heights for angle in angles]
    return paths, (slice(None, None, 4), slice(None, None, 2))


def test_transmittance_is_that_of_the_shipped_table(make, table):
    paths, chosen = nodes(table)
    expected = table["transmittance"][chosen]
    found = make().transmittance(table["wavenumber_cm1"], paths).reshape(expected.shape)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-4)


def test_path_radiance_is_that_of_the_shipped_table(make, table):
    # The table's rays were traced downwards, these upwards.
    paths, chosen = nodes(table)
    wavenumber = table["wavenumber_cm1"]
    expected = table["path_radiance"][chosen]
    found = make().path_radiance(wavenumber, paths).reshape(expected.shape)
    for low_um, high_um in ((2.7, 3.0), (3.0, 5.0), (8.0, 14.0)):
        band = (wavenumber >= 1e4 / high_um) & (wavenumber <= 1e4 / low_um)
        np.testing.assert_allclose(found[..., band].sum(-1), expected[..., band].sum(-1), rtol=5e-4)


def test_double_precision_only_removes_noise(make):
    paths = [to_space(height, angle) for height in (0.0, 1000.0, 6000.0) for angle in (0.0, 40.0, 75.0)]
    single, double = make(), make(precision="double")
    one, other = (provider.transmittance(INFRARED_CM1, paths) for provider in (single, double))
    np.testing.assert_allclose(one, other, rtol=0, atol=3e-4)
    # The vertical needs no ray tracing.
    np.testing.assert_allclose(one[0], other[0], rtol=0, atol=1e-5)


@pytest.mark.parametrize("height_m", [0.0, 1000.0, 6000.0])
@pytest.mark.parametrize(("view", "sun"), [(0.0, 30.0), (0.0, 60.0), (40.0, 45.0)])
def test_two_way_transmittance_is_lowtran7s_own(make, height_m, view, sun):
    """A run with scattered sunlight lists the transmittance sun - target - sensor, to four decimals."""
    down, incident = local_zenith_deg(view, height_m), local_zenith_deg(sun, height_m)
    at_sensor = local_zenith_deg(view, 100_000.0)
    # The sun at right angles to the line of sight; its zenith angle where the ray leaves the air.
    beyond = np.degrees(np.arccos(np.cos(np.radians(incident)) / np.cos(np.radians(down - at_sensor))))
    cards = deck(
        Air(6),
        Ray(SLANT, 100.0, height_m / 1000.0, 180.0 - at_sensor),
        SOLAR_RADIANCE,
        (INFRARED_CM1[0], INFRARED_CM1[-1]),
        SunGeometry(90.0, float(beyond), 100),
        listing=True,
    )
    output = run(build(find_source()), [Job(AS_IT_IS, (cards,))], INFRARED_CM1[0], INFRARED_CM1[-1])
    expected = read_tape7(output.tape7, SOLAR_RADIANCE)["sun_to_end_to_observer_transmittance"]
    path = to_space(height_m, view) + to_space(height_m, sun)
    one, other, both = make().transmittance(INFRARED_CM1, [to_space(height_m, view), to_space(height_m, sun), path])
    np.testing.assert_allclose(both, expected, rtol=0, atol=3e-4)
    assert np.max(both - one * other) > 0.03, "a product of legs would have passed"


def test_aerosol_is_that_of_lowtran7s_listing(make):
    haze = Haze(4, 0, 10.0)
    cards = deck(Air(6, None, haze), Ray(TO_SPACE, 0.0, 0.0, 0.0), 0, (2400.0, 2900.0), listing=True)
    output = run(build(find_source()), [Job(AS_IT_IS, (cards,))], 2400.0, 2900.0)
    listed = read_tape7(output.tape7, 0)
    path = [to_space(0.0, 0.0)]
    wavenumber = listed["wavenumber_cm1"]
    hazy = make(aerosol="maritime", visibility_km=10).transmittance(wavenumber, path)[0]
    clear = make().transmittance(wavenumber, path)[0]
    np.testing.assert_allclose(hazy, listed["transmittance"], rtol=0, atol=6e-5)
    np.testing.assert_allclose((hazy / clear)[clear > 0.3], listed["aerosol"][clear > 0.3], rtol=0, atol=2e-4)
    assert listed["aerosol"].max() < 0.95


def test_less_visibility_transmits_less(make):
    window = np.array([2500.0])
    values = [
        make(aerosol="maritime", visibility_km=visibility).transmittance(window, [to_space(0.0, 0.0)])[0, 0]
        for visibility in (5, 23, 50)
    ]
    assert np.all(np.diff(values) > 0.005)


def test_profile_of_the_built_in_values_gives_the_built_in_transmittance(make, standard):
    renamed = AtmosphereInputs(dataclasses.replace(standard.profile, name="radiosonde"), standard.catalog)
    provider, original = make(renamed, precision="double"), make(precision="double")
    assert any("radiosonde on 33 levels of its 50" in note for note in provider.declares.notes)
    assert any("own model atmosphere 6" in note for note in original.declares.notes)
    paths = [to_space(0.0, 0.0), to_space(0.0, 70.0), to_space(3000.0, 40.0)]
    found, expected = (source.transmittance(INFRARED_CM1, paths) for source in (provider, original))
    np.testing.assert_allclose(found, expected, rtol=0, atol=3e-4)


def test_profile_with_another_gas_is_not_taken_for_the_built_in_one(make, standard):
    ratios = dict(standard.profile.mixing_ratio)
    ratios["co2"] = 2.0 * ratios["co2"]
    changed = dataclasses.replace(standard.profile, mixing_ratio=ratios)
    provider = make(AtmosphereInputs(changed, standard.catalog))
    wing = np.array([2395.0])
    path = [to_space(0.0, 0.0)]
    assert provider.transmittance(wing, path)[0, 0] < make().transmittance(wing, path)[0, 0] - 0.02


@pytest.mark.parametrize(("name", "model"), BUILT_IN.items())
def test_catalog_profiles_are_recognised_as_built_in(standard, name, model):
    """The tropical atmosphere is not the US Standard, and so on; those in the catalog are LOWTRAN7's."""
    from hcss_twin.models.atmosphere.profile_file import load_profile

    model_profile = built_in(build(find_source()), model)
    assert agrees(model_profile, model_profile)
    assert agrees(standard.profile, model_profile) == (model == 6)
    if name in Catalog().names("atmospheres", ".csv"):
        assert agrees(load_profile(name, Catalog()), model_profile)


def test_isothermal_atmosphere_emits_one_minus_transmittance_times_planck(make):
    inputs = AtmosphereInputs(sample_profile(temperature_K=270.0), Catalog())
    provider = make(inputs, precision="double")
    legs = [to_space(0.0, 0.0), to_space(0.0, 60.0), to_space(5000.0, 30.0)]
    radiance = provider.path_radiance(INFRARED_CM1, legs)
    emitted = (1.0 - provider.transmittance(INFRARED_CM1, legs)) * planck(INFRARED_CM1, 270.0)
    # LOWTRAN7 (function BBFN) has 1.190956e-16 W cm2 sr-1 and 1.43879 cm K for the radiation constants.
    ratio = 1.190956 / 1.191042972 * np.expm1(1.438776877 / 270.0 * INFRARED_CM1)
    ratio /= np.expm1(1.43879 / 270.0 * INFRARED_CM1)
    np.testing.assert_allclose(radiance, emitted * ratio, rtol=2.1e-5)  # its sum ends where T is below 1e-5


def test_a_leg_cut_in_two_is_the_whole_leg(make):
    provider = make(precision="double")
    cut = Path((Leg(0.0, 2000.0, 0.0), Leg(2000.0, SPACE, 0.0)))  # at a level of the atmosphere
    whole, parts = provider.transmittance(INFRARED_CM1, [to_space(0.0, 0.0), cut])
    np.testing.assert_allclose(parts, whole, rtol=0, atol=1e-6)


def test_grazing_paths_and_paths_above_the_air_are_traced(make):
    paths = [to_space(0.0, 89.9), to_space(20_000.0, 85.0), to_space(99_000.0, 0.0), to_space(200_000.0, 0.0)]
    grazing, high, thin, none = make().transmittance(INFRARED_CM1, paths)
    assert 0.0 < grazing.max() < high.max() < thin.max() <= 1.0
    assert np.all(none == 1.0)


def test_untraceable_path_is_named():
    cards = deck(Air(6), Ray(SLANT, 5.0, 1.0, 30.0))
    with pytest.raises(ProviderError, match=r"cannot trace.*5\.0000000"):
        run(build(find_source()), [Job(0, (cards,))], 2000.0, 2100.0)


def test_wavenumber_outside_is_refused(make):
    with pytest.raises(ProviderError, match="allowed 100 to 30000"):
        make().transmittance(np.array([90.0]), [to_space(0.0, 0.0)])


def test_path_radiance_of_two_legs_is_refused(make):
    with pytest.raises(ProviderError, match="2 legs"):
        make().path_radiance(INFRARED_CM1, [to_space(0.0, 0.0) + to_space(0.0, 10.0)])
