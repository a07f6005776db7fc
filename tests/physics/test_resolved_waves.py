"""Laws of the waves that pixels resolve: what tilted parts send adds up to what the sea sends."""

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ProviderError
from hcss_twin.models.parameters import RoughSeaParameters
from hcss_twin.models.sea.facets import smith_lambda
from hcss_twin.models.sea.rough_sea import RoughSea
from hcss_twin.models.sea.slope_statistics import SlopeStatistics, Tilt, slope_statistics, unresolved
from hcss_twin.models.sea.wave_spectrum import WaveSpectrum
from hcss_twin.providers import Grid, Motion, SeaInputs

PIXEL_M = 2.0
WAVENUMBER = 1e4 / np.array([10.8, 3.7])
GRID = Grid(120, 160, PIXEL_M)
STILL, FLYING = Motion(0.0, (0.0, 0.0), np.inf, 1.0), Motion(40.0, (0.0, 0.0), np.inf, 1.0)


def sea(wind=10.0, **parameters):
    return RoughSea(SeaInputs(wind, 250.0, 290.0, Catalog()), RoughSeaParameters(**parameters))


def facets(slopes):
    """Statistics of the facets that pixels do not resolve, of the sea of :func:`sea` with this law of slopes."""
    return unresolved(slope_statistics(10.0, slopes), WaveSpectrum("pierson-moskowitz", 10.0), PIXEL_M)


def test_slope_of_waves_and_facets_is_that_of_the_sea():
    for law in ("isotropic", "upwind-crosswind"):
        whole = sea(slopes=law)
        upwind, crosswind = whole.wave_slope_rms(PIXEL_M)
        assert upwind**2 + crosswind**2 + facets(law).mean_square_slope == pytest.approx(whole.mean_square_slope)
        slopes = whole.wave_field(GRID, STILL, 1).slopes(0.0, slice(0, 120), slice(0, 160))
        assert np.var(slopes) * 2 == pytest.approx(upwind**2 + crosswind**2, rel=0.06)
        bearing = np.radians(250.0)
        along = slopes[0] * np.sin(bearing) + slopes[1] * np.cos(bearing)
        across = slopes[0] * np.cos(bearing) - slopes[1] * np.sin(bearing)
        assert along.std() == pytest.approx(upwind, rel=0.06)
        assert across.std() == pytest.approx(crosswind, rel=0.06)


def tilts(count, rms):
    """Gaussian tilts along and across the wind, and their weights: count x count Gauss-Hermite nodes."""
    x, weight = np.polynomial.hermite_e.hermegauss(count)
    weight /= weight.sum()
    for i, up in enumerate(x):
        for j, cross in enumerate(x):
            yield rms[0] * up, rms[1] * cross, weight[i] * weight[j]


SEPARABLE = {"slopes": "upwind-crosswind", "shadowing": "separable", "foam": False}


@pytest.mark.parametrize(("parameters", "zenith"), [({}, 40.0), ({}, 60.0), (SEPARABLE, 0.0), (SEPARABLE, 60.0)])
def test_parts_weighted_with_the_area_they_show_send_what_the_sea_sends(zenith, parameters):
    """Sum over Gaussian tilts of cross-section times emission, reflection and glint.

    11 x 11 nodes are needed for the glint; 7 x 7 are enough for the others, which are slow and smooth.
    """
    whole, law = sea(**parameters), parameters.get("slopes", "isotropic")
    mu, bearing = np.array([np.cos(np.radians(zenith))]), np.array([0.7])
    mu_sun, azimuth, nodes = np.array([0.6]), np.array([2.6]), np.array([0.1, 0.5, 0.9])
    rms = whole.wave_slope_rms(PIXEL_M)
    emitted, reflected, glint, area = 0.0, 0.0, 0.0, 0.0
    for up, cross, weight in tilts(11, rms):
        part = whole.tilted(up, cross, PIXEL_M)
        shown = Tilt(up, cross, facets(law)).cross_section(mu, bearing)[0] * weight
        area += shown
        glint += shown * part.brdf(WAVENUMBER, mu, mu_sun, azimuth, bearing)[0]
    for up, cross, weight in tilts(7, rms):
        part = whole.tilted(up, cross, PIXEL_M)
        shown = Tilt(up, cross, facets(law)).cross_section(mu, bearing)[0] * weight
        emitted += shown * part.emissivity(WAVENUMBER, mu, bearing)[0]
        reflected += shown * part.reflection_weights(WAVENUMBER, mu, nodes, "linear", bearing)[0]
    variance = slope_statistics(10.0, law).variance_along(bearing)
    assert area == pytest.approx((mu * (1.0 + smith_lambda(mu, variance))).item(), rel=1e-12)
    np.testing.assert_allclose(emitted / area, whole.emissivity(WAVENUMBER, mu, bearing)[0], atol=2e-5)
    expected = whole.reflection_weights(WAVENUMBER, mu, nodes, "linear", bearing)[0]
    np.testing.assert_allclose(reflected / area, expected, atol=5e-5)
    np.testing.assert_allclose(glint / area, whole.brdf(WAVENUMBER, mu, mu_sun, azimuth, bearing)[0], rtol=1e-6)


