"""The Cox-Munk sea, slopes, shadowing, foam fields of waves: winds to 60 m/s, views to 85 degrees, 1e9 pixels out."""

import numpy as np
import pytest
from examples import examples
from hypothesis import given
from hypothesis import strategies as st

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.parameters import CoxMunkParameters
from hcss_twin.models.sea.cox_munk import CoxMunkSea
from hcss_twin.models.sea.facets import smith_lambda
from hcss_twin.models.sea.sea_water import foam_coverage
from hcss_twin.models.sea.slope_statistics import slope_statistics
from hcss_twin.models.sea.wave_field import WaveField
from hcss_twin.models.sea.wave_spectrum import WaveSpectrum
from hcss_twin.providers import SeaInputs

CATALOG = Catalog()
WAVENUMBER = 1e4 / np.array([14.3, 10.0, 6.0, 3.7, 2.75, 1.0, 0.7])
WIND = st.one_of(st.sampled_from([0.0, 60.0]), st.floats(0.0, 60.0))
VIEW = st.one_of(st.sampled_from([0.0, 85.0]), st.floats(0.0, 85.0))
SUN = st.one_of(st.sampled_from([0.0, 89.99]), st.floats(0.0, 89.99))
SOME = examples(60)


@SOME
@given(WIND, VIEW, SUN, st.floats(0.0, np.pi))
def test_the_cox_munk_sea_emits_a_share_and_mirrors_both_ways(wind, view, sun, azimuth):
    sea = CoxMunkSea(SeaInputs(wind, 0.0, 290.0, CATALOG), CoxMunkParameters())
    mu, mu0 = (np.cos(np.radians([each])) for each in (view, sun))
    emissivity = sea.emissivity(WAVENUMBER, mu)
    assert np.all((emissivity > 0.0) & (emissivity < 1.0))
    # With the band and one of its wavelengths alone alike.
    np.testing.assert_allclose(sea.emissivity(WAVENUMBER[2:3], mu), emissivity[:, 2:3], rtol=1e-13)
    forth = sea.brdf(WAVENUMBER, mu, mu0, np.array([azimuth]))
    assert np.all(np.isfinite(forth))
    assert np.all(forth >= 0.0)
    np.testing.assert_allclose(forth, sea.brdf(WAVENUMBER, mu0, mu, np.array([azimuth])), rtol=1e-9)


@SOME
@given(st.floats(allow_nan=True, allow_infinity=True))
def test_any_other_wind_is_refused(wind):
    if 0.0 <= wind <= 60.0:
        return
    with pytest.raises(ValueError, match="allowed 0 to 60"):
        CoxMunkSea(SeaInputs(wind, 0.0, 290.0, CATALOG), CoxMunkParameters())


@SOME
@given(WIND, st.sampled_from(["isotropic", "upwind-crosswind", "gram-charlier"]), st.floats(0.01, 1.0))
def test_slopes_have_variances_above_0_and_a_density_that_is_not_negative(wind, law, mu):
    statistics = slope_statistics(min(wind, 20.0) if law == "gram-charlier" else wind, law)
    assert 0.0 < statistics.variance_crosswind <= 0.16
    assert 0.0 < statistics.variance_upwind <= 0.2
    axis = np.linspace(-8.0, 8.0, 41)
    density = statistics.density(
        axis[:, None] * statistics.variance_upwind**0.5, axis[None, :] * statistics.variance_crosswind**0.5
    )
    assert np.all(density >= 0.0)
    step = 0.16 * statistics.variance_upwind * statistics.variance_crosswind
    assert density.sum() * step**0.5 * 0.4 == pytest.approx(1.0, rel=0.02)
    hidden = smith_lambda(np.array([mu]), statistics.variance_along(0.3))
    assert np.all(np.isfinite(hidden))
    assert np.all(hidden >= 0.0)
    for law_of_foam in ("monahan-1980", "monahan-1980-least-squares", "monahan-1986"):
        assert 0.0 <= foam_coverage(wind, law_of_foam) <= 1.0


@SOME
@given(
    st.sampled_from(["pierson-moskowitz", "jonswap"]),
    st.one_of(WIND, st.floats(1e-6, 1e-2)),
    st.floats(3.0, 6.3).map(lambda x: 10.0**x),
    st.floats(-2.0, 5.0).map(lambda x: 10.0**x),
    st.floats(0.0, 360.0),
    st.integers(-(10**9), 10**9),
    st.integers(-(10**9), 10**9),
    st.floats(0.0, 1e6),
)
def test_a_field_of_waves_is_finite_and_bounded_anywhere(name, wind, fetch, pixel, bearing, row, column, time):
    field = WaveField(WaveSpectrum(name, wind, fetch), bearing, pixel, seed=2, components=32)
    window = slice(row, row + 7), slice(column, column + 9)
    slopes = field.slopes(time, *window)
    # 32 waves of equal slope in phase.
    most = np.sqrt(2.0 * 32.0 * field.resolved_mean_square_slope)
    assert 0.0 <= field.resolved_mean_square_slope < 0.2
    for each in slopes:
        assert each.shape == (7, 9)
        assert np.all(np.isfinite(each))
        assert np.abs(each).max() <= most * (1 + 1e-9)
    part = field.slopes(time, slice(row + 3, row + 4), slice(column + 5, column + 6))
    # Phases of 1e9 pixels of 100 km keep seven digits less than double precision has.
    np.testing.assert_allclose(part[0][0, 0], slopes[0][3, 5], rtol=0, atol=1e-9 + most * 1e-9)
    assert np.all(np.isfinite(field.elevation_m(time, *window)))
