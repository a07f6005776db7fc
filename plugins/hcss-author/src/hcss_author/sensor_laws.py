"""Laws of sensors that need no reference: the place and size of what is measured, and its random numbers."""

from __future__ import annotations

import contextlib
import dataclasses
from typing import Any

import numpy as np
import pytest

from hcss_author.samples import StillScene
from hcss_twin.laws.samples import frozen
from hcss_twin.providers import Array, Measured, Sensor, SensorInputs

RADIANCE_TOLERANCE = 0.3
"""Allowed relative difference between measured and true radiance, averaged over a quarter of the image."""

LEAST_USED = 0.01
"""Share of the declared instants that calls reach."""

CORNER = (5, 9)
"""Row and column of a window's first pixel."""


class SensorLaws:
    """Laws of a sensor; part of ``SensorContract``."""

    scene_W_m2_sr: tuple[float, float]

    def make_provider(self, inputs: SensorInputs) -> Sensor:
        """Return the provider under test."""
        raise NotImplementedError("define make_provider(self, inputs)")

    def known_delay_s(self, inputs: SensorInputs) -> Array | None:
        """Return how long after the frame each pixel is measured, in the mean (y, x); override to have it checked."""
        return None

    def test_each_quarter_is_measured_in_its_place(self, inputs: SensorInputs) -> None:
        """Radiance of a scene of four grey quarters, other ones in each band: mean of each quarter within 30 %."""
        scene = self._quarters(inputs)
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
        scene = self._quarters(inputs)
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
        measured = measure(self.make_provider(inputs), inputs, self._quarters(inputs))
        if measured.saturated is None:
            pytest.skip("the sensor marks no saturated pixels")
        counted = measured.radiance if measured.digital_number is None else measured.digital_number
        for value, mark in zip(counted, measured.saturated, strict=True):
            if np.any(mark == 1):
                assert np.max(value) <= np.min(value[mark == 1]) * 1.001 + 1e-9

    def test_seed_and_place_matter_to_noise(self, inputs: SensorInputs) -> None:
        """A sensor that measures a scene otherwise in another frame is random: frame, seed and corner then matter."""
        scene = self._quarters(inputs)
        one = self.make_provider(inputs)
        frames = [measure(one, inputs, scene, frame) for frame in range(3)]
        if one.declares.remembers or all(_same(frames[0], frame) for frame in frames[1:]):
            pytest.skip("frames of one scene are equal, or depend on earlier ones")
        assert not _same(frames[0], frames[1]), "frames 0 and 1 have the same random numbers"
        usual = measure(self.make_provider(inputs), inputs, scene)
        changes: dict[str, Any] = {"seed": inputs.seed + 1, "corner": (inputs.corner[0] + 5, inputs.corner[1] + 9)}
        for name, value in changes.items():
            changed = dataclasses.replace(inputs, **{name: value})
            other = measure(self.make_provider(changed), changed, scene)
            assert not _same(usual, other), f"{name} has no influence on random numbers"

    def test_a_later_stage_takes_what_an_earlier_one_measured(self, inputs: SensorInputs) -> None:
        """Radiance with noise, a part of it negative, gives finite measurements."""
        noise = np.random.default_rng(5).normal(0.0, 0.5 * self.scene_W_m2_sr[1], self._quarters(inputs).shape)
        measured = measure(self.make_provider(inputs), inputs, frozen(self._quarters(inputs) + noise))
        assert np.all(np.isfinite(measured.radiance))

    def test_the_scene_is_asked_for_as_declared(self, inputs: SensorInputs) -> None:
        """Other instants are within ``instants``, their windows within the frame, and a scene that changes shows."""
        scene = self._quarters(inputs)
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
            assert not _same(before, after), "instants have no effect"

    def test_pixels_are_measured_when_it_is_known(self, inputs: SensorInputs) -> None:
        """The mean time of each pixel is that of ``known_delay_s``, to a hundredth of the longest."""
        known = self.known_delay_s(inputs)
        if known is None:
            pytest.skip("define known_delay_s(self, inputs) to have the time checked at which pixels are measured")
        still, longest = _asked_for(inputs), float(np.max(np.abs(known)))
        provider, scene = self.make_provider(inputs), self._quarters(inputs)
        before = measure(provider, inputs, scene, 1).radiance
        with still.brightening(0.2 / longest):
            after = measure(provider, inputs, scene, 1).radiance
        late = (after / before - 1.0) * longest / 0.2
        np.testing.assert_allclose(late, np.broadcast_to(known, late.shape), rtol=0.0, atol=0.01 * longest)

    def test_a_window_is_measured_as_the_image(self, inputs: SensorInputs) -> None:
        """A window, by its ``corner``, is that part of the image; rounding may change 1 % of the pixels."""
        provider = self.make_provider(inputs)
        reach, (top, left) = provider.declares.reach_pixels, CORNER
        rows, columns = inputs.grid.rows - top - 3, inputs.grid.columns - left - 4
        if reach is None or 2 * reach >= min(rows, columns):
            pytest.skip("each pixel depends on a large part of the frame")
        grid = dataclasses.replace(inputs.grid, rows=rows, columns=columns)
        corner = inputs.corner[0] + top, inputs.corner[1] + left
        cropped = dataclasses.replace(inputs, grid=grid, corner=corner)
        scene, part = self._quarters(inputs), np.s_[:, top : top + rows, left : left + columns]
        latest, still = max(map(abs, getattr(provider, "instants", (0.0, 0.0)))), inputs.scene_at
        with still.brightening(0.2 / latest) if isinstance(still, StillScene) and latest else contextlib.nullcontext():
            whole = measure(provider, inputs, scene).radiance[part]
            alone = measure(self.make_provider(cropped), cropped, frozen(scene[part])).radiance
        inner = np.s_[:, reach : rows - reach, reach : columns - reach]
        same = np.isclose(alone[inner], whole[inner], rtol=1e-6, atol=1e-9 * np.max(np.abs(whole)))
        assert np.mean(same) >= 0.99, f"{np.mean(~same):.0%} of the pixels differ with the corner {corner}"

    def _quarters(self, inputs: SensorInputs) -> Array:
        low, high = self.scene_W_m2_sr
        rows, columns = inputs.grid.rows, inputs.grid.columns
        part = 2 * (np.arange(rows) >= rows // 2)[:, None] + (np.arange(columns) >= columns // 2)
        shares = np.array([[0.0, 0.3, 1.0, 0.6], [1.0, 0.5, 0.2, 0.0]])[np.arange(len(inputs.bands)) % 2]
        return frozen(low + (high - low) * shares[:, part])


def measure(provider: Sensor, inputs: SensorInputs, radiance: Array, frame: int = 0) -> Measured:
    """Return the measurement of a frame; at other instants the scene is that of :class:`StillScene`."""
    time_s = frame * inputs.frame_interval_s
    if isinstance(inputs.scene_at, StillScene):
        inputs.scene_at.begin(radiance, time_s)
    return provider.measure(radiance, frame, time_s)


def _asked_for(inputs: SensorInputs) -> StillScene:
    if not isinstance(inputs.scene_at, StillScene):
        pytest.skip("the inputs have a scene_at of their own, not that of sample_sensor_inputs")
    return inputs.scene_at


def quarter_means(frame: Any) -> Array:
    """Return the mean of each quarter of each band, (B, y, x) to (B, 4)."""
    rows, columns = frame.shape[1] // 2, frame.shape[2] // 2
    parts = [frame[:, y, x] for y in (slice(rows), slice(rows, None)) for x in (slice(columns), slice(columns, None))]
    result: Array = np.stack([np.mean(part, axis=(1, 2)) for part in parts], axis=1)
    return result


def _same(one: Measured, other: Measured) -> bool:
    return np.array_equal(one.radiance, other.radiance)
