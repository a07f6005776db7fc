"""Instruments against closed forms: radiance, electrons, numbers, NEDT, saturation, self-emission, calibration."""

import numpy as np
import pytest
from scipy import integrate, stats

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ScenarioError
from hcss_twin.models.sensor.detector import band_radiance, band_radiance_per_kelvin
from hcss_twin.models.sensor.parameters import RadiometerParameters
from hcss_twin.models.sensor.radiometer import Radiometer
from hcss_twin.providers import Grid, SensorBand, SensorInputs
from hcss_twin.scenario.bands import sensor_bands, spectral_band
from hcss_twin.scenario.instrument import Instrument, load_instrument

PLANCK, LIGHT, BOLTZMANN = 6.62607015e-34, 299792458.0, 1.380649e-23
BOX = (3.7, 4.8)
LIT = {
    "f_number": 2.0,
    "focal_length": 0.25,
    "detector_pitch": 15e-6,
    "transmission": 0.8,
    "quantum_efficiency": 0.75,
    "integration_time": "3 ms",
    "photon_temperature": 300.0,
}


def built(keys, bands=((*BOX,),), rows=64, columns=64, seed=1):
    sides = [SensorBand(f"b{index}", np.array(side), np.ones(2)) for index, side in enumerate(bands)]
    parameters = RadiometerParameters(**Instrument(**keys).sensor_parameters())
    return Radiometer(SensorInputs(tuple(sides), Grid(rows, columns, 20.0), 0.0, 1.0, seed, Catalog()), parameters)


def black_body(kelvin, per=1.0, box=BOX):
    """Band radiance of a black body by quadrature, W m-2 sr-1; ``per`` is divided by for each wavelength in m."""

    def spectral(um):
        wavelength = um * 1e-6
        x = PLANCK * LIGHT / (wavelength * BOLTZMANN * kelvin)
        power = 2.0 * PLANCK * LIGHT**2 / wavelength**5 / np.expm1(x) * 1e-6
        return power if per == 1.0 else power * wavelength / (PLANCK * LIGHT)

    return integrate.quad(spectral, *box, epsabs=0.0)[0]


def electrons(kelvin, keys=LIT):
    """Electrons of an integration from the etendue pi p^2 / (4 F^2)."""
    etendue = np.pi * keys["detector_pitch"] ** 2 / (4.0 * keys["f_number"] ** 2)
    photons = etendue * keys["transmission"] * black_body(kelvin, per=0.0)
    return photons * keys["quantum_efficiency"] * 3e-3


def slope(kelvin):
    return (black_body(kelvin + 0.05) - black_body(kelvin - 0.05)) / 0.1


def flat(provider, kelvin, frame=0, time_s=0.0):
    grid = provider.channels[0].inputs.grid
    shape = len(provider.channels), grid.rows, grid.columns
    return provider.measure(np.full(shape, black_body(kelvin)), frame, time_s)


def test_radiance_of_a_black_body_is_plancks_integral():
    band = SensorBand("b", np.array(BOX), np.ones(2))
    for kelvin in (220.0, 300.0, 340.0):
        assert band_radiance(band, kelvin) == pytest.approx(black_body(kelvin), rel=1e-9)


def test_electrons_follow_from_f_number_and_pitch():
    provider = built({**LIT, "read_noise": 0.0, "shot_noise": False})
    found = provider.worked_out["bands"]["b0"]["electrons_per_radiance"] * black_body(300.0)
    assert found == pytest.approx(electrons(300.0), rel=0.01)


def test_nedt_of_electrons_is_that_of_shots_and_reading():
    read = 400.0
    provider = built({**LIT, "read_noise": read})
    closed = np.sqrt(electrons(300.0) + read**2) / (electrons(300.0) / black_body(300.0) * slope(300.0))
    assert provider.worked_out["bands"]["b0"]["nedt"] == pytest.approx(closed, rel=0.01)
    noise = np.std(flat(provider, 300.0).radiance) / slope(300.0)
    low, high = np.sqrt(stats.chi2.ppf((1e-4, 1.0 - 1e-4), 64**2 - 1) / (64**2 - 1))
    assert low * closed < noise < high * closed


