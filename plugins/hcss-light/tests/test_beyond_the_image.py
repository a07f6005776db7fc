"""Light between columns around the image, where the blur of a sensor wants the scene."""

import numpy as np
import pytest
from light_scene import DAY, scene

from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import PartMaker
from hcss_twin.plan.make_plan import make_plan

LAYERS = [{"type": "stratocumulus", "generator": "fractal", "coverage": 0.5}, {"type": "paper-cirrus", "coverage": 0.5}]


SIZE, AROUND = (24, 18), ((-40, 31), (-7, 60))


def maker(light, size=SIZE, **changes):
    """Cloud of which a pixel does not depend on the rest of its frame: a larger image has the same sky."""
    clouds = {"clouds": {"type": "stratocumulus", "generator": "fractal", "coverage": 0.5, "coverage_mode": "field"}}
    image = {"rows": size[0], "columns": size[1], "pixel_size": 400.0}
    common = {"image": image, "time": DAY, "bands": [[3.6, 3.8]], "sea": {"temperature_texture": 0.0}}
    plan = make_plan(scene(light, **(clouds | common | {"model": "as-printed"} | changes)))
    return PartMaker(plan, tables_of(plan))


def radiance(parts, rows, columns, number):
    return parts.part(number, (slice(*rows), slice(*columns)))[0]["radiance"]


DRIFTING = {"frames": {"count": 3, "interval": 10.0}, "motion": {"wind_speed": 10.0}}
TWO_LAYERS = {"clouds": {"layers": [layer | {"coverage_mode": "field"} for layer in LAYERS]}, "model": "physical"}
again = pytest.mark.campaign


@pytest.mark.parametrize(
    ("light", "number", "changes", "allowed", "parallax"),
    [
        ("source", 0, {}, 1e-3, "on"),
        pytest.param("source", 0, {}, 1e-3, "off", marks=again),
        ("slant", 0, {}, 1e-4, "off"),
        pytest.param("slant", 0, {}, 1e-4, "on", marks=again),
        ("source", 2, DRIFTING, 0.02, "on"),
        pytest.param("source", 2, DRIFTING, 0.02, "off", marks=again),
        ("source", 0, TWO_LAYERS, 0.03, "off"),
        pytest.param("source", 0, TWO_LAYERS, 0.03, "on", marks=again),
    ],
)
def test_around_an_image_lies_what_a_larger_image_shows_whatever_the_window(light, number, changes, allowed, parallax):
    """Light that is kept while clouds drift, and light between layers in squares of another size, is less exact."""
    changes = changes | {"slant": {"shadows": "off", "parallax": parallax}}
    parts, ((top, bottom), (left, right)) = maker(light, **changes), AROUND
    wide = radiance(parts, *AROUND, number)
    assert np.std(wide / radiance(maker("columns", **changes), *AROUND, number)) > 0.005
    for rows, columns in (((0, 24), (0, 18)), ((-38, -1), (20, 55)), ((3, 30), (-5, 2)), ((25, 29), (0, 18))):
        inside = wide[:, rows[0] - top : rows[1] - top, columns[0] - left : columns[1] - left]
        np.testing.assert_array_equal(radiance(parts, rows, columns, number), inside)
    larger = maker(light, (SIZE[0] + 80, SIZE[1] + 84), **changes)
    shown = radiance(larger, (top + 40, bottom + 40), (left + 42, right + 42), number)
    np.testing.assert_allclose(wide, shown, rtol=allowed)
