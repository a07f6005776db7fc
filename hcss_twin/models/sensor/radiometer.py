"""The default sensor: optics, detector and converter, stage after stage."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.models.sensor.blur import Blur
from hcss_twin.models.sensor.detector import (
    Detection,
    Readout,
    band_radiance_per_kelvin,
    photon_wavelength_um,
    photons_per_radiance,
)
from hcss_twin.models.sensor.noise import FixedPattern, gaussian_noise, shot_noise
from hcss_twin.models.sensor.parameters import RadiometerParameters, of_band
from hcss_twin.models.sensor.random_numbers import key_of
from hcss_twin.providers import Declares, Measured, SensorBand, SensorInputs


class Radiometer:
    """Blur, smear, photons, noise, fixed pattern, saturation and quantisation (docs/sensor.md)."""

    def __init__(self, inputs: SensorInputs, parameters: RadiometerParameters) -> None:
        self._blur = Blur(inputs, parameters)
        self._channels = tuple(_Channel(inputs, parameters, band) for band in inputs.bands)
        photons = parameters.aperture_diameter is not None and parameters.pixel_angle is not None
        self.variables = (
            *(("photon_rate",) if photons else ()),
            *(("digital_number",) if parameters.bits is not None else ()),
            *(("saturated",) if any(each.can_saturate for each in self._channels) else ()),
        )
        self.declares = Declares(reach_pixels=self._blur.reach_pixels)
        self.worked_out: Mapping[str, Any] = {
            **self._blur.worked_out,
            "bands": {
                channel.band.name: {**self._blur.worked_out_of(channel.band), **channel.worked_out}
                for channel in self._channels
            },
        }

    def measure(self, radiance: Array, frame: int, time_s: float) -> Measured:
        """Return what is measured of ``radiance`` (B, y, x); see :class:`hcss_twin.providers.Sensor`."""
        clean = np.asarray(radiance, dtype=np.float64)
        made = [
            channel.measure(self._blur(clean[index], channel.band), frame)
            for index, channel in enumerate(self._channels)
        ]
        numbers = [each.digital_number for each in made if each.digital_number is not None]
        return Measured(
            radiance=np.stack([each.radiance for each in made]),
            photon_rate=np.stack([each.photon_rate for each in made]) if "photon_rate" in self.variables else None,
            digital_number=np.stack(numbers) if numbers else None,
            saturated=np.stack([each.saturated for each in made]) if "saturated" in self.variables else None,
        )


@dataclass(frozen=True)
class _Read:
    """A frame of one band; see :class:`hcss_twin.providers.Measured`."""

    radiance: Array
    photon_rate: Array
    digital_number: NDArray[np.int32] | None
    saturated: NDArray[np.uint8]


@dataclass(frozen=True)
class _Channel:
    """One band behind the optics."""

    inputs: SensorInputs
    parameters: RadiometerParameters
    band: SensorBand
    worked_out: dict[str, Any] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        # Made here so that what a band lacks is found with the parameters, not with the first frame.
        told: dict[str, float | int | None] = {
            "noise_radiance": None if self.detection is not None else self.noise_radiance,
            "photon_wavelength_um": self.photon_wavelength_um if self.photons_per_radiance else None,
            "photons_per_radiance": self.photons_per_radiance or None,
            "electrons_per_radiance": None if self.detection is None else self.detection.electrons_per_radiance,
            "signal_per_number": self.readout.step if self.readout.bits is not None else None,
        }
        self.worked_out.update({name: value for name, value in told.items() if value is not None})
        self._number("offset_radiance")

    @property
    def can_saturate(self) -> bool:
        """Whether there is a largest value."""
        return self.readout.full is not None or self.readout.bits is not None

    @cached_property
    def photon_wavelength_um(self) -> float:
        """Wavelength at which energy becomes photons."""
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
    def detection(self) -> Detection | None:
        """How electrons are counted; None where the noise has a size of its own."""
        given = self.parameters
        if given.noise != "photon" or given.integration_time is None:
            return None
        per_radiance = self.photons_per_radiance * self._number("quantum_efficiency") * given.integration_time
        return Detection(
            photons_per_radiance=self.photons_per_radiance,
            electrons_per_radiance=per_radiance,
            dark_electrons=given.dark_current * given.integration_time,
            read_noise=given.read_noise,
            shot_noise=given.shot_noise,
        )

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
        counts = self.detection is not None
        range_of, step_of = (
            ("well_depth", "electrons_per_number") if counts else ("saturation_radiance", "radiance_per_number")
        )
        full = None if getattr(given, range_of) is None else self._number(range_of)
        if given.bits is None:
            return Readout(full)
        if getattr(given, step_of) is not None:
            step = self._number(step_of)
        else:
            assert full is not None  # the parameters ask for one of both
            most = 2**given.bits - 1 - given.number_offset
            step = full / max(most, 1)
        return Readout(full, given.bits, step, given.number_offset)

    @cached_property
    def pattern(self) -> FixedPattern:
        """Gain and offset of the detectors."""
        given, grid = self.parameters, self.inputs.grid
        offset = self._number("offset_radiance") if self.detection is None else given.offset_electrons
        return FixedPattern(
            (grid.rows, grid.columns),
            self.inputs.corner,
            given.gain_deviation,
            offset,
            given.fixed_pattern == "row",
            self.inputs.seed,
            self.band.name,
        )

    def measure(self, radiance: Array, frame: int) -> _Read:
        """Return what is read of a blurred frame (Y, X)."""
        rate = radiance * self.photons_per_radiance
        counts = self.detection
        signal = radiance if counts is None else radiance * counts.electrons_per_radiance
        signal = self.pattern(signal)
        per_radiance, dark = 1.0, 0.0
        if counts is None:
            if self.noise_radiance:
                signal = gaussian_noise(signal, self.noise_radiance, *self._random("noise", frame))
        else:
            per_radiance, dark = counts.electrons_per_radiance, counts.dark_electrons
            signal = signal + dark
            if counts.shot_noise:
                signal = shot_noise(signal, *self._random("shot", frame))
            if counts.read_noise:
                signal = gaussian_noise(signal, counts.read_noise, *self._random("read", frame))
        signal, number, flags = self.readout.read(signal)
        return _Read((signal - dark) / per_radiance, rate, number, flags)

    def _random(self, stage: str, frame: int) -> tuple[int, tuple[int, int]]:
        """Key of the random numbers of a stage, and the first pixel's row and column, which they depend on as well."""
        return key_of(self.inputs.seed, stage, self.band.name, frame), self.inputs.corner

    def _number(self, name: str) -> float:
        return of_band(getattr(self.parameters, name), self.band.name, name)
