"""Laws of sensors that need no reference: the place and size of what is measured, and its random numbers."""

from __future__ import annotations

import numpy as np
import pytest

from hcss_author.contract import NoMaker
from hcss_author.samples import frozen
from hcss_twin.laws.samples import StillScene
from hcss_twin.providers import Array, Measured, Sensor, SensorInputs

SCENE_W_M2_SR = (0.5, 2.0)
"""Lowest and highest radiance of the frames of the kit."""

RADIANCE_TOLERANCE = 0.3
"""Allowed relative difference between measured and true radiance, averaged over a quarter of the image."""

LEAST_USED = 0.01
"""Share of the declared instants that calls reach."""


class SensorLaws:
    """Laws of a sensor; part of ``SensorContract``."""

    scene_W_m2_sr: tuple[float, float]

    def make_provider(self, inputs: SensorInputs) -> Sensor:
        """Return the provider under test."""
        raise NoMaker("define make_provider(self, inputs)")

    def known_delay_s(self, inputs: SensorInputs) -> Array | None:
        """Return how long after the frame each pixel is measured, in the mean (y, x); override to have it checked."""
        return None

    def test_each_quarter_is_measured_in_its_place(self, inputs: SensorInputs) -> None:
        """Radiance of a scene of four grey quarters, other ones in each band: mean of each quarter within 30 %."""
        scene = quarters(inputs, self.scene_W_m2_sr)
        measured = quarter_means(measure(self.make_provider(inputs), inputs, scene).radiance)
        np.testing.assert_allclose(measured, quarter_means(scene), rtol=RADIANCE_TOLERANCE)

    def test_a_bright_spot_is_measured_where_it_is(self, inputs: SensorInputs) -> None:
        """The change of radiance by a brighter square is centred on it, to half a pixel."""
        low, high = self.scene_W_m2_sr
        rows, columns = inputs.grid.rows, inputs.grid.columns
        top, left = rows // 3, columns // 2
        dark = np.full((len(inputs.bands), rows, columns), low)
        bright = dark.copy()
        bright[:, top : top + 5, left : left + 5] = high
        one, other = (measure(self.make_provider(inputs), inputs, frozen(scene)).radiance for scene in (dark, bright))
        near = np.s_[:, top - 4 : top + 9, left - 4 : left + 9]
        change = np.maximum(other[near] - one[near], 0.0)
        assert np.all(change.sum(axis=(1, 2)) > 0.0)
        for axis, name in ((1, "rows"), (2, "columns")):
            along = change.sum(axis=3 - axis)
            centre = along @ np.arange(13.0) / along.sum(axis=1)
            np.testing.assert_allclose(centre, 6.0, rtol=0, atol=0.5, err_msg=name)

    def test_no_row_or_column_is_lost(self, inputs: SensorInputs) -> None:
        """Each row and column of an even scene has at least 30 % of its radiance, also at the edges."""
        level = float(np.mean(self.scene_W_m2_sr))
        scene = frozen(np.full((len(inputs.bands), inputs.grid.rows, inputs.grid.columns), level))
        radiance = measure(self.make_provider(inputs), inputs, scene).radiance
        for axis in (1, 2):
            assert np.all(radiance.mean(axis=axis) >= 0.3 * level)

    def test_more_light_is_counted_as_more(self, inputs: SensorInputs) -> None:
        """Photon rates and digital numbers of a brighter quarter are not lower; rates are in proportion to radiance."""
        scene = quarters(inputs, self.scene_W_m2_sr)
        provider = self.make_provider(inputs)
        measured, truth = measure(provider, inputs, scene), quarter_means(scene)
        order = np.argsort(truth, axis=1)
        for name in ("photon_rate", "digital_number"):
            value = getattr(measured, name)
            if value is None:
                continue
            means = quarter_means(value)
            ascending = np.take_along_axis(means, order, axis=1)
            assert np.all(np.diff(ascending, axis=1) >= 0.0), f"{name} falls where radiance rises"
            assert np.all(ascending[:, -1] > 0.0), f"{name} is 0 in light"
            if name == "photon_rate":
                share, expected = means / means.max(axis=1)[:, None], truth / truth.max(axis=1)[:, None]
                np.testing.assert_allclose(share, expected, atol=0.15, err_msg=name)

    def test_saturated_pixels_are_the_extreme_ones(self, inputs: SensorInputs) -> None:
        """No pixel within range is brighter than one that is cut at the upper end."""
        measured = measure(self.make_provider(inputs), inputs, quarters(inputs, self.scene_W_m2_sr))
        if measured.saturated is None:
            pytest.skip("the sensor marks no saturated pixels")
        counted = measured.radiance if measured.digital_number is None else measured.digital_number
        for value, mark in zip(counted, measured.saturated, strict=True):
            if np.any(mark == 1):
                assert np.max(value) <= np.min(value[mark == 1]) * 1.001 + 1e-9

    def test_a_later_stage_takes_what_an_earlier_one_measured(self, inputs: SensorInputs) -> None:
        """Radiance with noise, a part of it negative, gives finite measurements."""
        noise = np.random.default_rng(5).normal(
            0.0, 0.5 * self.scene_W_m2_sr[1], quarters(inputs, self.scene_W_m2_sr).shape
        )
        measured = measure(self.make_provider(inputs), inputs, frozen(quarters(inputs, self.scene_W_m2_sr) + noise))
        assert np.all(np.isfinite(measured.radiance))

    def test_the_scene_is_asked_for_as_declared(self, inputs: SensorInputs) -> None:
        """Other instants are within ``instants``, their windows within the frame, and a scene that changes shows."""
        scene = quarters(inputs, self.scene_W_m2_sr)
        still = _asked_for(inputs)
        provider = self.make_provider(inputs)
        before = measure(provider, inputs, scene, 1)
        instants = getattr(provider, "instants", None)
        if instants is None:
            assert not still.calls, "the sensor calls scene_at and has no attribute instants"
            pytest.skip("the sensor asks for no other instants")
        for time_s, rows, columns in still.calls:
            late = time_s - inputs.frame_interval_s
            assert instants[0] - 1e-9 <= late <= instants[1] + 1e-9, f"{late:g} s after the frame, not in {instants}"
            assert 0 <= rows.start <= rows.stop <= inputs.grid.rows, rows
            assert 0 <= columns.start <= columns.stop <= inputs.grid.columns, columns
        reached = [0.0]
        for frame in range(3):
            measure(provider, inputs, scene, frame)
            reached += [time_s - frame * inputs.frame_interval_s for time_s, *_ in still.calls]
        assert max(reached) - min(reached) >= LEAST_USED * (instants[1] - instants[0]), (
            f"asks at {min(reached):g} to {max(reached):g} s after frames, and declares {instants}"
        )
        if any(instants):
            with still.brightening(0.2 / max(map(abs, instants))):
                after = measure(provider, inputs, scene, 1)
            assert not np.array_equal(before.radiance, after.radiance), "instants have no effect"

    def test_pixels_are_measured_when_it_is_known(self, inputs: SensorInputs) -> None:
        """The mean time of each pixel is that of ``known_delay_s``, to a hundredth of the longest."""
        known = self.known_delay_s(inputs)
        if known is None:
            pytest.skip("define known_delay_s(self, inputs) to have the time checked at which pixels are measured")
        still, longest = _asked_for(inputs), float(np.max(np.abs(known)))
        provider, scene = self.make_provider(inputs), quarters(inputs, self.scene_W_m2_sr)
        before = measure(provider, inputs, scene, 1).radiance
        with still.brightening(0.2 / longest):
            after = measure(provider, inputs, scene, 1).radiance
        late = (after / before - 1.0) * longest / 0.2
        np.testing.assert_allclose(late, np.broadcast_to(known, late.shape), rtol=0.0, atol=0.01 * longest)


