"""Equations 8 and 12-20 of the HCSS paper, written out again with plain numbers at one wavenumber, and the
laws the model keeps."""

import math

import numpy as np
import pytest
from scipy import constants

from hcss_twin.core.catalog import Catalog
from hcss_twin.laws.radiance import LawScene
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.parameters import AsPrintedParameters
from hcss_twin.models.radiance.as_printed import AsPrinted
from hcss_twin.providers import (
    AtmosphereDeclaration,
    CloudLayer,
    ColumnSetting,
    Microphysics,
    OpticsDeclaration,
    RadianceInputs,
    SeaDeclaration,
    SingleScattering,
    Sun,
    View,
)

WAVENUMBER = np.array([2500.0])
SUN = Sun(zenith_deg=30.0, azimuth_deg=200.0, distance_au=1.0)
VIEW = View(zenith_deg=40.0, azimuth_deg=50.0)
EXTINCTION, ALBEDO, ASYMMETRY = 0.02, 0.9, 0.85
BRDF, SEA_EMISSIVITY, IRRADIANCE = 0.3, 0.97, 1.5e-3


class Gas:
    """T = exp(-0.1 x number of legs x (1 - height / 20 km)); path radiance from the engine."""

    declares = AtmosphereDeclaration()

    def transmittance(self, wavenumber_cm1, paths):
        depth = [sum(0.1 * (1 - min(leg.lower_m, 2e4) / 2e4) for leg in path.legs) for path in paths]
        return np.exp(-np.array(depth))[:, None] * np.ones(wavenumber_cm1.size)


class Sea:
    declares = SeaDeclaration()

    def emissivity(self, wavenumber_cm1, mu):
        return np.full((mu.size, wavenumber_cm1.size), SEA_EMISSIVITY)

    def brdf(self, wavenumber_cm1, mu_out, mu_in, relative_azimuth):
        return np.full((mu_out.size, wavenumber_cm1.size), BRDF)


class Particles:
    declares = OpticsDeclaration()

    def single_scattering(self, cloud, wavenumber_cm1):
        ones = np.ones(wavenumber_cm1.size)
        return SingleScattering(EXTINCTION * ones, ALBEDO * ones, np.stack([ones, ASYMMETRY * ones]))


def layer(**changes):
    values = {
        "name": "test",
        "base_m": 1000.0,
        "top_m": 3000.0,
        "anchor": "base",
        "thickness_min_m": 1.0,
        "coverage": 0.5,
        "temperature_K": None,
        "microphysics": Microphysics("water", 2.0, 1.0, 1.0, 1e8, (1.0, 50.0)),
    }
    return CloudLayer(**{**values, **changes})


def model(parameters=None, **changes):
    own = {
        "view": VIEW,
        "sun": None,
        "sea": Sea(),
        "sea_temperature_K": 290.0,
        "profile": load_profile("us-standard-1976", Catalog()),
        "transmittance": Gas(),
        "layers": (layer(),),
    }
    setting = ColumnSetting(**{**own, **changes})
    inputs = RadianceInputs(setting, Particles(), lambda wavenumber: np.full(wavenumber.size, IRRADIANCE))
    return LawScene(AsPrinted(inputs, AsPrintedParameters(**(parameters or {}))), setting)


def planck(wavenumber_cm1, temperature):
    v = wavenumber_cm1 * 100
    exponent = constants.h * constants.c * v / (constants.k * temperature)
    return 100 * 2 * constants.h * constants.c**2 * v**3 / math.expm1(exponent)


def scattering_cosine(mu, mu0, difference_deg):
    return -mu * mu0 - math.sqrt(1 - mu**2) * math.sqrt(1 - mu0**2) * math.cos(math.radians(difference_deg))


