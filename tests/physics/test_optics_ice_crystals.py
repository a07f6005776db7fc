"""Ice crystals: published band averages come back, and the limits of large particles and of spheres hold."""

import shutil

import netCDF4
import numpy as np
import pytest
from pydantic import ValidationError

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, ScenarioError
from hcss_twin.models.optics.ice_crystals import load_crystals
from hcss_twin.models.optics.mie import BulkOptics, MieOptics
from hcss_twin.models.optics.size_distribution import gamma_distribution, projected_area_m1
from hcss_twin.models.parameters import BulkParameters, MieParameters
from hcss_twin.models.refractive_index import load_refractive_index, load_water_at
from hcss_twin.physics.multiple_scattering.layer import solve_layers
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun
from hcss_twin.physics.planck import planck
from hcss_twin.providers import Microphysics, OpticsInputs

CIRRUS = Microphysics("ice", 7.0, 1.0 / 3.0, 1.0, 0.13e6, (1.0, 150.0))
STRATUS = Microphysics("water", 3.0, 0.193, 1.30, 80e6, (0.02, 50.0))


@pytest.fixture(scope="module")
def bulk() -> BulkOptics:
    # Coarse where nothing ships: the ratios to spheres are what is looked at here.
    return BulkOptics(OpticsInputs(Catalog()), BulkParameters(radius_nodes=50, spectral_step=0.05))


@pytest.fixture(scope="module")
def published():
    with netCDF4.Dataset(Catalog().root / "optics" / "ice-yang-2013.nc") as data:
        return {name: np.asarray(data[name][:]) for name in data.variables if name != "roughness"}


@pytest.mark.parametrize("row", [1, 5])
def test_band_means_are_the_published_ones(bulk, published, row) -> None:
    # The published tables are means over RRTMGP's bands; between band centres ours are interpolated.
    cloud = gamma_distribution("ice", published["effective_diameter"][row] / 2.0, 0.1, 1e-3)
    for band, (low, high) in enumerate(published["band_limits"]):
        if low < 700.0 or high > 3250.0:
            continue
        nu = np.linspace(low, high, 40)
        found = bulk.single_scattering(cloud, nu)
        weight = planck(nu, 245.0)
        weight /= weight.sum()
        extinction = weight @ found.extinction_m1
        scattering = weight @ (found.extinction_m1 * found.albedo)
        asymmetry = weight @ (found.extinction_m1 * found.albedo * found.moments[1]) / scattering
        assert extinction == pytest.approx(published["extinction"][2, band, row], rel=0.01)
        assert scattering / extinction == pytest.approx(published["albedo"][2, band, row], abs=0.012)
        assert asymmetry == pytest.approx(published["asymmetry"][2, band, row], abs=0.03)


def test_diameters_are_enlarged_by_what_the_documentation_says(published) -> None:
    """Published extinction 2 to 5 % below twice the area, and diameters 6 to 9 % larger for it."""
    label = published["published_diameter"]
    visible = int(np.flatnonzero(published["band_limits"][:, 0] == 16000.0)[0])
    # Twice the projected area per mass of ice, m2 g-1, with the diameter in um: 3 / (density D).
    share = published["extinction"][:, visible] * 0.917 * label / 3.0 - 1.0
    assert (round(100 * share.max()), round(100 * share.min())) == (-2, -5)
    enlarged = published["effective_diameter"] / label - 1.0
    assert (round(100 * enlarged.min()), round(100 * enlarged.max())) == (6, 9)


@pytest.mark.parametrize("radius", [20.0, 60.0])
def test_in_the_visible_crystals_take_away_twice_their_projected_area(bulk, radius) -> None:
    cloud = gamma_distribution("ice", radius, 0.1, 1e-3)
    result = bulk.single_scattering(cloud, np.array([1e4 / 0.7]))
    assert result.extinction_m1[0] / projected_area_m1(cloud) == pytest.approx(2.05, abs=0.03)
    assert result.albedo[0] > 0.9999


def test_crystals_scatter_less_forward_than_spheres_in_the_visible(bulk) -> None:
    nu = np.array([1e4 / 2.2, 1e4 / 1.6, 1e4 / 0.87])
    spheres = MieOptics(OpticsInputs(Catalog()), MieParameters())
    crystals, round_ones = (each.single_scattering(CIRRUS, nu).moments[1] for each in (bulk, spheres))
    assert np.all(crystals < round_ones - 0.04)
    assert crystals[2] == pytest.approx(0.75, abs=0.02)  # Yang et al. (2013), severely roughened


