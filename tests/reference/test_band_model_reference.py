"""The band model against results of the LOWTRAN7 Fortran (tests/data/lowtran7-reference.nc, made by a recipe)."""

from pathlib import Path

import netCDF4
import numpy as np
import pytest
from printed_tables import PAPER

from hcss_twin.core.catalog import Catalog, catalog_root
from hcss_twin.models.atmosphere.band_model.provider import BandModelTransmittance
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.parameters import COEFFICIENTS, BandModelParameters
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.physics.paths import to_space
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import Profile
from hcss_twin.providers import AtmosphereInputs
from hcss_twin.scenario.bands import spectral_band

REFERENCE = Path(__file__).parent.parent / "data" / "lowtran7-reference.nc"
LOWTRAN7 = COEFFICIENTS["lowtran7"]
MODELS = range(6)
WINTER = (2, 4)


@pytest.fixture(scope="module")
def reference():
    with netCDF4.Dataset(REFERENCE) as file:
        file.set_auto_mask(False)
        return {name: np.asarray(variable[:], dtype=np.float64) for name, variable in file.variables.items()}


@pytest.fixture(scope="module")
def band_model(reference):
    """Provider for one of LOWTRAN7's own model atmospheres, at LOWTRAN7's levels."""
    with netCDF4.Dataset(catalog_root() / "atmospheres" / f"{LOWTRAN7}.nc") as file:
        file.set_auto_mask(False)
        tables = {name: np.asarray(variable[:], dtype=np.float64) for name, variable in file.variables.items()}
    at = np.searchsorted(tables["altitude_km"], reference["level_altitude_km"])
    np.testing.assert_array_equal(tables["altitude_km"][at], reference["level_altitude_km"])
    catalog = Catalog()

    def make(model, maritime):
        gases = {gas: tables[f"{gas}_ppmv"][model, at] * 1e-6 for gas in ("h2o", "co2", "o3", "n2o", "co", "ch4", "o2")}
        profile = Profile(
            f"model {model + 1}",
            1e3 * tables["altitude_km"][at],
            100.0 * tables["pressure_mb"][model, at],
            tables["temperature_K"][model, at],
            gases,
        )
        parameters = BandModelParameters(
            aerosol="maritime" if maritime else "none",
            season="fall-winter" if model in WINTER else "spring-summer",
            earth_radius_m=1e3 * reference["earth_radius_km"][model],
            file=LOWTRAN7,
        )
        return BandModelTransmittance(AtmosphereInputs(profile, catalog), parameters)

    return make


def targets(reference):
    return [to_space(1e3 * height, zenith) for height in reference["target_km"] for zenith in reference["zenith_deg"]]


@pytest.mark.parametrize("maritime", [False, True], ids=["clear", "maritime"])
@pytest.mark.parametrize("model", MODELS)
def test_transmittance_is_that_of_the_fortran(reference, band_model, model, maritime):
    expected = reference["transmittance"][model, int(maritime)]
    paths = targets(reference)
    found = band_model(model, maritime).transmittance(reference["coarse_cm1"], paths)
    error = found - expected.reshape(found.shape)
    # Required: 2e-3 and 2e-4.
    assert np.max(np.abs(error)) < 2e-4
    assert np.sqrt(np.mean(error**2)) < 5e-5


def test_every_wavenumber_agrees_also_between_levels_and_at_85_deg(reference, band_model):
    keys = ("model", "maritime", "target_km", "zenith_deg")
    rows = zip(*(reference[f"complete_{key}"] for key in keys), strict=True)
    for (model, maritime, height, zenith), expected in zip(rows, reference["complete_transmittance"], strict=True):
        provider = band_model(int(model) - 1, bool(maritime))
        np.testing.assert_array_equal(provider.declares.native_grid_cm1, reference["wavenumber_cm1"])
        found = provider.transmittance(reference["wavenumber_cm1"], [to_space(1e3 * height, zenith)])[0]
        assert np.max(np.abs(found - expected)) < 2e-4
        assert np.sqrt(np.mean((found - expected) ** 2)) < 1e-4