def test_clear_column_is_eq_19():
    terms = model().clear(WAVENUMBER, SUN)
    up = math.exp(-0.1)
    both = math.exp(-0.2)
    mu0 = math.cos(math.radians(30))
    assert terms["sea_emission"][0] == pytest.approx(up * SEA_EMISSIVITY * planck(2500.0, 290.0), rel=1e-9)
    assert terms["sea_reflected_sun"][0] == pytest.approx(both * IRRADIANCE * mu0 * BRDF, rel=1e-12)
    assert terms["cloud_emission"][0] == terms["cloud_reflected_sun"][0] == 0


def test_cloudy_column_is_eq_20():
    thickness = 400.0
    terms = model().cloudy(WAVENUMBER, np.array([[thickness]]), SUN)
    top = 1400.0
    profile = load_profile("us-standard-1976", Catalog())
    temperature = float(np.interp(top, profile.altitude_m, profile.temperature_K))
    above = math.exp(-0.1 * (1 - top / 2e4))
    mu, mu0 = math.cos(math.radians(40)), math.cos(math.radians(30))
    emissivity = 1 - math.exp(-EXTINCTION * (1 - ALBEDO) * thickness)  # eqs 8-11
    cosine = scattering_cosine(mu, mu0, 150)
    phase = (1 - ASYMMETRY**2) / (1 + ASYMMETRY**2 - 2 * ASYMMETRY * cosine) ** 1.5  # eq 13
    brdf = ALBEDO / (4 * math.pi) * phase * mu0 / (mu0 + mu)  # eq 12
    expected = {
        "cloud_emission": above * emissivity * planck(2500.0, temperature),  # eq 15
        "cloud_reflected_sun": above**2 * IRRADIANCE * mu0 * brdf,  # eq 16
        "sea_emission": (1 - emissivity) * math.exp(-0.1) * SEA_EMISSIVITY * planck(2500.0, 290.0),  # eq 17
        "sea_reflected_sun": (1 - emissivity) * math.exp(-0.2) * IRRADIANCE * mu0 * BRDF,  # eq 18
    }
    for name, value in expected.items():
        assert terms[name][0, 0] == pytest.approx(value, rel=1e-9), name


def test_path_emission_counts_the_air_above_the_cloud_top_only():
    terms = model(layers=(layer(anchor="top"),)).cloudy(WAVENUMBER, np.array([[100.0], [2000.0]]), None)
    clear = model().clear(WAVENUMBER, None)
    assert np.all(terms["path_emission"] < clear["path_emission"])
    assert terms["path_emission"][0] == terms["path_emission"][1]


@pytest.mark.parametrize("sun", [None, Sun(90.0, 200.0, 1.0), Sun(140.0, 200.0, 1.0)])
def test_no_sun_no_solar_term(sun):
    tested = model()
    for terms in (tested.clear(WAVENUMBER, sun), tested.cloudy(WAVENUMBER, np.array([[10.0], [100.0]]), sun)):
        for name in tested.model.solar_terms:
            assert np.all(terms[name] == 0.0)


def test_thickness_to_infinity_is_an_opaque_cloud():
    thick = model(layers=(layer(anchor="top", temperature_K=260.0),)).cloudy(WAVENUMBER, np.array([[1e6]]), SUN)
    above = math.exp(-0.1 * (1 - 3000 / 2e4))
    assert thick["cloud_emission"][0, 0] == pytest.approx(above * planck(2500.0, 260.0), rel=1e-9)
    assert thick["sea_emission"][0, 0] == thick["sea_reflected_sun"][0, 0] == 0.0


def test_emission_of_a_vanishing_cloud_is_that_of_clear_sky():
    tested = model(layers=(layer(anchor="top"),))
    thin, clear = tested.cloudy(WAVENUMBER, np.array([[1e-9]]), None), tested.clear(WAVENUMBER, None)
    assert thin["cloud_emission"][0, 0] == pytest.approx(0.0, abs=1e-12)
    assert thin["sea_emission"][0, 0] == pytest.approx(clear["sea_emission"][0], rel=1e-9)