def test_the_area_a_part_shows_is_the_mean_over_its_facets():
    tilt = Tilt(0.1, -0.2, SlopeStatistics(0.02, 0.01))
    up, across = (np.linspace(-1.0, 1.0, 1001) * 8.0 * np.sqrt(v) for v in (0.02, 0.01))
    density = tilt.rest.density(up[:, None], across[None, :])
    for zenith, bearing in ((0.0, 0.0), (50.0, 1.0), (80.0, 4.0)):
        mu, sine = np.cos(np.radians(zenith)), np.sin(np.radians(zenith))
        along = (up + 0.1)[:, None] * np.cos(bearing) + (across - 0.2)[None, :] * np.sin(bearing)
        expected = np.sum(density * np.maximum(mu - along * sine, 0.0)) / np.sum(density)
        found = tilt.cross_section(np.array([mu]), np.array([bearing]))[0]
        assert found == pytest.approx(expected, rel=1e-5)


def test_a_part_tilted_into_the_mirror_slope_shines_brightest():
    """The glint peaks where the tilt is the slope that mirrors the sun into the sensor, seen straight down."""
    whole = sea(foam=False)
    mu, mu_sun = np.ones(1), np.array([np.cos(np.radians(20.0))])
    bearing = np.array([np.radians(30.0)])
    azimuth = np.array([2.0])
    mirror = np.tan(np.radians(10.0))
    toward = bearing[0] + azimuth[0]  # of the sun: the facet leans away from it, its normal toward it
    tilts = np.linspace(-0.3, 0.3, 61)
    glint = [
        whole.tilted(t * np.cos(toward), t * np.sin(toward), PIXEL_M).brdf(WAVENUMBER, mu, mu_sun, azimuth, bearing)[
            0, 0
        ]
        for t in tilts
    ]
    assert tilts[np.argmax(glint)] == pytest.approx(-mirror, abs=0.011)


def test_the_same_seed_gives_the_same_waves_and_another_others():
    window = 3.0, slice(0, 40), slice(0, 50)
    first = sea().wave_field(GRID, STILL, 7).slopes(*window)
    assert first.dtype == np.float32
    assert first.shape == (2, 40, 50)
    assert first.tobytes() == sea().wave_field(GRID, STILL, 7).slopes(*window).tobytes()
    assert np.corrcoef(first.ravel(), sea().wave_field(GRID, STILL, 8).slopes(*window).ravel())[0, 1] < 0.3


def test_time_runs_back_to_the_same_waves():
    waves = sea().wave_field(GRID, FLYING, 3)
    window = slice(0, 20), slice(0, 20)
    before = waves.slopes(0.0, *window)
    assert not np.array_equal(waves.slopes(30.0, *window), before)
    assert np.array_equal(waves.slopes(0.0, *window), before)


def test_the_image_moves_over_the_waves_with_the_platform():
    """At one instant a flying image sees what a still one sees as many columns further east."""
    still, flying = (sea().wave_field(GRID, motion, 3) for motion in (STILL, FLYING))
    rows, time_s = slice(0, 30), 2.0
    shift = int(40.0 * time_s / PIXEL_M)
    ahead = still.slopes(time_s, rows, slice(shift, shift + 50))
    np.testing.assert_allclose(flying.slopes(time_s, rows, slice(0, 50)), ahead, atol=1e-6)


def test_waves_run_downwind():
    """The image that follows the wind's direction at the phase speed of long waves changes least."""
    waves = sea().wave_field(Grid(1, 1, 10.0), STILL, 3)
    rows, columns = slice(0, 100), slice(0, 100)
    before, after = waves.slopes(0.0, rows, columns), waves.slopes(4.0, rows, columns)

    def likeness(dy, dx):
        a = before[0][20:80, 20:80]
        b = after[0][20 + dy : 80 + dy, 20 + dx : 80 + dx]
        return np.corrcoef(a.ravel(), b.ravel())[0, 1]

    # Wind from 250 degrees: toward east (columns) and a little north (rows).
    best = max(((dy, dx) for dy in range(-8, 9) for dx in range(-8, 9)), key=lambda shift: likeness(*shift))
    assert best[1] >= 1
    assert best[0] >= 0


def test_calls_without_a_bearing_give_the_sea_as_a_whole():
    whole = sea()
    part, mu, other = whole.tilted(0.1, 0.05, PIXEL_M), np.array([0.6]), np.array([0.8])
    np.testing.assert_array_equal(part.emissivity(WAVENUMBER, mu), whole.emissivity(WAVENUMBER, mu))
    azimuth = np.array([2.0])
    np.testing.assert_array_equal(part.brdf(WAVENUMBER, mu, other, azimuth), whole.brdf(WAVENUMBER, mu, other, azimuth))


def test_slopes_that_cannot_be_divided_are_refused():
    with pytest.raises(ProviderError, match=r"'gram-charlier'.*allowed: 'isotropic'"):
        sea(slopes="gram-charlier").tilted(0.0, 0.0, PIXEL_M)
    with pytest.raises(ProviderError, match="cannot be resolved with pixels this small; allowed: larger"):
        sea(wind=1.0, slopes="upwind-crosswind").tilted(0.0, 0.0, 0.001)
