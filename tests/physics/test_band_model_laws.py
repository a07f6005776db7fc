"""Laws of the band model that need no other program."""

import dataclasses

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog, catalog_root
from hcss_twin.core.errors import CatalogError, ProviderError
from hcss_twin.models.atmosphere.band_model.absorber_density import level_state, relative_humidity
from hcss_twin.models.atmosphere.band_model.absorption import CONTINUA, read_coefficients
from hcss_twin.models.atmosphere.band_model.layers import LayeredAir
from hcss_twin.models.atmosphere.band_model.provider import BandModelTransmittance
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.parameters import BandModelParameters
from hcss_twin.physics.paths import SPACE, Leg, Path, to_space
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import EARTH_RADIUS_M, Profile, slant_length_m
from hcss_twin.providers import AtmosphereInputs

CATALOG = Catalog()
STANDARD = load_profile("us-standard-1976", CATALOG)
COEFFICIENTS = read_coefficients(catalog_root() / "atmospheres" / "lowtran7-band-model.nc")
WAVENUMBER = np.arange(500.0, 14285.0, 65.0)


def provider(profile=STANDARD, **parameters):
    return BandModelTransmittance(AtmosphereInputs(profile, CATALOG), BandModelParameters(**parameters))


def isothermal(temperature_K):
    return dataclasses.replace(STANDARD, temperature_K=np.full_like(STANDARD.temperature_K, temperature_K))


@pytest.fixture(scope="module", params=["none", "maritime"])
def air(request):
    return provider(aerosol=request.param)


def test_no_path_transmits_all(air):
    thin = [Path(), to_space(5e5, 30.0), Path((Leg(1234.0, 1234.0, 60.0),))]
    np.testing.assert_array_equal(air.transmittance(WAVENUMBER, thin), 1.0)
    np.testing.assert_array_equal(air.path_radiance(WAVENUMBER, thin), 0.0)


def test_transmittance_falls_with_every_piece_of_path(air):
    heights = [0.0, 90.0, 1000.0, 2700.0, 7777.0, 15e3, 60e3]
    rising = air.transmittance(WAVENUMBER, [to_space(height, 50.0) for height in heights])
    assert np.all(np.diff(rising, axis=0) >= 0.0)
    slants = air.transmittance(WAVENUMBER, [to_space(0.0, zenith) for zenith in (0, 30, 60, 80, 85, 88)])
    assert np.all(np.diff(slants, axis=0) <= 0.0)
    tops = air.transmittance(WAVENUMBER, [Path((Leg(300.0, top, 40.0),)) for top in (400.0, 900.0, 5e3, SPACE)])
    assert np.all(np.diff(tops, axis=0) <= 0.0)


@pytest.mark.parametrize("parameters", [{}, {"file": "lowtran7-band-model"}], ids=["fitted", "lowtran7"])
@pytest.mark.parametrize("aerosol", ["none", "maritime"])
@pytest.mark.parametrize(("zenith", "base"), [(0.0, 0.0), (60.0, 630.0), (85.0, 10e3), (85.0, 0.0)])
def test_isothermal_air_closes(aerosol, zenith, base, parameters):
    gas = provider(isothermal(251.3), aerosol=aerosol, **parameters)
    native = gas.declares.native_grid_cm1
    path = [to_space(base, zenith)]
    source = planck(native, 251.3)
    black = (1.0 - gas.transmittance(native, path)) * source
    rounding = {"rtol": 1e-10, "atol": 1e-10 * float(source.min())}
    np.testing.assert_allclose(gas.path_radiance(native, path), black, **rounding)
    sky = gas.sky_radiance(native, path)
    if aerosol == "none" or parameters:
        np.testing.assert_allclose(sky, black, **rounding)
    else:  # the sky lacks what aerosol scatters
        depth = gas.scattering_of_amounts(native, gas.absorber_amounts(path))[0]
        assert np.all((sky < black) & (sky >= black - 1.001 * depth * source))


def test_isothermal_transmittance_does_not_depend_on_the_direction_of_light(air):
    path = [to_space(0.0, 30.0)]
    one = air.path_radiance(WAVENUMBER, path) - air.sky_radiance(WAVENUMBER, path)
    assert np.any(np.abs(one) > 1e-4)  # the standard atmosphere is not isothermal