def test_literal_switches_restore_the_printed_forms():
    plain = model().cloudy(WAVENUMBER, np.array([[400.0]]), SUN)
    clear = model().clear(WAVENUMBER, SUN)
    twice = model({"literal_eq20": True}).cloudy(WAVENUMBER, np.array([[400.0]]), SUN)
    np.testing.assert_allclose(twice["sea_emission"], plain["sea_emission"] + clear["sea_emission"])
    full = model({"literal_eq19": True}).cloudy(WAVENUMBER, np.array([[400.0], [500.0]]), SUN)
    np.testing.assert_allclose(full["path_emission"], np.tile(clear["path_emission"], (2, 1)))
    once = model({"literal_eq18": True}).clear(WAVENUMBER, SUN)
    assert once["sea_reflected_sun"][0] / clear["sea_reflected_sun"][0] == pytest.approx(math.exp(0.1))
    mu, mu0 = math.cos(math.radians(40)), math.cos(math.radians(30))
    wrong = mu * mu0 - math.sqrt(1 - mu**2) * math.sqrt(1 - mu0**2) * math.cos(math.radians(150))
    sign = model({"literal_eq14": True}).cloudy(WAVENUMBER, np.array([[400.0]]), SUN)
    ratio = (1 + ASYMMETRY**2 - 2 * ASYMMETRY * scattering_cosine(mu, mu0, 150)) / (
        1 + ASYMMETRY**2 - 2 * ASYMMETRY * wrong
    )
    assert sign["cloud_reflected_sun"][0, 0] / plain["cloud_reflected_sun"][0, 0] == pytest.approx(ratio**1.5)


def test_fitted_scales_multiply_their_term_alone():
    plain = model().cloudy(WAVENUMBER, np.array([[400.0]]), SUN)
    scaled = model({"glint_scale": 0.162, "cloud_sun_scale": 0.5}).cloudy(WAVENUMBER, np.array([[400.0]]), SUN)
    for name, factor in {"sea_reflected_sun": 0.162, "cloud_reflected_sun": 0.5}.items():
        np.testing.assert_allclose(scaled[name], factor * plain[name])
    for name in ("cloud_emission", "sea_emission", "path_emission"):
        np.testing.assert_array_equal(scaled[name], plain[name])


def test_distance_of_the_sun_enters_squared():
    near, far = (model().clear(WAVENUMBER, Sun(30.0, 200.0, au))["sea_reflected_sun"][0] for au in (1.0, 1.01))
    assert near / far == pytest.approx(1.01**2)


HIGH = layer(name="high", base_m=8000.0, top_m=10_000.0)
LOW = layer(name="low")


def test_two_layers_are_eq_20_once_more():
    """Each cloud through the clouds above, which transmit 1 - emissivity; the air above the highest top only."""
    low, high = 400.0, 700.0
    terms = model(layers=(LOW, HIGH)).cloudy(WAVENUMBER, np.array([[low, high]]), SUN)
    profile = load_profile("us-standard-1976", Catalog())
    mu, mu0 = math.cos(math.radians(40)), math.cos(math.radians(30))
    phase = (1 - ASYMMETRY**2) / (1 + ASYMMETRY**2 - 2 * ASYMMETRY * scattering_cosine(mu, mu0, 150)) ** 1.5
    brdf = ALBEDO / (4 * math.pi) * phase * mu0 / (mu0 + mu)
    emitted, reflected, through = 0.0, 0.0, 1.0
    for top, thickness in ((8700.0, high), (1400.0, low)):
        above = math.exp(-0.1 * (1 - top / 2e4))
        emissivity = 1 - math.exp(-EXTINCTION * (1 - ALBEDO) * thickness)
        temperature = float(np.interp(top, profile.altitude_m, profile.temperature_K))
        emitted += through * above * emissivity * planck(2500.0, temperature)
        reflected += through * above**2 * IRRADIANCE * mu0 * brdf
        through *= 1 - emissivity
    expected = {
        "cloud_emission": emitted,
        "cloud_reflected_sun": reflected,
        "sea_emission": through * math.exp(-0.1) * SEA_EMISSIVITY * planck(2500.0, 290.0),
        "sea_reflected_sun": through * math.exp(-0.2) * IRRADIANCE * mu0 * BRDF,
        "path_emission": model(layers=(HIGH,)).cloudy(WAVENUMBER, np.array([[high]]), SUN)["path_emission"][0, 0],
    }
    for name, value in expected.items():
        assert terms[name][0, 0] == pytest.approx(value, rel=1e-9), name


