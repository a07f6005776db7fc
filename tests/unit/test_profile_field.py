"""Profiles at several places: interpolation, and rejected inputs."""

import netCDF4
import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.profile_file import load_profile, load_profiles

PRESSURE_PA = np.array([101300.0, 90000.0, 80000.0, 70000.0, 50000.0, 30000.0, 20000.0, 10000.0])
HEIGHT_M = 44330.0 * (1.0 - (PRESSURE_PA / 101300.0) ** 0.19)


def temperature(latitude, longitude=0.0):
    """Linear in both coordinates, at the levels."""
    return 288.15 - 6.5e-3 * HEIGHT_M - (0.1 + 4e-6 * HEIGHT_M) * (latitude - 35.0) + 0.1 * (longitude - 150.0)


def humidity(latitude):
    """Mole fraction, linear in latitude."""
    return 1e-2 * np.exp(-HEIGHT_M / 1500.0) * (1.0 - 0.02 * (latitude - 35.0))


def write(path, latitude, longitude=None, temperature_of=temperature, names=("latitude", "longitude")):
    """Write a file in the layout of a reanalysis: one time, pressure levels, latitude and longitude."""
    with netCDF4.Dataset(path, "w") as file:
        dimensions = ["time", "pressure_level", names[0]]
        coordinates = {names[0]: latitude} | ({} if longitude is None else {names[1]: longitude})
        file.createDimension("time", 1)
        file.createDimension("pressure_level", PRESSURE_PA.size)
        for name, values in coordinates.items():
            file.createDimension(name, len(values))
            file.createVariable(name, "f8", (name,))[:] = values
        if longitude is not None:
            dimensions.append(names[1])
        pressure = file.createVariable("pressure_level", "f8", ("pressure_level",))
        pressure.units, pressure[:] = "Pa", PRESSURE_PA
        height = file.createVariable("altitude", "f8", ("pressure_level",))
        height.units, height[:] = "m", HEIGHT_M
        for name, units in (("t", "K"), ("h2o", "1")):
            variable = file.createVariable(name, "f8", dimensions)
            variable.units = units
            for row, north in enumerate(latitude):
                for column, east in enumerate([150.0] if longitude is None else longitude):
                    own = temperature_of(north, east) if name == "t" else humidity(north)
                    place = (0, slice(None), row) if longitude is None else (0, slice(None), row, column)
                    variable[place] = own
    return str(path)


def profiles(*arguments, **options):
    return load_profiles(write(*arguments, **options), Catalog()).with_levels_near(36.0, 179.0)


@pytest.mark.parametrize("latitude", [[30.0, 40.0], [20.0, 30.0, 33.0, 41.0, 50.0], [50.0, 41.0, 33.0, 30.0, 20.0]])
def test_a_field_that_is_linear_in_latitude_is_reproduced(tmp_path, latitude):
    field = profiles(tmp_path / "air.nc", latitude)
    for at in (30.0, 31.7, 36.0, 40.0):
        profile = field.at(at, -77.0)
        np.testing.assert_allclose(profile.temperature_K[:8], temperature(at, 150.0), rtol=1e-12)
        np.testing.assert_allclose(profile.pressure_Pa[:8], PRESSURE_PA, rtol=1e-12)
        np.testing.assert_allclose(profile.mixing_ratio["h2o"][:8], humidity(at), rtol=1e-12)


def test_between_places_in_both_directions_it_is_bilinear(tmp_path):
    # Also across the date line, and with the longitudes of the file from 0 to 360.
    latitude, longitude = np.array([30.0, 40.0]), np.array([179.0, 182.0])
    table = np.random.default_rng(4).uniform(-3.0, 3.0, (2, 2))

    def warm(north, east):
        return temperature(35.0, 150.0) + table[int(north > 35.0), int(east > 180.0)]

    field = profiles(tmp_path / "air.nc", latitude, longitude, warm)
    expected = RegularGridInterpolator((latitude, longitude), table)([[33.0, 181.0]])[0]
    found = field.at(33.0, -179.0).temperature_K[:8] - temperature(35.0, 150.0)
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_values_stay_between_those_of_the_neighbours_and_have_no_kinks(tmp_path):
    latitude = np.arange(20.0, 51.0, 5.0)
    front = {20: 4.0, 25: 4.0, 30: 3.9, 35: -2.0, 40: -2.1, 45: -2.1, 50: 0.0}
    field = profiles(
        tmp_path / "air.nc", latitude, temperature_of=lambda north, _: temperature(35.0, 150.0) + front[int(north)]
    )
    at = np.linspace(20.0, 50.0, 151)
    warm = np.array([field.at(each, 179.0).temperature_K[0] for each in at.tolist()])
    surface = warm - temperature(35.0, 150.0)[0]
    cell = np.clip(((at - 20.0) // 5.0).astype(int), 0, 5)
    nodes = np.array(list(front.values()))
    low, high = np.minimum(nodes[cell], nodes[cell + 1]), np.maximum(nodes[cell], nodes[cell + 1])
    assert np.all((surface >= low - 1e-6) & (surface <= high + 1e-6))
    slope = np.diff(surface) / 0.2
    assert (
        np.max(np.abs(np.diff(slope))) < 0.3 * np.ptp(nodes) / 5.0
    )  # piecewise linear interpolation: 1.0 instead of 0.3


def test_leaving_out_a_profile_bounds_the_error_between_them(tmp_path):
    def curved(north, _):
        return temperature(35.0, 150.0) + 0.02 * (north - 35.0) ** 2

    field = profiles(tmp_path / "air.nc", np.arange(20.0, 51.0, 5.0), temperature_of=curved)
    ((factor, exact, guess),) = field.left_out(36.0, 179.0)
    assert factor == 0.25
    bound = factor * np.max(np.abs(exact.temperature_K[:8] - guess.temperature_K[:8]))
    between = np.arange(31.0, 41.0, 0.5).tolist()
    found = [field.at(each, 179.0).temperature_K[0] - curved(each, 0.0)[0] for each in between]
    assert 0.0 < np.max(np.abs(found)) < bound
    ((factor, exact, guess),) = profiles(tmp_path / "two.nc", [30.0, 40.0]).left_out(36.0, 179.0)
    assert factor == 1.0
    difference = exact.temperature_K[:8] - guess.temperature_K[:8]
    np.testing.assert_allclose(difference, temperature(40.0, 150.0) - temperature(30.0, 150.0))


def test_what_a_field_cannot_give_is_refused(tmp_path):
    field = profiles(tmp_path / "air.nc", [30.0, 40.0])
    with pytest.raises(CatalogError, match=r"air\.nc: latitude 41 lies outside the profiles; allowed: 30 to 40 "):
        field.at(41.0, 0.0)
    with pytest.raises(CatalogError, match=r"allowed: one column of levels"):
        load_profile(str(tmp_path / "air.nc"), Catalog())
    with pytest.raises(CatalogError, match=r"latitude does not ascend or descend"):
        profiles(tmp_path / "air.nc", [30.0, 40.0, 35.0])
    with pytest.raises(CatalogError, match=r"air\.nc at 40 N, level 1: t is missing"):
        profiles(tmp_path / "air.nc", [30.0, 40.0], temperature_of=lambda *_: np.full(8, np.nan))
    with pytest.raises(CatalogError, match=r"'t' has the dimensions .*allowed: levels, latitude and longitude"):
        profiles(tmp_path / "air.nc", [30.0, 40.0], [1.0, 2.0], names=("latitude", "station"))
