"""Suggestions in messages: close spellings of one name, never another quantity."""

import pytest

from hcss_twin.core.errors import Problem


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
        ("table-12", ["table-1", "table-2", "table-9", "table-10", "table-9-ev"], "table-10"),
        ("figure-8", ["figure-3", "figure-10", "figure-9"], "figure-9"),
        ("lwir-10.3", ["lwir-9.7", "lwir-10.8", "lwir"], "lwir-10.8"),
        ("gaussian", ["log-uniform", "normal", "uniform"], "normal"),
        ("", ["rows"], None),
        ("rows", [], None),
    ],
)
def test_suggestions_are_close_and_of_the_same_meaning(name, choices, suggestion):
    assert Problem.closest(name, choices) == suggestion