@pytest.mark.parametrize("wanted", [0.02, 0.06])
def test_read_noise_fills_what_a_stated_nedt_leaves(wanted):
    provider = built({**LIT, "nedt": f"{wanted} K at 300 K"})
    noise = np.std(flat(provider, 300.0).radiance, ddof=1) / slope(300.0)
    low, high = np.sqrt(stats.chi2.ppf((1e-4, 1.0 - 1e-4), 64**2 - 1) / (64**2 - 1))
    assert low * wanted < noise < high * wanted
    colder = np.std(flat(provider, 250.0).radiance) / slope(250.0)
    assert colder > 2.0 * wanted  # shots and reading in kelvin of a colder scene


def test_an_nedt_that_no_reading_can_have_is_refused():
    with pytest.raises(ScenarioError, match=r"sensor.parameters.nedt: 0.001 K at 300 K in band 'b0', but without read"):
        built({**LIT, "nedt": "1 mK at 300 K"})
    with pytest.raises(ScenarioError, match=r"but with read_noise it is 0\.0"):
        built({**LIT, "nedt": "1 K at 300 K", "read_noise": 100.0})


@pytest.mark.parametrize("keys", [{**LIT, "read_noise": 0.0}, {"nedt": 0.02}])
def test_detectors_saturate_at_the_stated_temperature(keys):
    provider = built({**keys, "saturation_temperature": "330 K", "bits": 14, "number_offset": 100})
    assert not np.any(flat(provider, 329.5).saturated)
    assert np.all(flat(provider, 330.5).saturated)
    assert np.all(flat(provider, 330.5).digital_number == 2**14 - 1)
    assert provider.worked_out["bands"]["b0"]["saturation_temperature"] == pytest.approx(330.0, abs=0.01)


def test_a_well_that_is_full_below_saturation_is_refused():
    with pytest.raises(ScenarioError, match=r"it is full at 29\d"):
        built({**LIT, "saturation_temperature": 330.0, "well_depth": electrons(295.0)})


@pytest.mark.parametrize("keys", [{**LIT, "read_noise": 300.0, "dark_current": "20 Me/s"}, {"nedt": 0.02}])
def test_numbers_turn_back_into_radiance_within_the_noise(keys):
    provider = built({**keys, "saturation_temperature": 330.0, "bits": 14, "number_offset": 100})
    constants = provider.worked_out["bands"]["b0"]
    measured = flat(provider, 300.0)
    back = constants["radiance_per_number"] * measured.digital_number + constants["radiance_at_number_0"]
    np.testing.assert_allclose(back, measured.radiance, rtol=1e-5)
    noise = np.std(back)
    assert abs(np.mean(back) - black_body(300.0)) < 5.0 * noise / 64.0
    assert noise < 0.06 * slope(300.0)


def test_numbers_of_a_black_body_are_radiance_over_steps():
    provider = built({"saturation_temperature": 330.0, "bits": 12})
    expected = black_body(300.0) / (black_body(330.0) / 4095)
    assert np.all(np.abs(flat(provider, 300.0).digital_number - expected) <= 0.51)


def test_optics_and_housing_emit_like_grey_bodies():
    warm = {**LIT, "read_noise": 0.0, "optics_temperature": "20 degC", "housing_temperature": 290.0, "cold_shield": 1.5}
    etendue = np.pi * 15e-6**2 / 4.0
    from_optics = etendue / 4.0 * 0.2 * black_body(293.15, per=0.0)
    from_housing = etendue * (1.0 / 1.5**2 - 1.0 / 4.0) * black_body(290.0, per=0.0)
    closed = (from_optics + from_housing) * 0.75 * 3e-3
    provider = built(warm)
    assert provider.worked_out["bands"]["b0"]["background_electrons"] == pytest.approx(closed, rel=0.01)
    found = flat(provider, 300.0).radiance
    assert np.mean(found) == pytest.approx(black_body(300.0), rel=1e-3)  # its mean is subtracted
    noise = np.sqrt(electrons(300.0) + closed) / electrons(300.0) * black_body(300.0)
    assert np.std(found) == pytest.approx(noise, rel=0.05)


