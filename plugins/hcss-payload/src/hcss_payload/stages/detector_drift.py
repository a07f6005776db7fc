"""Drift and 1/f noise of detectors."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_payload.stages.random_numbers import pixel_key, row_key
from hcss_twin.core.kernels import kernel
from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.models.sensor.noise import Noise
from hcss_twin.models.sensor.parameters import OfBands
from hcss_twin.providers import Array, Measured, Problem, ScenarioError, SensorDeclaration, SensorInputs

PER_OCTAVE = 4
"""Sinusoids per octave."""


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    rms_radiance: Annotated[float | dict[str, float], OfBands.within(0.0, 1e9)] = Field(
        description="Rms of the 1/f noise, W m-2 sr-1; one number or a table by band."
    )
    lowest: Quantity.Frequency = Field(1e-3, gt=0, le=1e4, description="Lowest frequency of the noise, Hz.")
    highest: Quantity.Frequency = Field(10.0, gt=0, le=1e5, description="Highest frequency, Hz.")
    exponent: float = Field(1.0, ge=0, le=3, description="Of the power spectral density, f^-exponent.")
    detectors: Literal["pixel", "row", "column", "frame"] = Field(
        "pixel", description="What has noise of its own; columns are the amplifiers of most readout circuits."
    )
    drift_radiance: float = Field(
        0.0, ge=0, description="Standard deviation among detectors of a steady drift, W m-2 sr-1 per hour."
    )


class DetectorDrift:
    """Offsets that change in time with the power spectral density f^-exponent between two frequencies, and drift.

    The offset of a detector is a sum of sinusoids at frequencies spaced evenly in their logarithm, each with the power
    of its interval and a phase of its own: a function of time, so that frames may come in any order. Means over an
    integration time are not taken; let the highest frequency be below its inverse.

    References
    ----------
    F. N. Hooge, "1/f noise sources", IEEE Trans. Electron Devices 41, 1926-1935 (1994), for the spectrum.
    """

    variables = ()
    declares = SensorDeclaration(reach_pixels=0)

    def __init__(self, inputs: SensorInputs, parameters: Parameters) -> None:
        self._rms = {
            band.name: OfBands.number(parameters.rms_radiance, band.name, "rms_radiance") for band in inputs.bands
        }
        if parameters.highest < 1.1 * parameters.lowest:
            message = (
                f"{parameters.highest:g} Hz with lowest = {parameters.lowest:g} Hz; allowed: "
                f"{1.1 * parameters.lowest:g} Hz or more"
            )
            raise ScenarioError([Problem("sensor.parameters.highest", message)])
        self._inputs, self._of = inputs, parameters
        self.frequency_hz, self._amplitude = _sinusoids(parameters.lowest, parameters.highest, parameters.exponent)
        rows, columns = inputs.grid.rows, inputs.grid.columns
        self._shape = {"pixel": (rows, columns), "row": (rows, 1), "column": (1, columns), "frame": (1, 1)}[
            parameters.detectors
        ]
        # Detectors are numbered by their place in the image; those shared by rows or columns have no other place.
        alone = {"pixel": (1, 1), "row": (1, 0), "column": (0, 1), "frame": (0, 0)}[parameters.detectors]
        self._corner = inputs.corner[0] * alone[0], inputs.corner[1] * alone[1]

    def measure(self, radiance: Array, frame: int, time_s: float) -> Measured:
        """Return the radiance with the offsets of a time."""
        measured = np.array(radiance, dtype=np.float64)
        for band_image, band in zip(measured, self._inputs.bands, strict=True):
            band_image += self.offset(band.name, time_s)
        return Measured(measured)

    def offset(self, band: str, time_s: float) -> Array:
        """Return the offsets (Y, X), (Y, 1), (1, X) or (1, 1) of the detectors at a time, W m-2 sr-1."""
        offsets = np.zeros(self._shape)
        amplitude = self._amplitude * self._rms[band]
        key = Noise.key_of(self._inputs.seed, "1/f noise", band)
        # Turns, so that late times keep their digits.
        turns = np.fmod(self.frequency_hz * time_s, 1.0)
        _add_sinusoids(offsets, turns, amplitude, np.uint64(key), np.int64(self._corner[0]), np.int64(self._corner[1]))
        if self._of.drift_radiance:
            rate = Noise.standard_normal(Noise.key_of(self._inputs.seed, "drift", band), self._shape, self._corner)
            offsets += self._of.drift_radiance * (time_s / 3600.0) * rate
        return offsets


def _sinusoids(lowest_hz: float, highest_hz: float, exponent: float) -> tuple[Array, Array]:
    """Return frequencies (K,) and amplitudes (K,) with a mean square of 1 in all."""
    count = max(1, math.ceil(PER_OCTAVE * math.log2(highest_hz / lowest_hz)))
    edges = np.geomspace(lowest_hz, highest_hz, count + 1)
    power = np.log(edges) if exponent == 1.0 else edges ** (1.0 - exponent) / (1.0 - exponent)
    share = np.diff(power) / (power[-1] - power[0])
    return np.sqrt(edges[1:] * edges[:-1]), np.sqrt(2.0 * share)


@kernel()
def _add_sinusoids(offsets: Any, turns: Any, amplitude: Any, key: Any, first_row: Any, first_column: Any) -> None:
    for y in range(offsets.shape[0]):
        own_row = row_key(key, np.int64(first_row + y))
        for x in range(offsets.shape[1]):
            key_of_pixel = pixel_key(own_row, np.int64(first_column + x))
            total = 0.0
            for k in range(turns.size):
                phase = float(row_key(key_of_pixel, np.int64(k)) >> np.uint64(12)) * 2.0**-52
                total += amplitude[k] * math.sin(2.0 * math.pi * (turns[k] + phase))
            offsets[y, x] += total
