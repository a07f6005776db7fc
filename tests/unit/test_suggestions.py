"""Suggestions in messages: close spellings of one name, never another quantity."""

import pytest

from hcss_twin.core.errors import closest


@pytest.mark.parametrize(
    ("name", "choices", "suggestion"),
    [
        ("colums", ["rows", "columns"], "columns"),
        ("cols", ["rows", "columns"], "columns"),
        ("pixelsize", ["pixel_size", "rows"], "pixel_size"),
        ("lat", ["latitude", "longitude"], "latitude"),
        ("mwr", ["mwir", "lwir"], "mwir"),
        ("swir", ["swir-2.7-3.0", "mwir"], "swir-2.7-3.0"),
        ("speed", ["wind_from", "wind_speed"], "wind_speed"),
        ("Stratus", ["cirrus", "stratus"], "stratus"),
        ("jitter", ["fixed_pattern", "nedt", "integration_time"], None),
        ("zenith", ["azimuth"], None),
        ("sensor_zenith", ["solar_zenith"], None),
        ("wind_speed", ["wind_from"], None),
        ("cloud_top_temperature", ["cloud_top_altitude"], None),
        ("", ["rows"], None),
        ("rows", [], None),
    ],
)
def test_suggestions_are_close_and_of_the_same_meaning(name, choices, suggestion):
    assert closest(name, choices) == suggestion