def test_rougher_crystals_scatter_less_forward() -> None:
    nu = np.array([1e4 / 0.87])
    asymmetry = [
        BulkOptics(OpticsInputs(Catalog()), BulkParameters(roughness=each)).single_scattering(CIRRUS, nu).moments[1, 0]
        for each in ("smooth", "moderate", "severe")
    ]
    assert asymmetry[0] > max(asymmetry[1:]) + 0.004


def test_albedo_stays_in_range_over_all_wavelengths_and_sizes(bulk) -> None:
    nu = 1e4 / np.linspace(2.0, 16.0, 24)[::-1]
    for radius in (6.0, 30.0, 90.0):
        result = bulk.single_scattering(gamma_distribution("ice", radius, 0.1, 1e-4), nu)
        assert np.all((result.albedo > 0.0) & (result.albedo <= 1.0))
        assert np.all((result.moments[1] > 0.5) & (result.moments[1] < 1.0))


@pytest.mark.parametrize("radius", [5.5, 70.0, 96.0])
def test_sunlight_can_be_solved_over_the_whole_table(bulk, radius) -> None:
    """Near 2.83 um, where ice refracts like air, the asymmetry of the largest crystals is .9951."""
    nu = 1e4 / np.array([2.7, 2.8318, 3.0])
    found = bulk.single_scattering(gamma_distribution("ice", radius, 0.1, 1e-5), nu)
    depth = np.array([[0.5]]) * np.ones((1, nu.size))
    sunlit = np.stack(solve_sun(depth, found.albedo, found.moments, [0.9], 0.8, [1.0], 8, 16))
    assert np.all((sunlit > 0.0) & (sunlit < 1.0))


@pytest.fixture(scope="module")
def columns() -> BulkOptics:
    parameters = BulkParameters(radius_nodes=50, spectral_step=0.05, ice_table="ice-fu-1996", roughness="smooth")
    return BulkOptics(OpticsInputs(Catalog()), parameters)


# Fu (1996), Table 3 and eqs 3.9, and Fu et al. (1998), for Dge = 50 um: wavelengths in um, extinction in m2 g-1,
# co-albedo and asymmetry.
FU = {
    (2.91, 3.42): (0.0501, 0.4645, 0.9329),
    (3.42, 4.0): (0.0505, 0.3742, 0.9058),
    (11.0, 11.0): (0.0474, 0.5255, 0.9569),
}


@pytest.mark.parametrize(("between_um", "published"), FU.items())
def test_hexagonal_columns_are_those_that_fu_published(columns, between_um, published) -> None:
    """From the polynomials as printed; the mean of a band is weighted with sunlight."""
    cloud = gamma_distribution("ice", 50.0 * 3.0 * np.sqrt(3.0) / 8.0, 0.1, 1e-3)
    nu = np.linspace(1e4 / between_um[1], 1e4 / between_um[0], 40)
    found = columns.single_scattering(cloud, nu)
    weight = planck(nu, 5778.0) / np.sum(planck(nu, 5778.0))
    extinction, scattering = weight @ found.extinction_m1, weight @ (found.extinction_m1 * found.albedo)
    asymmetry = weight @ (found.extinction_m1 * found.albedo * found.moments[1]) / scattering
    assert extinction == pytest.approx(published[0], rel=0.01)
    assert 1.0 - scattering / extinction == pytest.approx(published[1], abs=0.01)
    assert asymmetry == pytest.approx(published[2], abs=0.01)


def emissivity(depth, albedo, asymmetry) -> np.ndarray:
    moments = np.stack([np.ones_like(albedo), asymmetry])
    return solve_layers(depth, albedo, moments, [0.94], 8).emissivity[0, :, 0]


@pytest.mark.parametrize("thickness_m", [1000.0, 4000.0])
def test_emissivity_of_cirrus_is_that_of_the_published_bands_within_a_hundredth(bulk, published, thickness_m) -> None:
    row = 5
    cloud = gamma_distribution("ice", published["effective_diameter"][row] / 2.0, 0.1, 1e-5)
    for band, (low, high) in enumerate(published["band_limits"]):
        if low < 700.0 or high > 1400.0:
            continue
        nu = np.linspace(low, high, 8)
        found = bulk.single_scattering(cloud, nu)
        weight = planck(nu, 245.0) / np.sum(planck(nu, 245.0))
        ours = weight @ emissivity(thickness_m * found.extinction_m1[None], found.albedo, found.moments[1])
        numbers = (published[name][2, band, [row]] for name in ("extinction", "albedo", "asymmetry"))
        extinction, albedo, asymmetry = numbers  # m2 g-1; 0.01 g m-3 of ice
        assert ours == pytest.approx(emissivity(0.01 * thickness_m * extinction[None], albedo, asymmetry)[0], abs=0.01)


