"""Units of quantities against their definitions."""

import pytest

from hcss_twin.core.units import parse_quantity


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("36 kn", "speed", 36 * 1852 / 3600),  # international knot: one nautical mile of 1852 m per hour
        ("1 kn", "speed", 0.5144444444444445),
        ("36 km/h", "speed", 10.0),
        ("7 km/s", "speed", 7000.0),
    ],
)
def test_a_quantity_is_converted_by_the_definition_of_its_unit(text, dimension, value):
    assert parse_quantity(text, dimension) == pytest.approx(value, rel=1e-15)
