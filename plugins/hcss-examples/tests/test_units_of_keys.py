"""Keys of the examples may be text with a unit, and mean the same as numbers in plain units."""

import pytest
from hcss_examples import aircraft, rolling_shutter, ship, smoke, split_window
from hcss_examples.conical_projection import ConicalScanner
from pydantic import ValidationError


@pytest.mark.parametrize(
    ("model", "key", "text", "plain"),
    [
        (smoke.Smoke, "width", "3 km", 3000.0),
        (smoke.Smoke, "bearing", "100 mrad", 5.729577951308232),
        (ConicalScanner, "altitude", "700 km", 7e5),
        (split_window.Parameters, "thin", "1500 mK", 1.5),
        (aircraft.Parameters, "speed", "0.24 km/s", 240.0),
        (aircraft.Parameters, "skin", "-30 degC", 243.15),
        (aircraft.Parameters, "area", "2e6 cm2", 200.0),
        (rolling_shutter.Parameters, "delay", "50 us", 5e-5),
        (ship.Parameters, "x", "-2 km", -2000.0),
        (ship.Parameters, "temperature", "32 degC", 305.15),
    ],
)
def test_text_with_a_unit_is_the_number_in_plain_units(model, key, text, plain):
    assert getattr(model(**{key: text}), key) == pytest.approx(plain, rel=1e-12)


def test_a_unit_of_another_dimension_is_refused_with_those_allowed():
    with pytest.raises(ValidationError, match=r"'s' is not a unit of length; allowed: .*km"):
        smoke.Smoke(width="3 s")
