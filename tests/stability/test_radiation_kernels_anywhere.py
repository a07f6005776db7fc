"""Planck's law and its inverse, Fresnel, phase functions, the sun, bands and chosen wavenumbers, at any arguments."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from examples import examples
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from hcss_twin.core.errors import ProviderError
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.models.radiance.spectral_grid import SpectralBand, SpectralGrid
from hcss_twin.physics.fresnel import unpolarised_reflectance
from hcss_twin.physics.geometry import scattering_cosine, wind_azimuths
from hcss_twin.physics.monotone_cubic import pchip_in_window
from hcss_twin.physics.multiple_scattering.phase_function import henyey_greenstein
from hcss_twin.physics.planck import FIRST_RADIATION, SECOND_RADIATION, planck
from hcss_twin.physics.sun import sun_position

MANY = examples(200)
FEW = examples(40)
KELVIN = st.floats(150.0, 350.0)
MICRON = st.floats(0.7, 14.3)
ANGLE = st.floats(0.0, 2.0 * np.pi)
NATIVE = np.arange(500.0, 14286.0, 5.0)


@st.composite
def bands(draw):
    """Anywhere from 0.7 to 14.3 um; half of them 1 nm wide, some with a response of holes and steps."""
    width = draw(st.one_of(st.just(1e-3), st.floats(1e-3, 6.0)))
    low = draw(st.floats(0.7, 14.3 - width))
    count = draw(st.integers(2, 12))
    wavelength = np.linspace(low, low + width, count)
    response = np.array(draw(st.lists(st.sampled_from([0.0, 1e-12, 0.3, 1.0]), min_size=count, max_size=count)))
    return SpectralBand("drawn", wavelength, response if response.any() else np.ones(count))


@MANY
@given(MICRON, KELVIN)
def test_planck_is_positive_below_its_classical_limit_and_rises_with_temperature(micron, kelvin):
    wavenumber = np.array([1e4 / micron])
    cold, warm = planck(wavenumber, kelvin), planck(wavenumber, kelvin * 1.001)
    assert 0.0 < cold[0] < warm[0]
    assert warm[0] < FIRST_RADIATION / SECOND_RADIATION * wavenumber[0] ** 2 * kelvin * 1.001
    single = planck(wavenumber.astype(np.float32), np.float32(kelvin))
    # Rounding of the exponent, up to 137, is multiplied by it; beyond, single precision has no such numbers.
    if cold[0] > 1e-34:
        np.testing.assert_allclose(single, cold, rtol=3e-5)


@FEW
@given(bands(), st.lists(KELVIN, min_size=1, max_size=8))
def test_brightness_temperature_inverts_the_band_radiance_of_any_black_body(band, kelvin):
    """Within a hundredth of a kelvin, and less where single precision can tell that much, or is refused."""
    grid = SpectralGrid.dense([band], NATIVE)
    temperature = np.array(kelvin)
    exact = planck(grid.wavenumber_cm1[None, :], temperature[:, None]) @ grid.weights_cm1[0]
    single = exact.astype(np.float32).reshape(1, 1, -1)
    inverse = BrightnessTemperature(grid, ["drawn"])
    if single.min() < np.finfo(np.float32).tiny:
        return
    np.testing.assert_allclose(inverse(single)[0, 0], temperature, atol=2e-3, rtol=1e-6)
    with pytest.raises(ProviderError, match="no brightness temperature"):
        inverse(np.zeros_like(single))


@MANY
@given(st.floats(0.05, 20.0), st.one_of(st.just(0.0), st.floats(1e-12, 50.0)), st.floats(1e-6, 1.0))
def test_fresnel_reflectance_is_a_share(n, k, cosine):
    value = unpolarised_reflectance(complex(n, k), np.array([cosine, 1.0]))
    assert np.all((value >= 0.0) & (value <= 1.0 + 1e-12))
    normal = ((n - 1.0) ** 2 + k * k) / ((n + 1.0) ** 2 + k * k)
    assert value[1] == pytest.approx(normal, rel=1e-9, abs=1e-15)


@MANY
@given(st.floats(-0.999, 0.999), hnp.arrays(np.float64, 9, elements=st.floats(-1.0, 1.0)))
def test_henyey_greenstein_is_positive_between_its_ends(g, cosines):
    value = henyey_greenstein(np.concatenate([cosines, [-1.0, 1.0]]), g)
    assert np.all(np.isfinite(value))
    ends = sorted([(1 - g) / (1 + g) ** 2, (1 + g) / (1 - g) ** 2])
    assert np.all((value >= ends[0] * (1 - 1e-9)) & (value <= ends[1] * (1 + 1e-9)))


@MANY
@given(st.floats(0.0, 85.0), st.floats(0.0, 89.999), ANGLE)
def test_a_scattering_cosine_is_that_of_the_two_vectors(view, sun, azimuth):
    mu, mu0 = np.cos(np.radians([view, sun]))
    toward = np.array([np.sin(np.radians(view)), 0.0, mu])
    source = np.sin(np.radians(sun)) * np.array([np.cos(azimuth), np.sin(azimuth), 0.0]) + [0, 0, mu0]
    cosine = scattering_cosine(mu, mu0, azimuth)
    assert -1.0 <= cosine <= 1.0
    # A sine made from a cosine near 1 has half of its digits.
    assert cosine == pytest.approx(-float(toward @ source), abs=3e-8)
    relative, wind = wind_azimuths(view, sun, np.degrees(azimuth))
    assert 0.0 <= relative <= np.pi
    assert 0.0 <= wind <= 2.0 * np.pi


@FEW
@given(st.datetimes(datetime(1700, 1, 1), datetime(2200, 12, 30)), st.floats(-90.0, 90.0), st.floats(-180.0, 360.0))
def test_the_sun_is_somewhere_at_every_place_and_time(when, latitude, longitude):
    times = [when.replace(tzinfo=UTC) + timedelta(hours=hour) for hour in range(25)]
    zenith, azimuth, distance = sun_position(times, latitude, longitude)
    for values, low, high in ((zenith, 0.0, 180.0), (azimuth, 0.0, 360.0), (distance, 0.98, 1.02)):
        assert np.all((values >= low) & (values <= high))
    # 15 degrees an hour at most, and refraction of half a degree at the horizon.
    assert np.abs(np.diff(zenith)).max() < 15.7


@MANY
@given(bands(), st.sampled_from([NATIVE, None]))
def test_weights_of_any_band_are_not_negative_and_sum_to_its_integral(band, native):
    grid = SpectralGrid.dense([band], native)
    assert np.all(np.isfinite(grid.wavenumber_cm1))
    assert np.all(np.diff(grid.wavenumber_cm1) > 0.0)
    assert np.all(grid.weights_cm1 >= 0.0)
    edges = 1e4 / band.wavelength_um[[-1, 0]]
    assert grid.weights_cm1.sum() <= (edges[1] - edges[0]) * (1 + 1e-9)
    assert grid.weights_cm1.sum() > 0.0
    assert band.lower_um <= band.central_um <= band.upper_um
    if np.all(band.response == 1.0):
        assert grid.weights_cm1.sum() == pytest.approx(edges[1] - edges[0], rel=1e-9)


@FEW
@given(
    bands(),
    st.integers(0, 2**32),
    st.sampled_from([1e-1, 1e-3, 1e-5]),
    st.integers(-250, 250),
    st.sampled_from([0.0, 0.3, 0.9, 1.0]),
)
def test_chosen_wavenumbers_sum_any_spectra_within_the_tolerance(band, seed, tolerance, power, dark):
    """Spectra of any scale, of whole zeros, with zeros at random."""
    grid = SpectralGrid.dense([band], NATIVE)
    random = np.random.default_rng(seed)
    spectra = 10.0 ** random.uniform(-8, 0, (6, 3, grid.wavenumber_cm1.size)) * 10.0**power
    spectra[random.random(spectra.shape) < dark] = 0.0
    nodes = grid.choose_nodes(spectra, tolerance)
    assert np.all(nodes.weights_cm1 >= 0.0)
    assert np.all(np.isfinite(nodes.weights_cm1))
    kept = np.searchsorted(grid.wavenumber_cm1, nodes.wavenumber_cm1)
    exact, found = spectra @ grid.weights_cm1[0], spectra[..., kept] @ nodes.weights_cm1[0]
    total = exact.sum(axis=1, keepdims=True)
    assert np.all(np.abs(found - exact) <= (tolerance + 1e-12) * total)


@MANY
@given(
    st.integers(1, 4),
    st.integers(0, 2**32),
    st.integers(-290, 290),
    st.sampled_from(["any", "constant", "monotone", "steps"]),
)
def test_the_monotone_cubic_stays_between_its_nodes(count, seed, power, kind):
    random = np.random.default_rng(seed)
    nodes = np.cumsum(10.0 ** random.uniform(-4, 4, (5, count)), axis=1)
    values = random.standard_normal((5, count, 2)) * 10.0**power
    if kind == "constant":
        values[:] = values[:, :1]
    elif kind == "monotone":
        values.sort(axis=1)
    elif kind == "steps":
        values = np.round(values / 10.0**power) * 10.0**power
    x = nodes[:, 0] + random.random(5) * (nodes[:, -1] - nodes[:, 0])
    found = pchip_in_window(nodes, values, x)
    assert np.all(np.isfinite(found))
    margin = 1e-12 * np.abs(values).max(axis=1)
    assert np.all(found >= values.min(axis=1) - margin)
    assert np.all(found <= values.max(axis=1) + margin)


@MANY
@given(st.floats(0.71, 13.0), st.floats(-4, 0), st.integers(-1, 2))
def test_every_grid_of_a_band_has_its_width(low, power, refinement):
    """Whatever lies between the edges: no native wavenumber, one at an edge, or many."""
    high = min(low + 10.0**power, 14.29)
    edges = np.array([low, high])
    grid = SpectralGrid.dense([SpectralBand("any", edges, np.ones(2))], NATIVE, refinement)
    assert np.all(np.diff(grid.wavenumber_cm1) > 0.0)
    assert np.sum(grid.weights_cm1) == pytest.approx(1e4 / low - 1e4 / high, rel=1e-9)
    assert grid.weights_cm1.min() > 0.0
