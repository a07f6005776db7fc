"""The kit accepts a drifting checkerboard and refuses cloud generators that break a law."""

import threading

import numpy as np
import pytest
from hcss_author import CloudGeneratorContract, sample_cloud_inputs

from hcss_twin.providers import CloudDeclaration


class Checkerboard:
    """Each pixel of a frozen, infinite plane is cloudy or not by a (cheap) random number of its own."""

    def __init__(self, inputs):
        self.inputs = inputs
        wind = inputs.motion.cloud_velocity_m_s
        self.speed_x = (inputs.motion.platform_speed_m_s - wind[0]) / inputs.grid.pixel_size_m
        self.speed_y = -wind[1] / inputs.grid.pixel_size_m
        moves = self.speed_x or self.speed_y
        self.declares = CloudDeclaration(depends_on=frozenset({"time"} if moves else ()), tileable=True)

    def thickness_m(self, time_s, rows, columns):
        layer = self.inputs.layer
        x = np.arange(columns.start, columns.stop) + round(self.speed_x * time_s)
        y = np.arange(rows.start, rows.stop)[:, None] + round(self.speed_y * time_s)
        value = np.abs(np.sin((y + 1) * 12.9898 + x * 78.233 + self.inputs.seed) * 43758.5453) % 1.0
        span = layer.thickness_max_m - layer.thickness_min_m
        return np.where(value < layer.coverage, layer.thickness_min_m + span * value, 0.0).astype(np.float32)


class TestCheckerboard(CloudGeneratorContract):
    def make_provider(self, inputs):
        return Checkerboard(inputs)


def clouds_kit(mistake):
    class Broken(Checkerboard):
        def thickness_m(self, time_s, rows, columns):
            return mistake(self, super().thickness_m(time_s, rows, columns), time_s)

    class Kit(CloudGeneratorContract):
        def make_provider(self, inputs):
            return Broken(inputs)

    return Kit(), Broken(sample_cloud_inputs()), sample_cloud_inputs()


def counting(provider, field, time_s):
    provider.calls = getattr(provider, "calls", 0) + 1
    return np.where(field > 0.0, field - provider.calls, 0.0).astype(np.float32)


@pytest.mark.parametrize(
    ("law", "mistake"),
    [
        ("shape_and_type", lambda self, field, time_s: field.astype(np.float64)),
        ("shape_and_type", lambda self, field, time_s: field.T),
        ("thickness_stays_within_the_layer", lambda self, field, time_s: 3.0 * field),
        ("thickness_stays_within_the_layer", lambda self, field, time_s: 0.5 * field),
        ("windows_equal_the_whole", lambda self, field, time_s: field - field.mean()),
    ],
)
def test_kit_refuses_clouds_that_break_a_law(law, mistake):
    kit, provider, inputs = clouds_kit(mistake)
    with pytest.raises(AssertionError):
        getattr(kit, f"test_{law}")(provider, inputs)


@pytest.mark.parametrize(
    ("law", "mistake"),
    [
        ("field_does_not_depend_on_earlier_calls", counting),
        ("undeclared_time_has_no_influence", lambda self, field, time_s: field * np.float32(1 - time_s / 1e4)),
        ("frozen_field_only_translates", lambda self, field, time_s: field[::-1] if time_s else field),
    ],
)
def test_kit_refuses_clouds_that_remember_or_change(law, mistake):
    kit, _, inputs = clouds_kit(mistake)
    with pytest.raises(AssertionError):
        getattr(kit, f"test_{law}")(inputs)


@pytest.mark.parametrize("wrong", ["speed_x", "speed_y"])
def test_kit_refuses_clouds_that_drift_the_other_way(wrong):
    class Backward(Checkerboard):
        def __init__(self, inputs):
            super().__init__(inputs)
            setattr(self, wrong, -getattr(self, wrong))

    class Kit(CloudGeneratorContract):
        def make_provider(self, inputs):
            return Backward(inputs)

    with pytest.raises(AssertionError):
        Kit().test_frozen_field_only_translates(sample_cloud_inputs())


def test_kit_refuses_clouds_that_threads_disturb():
    class Shares(Checkerboard):
        def thickness_m(self, time_s, rows, columns):
            self.now = time_s
            barrier.wait()  # all threads have written before any reads
            return super().thickness_m(self.now, rows, columns)

    barrier = threading.Barrier(3)
    provider = Shares(sample_cloud_inputs())
    alone = Checkerboard(sample_cloud_inputs())
    provider_alone = provider.thickness_m

    def thickness_m(time_s, rows, columns):
        if threading.current_thread() is threading.main_thread():
            return alone.thickness_m(time_s, rows, columns)
        return provider_alone(time_s, rows, columns)

    provider.thickness_m = thickness_m
    with pytest.raises(AssertionError):
        CloudGeneratorContract().test_field_does_not_depend_on_threads(provider, sample_cloud_inputs())