@pytest.mark.parametrize("keys", [{**LIT, "shot_noise": False}, {}])
def test_drift_grows_between_calibrations_and_returns_to_zero(keys):
    provider = built({**keys, "drift": "-0.4 K", "calibration_cycle": "10 min"})
    for time_s, share in ((0.0, 0.0), (150.0, 0.25), (599.0, 599 / 600), (600.0, 0.0), (900.0, 0.5)):
        found = float(np.mean(flat(provider, 300.0, time_s=time_s).radiance))
        assert found - black_body(300.0) == pytest.approx(-0.4 * share * slope(300.0), abs=2e-3 * slope(300.0))


@pytest.mark.parametrize("keys", [{}, {"psf": "gaussian", "psf_sigma": 0.5}, {"psf": "airy", **LIT}])
@pytest.mark.parametrize(("along_y", "along_x"), [(0.0, 0.1), (0.2, 0.0), (0.15, 0.2)])
def test_jitter_has_the_transfer_of_a_gaussian(keys, along_y, along_x):
    def transfer(jitter):
        quiet = {"shot_noise": False} if "integration_time" in keys else {}
        provider = built({**keys, **quiet, **jitter}, rows=96, columns=96)
        y, x = np.mgrid[:96, :96]
        wave = np.cos(2.0 * np.pi * (along_y * y + along_x * x))
        measured = provider.measure((3.0 + wave)[None], 0, 0.0).radiance[0] - 3.0
        inner = slice(24, 72)
        return np.sum(measured[inner, inner] * wave[inner, inner]) / np.sum(wave[inner, inner] ** 2)

    expected = np.exp(-2.0 * np.pi**2 * 0.3**2 * (along_x**2 + along_y**2))
    assert transfer({"jitter": "0.3 px"}) / transfer({}) == pytest.approx(expected, rel=0.01)


def published(name):
    file = load_instrument(name, Catalog())
    bands = sensor_bands([spectral_band(band, Catalog()) for band in file.bands])
    inputs = SensorInputs(bands, Grid(32, 32, 100.0), 0.0, 1.0, 2, Catalog())
    return {band.name: band for band in bands}, Radiometer(inputs, RadiometerParameters(**file.sensor_parameters()))


@pytest.mark.parametrize("name", Catalog().names("instruments", ".toml"))
def test_shipped_instruments_measure_a_black_body_with_their_noise(name):
    bands, provider = published(name)
    given = provider.channels[0].parameters
    scene = {band: given.nedt_temperature if isinstance(given.nedt_temperature, float) else given.nedt_temperature[band]
             for band in bands}  # fmt: skip
    clean = np.stack([np.full((32, 32), band_radiance(bands[band], scene[band])) for band in bands])
    measured = provider.measure(clean, 0, 0.0).radiance
    for index, (band, side) in enumerate(bands.items()):
        per_kelvin = band_radiance_per_kelvin(side, scene[band])
        step = provider.worked_out["bands"][band].get("radiance_per_number", 0.0)
        if given.nedt is None:
            continue
        wanted = given.nedt if isinstance(given.nedt, float) else given.nedt[band]
        noise = np.hypot(wanted * per_kelvin, 0.0 if given.noise == "photon" else step / np.sqrt(12.0)) / per_kelvin
        pattern = given.gain_deviation * clean[index, 0, 0] / per_kelvin
        assert np.std(measured[index]) / per_kelvin == pytest.approx(np.hypot(noise, pattern), rel=0.2)


def test_published_radiances_of_modis_at_300_K_are_those_of_its_bands():
    # NASA, MODIS Technical Specifications: typical radiance at 300 K, W m-2 sr-1 um-1.
    typical = {"B20": 0.45, "B22": 0.67, "B23": 0.79, "B29": 9.58, "B31": 9.55, "B32": 8.94}
    bands, _ = published("modis")
    for name, radiance in typical.items():
        low, high = bands[name].wavelength_um[[0, -1]]
        assert band_radiance(bands[name], 300.0) / (high - low) == pytest.approx(radiance, rel=0.02)