def test_double_path_transmits_more_than_the_product_where_lines_saturate(air):
    view, sun = to_space(0.0, 20.0), to_space(0.0, 50.0)
    one, other, both = air.transmittance(WAVENUMBER, [view, sun, view + sun])
    assert np.all(both >= one * other - 1e-12)
    assert np.max(both - one * other) > 0.05


def test_one_band_obeys_the_double_exponential():
    """ln ln 1/T against ln of the number of crossings has the band exponent as its slope (CO2, 2349 cm-1)."""
    dry = dataclasses.replace(STANDARD, mixing_ratio={**STANDARD.mixing_ratio, "h2o": 1e-12 * np.ones(50)})
    gas = provider(dry, aerosol="none")
    path = to_space(25e3, 0.0)
    once, twice = gas.transmittance(np.array([2390.0]), [path, path + path])
    slope = np.log(np.log(twice[0]) / np.log(once[0])) / np.log(2.0)
    assert slope == pytest.approx(0.6033, abs=0.01)  # exponent of channel 38; N2 adds a trace


def test_column_of_air_weighs_what_the_barometer_says():
    """Molecular-scattering amount = p / (g rho0), 7.99 km of air at standard conditions."""
    state = level_state(STANDARD, COEFFICIENTS, BandModelParameters(aerosol="none"))
    amounts = LayeredAir(state, EARTH_RADIUS_M).amounts([to_space(0.0, 0.0)])
    column = amounts[0, COEFFICIENTS.exponent.size + CONTINUA.index("rayleigh")]
    assert column == pytest.approx(STANDARD.pressure_Pa[0] / (9.80665 * 1.2929) / 1e3, rel=0.005)


def test_rayleigh_extinction_at_700_nm():
    """Column of R. E. Bird and C. Riordan, J. Climate Appl. Meteor. 25, 87 (1986), eq 2-4."""
    row = COEFFICIENTS.absorption[COEFFICIENTS.exponent.size + CONTINUA.index("rayleigh"), -1]
    wavelength = 1e4 / COEFFICIENTS.wavenumber_cm1[-1]
    bird = 1.0 / (wavelength**4 * (115.6406 - 1.335 / wavelength**2))
    assert row * 7.996 == pytest.approx(bird, rel=0.02)


def test_refractive_index_of_standard_air():
    """n - 1 = 2.74e-4 at 15 C, 1013.25 mb and 1.35 um (P. E. Ciddor, Appl. Opt. 35, 1566, 1996)."""
    state = level_state(STANDARD, COEFFICIENTS, BandModelParameters(aerosol="none"))
    assert state.refractivity[0] == pytest.approx(2.733e-4, rel=0.003)


def test_saturation_density_of_water_vapour():
    """17.30 g m-3 at 20 C, 4.85 g m-3 at 0 C (Smithsonian Meteorological Tables)."""
    np.testing.assert_allclose(
        relative_humidity(np.array([17.30, 4.85]) / 2, np.array([293.15, 273.15])), 50.0, rtol=0.01
    )


@pytest.mark.parametrize("zenith", [0.0, 45.0, 70.0, 85.0])
def test_without_refraction_rays_are_straight(zenith):
    state = level_state(STANDARD, COEFFICIENTS, BandModelParameters(aerosol="none"))
    state = dataclasses.replace(state, refractivity=np.full(STANDARD.altitude_m.size, 1e-30))
    air = LayeredAir(state, EARTH_RADIUS_M)
    layers = air.between(0.0, SPACE)
    length = air.slant(layers, 0.0, np.array([zenith]))[0] * layers.thickness_m
    bottom, top = layers.radius_m[:, 0] - EARTH_RADIUS_M, layers.radius_m[:, 2] - EARTH_RADIUS_M
    np.testing.assert_allclose(length, slant_length_m(bottom, top, zenith), rtol=1e-6)