@pytest.mark.parametrize(
    ("law", "mistake"),
    [
        ("no_coverage_is_clear_sky_and_full_coverage_has_no_gap", lambda self, field, time_s: field + 1),
        ("cloudy_fraction_is_the_coverage", lambda self, field, time_s: field * (field > 300.0)),
    ],
)
def test_kit_refuses_clouds_of_wrong_coverage(law, mistake):
    kit, _, _ = clouds_kit(mistake)
    with pytest.raises(AssertionError):
        getattr(kit, f"test_{law}")()


@pytest.mark.parametrize(
    "mistake",
    [
        lambda field, rows, columns: field - field.mean(),  # another value in another window
        lambda field, rows, columns: field[::-1],
        lambda field, rows, columns: field.astype(np.float64),
    ],
)
def test_kit_refuses_clouds_that_go_on_otherwise(mistake):
    class Around(Checkerboard):
        def thickness_around_m(self, time_s, rows, columns, summary):
            return wrong(self.thickness_m(time_s, rows, columns), rows, columns)

    inputs = sample_cloud_inputs()
    wrong = lambda field, rows, columns: field  # noqa: E731
    CloudGeneratorContract().test_a_sky_goes_on_around_the_image(Around(inputs), inputs)
    wrong = mistake
    with pytest.raises(AssertionError):
        CloudGeneratorContract().test_a_sky_goes_on_around_the_image(Around(inputs), inputs)


@pytest.mark.parametrize(
    ("top_m", "accepted"),
    [
        (lambda rows, columns: 2000.0 + 10.0 * np.arange(rows.start, rows.stop), True),
        (lambda rows, columns: 2000.0 + 10.0 * np.arange(rows.stop - rows.start), False),
        (lambda rows, columns: np.full(rows.stop - rows.start, 4000.0), False),
        (lambda rows, columns: np.full(rows.stop - rows.start, 10.0), False),
    ],
    ids=["varies", "depends on the window", "above its range", "lower than the cloud is thick"],
)
def test_kit_refuses_cloud_tops_outside_their_range_or_their_clouds(top_m, accepted):
    class Hanging(Checkerboard):
        cloud_top_range_m = 0.0, 3000.0

        def cloud_top_m(self, time_s, rows, columns):
            shape = rows.stop - rows.start, columns.stop - columns.start
            return np.broadcast_to(top_m(rows, columns)[:, None], shape).astype(np.float32)

    inputs = sample_cloud_inputs()
    provider = Hanging(inputs)
    if accepted:
        CloudGeneratorContract().test_cloud_tops_are_within_their_range(provider, inputs)
        return
    with pytest.raises(AssertionError):
        CloudGeneratorContract().test_cloud_tops_are_within_their_range(provider, inputs)


@pytest.mark.parametrize(
    ("depth_m", "accepted"),
    [
        (lambda rows: 100.0 + np.arange(rows.start, rows.stop), True),
        (lambda rows: 100.0 + np.arange(rows.stop - rows.start), False),
        (lambda rows: np.zeros(rows.stop - rows.start), False),
        (lambda rows: np.full(rows.stop - rows.start, 1e5), False),
    ],
    ids=["varies", "depends on the window", "nothing", "deeper than the layer"],
)
def test_kit_refuses_heights_of_clouds_beyond_their_layer(depth_m, accepted):
    class Deep(Checkerboard):
        cloud_top_range_m = 0.0, 3000.0

        def cloud_depth_m(self, time_s, rows, columns):
            shape = rows.stop - rows.start, columns.stop - columns.start
            return np.broadcast_to(depth_m(rows)[:, None], shape).astype(np.float32)

    inputs = sample_cloud_inputs()
    provider = Deep(inputs)
    if accepted:
        CloudGeneratorContract().test_clouds_are_spread_over_heights_of_their_layer(provider, inputs)
        return
    with pytest.raises(AssertionError):
        CloudGeneratorContract().test_clouds_are_spread_over_heights_of_their_layer(provider, inputs)


@pytest.mark.parametrize(
    ("share", "accepted"),
    [
        (lambda layers, rows: np.full(rows, 1.0 / layers), True),
        (lambda layers, rows: np.full(rows, 0.5 / layers), False),
        (lambda layers, rows: np.full(rows, 1.0 / rows), False),
    ],
    ids=["even", "half of the column", "depends on the window"],
)
def test_kit_refuses_shares_of_heights_that_are_not_the_whole_column(share, accepted):
    class Layered(Checkerboard):
        def height_shares(self, time_s, rows, columns, thickness_m, edges_m):
            layers = edges_m.size - 1
            shares_of_slices = share(layers, thickness_m.shape[0])[:, None] * (thickness_m > 0.0)
            return np.broadcast_to(shares_of_slices, (layers, *thickness_m.shape)).astype(np.float32)

    inputs = sample_cloud_inputs()
    provider = Layered(inputs)
    if accepted:
        CloudGeneratorContract().test_shares_of_heights_hold_the_whole_column(provider, inputs)
        return
    with pytest.raises(AssertionError):
        CloudGeneratorContract().test_shares_of_heights_hold_the_whole_column(provider, inputs)
