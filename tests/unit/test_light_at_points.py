"""Light between columns that is known over classes of surface and at nodes of effects of points: exact polynomials."""

from types import SimpleNamespace

import numpy as np

from hcss_twin.engine.stages.light import LightStage
from hcss_twin.engine.tables.point_axis import PlacedStates
from hcss_twin.plan.axis import Axis, PlacedAxis

WINDOW = slice(0, 3), slice(0, 4)
CLASS = np.array([[0, 1, 1, 0], [1, 0, 1, 1], [0, 0, 1, 0]])
SMOKE, DUST = np.linspace(0.0, 1.0, 12).reshape(3, 4), np.linspace(2.0, 3.0, 12)[::-1].reshape(3, 4)


class Values(PlacedStates):
    """Given values at each point."""

    name = "values"

    def __init__(self, segments, values):
        super().__init__(PlacedAxis(Axis(segments[0][0], segments[-1][-1]), segments))
        self._values = values

    def plan_in(self, plan, state):
        raise NotImplementedError

    def values(self, time_s, window):
        return self._values[window]


def at_points(of, effects, classes=2):
    """What a stage makes of the values of a function of class and effects at all combinations of nodes."""
    stage = LightStage.__new__(LightStage)
    ground = SimpleNamespace(at=lambda time_s, extent: SimpleNamespace(number=CLASS[extent]))
    stage._effects, stage._ground = effects, ground if classes > 1 else None
    nodes = np.meshgrid(np.arange(classes), *(effect.nodes for effect in effects), indexing="ij")
    states = zip(*(axis.ravel().tolist() for axis in nodes), strict=True)
    of_states = [np.stack([np.full(CLASS.shape, of(*state)), np.full(CLASS.shape, -of(*state))]) for state in states]
    return stage._at_points(of_states, 0.0, WINDOW)


def test_points_of_two_classes_and_two_effects_have_the_polynomials_of_the_nodes():
    smoke = Values((np.array([0.0, 0.2, 0.4]), np.array([0.4, 0.7, 1.0])), SMOKE)
    dust = Values((np.array([2.0, 3.0]),), DUST)

    def of(number, absorbed, scattered):
        return (1.0 + number) * absorbed**2 + scattered * (1.0 - 3.0 * number)

    seen = at_points(of, [smoke, dust])
    np.testing.assert_allclose(seen[0], of(CLASS, SMOKE, DUST), rtol=1e-12)
    np.testing.assert_allclose(seen[1], -of(CLASS, SMOKE, DUST), rtol=1e-12)
    swapped = at_points(lambda number, scattered, absorbed: of(number, absorbed, scattered), [dust, smoke])
    np.testing.assert_allclose(swapped, seen, rtol=1e-12)


def test_points_over_one_class_with_one_effect():
    seen = at_points(lambda number, absorbed: absorbed**2, [Values((np.array([0.0, 0.5, 1.0]),), SMOKE)], classes=1)
    np.testing.assert_allclose(seen[0], SMOKE**2, rtol=1e-12, atol=1e-15)


def test_one_state_is_returned_as_it_is():
    seen = at_points(lambda number: 7.0, [], classes=1)
    np.testing.assert_array_equal(seen[0], np.full(CLASS.shape, 7.0))