@pytest.mark.parametrize(("kelvin", "published_K"), [(280.0, 0.59), (300.0, 0.5), (320.0, 0.43)])
def test_one_number_of_landsat_7_is_the_published_temperature(kelvin, published_K):
    # US Geological Survey: smallest change in low gain (0.067 W m-2 sr-1 um-1) at three temperatures.
    bands, provider = published("landsat-7-etm")
    step = provider.worked_out["bands"]["B6L"]["radiance_per_number"]
    assert step / band_radiance_per_kelvin(bands["B6L"], kelvin) == pytest.approx(published_K, rel=0.2)


TIRS_BAND_10 = {
    # NASA, InstruPy, examples/passive_scanner_model/landsat8_TIRS_band1.json; the read noise is a guess
    "f_number": 1.64,
    "focal_length": 0.178,
    "detector_pitch": 25e-6,
    "transmission": 0.60,
    "quantum_efficiency": 0.025,
    "integration_time": "3.49 ms",
    "read_noise": 20.0,
}


def test_electrons_and_nedt_of_landsat_8_tirs_are_those_of_instrupy():
    # InstruPy, tests/test_passive_optical_scanner_model.py: without air, scene at 290 K, band of 10.9 +- 0.3 um.
    dynamic_range, snr, nedt = 129736.13, 1610.69, 0.03895
    box = (10.6, 11.2)
    per_radiance = built({**TIRS_BAND_10, "photon_temperature": 290.0}, bands=(box,)).worked_out["bands"]["b0"][
        "electrons_per_radiance"
    ]
    found = per_radiance * black_body(290.0, box=box)
    noise = np.hypot(np.sqrt(found), 20.0)
    assert found / 20.0 == pytest.approx(dynamic_range, rel=1e-5)
    assert found / noise == pytest.approx(snr, rel=1e-5)
    per_kelvin = (black_body(290.5, box=box) - black_body(289.5, box=box)) * per_radiance
    assert noise / per_kelvin == pytest.approx(nedt, rel=0.01)


def test_photons_explain_most_of_the_noise_that_landsat_8_tirs_has_in_orbit():
    # Montanaro et al., Remote Sens. 6, 11753 (2014): about 0.05 K at 300 K; the dark current is not published.
    provider = built({**TIRS_BAND_10, "photon_temperature": 300.0}, bands=((10.60, 11.19),))
    of_photons = provider.worked_out["bands"]["b0"]["nedt"]
    assert of_photons == pytest.approx(0.0390, abs=5e-5)  # 22 % less
    assert of_photons < 0.05


@pytest.mark.parametrize("f_number", [1.5, 2.0, 4.0])
def test_mtf_at_half_a_cycle_per_pixel_is_that_of_diffraction_at_the_f_number(f_number):
    known = built({"f_number": f_number, "detector_pitch": 15e-6, "focal_length": 0.25}).worked_out["bands"]["b0"]
    of_cutoff = 0.5 * 4.25 * f_number / 15.0  # wavelength at the middle of the band, pitch, um
    expected = 2.0 / np.pi * (np.arccos(of_cutoff) - of_cutoff * np.sqrt(1.0 - of_cutoff**2))
    assert known["mtf_nyquist_x"] == pytest.approx(expected, rel=1e-9)
    assert known["mtf_nyquist_y"] == pytest.approx(expected, rel=1e-9)


def test_a_sensor_whose_optics_do_not_blur_names_what_diffraction_would_do():
    (note,) = built({"f_number": 2.0, "detector_pitch": 15e-6, "focal_length": 0.25, "psf": "none"}).declares.notes
    of_cutoff = 0.5 * 4.25 * 2.0 / 15.0
    mtf = 2.0 / np.pi * (np.arccos(of_cutoff) - of_cutoff * np.sqrt(1.0 - of_cutoff**2))
    assert f"MTF of {mtf:.2g} " in note
    assert 'psf = "airy" computes it' in note
