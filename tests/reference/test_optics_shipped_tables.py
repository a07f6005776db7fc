"""Tables that ship hold what would be computed without them."""

from dataclasses import replace

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.optics import bulk, table_store
from hcss_twin.models.optics.bulk import Accuracy, BulkTable, bulk_moments, bulk_properties
from hcss_twin.models.optics.mie import BulkOptics, MieOptics
from hcss_twin.models.optics.spheres import phase_function
from hcss_twin.models.parameters import BulkParameters, MieParameters
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.providers import OpticsInputs
from hcss_twin.scenario.cloud_types import load_cloud_type

TYPES = ("stratus", "stratocumulus", "cumulus", "paper-simulated", "cirrus")
PROVIDERS = {"mie": (MieOptics, MieParameters()), "bulk": (BulkOptics, BulkParameters())}
SHIPPED = sorted(name for name in Catalog().names("optics", ".nc") if not name.startswith("ice-"))


def particles(name):
    cloud_type = load_cloud_type(name, Catalog())
    return cloud_type.microphysics.particles(cloud_type.layer.material)


def refuse(*_):
    raise AssertionError("a shipped type was computed")


@pytest.mark.parametrize("provider", sorted(PROVIDERS))
@pytest.mark.parametrize("name", TYPES)
def test_types_of_the_catalog_need_no_mie_series_in_a_run(name, provider, monkeypatch, tmp_path) -> None:
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(bulk, "bulk_properties", refuse)
    monkeypatch.setattr(bulk, "bulk_moments", refuse)
    make, parameters = PROVIDERS[provider]
    result = make(OpticsInputs(Catalog()), parameters).single_scattering(
        particles(name), 1e4 / np.linspace(0.3, 16.0, 300)[::-1]
    )
    assert np.all(result.extinction_m1 > 0.0)
    assert np.all((result.albedo > 0.0) & (result.albedo <= 1.0))
    assert np.all(np.abs(result.moments) <= 1.0)
    assert not list(tmp_path.rglob("*.nc"))


@pytest.mark.parametrize("shipped", SHIPPED)
def test_a_shipped_table_equals_computation_at_random_nodes(shipped) -> None:
    provider, name = shipped.split("-")
    parameters = PROVIDERS[provider][1]
    cloud = particles(name)
    water = cloud.material == "water"
    index = load_refractive_index(Catalog(), parameters.water_index if water else parameters.ice_index)
    count = 2 if shipped == "bulk-cirrus" else parameters.moments_of(cloud.material)
    table = BulkTable(cloud, index, Accuracy(parameters.radius_nodes, parameters.spectral_step, count))
    table_store.read_into(table, Catalog().root / "optics" / f"{shipped}.nc")
    assert not np.any(np.isnan(table.properties.values))
    generator = np.random.default_rng(len(shipped))
    particle, radii = replace(cloud, number_density_m3=1.0), parameters.radius_nodes

    def properties(wavelength_um):
        found = bulk_properties(particle, index, wavelength_um, radii)
        return np.stack([np.log(found.extinction_m1), np.log(found.absorption_m1), found.asymmetry])

    def moments(wavelength_um):
        return bulk_moments(particle, index, wavelength_um, radii, count).astype(np.float32)  # as in files

    for part, evaluate in ((table.properties, properties), (table.moments, moments)):
        if part is table.moments and count == 2:
            continue
        beyond = np.flatnonzero(part.nodes > np.log(2.0))  # shorter wavelengths take long
        chosen = np.sort(generator.choice(beyond, 3, replace=False))
        np.testing.assert_allclose(part.values[:, chosen], evaluate(np.exp(part.nodes[chosen])), rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize(
    ("low_um", "high_um", "extinction", "albedo", "moment"),
    [(2.6, 16.0, 1e-5, 5e-6, 3e-4), (1.0, 2.6, 3e-4, 1e-4, 3e-3)],
)
def test_interpolation_stays_within_the_stated_errors(low_um, high_um, extinction, albedo, moment) -> None:
    cloud, index = particles("stratus"), load_refractive_index(Catalog(), "water-273K")
    optics = BulkOptics(OpticsInputs(Catalog()), BulkParameters())
    wavelength = np.sort(np.random.default_rng(5).uniform(low_um, high_um, 5))
    found = optics.single_scattering(cloud, 1e4 / wavelength)  # in the order of the wavelengths
    # Not at the table's nodes, and with other radii.
    exact = bulk_properties(cloud, index, wavelength, 331)
    np.testing.assert_allclose(found.extinction_m1, exact.extinction_m1, rtol=extinction)
    np.testing.assert_allclose(found.albedo, exact.albedo, atol=albedo)
    moments = bulk_moments(cloud, index, wavelength, 613, 128)
    np.testing.assert_allclose(found.moments, moments, atol=moment)


@pytest.mark.parametrize("name", ["stratus", "cumulus"])
def test_shipped_moments_make_phase_functions_above_zero_that_are_those_of_the_spheres(name) -> None:
    cloud, index = particles(name), load_refractive_index(Catalog(), "water")
    wavelength = np.sort(np.random.default_rng(11).uniform(3.2, 14.3, 12))[::-1]
    moments = MieOptics(OpticsInputs(Catalog()), MieParameters()).single_scattering(cloud, 1e4 / wavelength).moments
    mu = np.cos(np.linspace(0.0, np.pi, 361))
    shipped = phase_function(moments, mu)
    assert np.all(shipped > 0.0)
    in_full = phase_function(bulk_moments(cloud, index, wavelength[:3], 600, 400), mu)
    np.testing.assert_allclose(shipped[:, :3], in_full, rtol=0.01)