def test_refraction_lengthens_the_path_to_the_low_sun():
    with_air = level_state(STANDARD, COEFFICIENTS, BandModelParameters(aerosol="none"))
    without = dataclasses.replace(with_air, refractivity=np.full(STANDARD.altitude_m.size, 1e-30))
    air, vacuum = (LayeredAir(state, EARTH_RADIUS_M) for state in (with_air, without))
    column = COEFFICIENTS.exponent.size + CONTINUA.index("rayleigh")
    ratio = [a.amounts([to_space(0.0, 85.0), to_space(0.0, 0.0)])[:, column] for a in (air, vacuum)]
    airmass, straight = (r[0] / r[1] for r in ratio)
    # F. Kasten and A. T. Young, Appl. Opt. 28, 4735 (1989): 10.31 for apparent elevation 5 degrees.
    assert airmass == pytest.approx(10.306, rel=0.01)
    assert airmass > straight * 1.001


def test_finer_levels_of_the_same_air_change_little():
    altitude = np.unique(np.concatenate((STANDARD.altitude_m, np.arange(0.0, 25e3, 200.0))))

    def logarithmic(values):
        return np.exp(np.interp(altitude, STANDARD.altitude_m, np.log(values)))

    fine = Profile(
        "fine",
        altitude,
        logarithmic(STANDARD.pressure_Pa),
        np.interp(altitude, STANDARD.altitude_m, STANDARD.temperature_K),
        {gas: logarithmic(ratio) for gas, ratio in STANDARD.mixing_ratio.items()},
    )
    path = [to_space(0.0, 40.0)]
    # LOWTRAN7's haze fades linearly within the one layer above 2 km: there the levels do matter.
    for aerosol, tolerance in (("none", 1.1e-3), ("maritime", 2e-2)):
        one, two = (provider(profile, aerosol=aerosol) for profile in (STANDARD, fine))
        difference = one.transmittance(WAVENUMBER, path) - two.transmittance(WAVENUMBER, path)
        assert np.max(np.abs(difference)) < tolerance


def test_haze_grows_as_visibility_falls():
    path = [to_space(0.0, 30.0)]
    hazy = [provider(visibility_km=km).transmittance(WAVENUMBER, path) for km in (50.0, 30.0, 23.0, 8.0, 2.0)]
    assert np.all(np.diff(np.concatenate(hazy), axis=0) < 0.0)
    assert np.all(provider(aerosol="none").transmittance(WAVENUMBER, path) > hazy[0])


def test_scattered_sunlight_is_symmetric_and_brightest_forward():
    hazy, clear = provider(), provider(aerosol="none")
    path = [to_space(0.0, 40.0)]
    near = [gas.solar_path_radiance(WAVENUMBER, path, 40.0, 0.0)[0] for gas in (hazy, clear)]
    far = [gas.solar_path_radiance(WAVENUMBER, path, 40.0, 180.0)[0] for gas in (hazy, clear)]
    window = np.argmin(np.abs(WAVENUMBER - 9600.0))
    assert near[0][window] > near[1][window] > 0.0
    # A Henyey-Greenstein haze sends more light to a sensor facing the sun; molecules depend on the cosine's square.
    assert far[0][window] > near[0][window]
    cosine = {0.0: -1.0, 180.0: -np.cos(np.radians(80.0))}
    phase = {azimuth: 1.0279 + 0.9721 * value**2 for azimuth, value in cosine.items()}
    assert near[1][window] / far[1][window] == pytest.approx(phase[0.0] / phase[180.0], rel=1e-3)


def test_scattered_sunlight_of_a_thin_atmosphere():
    """Optical depth times phase function over the view's cosine, where hardly anything absorbs."""
    value = provider(aerosol="none").solar_path_radiance(np.array([9600.0]), [to_space(0.0, 0.0)], 30.0, 0.0)[0, 0]
    depth = COEFFICIENTS.absorption[COEFFICIENTS.exponent.size + CONTINUA.index("rayleigh"), 1820] * 7.99
    phase = 3 / (16 * np.pi) * 2 / 2.0279 * (1.0279 + 0.9721 * np.cos(np.radians(30.0)) ** 2)
    assert value == pytest.approx(depth * phase, rel=0.03)


def test_low_sun_is_refused(air):
    with pytest.raises(ProviderError, match="the sun is"):
        air.solar_path_radiance(WAVENUMBER, [to_space(0.0, 80.0)], 87.0, 180.0)


def test_gases_a_profile_lacks_are_the_standard_ones_and_said_so():
    bare = dataclasses.replace(STANDARD, mixing_ratio={"h2o": STANDARD.mixing_ratio["h2o"]})
    assert any("co2" in note and "1976" in note for note in provider(bare).declares.notes)
    path = [to_space(0.0, 30.0)]
    np.testing.assert_allclose(
        provider(bare).transmittance(WAVENUMBER, path), provider().transmittance(WAVENUMBER, path), atol=2e-3
    )