def _asked_for(inputs: SensorInputs) -> StillScene:
    if not isinstance(inputs.scene_at, StillScene):
        pytest.skip("the inputs have a scene_at of their own, not that of sample_sensor_inputs")
    return inputs.scene_at


def quarters(inputs: SensorInputs, scene_W_m2_sr: tuple[float, float]) -> Array:
    """Return a frame (B, y, x) of four grey quarters, other ones in each band."""
    low, high = scene_W_m2_sr
    shares = np.array([[[0.0, 0.3], [1.0, 0.6]], [[1.0, 0.5], [0.2, 0.0]]])[np.arange(len(inputs.bands)) % 2]
    right, lower = (np.arange(size) >= size // 2 for size in (inputs.grid.columns, inputs.grid.rows))
    return frozen(low + (high - low) * shares[:, lower.astype(int)][:, :, right.astype(int)])


def measure(provider: Sensor, inputs: SensorInputs, radiance: Array, frame: int = 0) -> Measured:
    """Return the measurement of a frame; at other instants the scene is that of :class:`StillScene`."""
    time_s = frame * inputs.frame_interval_s
    if isinstance(inputs.scene_at, StillScene):
        inputs.scene_at.begin(radiance, time_s)
    return provider.measure(radiance, frame, time_s)


def quarter_means(frame: Array) -> Array:
    """Return the mean of each quarter of each band, (B, y, x) to (B, 4)."""
    rows, columns = frame.shape[1] // 2, frame.shape[2] // 2
    parts = [frame[:, y, x] for y in (slice(rows), slice(rows, None)) for x in (slice(columns), slice(columns, None))]
    result: Array = np.stack([np.mean(part, axis=(1, 2)) for part in parts], axis=1)
    return result
