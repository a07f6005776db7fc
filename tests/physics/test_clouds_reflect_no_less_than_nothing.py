"""Sunlight that clouds of spheres reflect is nowhere negative, though the moments of their peaks are cut off."""

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.optics.mie import BulkOptics, MieOptics
from hcss_twin.models.parameters import BulkParameters, MieParameters
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun
from hcss_twin.physics.multiple_scattering.two_stream import solve_sun_two_stream
from hcss_twin.providers import OpticsInputs
from hcss_twin.scenario.cloud_types import load_cloud_type

WAVELENGTH_UM = np.array([0.75, 0.9, 1.2, 1.6, 2.2, 2.8, 3.094, 3.7, 4.5])
THICKNESS = 2.0 ** np.arange(-4.0, 6.0)


@pytest.fixture(scope="module")
def catalog():
    return Catalog()


def optics_of(catalog, provider, name):
    cloud_type = load_cloud_type(name, catalog)
    particles = cloud_type.microphysics.particles(cloud_type.layer.material)
    inputs = OpticsInputs(catalog)
    made = MieOptics(inputs, MieParameters()) if provider == "mie" else BulkOptics(inputs, BulkParameters())
    return made.single_scattering(particles, 1e4 / WAVELENGTH_UM)


@pytest.mark.parametrize(
    ("provider", "name"), [("mie", "cirrus"), ("mie", "stratus"), ("bulk", "stratus"), ("bulk", "cumulus")]
)
def test_no_cloud_reflects_less_than_nothing(catalog, provider, name) -> None:
    cloud = optics_of(catalog, provider, name)
    depth = THICKNESS[:, np.newaxis] * np.ones(WAVELENGTH_UM.size)
    random = np.random.default_rng(190)
    for sun_deg in random.uniform(0.0, 85.0, 3):
        view, azimuth = np.cos(np.radians(random.uniform(0.0, 75.0, 6))), random.uniform(0.0, np.pi, 6)
        where = view, float(np.cos(np.radians(sun_deg))), azimuth
        brdf, _ = solve_sun(depth, cloud.albedo, cloud.moments, *where, streams=8, modes=16)
        assert np.all(brdf > 0.0)
        closed, _ = solve_sun_two_stream(depth, cloud.albedo, cloud.moments, *where, streams=8)
        assert np.all(closed > 0.0)


def test_ice_spheres_at_3_um_reflect_what_they_do_with_all_their_moments(catalog) -> None:
    """Thin cirrus where ice absorbs most: the light of a single scattering is nearly all there is."""
    wavelength = np.array([3.094])
    cloud_type = load_cloud_type("cirrus", catalog)
    particles = cloud_type.microphysics.particles("ice")
    few, many = (
        MieOptics(OpticsInputs(catalog), MieParameters(moments=count)).single_scattering(particles, 1e4 / wavelength)
        for count in (128, 512)
    )
    assert abs(many.moments[-1, 0]) < 1e-6
    where = np.cos(np.radians([0.0, 18.0, 40.0, 60.0])), 0.73, np.array([0.0, 1.4, 2.0, 3.1])
    depth = np.array([[0.117], [0.256]])
    found, exact = (solve_sun(depth, each.albedo, each.moments, *where, streams=8, modes=16)[0] for each in (few, many))
    np.testing.assert_allclose(found, exact, rtol=0.005)