def test_an_opaque_upper_cloud_hides_what_is_below_exactly():
    """exp(-tau) underflows to 0 at 1e6 m."""
    high = layer(base_m=8000.0, top_m=10_000.0, anchor="top")
    tested = model(layers=(LOW, high))
    both = tested.cloudy(WAVENUMBER, np.array([[1.0, 1e6], [2000.0, 1e6]]), SUN)
    alone = model(layers=(high,)).cloudy(WAVENUMBER, np.array([[1e6]]), SUN)
    for name in tested.model.terms:
        np.testing.assert_array_equal(both[name], np.repeat(alone[name], 2, axis=0))


def test_a_vanishing_lower_cloud_leaves_the_upper_one_and_its_own_reflection():
    """Eq 12 reflects sunlight without regard to thickness; every other term is that of the upper cloud alone."""
    tested = model({"cloud_sun_scale": 0.0}, layers=(LOW, HIGH))
    vanishing = tested.cloudy(WAVENUMBER, np.array([[1e-9, 300.0]]), SUN)
    alone = tested.cloudy(WAVENUMBER, np.array([[0.0, 300.0]]), SUN)
    for name in tested.model.terms:
        np.testing.assert_allclose(vanishing[name], alone[name], rtol=1e-9)


def test_a_vanishing_upper_cloud_takes_away_only_the_emission_of_the_air_below_it():
    """As one thin cloud does over the sea (docs/development/radiance.md)."""
    tested = model({"cloud_sun_scale": 0.0}, layers=(LOW, HIGH))
    vanishing = tested.cloudy(WAVENUMBER, np.array([[300.0, 1e-9]]), SUN)
    alone = tested.cloudy(WAVENUMBER, np.array([[300.0, 0.0]]), SUN)
    for name in set(tested.model.terms) - {"path_emission"}:
        np.testing.assert_allclose(vanishing[name], alone[name], rtol=1e-9)
    assert vanishing["path_emission"] < alone["path_emission"]


def test_the_order_of_layers_does_not_matter():
    columns = np.array([[400.0, 700.0], [0.0, 50.0], [20.0, 0.0]])
    forward = model(layers=(LOW, HIGH)).cloudy(WAVENUMBER, columns, SUN)
    backward = model(layers=(HIGH, LOW)).cloudy(WAVENUMBER, columns[:, ::-1], SUN)
    for name, values in forward.items():
        np.testing.assert_array_equal(backward[name], values)


def test_columns_without_cloud_among_others_are_clear_sky():
    tested = model(layers=(LOW, HIGH))
    clear = tested.clear(WAVENUMBER, SUN)
    among = tested.cloudy(WAVENUMBER, np.array([[400.0, 0.0], [0.0, 0.0], [0.0, 700.0]]), SUN)
    for name, values in among.items():
        np.testing.assert_array_equal(values[1], clear[name])


@pytest.mark.parametrize("wrong", [[[-1.0, 5.0]], [[np.nan, 5.0]], [[5.0]], [5.0, 5.0]])
def test_columns_that_are_none_are_refused(wrong):
    with pytest.raises(ValueError, match="thickness_m"):
        model(layers=(LOW, HIGH)).cloudy(WAVENUMBER, np.array(wrong), SUN)
