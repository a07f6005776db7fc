"""Laws of sensors that any radiance shows: windows, seeds, and the place of noise."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.laws.law import Inapplicable, Law, at_least, at_most, require
from hcss_twin.laws.samples import StillScene, frozen
from hcss_twin.providers import Measured, Sensor, SensorInputs

Make = Callable[[SensorInputs], Sensor]

Ends = tuple[float, float] | tuple[Array, Array]
"""Lowest and highest radiance of all bands, or of each (B,)."""

SCENE_W_M2_SR = (0.5, 2.0)
"""Lowest and highest radiance of the frames of the kit."""

CORNER = (5, 9)
"""Row and column of a window's first pixel."""


def same_seed_same_bits(make: Make, inputs: SensorInputs, scene_W_m2_sr: Ends = SCENE_W_M2_SR) -> None:
    """Two sensors of the same seed measure the same."""
    scene = quarters(inputs, scene_W_m2_sr)
    one, other = make(inputs), make(inputs)
    for frame in range(3):
        first, second = measure(one, inputs, scene, frame), measure(other, inputs, scene, frame)
        for field in dataclasses.fields(Measured):
            values = getattr(first, field.name), getattr(second, field.name)
            same = (values[0] is None) == (values[1] is None) and (values[0] is None or np.array_equal(*values))
            require(same, f"{field.name} of frame {frame} differs between two sensors of one seed")


def seed_and_place_matter_to_noise(make: Make, inputs: SensorInputs, scene_W_m2_sr: Ends = SCENE_W_M2_SR) -> None:
    """A sensor that measures a scene otherwise in another frame is random: frame, seed and corner then matter."""
    scene, one = quarters(inputs, scene_W_m2_sr), make(inputs)
    frames = [measure(one, inputs, scene, frame) for frame in range(3)]
    if one.declares.remembers or all(same_radiance(frames[0], frame) for frame in frames[1:]):
        raise Inapplicable("frames of one scene are equal, or depend on earlier ones")
    require(not same_radiance(frames[0], frames[1]), "frames 0 and 1 have the same random numbers")
    usual = measure(make(inputs), inputs, scene)
    changes: dict[str, Any] = {"seed": inputs.seed + 1, "corner": (inputs.corner[0] + 5, inputs.corner[1] + 9)}
    for name, value in changes.items():
        changed = dataclasses.replace(inputs, **{name: value})
        other = measure(make(changed), changed, scene)
        require(not same_radiance(usual, other), f"{name} has no influence on random numbers")


def a_window_is_measured_as_the_image(make: Make, inputs: SensorInputs, scene_W_m2_sr: Ends = SCENE_W_M2_SR) -> None:
    """A window, by its ``corner``, is that part of the image; rounding may change 1 % of the pixels."""
    provider = make(inputs)
    reach, (top, left) = provider.declares.reach_pixels, CORNER
    rows, columns = inputs.grid.rows - top - 3, inputs.grid.columns - left - 4
    if reach is None or 2 * reach >= min(rows, columns):
        raise Inapplicable("each pixel depends on a large part of the frame")
    grid = dataclasses.replace(inputs.grid, rows=rows, columns=columns)
    corner = inputs.corner[0] + top, inputs.corner[1] + left
    cropped = dataclasses.replace(inputs, grid=grid, corner=corner)
    scene, part = quarters(inputs, scene_W_m2_sr), np.s_[:, top : top + rows, left : left + columns]
    latest, still = max(map(abs, getattr(provider, "instants", (0.0, 0.0)))), inputs.scene_at
    with still.brightening(0.2 / latest) if isinstance(still, StillScene) and latest else contextlib.nullcontext():
        whole = measure(provider, inputs, scene).radiance[part]
        alone = measure(make(cropped), cropped, frozen(scene[part])).radiance
    inner = np.s_[:, reach : rows - reach, reach : columns - reach]
    same = np.isclose(alone[inner], whole[inner], rtol=1e-6, atol=1e-9 * np.max(np.abs(whole)))
    require(np.mean(same) >= 0.99, f"{np.mean(~same):.0%} of the pixels differ with the corner {corner}")


def brighter_is_measured_as_brighter(make: Make, inputs: SensorInputs, scene_W_m2_sr: Ends = SCENE_W_M2_SR) -> None:
    """In each band the brightest quarter is not measured darker than the darkest, nor ten times brighter than it is.

    Beyond what noise explains, five standard errors; sensors may saturate.
    """
    scene = quarters(inputs, scene_W_m2_sr)
    measured, truth = measure(make(inputs), inputs, scene).radiance, _means(scene)[0]
    means, errors = _means(measured)
    for band, values, noise, expected in zip(inputs.bands, means, errors, truth, strict=True):
        dark, bright = int(np.argmin(expected)), int(np.argmax(expected))
        allowed = 5.0 * (noise[dark] + noise[bright])
        at_least(f"brightest quarter in '{band.name}', W m-2 sr-1,", values[bright], values[dark] - allowed)
        at_most(f"brightest quarter in '{band.name}', W m-2 sr-1,", values[bright], 10.0 * expected[bright] + allowed)


LAWS: tuple[Law, ...] = (
    same_seed_same_bits,
    seed_and_place_matter_to_noise,
    a_window_is_measured_as_the_image,
    brighter_is_measured_as_brighter,
)


def quarters(inputs: SensorInputs, scene_W_m2_sr: Ends) -> Array:
    """Return a frame (B, y, x) of four grey quarters, other ones in each band."""
    low, high = (np.reshape(end, (-1, 1, 1)) for end in scene_W_m2_sr)
    rows, columns = inputs.grid.rows, inputs.grid.columns
    part = 2 * (np.arange(rows) >= rows // 2)[:, None] + (np.arange(columns) >= columns // 2)
    shares = np.array([[0.0, 0.3, 1.0, 0.6], [1.0, 0.5, 0.2, 0.0]])[np.arange(len(inputs.bands)) % 2]
    return frozen(low + (high - low) * shares[:, part])


def _means(frame: Array) -> tuple[Array, Array]:
    """Return the mean of each quarter of each band (B, y, x), and its standard error: (B, 4) each."""
    rows, columns = frame.shape[1] // 2, frame.shape[2] // 2
    parts = [frame[:, y, x] for y in (slice(rows), slice(rows, None)) for x in (slice(columns), slice(columns, None))]
    flat = [part.reshape(frame.shape[0], -1) for part in parts]
    means = np.stack([part.mean(axis=1) for part in flat], axis=1)
    return means, np.stack([part.std(axis=1) / np.sqrt(part.shape[1]) for part in flat], axis=1)


def measure(provider: Sensor, inputs: SensorInputs, radiance: Array, frame: int = 0) -> Measured:
    """Return the measurement of a frame; at other instants the scene is that of :class:`StillScene`."""
    time_s = frame * inputs.frame_interval_s
    if isinstance(inputs.scene_at, StillScene):
        inputs.scene_at.begin(radiance, time_s)
    return provider.measure(radiance, frame, time_s)


def same_radiance(one: Measured, other: Measured) -> bool:
    """Whether two measurements have the same radiance, to the bit."""
    return np.array_equal(one.radiance, other.radiance)
