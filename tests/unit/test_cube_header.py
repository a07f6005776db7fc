"""Headers, footprints and global attributes."""

from datetime import datetime, timedelta, timezone

import numpy as np
import pytest
from example_cube import example_header

from hcss_twin.core.errors import CubeError
from hcss_twin.cube.coordinates import coordinate_values, time_units
from hcss_twin.cube.geometry import footprint
from hcss_twin.cube.header import BandInfo, LayerInfo
from hcss_twin.cube.metadata import creation_time, global_attributes

EQUATOR_M, ECCENTRICITY_SQUARED = 6378137.0, 6.69437999014e-3
"""Of WGS 84."""


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"start": datetime(2024, 6, 1)}, "start: .* no time zone"),
        ({"frame_times_s": (0.0, 1.0, 1.0)}, r"frame_times_s\[2\]"),
        ({"frame_times_s": (0.0, float("nan"), 1.0)}, r"frame_times_s\[1\]"),
        ({"frame_times_s": ()}, "dimension time"),
        ({"rows": 0}, "dimension y: length 0"),
        ({"solar_zenith_deg": (1.0,)}, "solar_zenith_deg: 1 values for 3 frames"),
        ({"solar_zenith_deg": (1.0, 181.0, 2.0)}, r"solar_zenith_deg\[1\]: 181.0 is outside 0 to 180"),
        ({"view_zenith_deg": 91.0}, "view_zenith_deg: 91.0 is outside 0 to 90"),
        ({"latitude": -90.1}, "latitude: -90.1"),
        ({"pixel_size_m": 0.0}, "pixel_size_m"),
        ({"bands": (BandInfo("A", 3.0, 5.0, 5.5),)}, "band 'A'"),
        ({"bands": (BandInfo("A", 3.0, 5.0, 4.0), BandInfo("A", 8.0, 9.0, 8.5))}, "'A' is empty or used more"),
        ({"variables": ()}, "variables: none"),
        ({"layers": ()}, "dimension layer: length 0"),
        ({"layers": (LayerInfo("low", 10.0, 10.0),)}, "layer 'low': 10.0 to 10.0 m"),
        ({"attributes": {"seed": True}}, "attribute seed: bool"),
        ({"attributes": {"seed": 2**63}}, "attribute seed: .* 64 bits"),
        ({"attributes": {"note": "a\0b"}}, "attribute note"),
    ],
)
def test_a_header_outside_its_ranges_is_refused(changes, message):
    with pytest.raises(CubeError, match=message):
        example_header(**changes)


@pytest.mark.parametrize("name", ["Conventions", "date_created", "geospatial_lat_min", "time_coverage_end"])
def test_computed_attributes_cannot_be_given(name):
    with pytest.raises(CubeError, match=name):
        global_attributes(example_header(attributes={name: "x"}))


def test_given_attributes_replace_defaults():
    attributes = global_attributes(example_header(attributes={"title": "Mine", "id": "me", "seed": 7}))
    assert (attributes["title"], attributes["id"], attributes["seed"]) == ("Mine", "me", 7)


def test_time_coverage_is_in_utc_and_iso_8601():
    start = datetime(2024, 6, 1, 1, 0, 0, 250000, tzinfo=timezone(timedelta(hours=8)))
    header = example_header(start=start)
    attributes = global_attributes(header)
    assert attributes["time_coverage_start"] == "2024-05-31T17:00:00.25Z"
    assert attributes["time_coverage_end"] == "2024-05-31T17:00:01.25Z"
    assert attributes["time_coverage_duration"] == "PT1S"
    assert attributes["time_coverage_resolution"] == "PT0.5S"
    assert time_units(header) == "seconds since 2024-05-31 17:00:00.250000"


def test_source_date_epoch_fixes_the_date_and_must_be_a_number(monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    assert global_attributes(example_header())["date_created"] == "1970-01-02T00:00:00Z"
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "yesterday")
    with pytest.raises(CubeError, match="'yesterday'"):
        creation_time()


def test_the_identifier_follows_the_scenario_only():
    one, same = (global_attributes(example_header())["id"] for _ in range(2))
    other = global_attributes(example_header(attributes={"hcss_scenario": "else"}))["id"]
    assert one == same != other


def test_the_footprint_of_a_small_image_is_its_size_over_the_radii_of_curvature():
    """On the equator a (1 - e2) along the meridian and a along the equator."""
    extent = footprint(example_header(rows=100, columns=200, latitude=0.0, longitude=10.0))
    north, east = EQUATOR_M * (1.0 - ECCENTRICITY_SQUARED), EQUATOR_M
    assert extent.north == pytest.approx(np.degrees(100 * 100 / 2 / north), rel=1e-6)
    assert extent.east - 10.0 == pytest.approx(np.degrees(200 * 100 / 2 / east), rel=1e-6)


def test_the_footprint_covers_the_way_of_the_platform_eastwards():
    still = footprint(example_header(latitude=0.0))
    moved = footprint(example_header(latitude=0.0, platform_speed_m_s=7000.0))
    assert moved.east - still.east == pytest.approx(np.degrees(7000.0 * 1.0 / EQUATOR_M), rel=1e-6)
    assert moved.west == pytest.approx(still.west, abs=1e-9)


def test_a_footprint_across_the_date_line_runs_on_and_one_around_a_pole_goes_all_round():
    across = footprint(example_header(longitude=179.9999))
    assert across.west < 180.0 < across.east < 180.1
    pole = footprint(example_header(latitude=89.9999))
    assert (pole.north, pole.west, pole.east) == (90.0, -180.0, 180.0)


def test_pixel_centres_are_symmetric_about_the_image_centre():
    values = coordinate_values(example_header(rows=4, columns=3, pixel_size_m=10.0, platform_speed_m_s=2.0))
    np.testing.assert_array_equal(values["y"], [-15.0, -5.0, 5.0, 15.0])
    np.testing.assert_array_equal(values["x"], [-10.0, 0.0, 10.0])
    np.testing.assert_array_equal(values["centre_displacement"], [0.0, 1.0, 2.0])
