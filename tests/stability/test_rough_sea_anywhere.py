"""The rough sea over all winds, views, waters and choices."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.parameters import RoughSeaParameters
from hcss_twin.models.sea.rough_sea import RoughSea
from hcss_twin.providers import SeaInputs

WAVENUMBER = 1e4 / np.array([14.0, 10.0, 3.7, 2.75, 1.0])
X, _ = np.polynomial.legendre.leggauss(8)
CATALOG = Catalog()


@settings(max_examples=15, deadline=None)
@given(
    wind=st.floats(0.0, 60.0),
    mu=st.floats(0.01, 1.0),
    other=st.floats(0.01, 1.0),
    azimuth=st.floats(0.0, np.pi),
    bearing=st.none() | st.floats(-10.0, 10.0),
    temperature=st.floats(263.15, 318.15),
    slopes=st.sampled_from(["isotropic", "upwind-crosswind", "gram-charlier"]),
    shadowing=st.sampled_from(["none", "separable", "height-correlated"]),
    re_reflection=st.booleans(),
    foam=st.booleans(),
)
def test_every_sea_is_finite_balanced_and_reciprocal(
    wind, mu, other, azimuth, bearing, temperature, slopes, shadowing, re_reflection, foam
):
    wind = min(wind, 20.0) if slopes == "gram-charlier" else wind
    parameters = RoughSeaParameters(slopes=slopes, shadowing=shadowing, re_reflection=re_reflection, foam=foam)
    sea = RoughSea(SeaInputs(wind, 0.0, temperature, CATALOG), parameters)
    views = np.array([mu])
    bearings = None if bearing is None else np.array([bearing])
    emissivity = sea.emissivity(WAVENUMBER, views, bearings)
    assert np.all((emissivity >= 0.0) & (emissivity <= 1.0))
    for basis in ("linear", "lagrange"):
        weights = sea.reflection_weights(WAVENUMBER, views, 0.5 * (X + 1.0), basis, bearings)
        np.testing.assert_allclose(weights.sum(axis=1) + emissivity, 1.0, rtol=0.0, atol=1e-11)
        assert basis == "lagrange" or weights.min() > -1e-7
    into, turn = np.array([other]), np.array([azimuth])
    forth = sea.brdf(WAVENUMBER, views, into, turn, bearings)
    back = sea.brdf(WAVENUMBER, into, views, turn, None if bearings is None else -(bearings + turn))
    assert np.all(np.isfinite(forth))
    assert np.all(forth >= 0.0)
    np.testing.assert_allclose(forth, back, rtol=1e-8, atol=1e-60)
