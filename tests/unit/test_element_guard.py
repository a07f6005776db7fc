"""What an element provider returns is checked before the engine uses it."""

from types import SimpleNamespace

import numpy as np
import pytest
from hcss_author import PlainScene, sample_element_inputs

from hcss_twin.core.errors import ProviderError
from hcss_twin.providers import Declaration, ElementPixels, ElementPoint
from hcss_twin.providers.common import check_element_variables
from hcss_twin.providers.registry.guard import guard
from hcss_twin.providers.registry.specs import Kind

GOOD = {
    "rows": np.array([3, 3]),
    "columns": np.array([4, 5]),
    "share": np.array([0.5, 1.0]),
    "altitude_m": 10.0,
    "intensity": np.ones(2),
    "truth": {"source": np.ones(2)},
}


def asked(answer):
    provider = SimpleNamespace(
        declares=Declaration(), variables={"source": ("1", "Its number.")}, pixels=lambda *arguments: answer
    )
    entry = SimpleNamespace(kind=Kind.ELEMENTS, name="ship", label="element provider 'ship'", distribution="hcss-ship")
    inputs = sample_element_inputs()
    return guard(entry, provider, inputs).pixels(0.0, slice(0, 8), slice(0, 8), PlainScene(inputs))


def test_sound_pixels_pass_unchanged():
    [pixels] = asked([ElementPixels(**GOOD)])
    for name, value in GOOD.items():
        np.testing.assert_equal(getattr(pixels, name), value)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rows": np.array([3, 8])}, "rows broke its contract: expected values in .0, 7., got 3 to 8"),
        ({"rows": np.array([3.0, 3.0])}, "whole numbers"),
        ({"columns": np.array([4, 4])}, "distinct pixels, got a pixel twice"),
        ({"share": np.array([0.0, 1.0])}, "share broke its contract"),
        ({"share": np.array([0.5, 1.1])}, "share broke its contract"),
        ({"share": np.ones(3)}, r"shape \(2,\), got shape \(3,\)"),
        ({"altitude_m": -1.0}, "altitude_m"),
        ({"intensity": None}, "either radiance or intensity, got both or neither"),
        ({"radiance": np.ones(2)}, "either radiance or intensity, got both or neither"),
        ({"intensity": np.array([1.0, np.nan])}, "finite values"),
        ({"intensity": None, "radiance": np.ones((2, 3))}, r"shape \(2, 2\)"),
        ({"temperature_K": 0.0}, "temperature_K"),
        ({"truth": {}}, "truth broke its contract: expected source"),
    ],
)
def test_anything_else_is_refused_by_name(changes, message):
    with pytest.raises(ProviderError, match=f"element provider 'ship': .*{message}"):
        asked([ElementPixels(**GOOD | changes)])


POINT = {"x_m": 1.0, "y_m": 2.0, "altitude_m": 10.0, "radiance": np.ones(2), "area_m2": 3.0, "truth": {"source": 1.0}}


def test_a_sound_point_passes_unchanged():
    [point] = asked([ElementPoint(**POINT)])
    for name, value in POINT.items():
        np.testing.assert_equal(getattr(point, name), value)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"x_m": np.nan}, "x_m"),
        ({"altitude_m": -1.0}, "altitude_m"),
        ({"intensity": np.ones(2)}, "either radiance or intensity, got both or neither"),
        ({"area_m2": None}, "area_m2 with radiance, got one of them"),
        ({"area_m2": 0.0}, "area_m2"),
        ({"radiance": np.ones((1, 2))}, r"shape \(2,\)"),
        ({"reflectance": 1.1}, "reflectance"),
        ({"velocity_m_s": (1.0, 2.0)}, r"velocity_m_s.* shape \(3,\)"),
        ({"side_m": -1.0}, "side_m"),
        ({"truth": {"source": np.inf}}, "truth"),
    ],
)
def test_any_other_point_is_refused_by_name(changes, message):
    with pytest.raises(ProviderError, match=f"element provider 'ship': .*{message}"):
        asked([ElementPoint(**POINT | changes)])


def test_a_single_answer_is_no_sequence():
    with pytest.raises(ProviderError, match="a sequence of ElementPixels and ElementPoint, got ElementPixels"):
        asked(ElementPixels(**GOOD))


@pytest.mark.parametrize("variables", [("source",), {"Source": ("1", "x")}, {"share": ("1", "x")}, {"source": "1"}])
def test_variables_are_pairs_of_text_by_name(variables):
    with pytest.raises(ValueError, match="expected a mapping of names"):
        check_element_variables(variables)
