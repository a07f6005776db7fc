"""The default sensor: optics, detector and converter, stage by stage."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.models.sensor.blur import Blur, Weights
from hcss_twin.models.sensor.detector import (
    Readout,
    band_radiance_per_kelvin,
    photon_wavelength_um,
    photons_per_radiance,
)
from hcss_twin.models.sensor.noise import Noise, too_many_electrons
from hcss_twin.models.sensor.parameters import OfBands, RadiometerParameters
from hcss_twin.models.sensor.rows import Detector, measure
from hcss_twin.providers import Measured, Points, SensorBand, SensorDeclaration, SensorInputs

_TYPES = {"radiance": np.float32, "photon_rate": np.float32, "digital_number": np.int32, "saturated": np.uint8}


class Radiometer:
    """Blur, smear, photons, noise, fixed pattern, saturation and quantisation (docs/how-to/sensors.md)."""

    single_precision = True

    def __init__(self, inputs: SensorInputs, parameters: RadiometerParameters) -> None:
        self.blur = Blur(inputs, parameters)
        self.channels = tuple(_Channel(inputs, parameters, band) for band in inputs.bands)
        photons = parameters.aperture_diameter is not None and parameters.pixel_angle is not None
        self.variables = (
            *(("photon_rate",) if photons else ()),
            *(("digital_number",) if parameters.bits is not None else ()),
            *(("saturated",) if any(channel.can_saturate for channel in self.channels) else ()),
        )
        self.declares = SensorDeclaration(reach_pixels=self.blur.reach_pixels)
        self.worked_out: Mapping[str, Any] = {
            **self.blur.worked_out,
            "bands": {
                channel.band.name: {**self.blur.worked_out_of(channel.band), **channel.worked_out()}
                for channel in self.channels
            },
        }

    def measure(self, radiance: Array, frame: int, time_s: float) -> Measured:
        """Return the measurement of ``radiance`` (B, y, x); see :class:`hcss_twin.providers.Sensor`."""
        return self._measured(radiance, frame, np.zeros((len(self.channels), 0, 0), np.float32))

    def measure_with(self, radiance: Array, points: Points, frame: int, time_s: float) -> Measured:
        """Return the measurement of a frame with points: see :class:`hcss_twin.providers.SensorOptions`."""
        return self._measured(radiance, frame, self.blur.of_points(points, *radiance.shape[1:]))

    def _measured(self, radiance: Array, frame: int, added: NDArray[np.float32]) -> Measured:
        """Return the measurement of a frame; what is added (B, y, x), if anything, is not blurred."""
        found = self.arrays(radiance.shape)
        self.measure_into(np.ascontiguousarray(radiance, dtype=np.float32), frame, found, added=added)
        return Measured(**found)

    def arrays(self, shape: tuple[int, ...]) -> dict[str, NDArray[Any]]:
        """Return arrays for the measurement of frames of a shape (B, y, x)."""
        return {name: np.empty(shape, _TYPES[name]) for name in ("radiance", *self.variables)}

    @property
    def any_rows(self) -> bool:
        """Whether :meth:`measure_into` may write some rows at little cost: no blur needs the whole frame."""
        return all(weights is not None for weights in self.blur.weights.values())

    def measure_into(
        self,
        clean: NDArray[np.float32],
        frame: int,
        found: Mapping[str, NDArray[Any]],
        bands: slice = slice(None),
        lines: tuple[int, int] | None = None,
        added: NDArray[np.float32] | None = None,
    ) -> None:
        """Write the measurement by rows of ``clean`` (B, y, x), or of some bands and rows, into :meth:`arrays`.

        ``added`` (B, y, x), if any, is not blurred.
        """
        none = {name: np.empty((0, 0), dtype) for name, dtype in _TYPES.items()}
        for index in range(len(self.channels))[bands]:
            channel = self.channels[index]
            image, weights = self.blur.by_rows(clean[index], channel.band)
            results = {name: values[index] for name, values in found.items()}
            more = none["radiance"] if added is None else added[index]
            channel.measure_rows(image, weights, more, frame, lines or (0, len(image)), {**none, **results})


@dataclass(frozen=True)
class _Channel:
    """One band behind the optics.

    The signal is in electrons with ``noise = "photon"``, and otherwise in radiance.
    """

    inputs: SensorInputs
    parameters: RadiometerParameters
    band: SensorBand

    def worked_out(self) -> dict[str, float]:
        """Derived quantities of the band; reports missing band values before the first frame."""
        electrons = self.electrons_per_radiance
        derived = {
            "noise_radiance": self.noise_radiance if electrons is None else None,
            "photon_wavelength_um": self.photon_wavelength_um if self.photons_per_radiance else None,
            "photons_per_radiance": self.photons_per_radiance or None,
            "electrons_per_radiance": electrons,
            "signal_per_number": self.readout.step if self.readout.bits is not None else None,
        }
        self._number("offset_radiance")
        return {name: value for name, value in derived.items() if value is not None}

    @property
    def can_saturate(self) -> bool:
        """Whether the signal has an upper limit."""
        return self.readout.full is not None or self.readout.bits is not None

    @cached_property
    def photon_wavelength_um(self) -> float:
        return photon_wavelength_um(self.band, self.parameters.photon_temperature)

    @cached_property
    def photons_per_radiance(self) -> float:
        """Photons per second and pixel for 1 W m-2 sr-1; 0 where aperture or angle is unknown."""
        given = self.parameters
        if given.aperture_diameter is None or given.pixel_angle is None:
            return 0.0
        transmission = self._number("transmission")
        return photons_per_radiance(given.aperture_diameter, given.pixel_angle, transmission, self.photon_wavelength_um)

    @cached_property
    def electrons_per_radiance(self) -> float | None:
        """Electrons per integration for 1 W m-2 sr-1; None where electrons are not counted."""
        given = self.parameters
        if given.noise != "photon" or given.integration_time is None:
            return None
        return self.photons_per_radiance * self._number("quantum_efficiency") * given.integration_time

    @cached_property
    def noise_radiance(self) -> float:
        """Standard deviation of Gaussian noise, W m-2 sr-1."""
        if self.parameters.noise == "nedt":
            slope = band_radiance_per_kelvin(self.band, self._number("nedt_temperature"))
            return self._number("nedt") * slope
        return self._number("ner") if self.parameters.noise == "ner" else 0.0

    @cached_property
    def readout(self) -> Readout:
        """Largest signal and digital numbers, in electrons or radiance."""
        given = self.parameters
        full_name, step_name = (
            ("saturation_radiance", "radiance_per_number")
            if self.electrons_per_radiance is None
            else ("well_depth", "electrons_per_number")
        )
        full = None if getattr(given, full_name) is None else self._number(full_name)
        if given.bits is None:
            return Readout(full)
        if getattr(given, step_name) is not None:
            step = self._number(step_name)
        else:
            assert full is not None  # the parameters require one of both
            step = full / max(2**given.bits - 1 - given.number_offset, 1)
        return Readout(full, given.bits, step, given.number_offset)

    @cached_property
    def pattern(self) -> tuple[NDArray[np.float32], ...]:
        """Gain differences and offsets of the detectors: (Y, X), (Y, 1) for one per row, or (0, 0) for none."""
        given, grid, corner = self.parameters, self.inputs.grid, self.inputs.corner
        shape = grid.rows, grid.columns
        if given.fixed_pattern == "row":  # stripes along the flight direction (x)
            shape, corner = (shape[0], 1), (corner[0], 0)
        offset = self._number("offset_radiance") if self.electrons_per_radiance is None else given.offset_electrons
        return tuple(
            (size * Noise.standard_normal(self._key(stage), shape if size else (0, 0), corner)).astype(np.float32)
            for stage, size in (("gain", given.gain_deviation), ("offset", offset))
        )

    def measure_rows(
        self,
        image: NDArray[np.float32],
        weights: Weights,
        added: NDArray[np.float32],
        frame: int,
        lines: tuple[int, int],
        results: Mapping[str, NDArray[Any]],
    ) -> None:
        """Write some rows of the results (Y, X) for a frame (Y, X) that is not blurred yet."""
        keys = tuple(np.uint64(self._key(stage, frame)) for stage in ("rows", "shot"))
        names = ("radiance", "photon_rate", "digital_number", "saturated")
        written = (results[name] for name in names)
        behind = (*self.pattern, self.detector, keys, self.inputs.corner, lines)
        if not measure(image, *weights, added, *behind, *written):
            raise too_many_electrons(float(image.max()) * self.detector.per_radiance + self.detector.dark)

    @cached_property
    def detector(self) -> Detector:
        """Numbers of the band for the computation by rows."""
        given, read, per_radiance = self.parameters, self.readout, self.electrons_per_radiance
        counts = per_radiance is not None
        return Detector(
            per_radiance=1.0 if per_radiance is None else per_radiance,
            dark=given.dark_current * (given.integration_time or 0.0) if counts else 0.0,
            photons=self.photons_per_radiance,
            shot=float(counts and given.shot_noise),
            deviation=given.read_noise if counts else self.noise_radiance,
            full=math.inf if read.full is None else read.full,
            step=read.step if read.bits is not None else 0.0,
            offset=float(read.offset),
            most=2.0 ** (read.bits or 0) - 1.0,
        )

    def _key(self, stage: str, frame: int = 0) -> int:
        """Return the key of a stage's random numbers."""
        return Noise.key_of(self.inputs.seed, stage, self.band.name, frame)

    def _number(self, name: str) -> float:
        return OfBands.number(getattr(self.parameters, name), self.band.name, name)
