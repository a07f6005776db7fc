"""Contract tests of sensors."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest

from hcss_author.contract import NoMaker, ProviderContract, holds
from hcss_author.samples import frozen, sample_sensor_inputs
from hcss_author.sensor_laws import SCENE_W_M2_SR, SensorLaws, measure
from hcss_twin.laws import questions_of
from hcss_twin.providers import Array, Kind, Measured, Sensor, SensorInputs

_FRAMES = 3


@holds(Kind.SENSORS)
class SensorContract(SensorLaws, ProviderContract):
    """Inherit in a class named ``Test...`` and define ``make_provider``.

    Attributes
    ----------
    scene_W_m2_sr : tuple of float
        Lowest and highest radiance of the measured frames.
    """

    _kind = Kind.SENSORS
    scene_W_m2_sr: tuple[float, float] = SCENE_W_M2_SR

    def make_provider(self, inputs: SensorInputs) -> Sensor:
        """Return the provider under test."""
        raise NoMaker("define make_provider(self, inputs)")

    @pytest.fixture
    def inputs(self) -> SensorInputs:
        """Inputs; override to choose others."""
        return sample_sensor_inputs()

    @pytest.fixture
    def scene(self, inputs: SensorInputs) -> Array:
        """Clean frames (F, B, y, x)."""
        low, high = self.scene_W_m2_sr
        shape = _FRAMES, len(inputs.bands), inputs.grid.rows, inputs.grid.columns
        return frozen(low + (high - low) * np.random.default_rng(8).random(shape))

    @pytest.fixture
    def questions(self, inputs: SensorInputs, scene: Array) -> tuple[Any, ...]:
        """Two frames."""
        return questions_of(Kind.SENSORS, None, inputs, two=(scene[0], scene[1]))

    def test_shapes_types_and_what_was_promised(self, provider: Sensor, inputs: SensorInputs, scene: Array) -> None:
        """Finite arrays of the frame's shape: radiance and exactly the variables in ``variables``."""
        _measured(self._guarded(provider, inputs), inputs, scene)

    def test_frames_may_come_in_any_order(self, provider: Sensor, inputs: SensorInputs, scene: Array) -> None:
        """A frame depends only on its number, not on earlier measurements, unless the sensor remembers."""
        if provider.declares.remembers:
            pytest.skip("the sensor needs its frames in order")
        forward = _measured(provider, inputs, scene)
        backward = _measured(provider, inputs, scene, order=reversed(range(len(scene))))
        for first, second in zip(forward, reversed(backward), strict=True):
            _assert_same(first, second)

    def test_a_band_alone_is_measured_as_among_others(self, inputs: SensorInputs, scene: Array) -> None:
        """Other bands have no influence."""
        every = _measured(self.make_provider(inputs), inputs, scene)
        for index, band in enumerate(inputs.bands):
            of_band = dataclasses.replace(inputs, bands=(band,))
            alone = _measured(self.make_provider(of_band), of_band, scene[:, index : index + 1])
            for among, single in zip(every, alone, strict=True):
                np.testing.assert_array_equal(single.radiance[0], among.radiance[index])

    def test_nothing_comes_from_farther_than_declared(
        self, provider: Sensor, inputs: SensorInputs, scene: Array
    ) -> None:
        """Changing one pixel affects only pixels within ``reach_pixels``."""
        reach = provider.declares.reach_pixels
        if reach is None:
            pytest.skip("each pixel depends on the whole frame")
        row, column = inputs.grid.rows // 2, inputs.grid.columns // 3
        changed = np.array(scene[0])
        changed[:, row, column] *= 1.2
        one = measure(self.make_provider(inputs), inputs, scene[0]).radiance
        other = measure(self.make_provider(inputs), inputs, frozen(changed)).radiance
        away_y = np.abs(np.arange(inputs.grid.rows) - row)[:, None] > reach
        away_x = np.abs(np.arange(inputs.grid.columns) - column)[None, :] > reach
        away = away_y | away_x
        # convolution by FFT causes rounding errors everywhere
        np.testing.assert_allclose(other[:, away], one[:, away], rtol=1e-9, atol=1e-12)


def _measured(
    provider: Sensor, inputs: SensorInputs, scene: Array, order: Iterable[int] | None = None
) -> list[Measured]:
    frames = range(len(scene)) if order is None else order
    return [measure(provider, inputs, scene[frame], frame) for frame in frames]


def _assert_same(one: Measured, other: Measured) -> None:
    for field in dataclasses.fields(Measured):
        first, second = getattr(one, field.name), getattr(other, field.name)
        assert (first is None) == (second is None)
        if first is not None:
            np.testing.assert_array_equal(first, second)