@pytest.mark.parametrize("maritime", [False, True], ids=["clear", "maritime"])
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("direction", ["path", "sky"])
def test_thermal_radiance_is_that_of_the_fortran(reference, band_model, model, maritime, direction):
    provider = band_model(model, maritime)
    native = provider.declares.native_grid_cm1
    expected = reference[f"{direction}_radiance"][model, int(maritime)]
    compute = provider.path_radiance if direction == "path" else provider.sky_radiance
    for band, (low, high) in enumerate(reference["band_um"]):
        inside = native[(native >= 1e4 / high) & (native <= 1e4 / low)]
        found = np.mean(compute(inside, targets(reference)), axis=1)
        np.testing.assert_allclose(found, expected[:, :, band].ravel(), rtol=1e-3)


def test_sun_target_sensor_is_one_path_as_in_the_fortran(reference, band_model):
    keys = ("model", "maritime", "target_km", "view_deg", "sun_deg")
    rows = zip(*(reference[f"sunlit_{key}"] for key in keys), strict=True)
    products = []
    for (model, maritime, height, view, sun), expected in zip(rows, reference["sunlit_transmittance"], strict=True):
        legs = [to_space(1e3 * height, zenith) for zenith in (view, sun)]
        one, other, both = band_model(int(model) - 1, bool(maritime)).transmittance(
            reference["coarse_cm1"], [*legs, legs[0] + legs[1]]
        )
        # LOWTRAN7 prints four decimals.
        assert np.max(np.abs(both - expected)) < 2e-4
        products.append(np.max(np.abs(one * other - expected)))
    # The product of two legs would fail by far.
    assert min(products) > 0.05


def test_sunlight_scattered_once_is_that_of_the_fortran(reference, band_model):
    keys = ("model", "maritime", "target_km", "view_deg", "surface_sun_deg", "relative_azimuth_deg", "asymmetry")
    rows = zip(*(reference[f"sunlit_{key}"] for key in keys), strict=True)
    for (model, maritime, height, view, sun, azimuth, asymmetry), expected in zip(
        rows, reference["sunlit_scattered"], strict=True
    ):
        provider = band_model(int(model) - 1, bool(maritime))
        path = [to_space(1e3 * height, view)]
        found = provider.solar_path_radiance(reference["coarse_cm1"], path, sun, azimuth, asymmetry)[0]
        bright = expected > 1e-3 * expected.max()  # elsewhere single precision shows
        np.testing.assert_allclose(found[bright], expected[bright], rtol=2e-3)


# Thermal-only MODTRAN runs of the paper over a black surface whose temperature was fitted to each column.
@pytest.mark.parametrize(
    ("table_name", "row", "band", "surface_K", "tolerance"),
    [
        ("table_2", "Scenario3", "mwir", 280.19, 0.007),
        ("table_4", "3.0-5.0", "mwir", 278.65, 0.007),
        ("table_2", "Scenario5", "lwir", 278.90, 0.005),
        ("table_4", "8.0-14.0", "lwir", 285.15, 0.005),
    ],
)
def test_clear_air_over_a_black_surface_gives_the_modtran_columns(table_name, row, band, surface_K, tolerance):
    catalog = Catalog()
    profile = load_profile("us-standard-1976", catalog)
    provider = BandModelTransmittance(
        AtmosphereInputs(profile, catalog), BandModelParameters(aerosol="none", file=LOWTRAN7)
    )
    grid = SpectralGrid.dense([spectral_band(band, catalog)], provider.declares.native_grid_cm1)
    paths = [to_space(0.0, zenith) for zenith in PAPER["view_zenith_deg"]]
    spectrum = provider.transmittance(grid.wavenumber_cm1, paths) * planck(grid.wavenumber_cm1, surface_K)
    spectrum += provider.path_radiance(grid.wavenumber_cm1, paths)
    printed = np.array(PAPER[table_name][row]["Modtran"])
    assert np.sqrt(np.mean((spectrum @ grid.weights_cm1[0] / printed - 1) ** 2)) < tolerance
