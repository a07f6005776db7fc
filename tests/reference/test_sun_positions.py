"""All 32 sun positions printed in Tables V and VI of the HCSS paper, with the conventions that reproduce them:
NREL algorithm, refracted zenith, 12:30 in the whole-hour zone round(longitude / 15), the year 2024 for January
to April of Table VI (the paper prints 2019)."""

from datetime import UTC, datetime, timedelta, timezone

import pytest
from printed_tables import PAPER

from hcss_twin.physics.sun import sun_position


@pytest.mark.parametrize("row", PAPER["table_5"]["rows"], ids=lambda row: f"scenario{row[0]}")
def test_table_5(row):
    _, latitude, longitude, zenith, azimuth, _ = row
    zone = timezone(timedelta(hours=round(longitude / 15)))
    found = sun_position([datetime(2019, 4, 20, 12, 30, tzinfo=zone)], latitude, longitude)
    assert found[0][0] == pytest.approx(zenith, abs=1e-3)
    assert found[1][0] == pytest.approx(azimuth, abs=1e-3)


@pytest.mark.parametrize("row", PAPER["table_6"]["rows"], ids=lambda row: f"scenario{row[0]}")
def test_table_6(row):
    _, date, zenith, azimuth, _ = row
    _, month, day = (int(part) for part in date.split("."))
    year = 2024 if month <= 4 else 2019
    zone = timezone(timedelta(hours=10))
    found = sun_position([datetime(year, month, day, 12, 30, tzinfo=zone)], 35.0, 150.0)
    assert found[0][0] == pytest.approx(zenith, abs=1e-3)
    assert found[1][0] == pytest.approx(azimuth, abs=1e-3)


def test_longitudes_beyond_180_are_the_same_place():
    time = [datetime(2024, 4, 20, 2, 30, tzinfo=UTC)]
    east, west = sun_position(time, 10.0, 200.0), sun_position(time, 10.0, -160.0)
    for one, other in zip(east, west, strict=True):
        assert one[0] == other[0]


def test_time_without_zone_is_refused():
    with pytest.raises(ValueError, match="zone"):
        sun_position([datetime(2024, 4, 20, 12, 30)], 0.0, 0.0)
