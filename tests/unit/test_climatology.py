"""Interpolation in the climatology: exact at its nodes, closed round the globe and the year, honest on land."""

from datetime import UTC, datetime, timedelta, timezone

import netCDF4
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcss_twin.core.catalog import Catalog, catalog_root
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.climatology import MAX_DISTANCE_KM, Climatology
from hcss_twin.models.atmosphere.cloud_top import climatological_cloud_top

FILE = catalog_root() / "climatology" / "coads-monthly.nc"
CLIMATE = Climatology(Catalog())


def middle_of(month, year=2023):
    """Instant at (month - 1/2) / 12 of a year."""
    start, end = datetime(year, 1, 1, tzinfo=UTC), datetime(year + 1, 1, 1, tzinfo=UTC)
    return start + (end - start) * ((month - 0.5) / 12)


def stored(name, month, latitude, longitude):
    with netCDF4.Dataset(FILE) as dataset:
        row = int(np.argmin(np.abs(dataset["latitude"][:] - latitude)))
        column = int(np.argmin(np.abs(dataset["longitude"][:] - longitude % 360)))
        return float(dataset[name][month - 1, row, column])


@pytest.mark.parametrize("month", [1, 4, 12])
@pytest.mark.parametrize("place", [(1, 181), (35, 151), (-39, 359), (61, 1)])
def test_cell_centres_in_mid_month_give_the_cell(place, month):
    for name in ("sea_surface_temperature", "wind_speed", "air_temperature", "specific_humidity"):
        found = CLIMATE.look_up(name, *place, middle_of(month))
        assert found.value == pytest.approx(stored(name, month, *place), abs=1e-6)
        assert found.distance_km == 0


def test_between_cells_and_months_it_is_the_mean():
    cells = [(35, 149), (35, 151), (37, 149), (37, 151)]
    expected = np.mean([stored("sea_surface_temperature", m, *cell) for cell in cells for m in (4, 5)])
    time = middle_of(4) + (middle_of(5) - middle_of(4)) / 2
    assert CLIMATE.look_up("sea_surface_temperature", 36, 150, time).value == pytest.approx(expected, abs=1e-6)


@given(latitude=st.floats(-35, 35), longitude=st.floats(170, 190), turns=st.integers(-1, 0))
def test_longitude_is_a_circle(latitude, longitude, turns):
    time = middle_of(7)
    one = CLIMATE.look_up("sea_surface_temperature", latitude, longitude, time).value
    assert CLIMATE.look_up("sea_surface_temperature", latitude, longitude + 360 * turns, time).value == pytest.approx(
        one, abs=1e-8
    )


@pytest.mark.parametrize("longitude", [0.0, 180.0, 1.0, 359.9999])
def test_no_step_where_the_file_begins(longitude):
    values = [CLIMATE.look_up("wind_speed", -30.5, longitude + d, middle_of(3)).value for d in (-1e-6, 0, 1e-6)]
    assert np.ptp(values) < 1e-5


@given(st.datetimes(datetime(1950, 1, 1), datetime(2090, 12, 30)))
def test_no_step_in_time_not_even_at_new_year(start):
    start = start.replace(tzinfo=UTC)
    for instant in (start, datetime(start.year, 1, 1, tzinfo=UTC)):
        before = CLIMATE.look_up("sea_surface_temperature", 40, -40, instant - timedelta(minutes=5)).value
        after = CLIMATE.look_up("sea_surface_temperature", 40, -40, instant + timedelta(minutes=5)).value
        assert abs(after - before) < 0.003


def test_the_zone_of_the_time_does_not_matter():
    utc = datetime(2024, 4, 20, 2, 30, tzinfo=UTC)
    local = utc.astimezone(timezone(timedelta(hours=10)))
    assert (
        CLIMATE.look_up("air_temperature", 35, 150, utc).value
        == CLIMATE.look_up("air_temperature", 35, 150, local).value
    )


@pytest.mark.parametrize("place", [(52.5, 13.4), (40, -100), (-25, 135), (0, 25), (-85, 0)])
def test_land_is_told(place):
    assert CLIMATE.is_land(*place)
    with pytest.raises(CatalogError, match="on land"):
        CLIMATE.look_up("sea_surface_temperature", *place, middle_of(6))


@pytest.mark.parametrize("place", [(43.3, 5.3), (21.3, -157.9), (1.3, 103.8), (-33.9, 18.4), (54.3, 10.3)])
def test_coasts_are_sea(place):
    """Marseille, Honolulu, Singapore, Cape Town, Kiel."""
    assert not CLIMATE.is_land(*place)
    assert 273 < CLIMATE.look_up("sea_surface_temperature", *place, middle_of(6)).value < 304


def test_where_no_ship_was_the_nearest_reports_are_used_and_their_distance_is_said():
    found = CLIMATE.look_up("sea_surface_temperature", -51.0, -21.0, middle_of(7))
    assert 0 <= found.distance_km <= MAX_DISTANCE_KM
    with netCDF4.Dataset(FILE) as dataset:
        missing = np.ma.getmaskarray(dataset["sea_surface_temperature"][6])
        rows, columns = np.nonzero(missing[20:24])
        latitude, longitude = dataset["latitude"][20:24], dataset["longitude"][:]
        distances = []
        for row, column in zip(rows, columns, strict=True):
            try:
                each = CLIMATE.look_up(
                    "sea_surface_temperature", float(latitude[row]), float(longitude[column]), middle_of(7)
                )
            except CatalogError:
                continue
            distances.append(each.distance_km)
    # A cell centre without report has none around it; its neighbours are 2 degrees away or more.
    assert distances
    assert min(distances) > 100
    assert max(distances) <= MAX_DISTANCE_KM


def test_ice_and_empty_seas_are_told():
    with pytest.raises(CatalogError, match=r"no sea surface temperature within 500 km of 86 N 0 E in month"):
        CLIMATE.look_up("sea_surface_temperature", 86, 0, middle_of(1))
    with pytest.raises(ValueError, match="latitude_deg 91"):
        CLIMATE.look_up("wind_speed", 91, 0, middle_of(1))


def test_the_file_is_small_and_says_what_it_is():
    assert FILE.stat().st_size < 1.5e6
    with netCDF4.Dataset(FILE) as dataset:
        assert "COADS" in dataset.title
        assert "public domain" in dataset.license
        assert "7.6.0-5" in dataset.origin


def test_a_cloud_top_is_as_much_colder_than_the_air_as_the_model_atmosphere_is_there():
    day = datetime(2019, 4, 20, 2, 30, tzinfo=UTC)
    at_sea, low, high = (climatological_cloud_top(35.0, 150.0, day, top) for top in (0.0, 1500.0, 6000.0))
    assert at_sea.scatter_K == 0.0
    assert at_sea.temperature_K == pytest.approx(
        Climatology(Catalog()).look_up("air_temperature", 35.0, 150.0, day).value
    )
    # The troposphere cools by 4 to 7 K per km.
    assert 6.0 < at_sea.temperature_K - low.temperature_K < 10.5
    assert 24.0 < at_sea.temperature_K - high.temperature_K < 42.0
    assert 0.0 < low.scatter_K < 5.0
    with pytest.raises(CatalogError, match="top_m: 20000 given"):
        climatological_cloud_top(35.0, 150.0, day, 20_000.0)
