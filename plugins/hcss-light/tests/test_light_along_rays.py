"""Light between columns toward rays that form no grid on the ground, as those of cameras."""

import math

import numpy as np
import pytest
from hcss_light.comparison import check
from light_scene import DAY, scene

from hcss_twin.core.errors import ScenarioError
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import PartMaker
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.plan.rays import Rays
from hcss_twin.providers import Grid, View

EVEN = {"temperature_texture": 0.0}
ROWS, COLUMNS, TURN = 12, 9, math.radians(25.0)


class Arc(Rays):
    """A square grid that is turned in the plane of the scene; each column of pixels has an azimuth of its own."""

    samples_per_pixel, suns = 1, None

    def __init__(self, degrees):
        self.image, self.view, self.directions, self.degrees = (
            Grid(ROWS, COLUMNS, 250.0),
            self.toward(0.0),
            self,
            degrees,
        )

    def toward(self, x, degrees=0.0):
        return View(50.0, 30.0 + degrees * x)

    def at(self, places):
        return [self.toward(x, self.degrees) for x, _ in places]

    def positions(self, window, time_s):
        x = 2.0 * (np.arange(COLUMNS) + 0.5) / COLUMNS - 1.0
        return np.tile(x, (ROWS, 1))[window], np.zeros((ROWS, COLUMNS))[window]

    def points_m(self, window, time_s, height_m):
        along, up = np.meshgrid(np.arange(COLUMNS) - 4.0, np.arange(ROWS) - 5.5)
        x, y = (
            250.0 * (math.cos(TURN) * a + sign * math.sin(TURN) * b) for a, b, sign in ((along, up, -1), (up, along, 1))
        )
        places = self.positions((slice(None), slice(None)), time_s)
        views = self.at(zip(*(axis.ravel().tolist() for axis in places), strict=True))
        azimuth = np.radians([view.azimuth_deg for view in views]).reshape(x.shape)
        away = height_m * math.tan(math.radians(50.0))
        return (x + away * np.sin(azimuth))[window], (y + away * np.cos(azimuth))[window]


def planned(light, rays=None, **changes):
    clouds = {"type": "stratocumulus", "generator": "fractal", "coverage": 0.5, "coverage_mode": "field"}
    common = {"clouds": clouds, "sea": EVEN, "slant": {"shadows": "off", "parallax": "off"}}
    common |= {"time": DAY, "bands": [[3.6, 3.8]], "image": {"rows": 40, "columns": 30, "pixel_size": 100.0}}
    if rays is not None:
        common |= {"slant": {"shadows": "off"}, "view": {}}
        return make_plan(scene(light, model="as-printed", **common, **changes), rays=lambda *_: rays)
    return make_plan(scene(light, model="as-printed", **common, **changes))


def radiance_of(plan):
    maker = PartMaker(plan, tables_of(plan))
    rows, columns = plan.image.rows, plan.image.columns
    return lambda *window: maker.part(0, window or (slice(0, rows), slice(0, columns)))[0]["radiance"][0]


@pytest.mark.parametrize(("light", "numbers"), [("source", (0, 4, 8)), ("slant", (8,))])
def test_a_ray_sees_the_column_nearest_to_where_it_meets_the_layer_as_an_image_toward_its_view_does(light, numbers):
    rays = Arc(2.0)
    plan = planned(light, rays)
    seen = radiance_of(plan)
    whole, columns = seen(), radiance_of(planned("columns", rays))()
    assert np.std(whole / columns) > 0.01
    window = slice(3, 9), slice(2, 8)
    np.testing.assert_array_equal(seen(*window), whole[window])
    x_m, y_m = rays.points_m((slice(None), slice(None)), 0.0, plan.layers[0].reference_height_m)
    row, column = (np.rint(place / 100.0 + 0.5 * size - 0.5).astype(int) for place, size in ((y_m, 40), (x_m, 30)))
    for number in numbers:
        azimuth = rays.at([(2.0 * (number + 0.5) / COLUMNS - 1.0, 0.0)])[0].azimuth_deg
        grid = radiance_of(planned(light, view={"zenith": 50.0, "azimuth": azimuth}))
        # Squares of pixels have the view of their middle.
        y, x = row[:, number], column[:, number]
        around = slice(y.min(), y.max() + 1), slice(x.min(), x.max() + 1)
        expected = grid(*around)[y - y.min(), x - x.min()]
        np.testing.assert_allclose(whole[:, number], expected, rtol=0.01 if number == 4 else 0.02)


def test_views_that_turn_too_much_within_few_pixels_are_refused_by_name():
    with pytest.raises(ScenarioError, match=r"radiance\.light: views that vary over the image displace lines of sight"):
        planned("source", Arc(40.0))


def test_light_of_several_layers_along_rays_agrees_with_monte_carlo():
    flat = {"generator": "fractal", "coverage": 0.5, "coverage_mode": "field"}
    layers = [flat | {"type": name} for name in ("stratocumulus", "paper-cirrus")]
    error = {}
    for light in ("source", "columns"):
        plan = make_plan(scene(light, 8, clouds={"layers": layers}, sea=EVEN, view={}), rays=lambda *_: Arc(0.1))
        (error[light],) = check(plan, tables_of(plan), 0)["bands"].values()
    # Cirrus over its neighbours' gaps: columns err by 11 %, light between them by 1.0 +- .3 %.
    assert abs(error["source"]["bias"]) < 0.1 * abs(error["columns"]["bias"]) + 2.0 * error["source"]["noise"]
    assert error["source"]["rms"] < 0.1 * error["columns"]["rms"]
