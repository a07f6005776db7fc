"""Spheres of any size and substance, and clouds of any particles a scenario may ask for."""

import numpy as np
import pytest
from examples import examples
from hypothesis import given
from hypothesis import strategies as st

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.optics.bulk import bulk_moments, bulk_properties
from hcss_twin.models.optics.size_distribution import gamma_distribution, water_content_kg_m3
from hcss_twin.models.optics.spheres import mie_efficiencies, phase_function
from hcss_twin.models.refractive_index import load_refractive_index

CATALOG = Catalog()
INDEX = {name: load_refractive_index(CATALOG, name) for name in ("water-273K", "ice")}


def powers(low, high):
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


@examples(150)
@given(st.floats(1.02, 3.0), st.one_of(st.just(0.0), powers(-10, 0.5)), powers(-5, 3.3))
def test_any_sphere_scatters_no_more_than_it_takes_out(n, k, size):
    extinction, scattering, asymmetry = (
        each[0] for each in mie_efficiencies(np.array([complex(n, k)]), np.array([size]))
    )
    assert 0.0 < scattering <= extinction * (1 + 1e-9)
    orders = np.ceil(size + 4.05 * np.cbrt(size) + 2.0)
    # Each multipole of degree n, electric or magnetic, takes out 2 (2 n + 1) / size^2 at most.
    assert extinction <= 4.0 / size**2 * orders * (orders + 2.0)
    assert -1.0 <= asymmetry <= 1.0
    if k == 0.0:
        assert scattering == pytest.approx(extinction, rel=1e-9)
    if size < 1e-3:
        # The limit of C. F. Bohren and D. R. Huffman (1983), eqs 5.7 and 5.8; next terms are size^2 of these.
        polarisability = (complex(n, k) ** 2 - 1.0) / (complex(n, k) ** 2 + 2.0)
        rayleigh = 8.0 / 3.0 * size**4 * abs(polarisability) ** 2
        assert scattering == pytest.approx(rayleigh, rel=1e-5)
        assert extinction == pytest.approx(rayleigh + 4.0 * size * polarisability.imag, rel=1e-4)


@examples(25)
@given(
    st.sampled_from(["water", "ice"]),
    powers(-3, 2.69),
    st.one_of(st.sampled_from([0.01, 0.4]), st.floats(0.01, 0.4)),
    powers(-9, -1),
    st.floats(0.7, 14.3),
)
def test_any_cloud_has_an_albedo_between_0_and_1_and_a_phase_function_of_mean_1(
    phase, radius, variance, content, micron
):
    """Few radii: what is held here is that nothing breaks, not how well resonances are averaged."""
    cloud = gamma_distribution(phase, radius, variance, content)
    assert water_content_kg_m3(cloud) == pytest.approx(content, rel=1e-6)
    index, wavelength = INDEX["ice" if phase == "ice" else "water-273K"], np.array([micron])
    bulk = bulk_properties(cloud, index, wavelength, 12)
    assert np.all(np.isfinite(bulk.extinction_m1))
    assert np.all(bulk.extinction_m1 > 0.0)
    assert np.all((bulk.albedo > 0.0) & (bulk.albedo <= 1.0 + 1e-12))
    assert np.all(bulk.absorption_m1 > 0.0)
    assert np.all(np.abs(bulk.asymmetry) < 1.0)
    if radius < 50.0:
        moments = bulk_moments(cloud, index, wavelength, 12, 16)
        assert moments[0, 0] == 1.0
        assert np.all(np.abs(moments) <= 1.0 + 1e-12)
        assert np.all(np.isfinite(phase_function(moments, np.linspace(-1.0, 1.0, 19))))