def test_a_profile_without_water_vapour_is_refused():
    with pytest.raises(ProviderError, match="no column h2o"):
        provider(dataclasses.replace(STANDARD, mixing_ratio={}))


def test_the_sun_fades_smoothly_down_to_the_horizon(air):
    angles = (85.0, 88.0, 89.0, 89.9, 89.9999, 89.99999999)
    fading = air.transmittance(WAVENUMBER, [to_space(0.0, 20.0) + to_space(0.0, angle) for angle in angles])
    assert np.all(np.diff(fading, axis=0) <= 1e-9)
    assert np.max(np.abs(fading[-1] - fading[-2])) < 1e-4


def test_outside_the_declared_range_is_an_error(air):
    with pytest.raises(ProviderError, match="allowed 0 to 88 deg"):
        air.path_radiance(WAVENUMBER, [to_space(0.0, 88.5)])
    with pytest.raises(ProviderError, match="allowed 500 to 14285 cm-1"):
        air.transmittance(np.array([450.0, 900.0]), [to_space(0.0, 0.0)])
    with pytest.raises(ProviderError, match="single legs"):
        air.path_radiance(WAVENUMBER, [to_space(0.0, 0.0) + to_space(0.0, 10.0)])


def test_another_file_is_refused():
    with pytest.raises(CatalogError, match="hcss-band-model"):
        read_coefficients(catalog_root() / "atmospheres" / "us-standard-1976-lowtran7.nc")


def test_amounts_of_legs_add_to_those_of_paths_and_stand_for_them(air):
    legs = [Leg(0.0, 2_300.0, 20.0), Leg(2_300.0, SPACE, 20.0), Leg(1_000.0, SPACE, 55.0)]
    wavenumber = np.array([800.0, 2_345.0, 2_347.5, 3_500.0])
    path = Path(tuple(legs))
    added = sum(air.absorber_amounts([Path((leg,))]) for leg in legs)
    np.testing.assert_allclose(air.absorber_amounts([path]), added, rtol=1e-13)
    np.testing.assert_array_equal(
        air.transmittance_of_amounts(wavenumber, air.absorber_amounts([path, Path()])),
        air.transmittance(wavenumber, [path, Path()]),
    )


def test_a_leg_has_the_same_absorbers_whatever_else_is_asked():
    several = [Leg(500.0, upper, zenith) for upper in (2_000.0, 2_345.6, 10_000.0, SPACE) for zenith in (0.0, 60.0)]
    together = provider().absorber_amounts([Path((leg,)) for leg in several])
    alone = np.concatenate([provider().absorber_amounts([Path((leg,))]) for leg in several])
    np.testing.assert_array_equal(together, alone)


def test_few_scattered_wavenumbers_have_the_values_of_the_whole_grid(air):
    whole = air.declares.native_grid_cm1[100:1500]
    paths = [to_space(0.0, 30.0), to_space(4_321.0, 0.0)]
    some = np.sort(np.concatenate((whole[[3, 500, 501, 1200]], [0.5 * (whole[700] + whole[701])])))
    exact = air.transmittance(whole, paths)
    expected = np.array([np.interp(some, whole, row) for row in exact])
    np.testing.assert_allclose(air.transmittance(some, paths), expected, rtol=1e-12)
    np.testing.assert_allclose(
        air.path_radiance(some, paths),
        [np.interp(some, whole, row) for row in air.path_radiance(whole, paths)],
        rtol=1e-12,
    )


@pytest.mark.parametrize("region_top_m", [2e3, 10e3])
def test_scattered_sunlight_does_not_jump_where_a_region_of_aerosol_begins(region_top_m):
    maritime = provider(aerosol="maritime")
    targets = [to_space(region_top_m + offset, 20.0) for offset in (-0.01, 0.0, 0.01)]
    below, at, above = maritime.solar_path_radiance(np.array([2500.0, 3000.0, 4500.0]), targets, 40.0, 60.0)
    np.testing.assert_allclose(at, below, rtol=1e-4)
    np.testing.assert_allclose(at, above, rtol=1e-4)
