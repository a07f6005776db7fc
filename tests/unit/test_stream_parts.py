"""Windows of clouds and truth: which frames are computed whole, and where each window lies."""

from types import SimpleNamespace

import numpy as np
import pytest
from cheap import CHEAP

from hcss_twin import Scenario, make_plan
from hcss_twin.engine import clouds
from hcss_twin.engine.clouds import FrameClouds
from hcss_twin.engine.stages.stage import FramePart, PartWindow
from hcss_twin.engine.stages.truth import Truth
from hcss_twin.providers import CloudDeclaration

SHAPE = (6, 10)


@pytest.fixture(scope="module")
def plan():
    size = {"image.rows": SHAPE[0], "image.columns": SHAPE[1], "output.variables": ["truth"]}
    return make_plan(Scenario.load("stratus", CHEAP | size))


class Numbered:
    """The thickness of a point is its number; asked for the frame, a window of it, and around it."""

    def __init__(self, tileable):
        self.declares = CloudDeclaration(tileable=tileable)
        self.asked = []

    def _at(self, how, rows, columns):
        self.asked.append(how)
        y, x = (np.arange(part.start, part.stop) for part in (rows, columns))
        return (1.0 + 100.0 * y[:, None] + x).astype(np.float32)

    def thickness_m(self, time_s, rows, columns):
        return self._at("thickness_m", rows, columns)

    def frame_summary(self, time_s):
        self.asked.append("frame_summary")
        return "summary"

    def thickness_in_frame_m(self, time_s, rows, columns, summary):
        return self._at("thickness_in_frame_m", rows, columns)

    def thickness_around_m(self, time_s, rows, columns, summary):
        return self._at("thickness_around_m", rows, columns)


def of(plan, generator):
    assembly = SimpleNamespace(generators=(generator,), cloudy_layers=(True,))
    return SimpleNamespace(
        assembly=assembly, layers=plan.layers, grid=plan.grid, scene=plan.scene, is_grid=True, rays=plan.rays
    )


@pytest.mark.parametrize(
    ("tileable", "largest", "asked"),
    [(True, 1, ["thickness_m"]), (False, 60, ["thickness_m"]), (False, 59, ["frame_summary", "thickness_in_frame_m"])],
)
def test_only_a_large_frame_of_a_generator_of_whole_frames_is_computed_by_its_summary(
    plan, monkeypatch, tileable, largest, asked
):
    monkeypatch.setattr(clouds, "WHOLE_POINTS", largest)
    generator = Numbered(tileable)
    (found,) = FrameClouds(of(plan, generator), 0.0).thickness_m((slice(2, 4), slice(3, 7)))
    np.testing.assert_array_equal(found, 1.0 + 100.0 * np.array([[2], [3]]) + np.arange(3, 7))
    assert generator.asked == asked


@pytest.mark.parametrize("window", [(-1, 3, 0, 5), (0, 7, 0, 5), (0, 3, -1, 5), (0, 3, 4, 11)])
def test_a_window_with_any_pixel_outside_the_image_is_one_around_it(plan, window):
    generator = Numbered(True)
    FrameClouds(of(plan, generator), 0.0).thickness_m((slice(*window[:2]), slice(*window[2:])))
    assert generator.asked == ["thickness_around_m"]


def test_truth_of_a_window_stands_in_its_rows_and_columns(plan):
    stage, window = Truth(plan), (slice(1, 3), slice(4, 9))
    nothing = np.empty((0, *SHAPE), dtype=np.float32)
    part = FramePart(0, 0.0, (slice(0, SHAPE[0]), slice(0, SHAPE[1])), FrameClouds(plan, 0.0), None, nothing, nothing)
    stage.begin(part)
    thickness = np.linspace(100.0, 900.0, 10, dtype=np.float32).reshape(2, 5)
    stage.apply(part, PartWindow(window, [thickness], window=window))
    inside = np.zeros(SHAPE, dtype=bool)
    inside[window] = True
    np.testing.assert_array_equal(part.truth["cloud_mask"] > 0, inside)
    np.testing.assert_array_equal(part.truth["cloud_thickness"][window], thickness)
    assert not part.truth["cloud_thickness"][~inside].any()
    np.testing.assert_array_equal(np.isfinite(part.truth["cloud_top_altitude"]), inside)