def test_emissivity_of_cirrus_differs_from_a_second_set_by_less_than_four_hundredths(bulk, columns) -> None:
    nu = np.linspace(1e4 / 14.0, 1e4 / 8.0, 13)
    for thickness_m in (300.0, 1200.0, 4000.0):
        each = [optics.single_scattering(CIRRUS, nu) for optics in (bulk, columns)]
        one, other = (emissivity(thickness_m * of.extinction_m1[None], of.albedo, of.moments[1]) for of in each)
        assert 0.0 < np.max(np.abs(one - other)) < 0.04


def test_a_size_outside_the_table_is_refused(bulk) -> None:
    with pytest.raises(
        ValueError, match=r"effective radius 4 um of ice: .* allows 5\.4\d+ to 96\.0\d; closest is 5\.4"
    ):
        bulk.single_scattering(gamma_distribution("ice", 4.0, 0.1, 1e-4), np.array([1000.0]))


def test_unknown_tables_are_refused(tmp_path) -> None:
    with pytest.raises(CatalogError, match="'yang' is neither"):
        load_crystals(Catalog(), "yang", "severe")
    with pytest.raises(CatalogError, match="no roughness 'rough'; it has smooth, moderate, severe"):
        load_crystals(Catalog(), "ice-yang-2013", "rough")
    (tmp_path / "mine.nc").write_bytes(b"no")
    with pytest.raises(CatalogError, match="not a readable NetCDF"):
        load_crystals(Catalog(base=tmp_path), "mine.nc", "severe")


@pytest.mark.parametrize(
    ("name", "place", "value", "message"),
    [
        ("band_limits", (0, 0), 0.0, "above 0"),
        ("band_limits", (0, 1), 1.0, "limits ascend"),
        ("band_limits", (1, 0), 1.0, "must increase"),
        ("effective_diameter", 0, 0.0, "above 0"),
        ("extinction_ratio", (2, 3, 4), 0.0, "ratios must be above 0"),
    ],
)
def test_a_table_with_an_impossible_value_is_refused(tmp_path, name, place, value, message) -> None:
    path = tmp_path / "mine.nc"
    shutil.copyfile(Catalog().root / "optics" / "ice-yang-2013.nc", path)
    with netCDF4.Dataset(path, "a") as data:
        data[name][place] = value
    with pytest.raises(CatalogError, match=message):
        load_crystals(Catalog(base=tmp_path), "mine.nc", "severe")


def test_water_is_the_same_spheres_as_of_mie() -> None:
    nu = np.array([900.0, 2500.0])
    inputs = OpticsInputs(Catalog())
    ours = BulkOptics(inputs, BulkParameters()).single_scattering(STRATUS, nu)
    theirs = MieOptics(inputs, MieParameters(water_index="water-273K")).single_scattering(STRATUS, nu)
    np.testing.assert_array_equal(ours.extinction_m1, theirs.extinction_m1)
    np.testing.assert_array_equal(ours.moments, theirs.moments)


def test_water_index_between_two_tables_is_linear_in_temperature() -> None:
    catalog = Catalog()
    cold, warm = (load_refractive_index(catalog, f"water-{kelvin}K") for kelvin in (263, 273))
    between = load_water_at(catalog, 268.0)
    np.testing.assert_allclose(between.n, 0.5 * (cold.n + warm.n), rtol=1e-12)
    np.testing.assert_allclose(between.k, np.sqrt(cold.k * warm.k), rtol=1e-12)
    np.testing.assert_array_equal(load_water_at(catalog, 263.0).k, cold.k)
    # Rowe et al. (2020), Fig 5: near 11 um colder water absorbs more.
    assert load_water_at(catalog, 243.0).at(np.array([900.0]))[0].imag > warm.at(np.array([900.0]))[0].imag


@pytest.mark.parametrize(("kelvin", "closest"), [(239.0, "240"), (274.0, "273")])
def test_water_temperatures_without_data_are_refused(kelvin, closest) -> None:
    with pytest.raises(ValidationError, match=f"equal to {closest}"):
        MieParameters(water_temperature_K=kelvin)
    with pytest.raises(ValueError, match=f"allow 240 to 273 K; closest is {closest}"):
        load_water_at(Catalog(), kelvin)


def test_an_index_and_a_temperature_together_are_refused() -> None:
    parameters = MieParameters(water_index="water", water_temperature_K=260.0)
    with pytest.raises(ScenarioError, match=r"water_temperature_K: given together with water_index = 'water'"):
        MieOptics(OpticsInputs(Catalog()), parameters)
