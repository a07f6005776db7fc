"""The shipped LOWTRAN7 table against the paper's MODTRAN columns and against itself."""

import numpy as np
import pytest
from printed_tables import PAPER

from hcss_twin.core.catalog import Catalog, catalog_root
from hcss_twin.models.atmosphere.path_radiance import path_radiance
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.atmosphere.table import TableTransmittance
from hcss_twin.models.parameters import TableParameters
from hcss_twin.models.radiance.spectral_grid import SolarSpectrum, SpectralGrid
from hcss_twin.physics.paths import to_space
from hcss_twin.physics.planck import planck
from hcss_twin.providers import AtmosphereInputs
from hcss_twin.scenario.bands import spectral_band

VIEWS = PAPER["view_zenith_deg"]


@pytest.fixture(scope="module")
def atmosphere():
    catalog = Catalog()
    profile = load_profile("us-standard-1976", catalog)
    return TableTransmittance(AtmosphereInputs(profile, catalog), TableParameters()), profile


def band_grid(name, table):
    return SpectralGrid.dense([spectral_band(name, Catalog())], table.declares.native_grid_cm1)


# The MODTRAN columns are thermal-only runs over a black surface whose temperature was fitted to each.
@pytest.mark.parametrize(
    ("table_name", "row", "band", "surface_K", "tolerance"),
    [
        ("table_2", "Scenario3", "mwir", 280.19, 0.007),
        ("table_4", "3.0-5.0", "mwir", 278.65, 0.007),
        ("table_2", "Scenario5", "lwir", 278.90, 0.005),
        ("table_4", "8.0-14.0", "lwir", 285.15, 0.005),
    ],
)
def test_black_surface_gives_the_modtran_columns(atmosphere, table_name, row, band, surface_K, tolerance):
    table, profile = atmosphere
    grid = band_grid(band, table)
    wavenumber = grid.wavenumber_cm1
    computed = []
    for zenith in VIEWS:
        spectrum = table.transmittance(wavenumber, [to_space(0.0, zenith)])[0] * planck(wavenumber, surface_K)
        spectrum = spectrum + path_radiance(table, profile, wavenumber, [0.0], zenith)[0]
        computed.append(float(spectrum @ grid.weights_cm1[0]))
    printed = np.array(PAPER[table_name][row]["Modtran"])
    assert np.sqrt(np.mean((np.array(computed) / printed - 1) ** 2)) < tolerance


class WithoutOwnPathRadiance:
    """The same transmittances, path radiance left to the engine."""

    def __init__(self, table):
        self.declares = table.declares
        self.transmittance = table.transmittance


@pytest.mark.parametrize(("band", "tolerance"), [("mwir", 0.006), ("lwir", 0.005)])
@pytest.mark.parametrize("zenith", [0.0, 35.0, 70.0])
def test_engine_path_radiance_agrees_with_lowtran7s_own(atmosphere, band, tolerance, zenith):
    table, profile = atmosphere
    wavenumber = band_grid(band, table).wavenumber_cm1
    weights = band_grid(band, table).weights_cm1[0]
    # The table's highest target is at 20 km: above it only LOWTRAN7's own sum knows the emission.
    top = 20_000.0
    levels = profile.altitude_m[profile.altitude_m <= top]
    transmittance = table.transmittance(wavenumber, [to_space(float(level), zenith) for level in levels])
    layer_K = 0.5 * (profile.temperature_at(levels)[1:] + profile.temperature_at(levels)[:-1])
    below = np.sum(planck(wavenumber[None, :], layer_K[:, None]) * np.diff(transmittance, axis=0), axis=0)
    above = path_radiance(table, profile, wavenumber, [top], zenith)[0]
    own = path_radiance(table, profile, wavenumber, [0.0], zenith)[0]
    assert (below + above) @ weights == pytest.approx(own @ weights, rel=tolerance)


def test_transmittance_at_the_nodes_is_the_stored_one(atmosphere):
    import netCDF4

    table, _ = atmosphere
    with netCDF4.Dataset(catalog_root() / "atmospheres" / "us-standard-1976-lowtran7.nc") as stored:
        wavenumber = np.asarray(stored["wavenumber_cm1"][:], dtype=np.float64)
        assert table.declares.valid["wavenumber_cm1"] == (wavenumber.min(), wavenumber.max())
        for height in (0, 5, 12):
            for angle in (0, 4, 10):
                target = float(stored["target_altitude_m"][height])
                zenith = float(stored["zenith_deg"][angle])
                expected = np.asarray(stored["transmittance"][height, angle], dtype=np.float64)
                found = table.transmittance(wavenumber, [to_space(target, zenith)])[0]
                np.testing.assert_allclose(found, expected, atol=2e-7)


def test_two_way_path_is_longer_than_either_leg_but_more_transparent_than_their_product(atmosphere):
    table, _ = atmosphere
    grid = band_grid("mwir", table)
    wavenumber = grid.wavenumber_cm1
    sunlight = SolarSpectrum(Catalog())(wavenumber) * grid.weights_cm1[0]
    view, sun = to_space(0.0, 20.0), to_space(0.0, 24.39)
    up, down, both = table.transmittance(wavenumber, [view, sun, view + sun])
    # Where nothing passes all three are 1e-30, to rounding.
    assert np.all(both <= np.minimum(up, down) * (1 + 1e-12))
    # LOWTRAN7 with the absorber amounts of both legs: the product has 0.83 of the true band mean in sunlight.
    assert (up * down) @ sunlight / (both @ sunlight) == pytest.approx(0.83, abs=0.02)


def test_two_equal_legs_are_one_leg_of_twice_the_air_mass(atmosphere):
    table, profile = atmosphere
    wavenumber = band_grid("lwir", table).wavenumber_cm1
    airmass = profile.mean_airmass(0.0, np.linspace(0, 80, 8001))
    slant = float(np.interp(2.0, airmass, np.linspace(0, 80, 8001)))
    vertical = to_space(0.0, 0.0)
    twice, once = table.transmittance(wavenumber, [vertical + vertical, to_space(0.0, slant)])
    np.testing.assert_allclose(twice, once, atol=1e-5)  # slant is known to 0.01 deg
