"""Where the fractal generator's parameters come from, and what is refused."""

from pathlib import Path

import pytest
from pydantic import ValidationError

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ScenarioError
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import CloudGenerator, CloudInputs, CloudLayer, Grid, Microphysics, Motion

STRATUS = {"gamma": 3, "H": 0.8, "L": [10, 10], "k": [0, 4]}
WATER = Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0))
MOVING = Motion(1000.0, (10.0, 0.0), 600.0, 1.0)


def generator(type_parameters=STRATUS, motion=MOVING, pixel=20.0, **given):
    layer = CloudLayer("stratus", 0.0, 1000.0, "base", 33.0, 0.5, None, WATER)
    inputs = CloudInputs(layer, Grid(8, 9, pixel), motion, 1, Catalog(root=Path("none")), type_parameters)
    return FractalClouds(inputs, FractalParameters(**given))


def test_defaults_come_from_the_cloud_type_and_given_values_win():
    made = generator(H=0.3, k=[1, 2]).parameters
    assert (made.gamma, made.H, made.L, made.k) == (3.0, 0.3, (10.0, 10.0), (1, 2))


def test_every_parameter_given_nowhere_is_named():
    with pytest.raises(ScenarioError) as caught:
        generator({"gamma": 3.0}, L=[3, 7])
    assert [problem.field for problem in caught.value.problems] == ["clouds.parameters.H", "clouds.parameters.k"]


def test_a_wrong_value_in_the_cloud_type_is_named():
    with pytest.raises(ScenarioError, match=r"fractal\.H: .*less than 1"):
        generator({**STRATUS, "H": 1.5})


@pytest.mark.parametrize(
    "bad",
    [
        {"gamma": 1.0},
        {"gamma": 8.1},
        {"gamma": "3"},
        {"gamma": True},
        {"H": 0.0},
        {"H": 1.0},
        {"H": float("nan")},
        {"L": [10]},
        {"L": [10, 0]},
        {"L": [10, float("inf")]},
        {"L": 10},
        {"k": [3, 2]},
        {"k": [-1, 2]},
        {"k": [0, 17]},
        {"k": [0, 2.5]},
        {"octaves": 3},
    ],
    ids=str,
)
def test_out_of_range_values_are_refused(bad):
    with pytest.raises(ValidationError):
        FractalParameters(**bad)


@pytest.mark.parametrize(
    "edge", [{"gamma": 1.01}, {"gamma": 8}, {"k": [0, 16]}, {"k": (16, 16)}, {"L": [1e-3, 1e4]}], ids=str
)
def test_the_edges_of_the_ranges_are_allowed(edge):
    FractalParameters(**edge)


@pytest.mark.parametrize(
    ("motion", "pixel", "field"),
    [
        (Motion(0.0, (0.0, 0.0), 0.0, 1.0), 20.0, "evolution_time_s"),
        (Motion(0.0, (0.0, 0.0), 1.0, -1.0), 20.0, "frame_interval_s"),
        (Motion(0.0, (0.0, 0.0), 1.0, 1.0), 0.0, "pixel_size_m"),
    ],
)
def test_impossible_motion_is_refused(motion, pixel, field):
    with pytest.raises(ScenarioError, match=field):
        generator(motion=motion, pixel=pixel)


@pytest.mark.parametrize(
    ("motion", "time", "evolves"),
    [
        (Motion(0.0, (0.0, 0.0), float("inf"), 1.0), False, False),
        (Motion(10.0, (10.0, 0.0), float("inf"), 1.0), False, False),
        (Motion(0.0, (0.0, 3.0), float("inf"), 1.0), True, False),
        (Motion(1000.0, (0.0, 0.0), float("inf"), 1.0), True, False),
        (Motion(0.0, (0.0, 0.0), 600.0, 1.0), True, True),
    ],
)
def test_time_dependence_is_declared_where_there_is_any(motion, time, evolves):
    made = generator(motion=motion)
    assert isinstance(made, CloudGenerator)
    assert ("time" in made.declares.depends_on) is time
    assert made.declares.evolves is evolves
    assert not made.declares.tileable


def test_what_is_skipped_is_said():
    whats = [what for what, _ in generator(k=[0, 8]).skipped]
    assert any("axis z" in what for what in whats)
    assert any("octave 5 along x, y" in what for what in whats)
    # From 2.5 cells per pixel on an octave is white; 6 to 8 join 5.
    assert "octaves 6, 7, 8 as separate terms" in whats
    assert "time axis" not in whats
    frozen = generator(motion=Motion(0.0, (0.0, 0.0), float("inf"), 1.0), k=[0, 8])
    assert "time axis" in [what for what, _ in frozen.skipped]
    assert len(frozen.octaves) == 6


@pytest.mark.parametrize(
    "window", [slice(0, 9), slice(-1, 3), slice(0, 8, 2), slice(5, 4)], ids=["long", "negative", "step", "back"]
)
def test_a_window_outside_the_image_is_refused(window):
    with pytest.raises(ValueError, match="rows"):
        generator().thickness_m(0.0, window, slice(None))


def test_a_field_window_without_ends_and_a_time_that_is_not_finite_are_refused():
    made = generator()
    with pytest.raises(ValueError, match="columns"):
        made.field(0.0, slice(0, 3), slice(None, 3))
    with pytest.raises(ValueError, match="time_s"):
        made.field(float("nan"), slice(0, 3), slice(0, 3))


def test_clouds_smaller_than_pixels_are_told_and_others_are_not():
    def told(pixel):
        return [note for note in generator(pixel=pixel).declares.notes if "smaller than pixels" in note]

    # the largest cell is 1.6 km: 80 pixels of 20 m, half a pixel of 3 km
    assert told(20.0) == []
    assert "100% of the variance" in told(4000.0)[0]
