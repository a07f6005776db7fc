"""The scenario's sensor on live frames: blur, noise, fixed pattern and converter in one pass over the rows."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_payload.camera import Camera
from hcss_payload.checks import PayloadError
from hcss_payload.live.measure import Kernels, Weights, measure_rows
from hcss_twin.models.sensor.noise import Noise
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.sensor_stages import Stage
from hcss_twin.providers import Grid, Points, SensorBand, SensorInputs

Each = Callable[[Callable[[Any], None], list[Any]], None]

_LINES = 64
"""Rows that a thread measures at once."""

LEAST, TAPS_AT_ONCE = 7, 4
"""Smallest reach in pixels of kernels that decrease slowly, and weights in a group: those of the sensors of cubes."""

BLUR_LEFT_OUT = 0.015
"""Largest share of a blur's weights, in absolute values, that live frames leave out: a narrow point spread that is
known up to half a cycle per pixel has small tails of alternating sign, which reach 16 pixels in cubes."""

TICKS_PER_S = 1e6
"""Noise is numbered by the time in microseconds: frames at the same microsecond have the same noise."""


class LiveSensor:
    """The sensor of a scenario behind the pixels of a camera.

    Targets smear by their motion in the image. The scene behind them does not, which passes state as an omission.

    Parameters
    ----------
    plan : Plan
        With one stage of the model ``radiometer``, computed by rows.

    Attributes
    ----------
    scene : ndarray of float32 (B, rows, columns)
        Where the radiance that it measures is written.
    smear_time_s : float
        Integration time in which motion smears; 0 if it does not.

    Raises
    ------
    PayloadError
        If the scenario has another sensor.
    """

    def __init__(self, plan: Plan, camera: Camera) -> None:
        section = plan.scenario.sensor
        assert section is not None
        inputs = SensorInputs(
            bands=tuple(SensorBand(band.name, band.wavelength_um, band.response) for band in plan.bands),
            grid=Grid(camera.rows, camera.columns, 1.0),
            platform_speed_m_s=0.0,
            frame_interval_s=plan.assembly.motion.frame_interval_s,
            seed=plan.scenario.seed,
            catalog=plan.catalog,
        )
        stages = Stage.build(section, inputs)
        optics = {"focal_length": camera.focal_length_m, "detector_pitch": camera.pitch_m}
        Stage.examine_geometry({"camera": optics}, stages)
        self._sensor: Any
        self._sensor = sensor = _unchecked(stages[0].provider)
        if len(stages) > 1 or not hasattr(sensor, "measure_into"):
            raise PayloadError(
                f"sensor: {', then '.join(stage.entry.name for stage in stages)}; allowed: one "
                "'radiometer', for live frames"
            )
        weights = sensor.blur.weights.items()
        sensor.blur.weights = {name: shortened(of_band, BLUR_LEFT_OUT) for name, of_band in weights}
        self.smear_time_s = stages[0].smear_time_s or 0.0
        self._seed = plan.scenario.seed
        self._kernels = [Kernels.of(weights) for weights in sensor.blur.weights.values()]
        self.scene = np.zeros((len(plan.bands), camera.rows, camera.columns), np.float32)
        # Parts of the frame, by band and row, that threads may measure at once.
        ends = range(0, camera.rows, _LINES) if sensor.any_rows else (0,)
        step = _LINES if sensor.any_rows else camera.rows
        self._parts = [(band, first, first + step) for band in range(len(plan.bands)) for first in ends]
        self._results = {name: array for name, array in sensor.arrays(self.scene.shape).items() if name != "radiance"}
        self._none = np.empty((0, 0), np.int32)

    @property
    def has_numbers(self) -> bool:
        """Whether it has a converter."""
        return "digital_number" in self._results

    def measure(
        self, time_s: float, radiance: NDArray[np.float32], in_parts: Each, points: Points | None = None
    ) -> NDArray[np.int32] | None:
        """Measure ``scene``: write the radiance, and return the digital numbers, which the next call overwrites.

        Parameters
        ----------
        in_parts : callable
            Runs work for each of several parts of a frame.
        points : Points, optional
            Targets, which ``scene`` lacks.
        """
        number = round(time_s * TICKS_PER_S)
        results = {**self._results, "radiance": radiance}
        written = results.get("digital_number")
        channels = self._sensor.channels
        added = np.zeros((len(channels), 0, 0), np.float32)
        if points is not None:
            added = self._sensor.blur.of_points(points, *self.scene.shape[1:])
        keys = [np.uint64(Noise.key_of(self._seed, "rows", channel.band.name, number)) for channel in channels]
        patterns = [channel.pattern_at(time_s) for channel in channels]

        def part(band_rows: tuple[int, int, int]) -> None:
            (band, *lines), channel = band_rows, channels[band_rows[0]]
            kernels, detector = self._kernels[band], channel.detector
            counts = detector.shot and not detector.deviation  # whole electrons
            drawn = kernels is not None and not counts and measure_rows(
                self.scene[band], kernels.down, kernels.across, kernels.reach, added[band], *patterns[band],
                detector, keys[band], tuple(lines), radiance[band], self._none if written is None else written[band],
            )  # fmt: skip
            if not drawn:
                bands = slice(band, band + 1)
                self._sensor.measure_into(self.scene, number, results, bands, tuple(lines), added, time_s)

        in_parts(part, self._parts)
        return written


def shortened(weights: Weights | None, share: float) -> Weights | None:
    """Return weights without the farthest ones, up to a share of their absolute values.

    Kernels that end by themselves stay: their last weights have one sign, and cutting them would sharpen the image.
    The sum of the weights is kept.
    """
    if weights is None or len(weights.down) != 1 or max(weights.reach) <= LEAST:
        return weights
    result = []
    for axis_weights, reach in zip((weights.down[0], weights.across[0]), weights.reach, strict=True):
        size = np.abs(axis_weights[reach : 2 * reach + 1].astype(np.float64))
        beyond = 2.0 * (size.sum() - np.cumsum(size))
        # The reach whose weights fill whole groups: more of them cost nothing.
        least = int(np.argmax(beyond <= share * np.abs(axis_weights).sum()))
        new = min(reach, -(-(2 * least + 1) // TAPS_AT_ONCE) * TAPS_AT_ONCE // 2 - 1)
        new = max(new, least)
        kept = axis_weights[reach - new : reach + new + 1].astype(np.float64)
        padded = np.zeros((1, kept.size + -kept.size % TAPS_AT_ONCE), np.float32)
        padded[0, : kept.size] = kept * (axis_weights.sum(dtype=np.float64) / kept.sum())
        result.append((padded, new))
    (down, up), (across, side) = result
    return Weights(down, across, (up, side))


def _unchecked(sensor: object) -> Any:
    """Return a sensor as one with more members than the contract knows."""
    return sensor
