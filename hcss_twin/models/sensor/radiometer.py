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
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.models.sensor.blur import UNBLURRED, Blur, Weights
from hcss_twin.models.sensor.detector import (
    Readout,
    band_radiance,
    band_radiance_per_kelvin,
    black_body_K,
    photon_wavelength_um,
    photons_per_radiance,
)
from hcss_twin.models.sensor.noise import Noise, too_many_electrons
from hcss_twin.models.sensor.parameters import OfBands, RadiometerParameters
from hcss_twin.models.sensor.rows import Detector, measure
from hcss_twin.providers import Measured, Points, SensorBand, SensorDeclaration, SensorInputs

NEDT_AGREES, WELL_AGREES = 0.2, 1.02
"""Relative difference of a stated NEDT and that of the electrons, and share of a well that may be full at saturation:
published numbers are rounded."""

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
        unshaken = parameters.jitter > 0.0 and parameters.psf in ("airy", "file")
        notes = ["sensor: jitter blurs the image, but not small elements"] if unshaken else []
        if parameters.psf == "none":
            notes += [self.blur.without_optics(inputs.bands)]
        self.declares = SensorDeclaration(reach_pixels=self.blur.reach_pixels, notes=tuple(notes))
        self.worked_out: Mapping[str, Any] = {
            **self.blur.worked_out,
            "bands": {
                channel.band.name: {**self.blur.worked_out_of(channel.band), **channel.worked_out()}
                for channel in self.channels
            },
        }

    def measure(self, radiance: Array, frame: int, time_s: float) -> Measured:
        """Return the measurement of ``radiance`` (B, y, x); see :class:`hcss_twin.providers.Sensor`."""
        return self._measured(radiance, frame, time_s, np.zeros((len(self.channels), 0, 0), np.float32))

    def measure_with(self, radiance: Array, points: Points, frame: int, time_s: float) -> Measured:
        """Return the measurement of a frame with points: see :class:`hcss_twin.providers.SensorOptions`."""
        return self._measured(radiance, frame, time_s, self.blur.of_points(points, *radiance.shape[1:]))

    def _measured(self, radiance: Array, frame: int, time_s: float, added: NDArray[np.float32]) -> Measured:
        """Return the measurement of a frame; what is added (B, y, x), if anything, is not blurred."""
        found = self.arrays(radiance.shape)
        self.measure_into(np.ascontiguousarray(radiance, dtype=np.float32), frame, found, added=added, time_s=time_s)
        return Measured(**found)

    def measure_blurred(
        self, blurred: NDArray[np.float32], points: Points | None, frame: int, time_s: float, place: tuple[int, int]
    ) -> Measured:
        """Return the measurement of a part of a frame that has passed the optics, with points drawn into it.

        Parameters
        ----------
        blurred : ndarray of float32 (B, y, x)
            As :meth:`measure` returns it without noise.
        points : Points, optional
            Their rows and columns count from the first pixel of the part.
        place : (int, int)
            Row and column in the frame of this pixel.
        """
        added = None if points is None else self.blur.of_points(points, *blurred.shape[1:])
        found = self.arrays(blurred.shape)
        self.measure_into(np.ascontiguousarray(blurred), frame, found, added=added, time_s=time_s, place=place)
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
        time_s: float = 0.0,
        place: tuple[int, int] | None = None,
    ) -> None:
        """Write the measurement by rows of ``clean`` (B, y, x), or of some bands and rows, into :meth:`arrays`.

        ``added`` (B, y, x), if any, is not blurred, nor is a part of a frame at a ``place``. The time counts for drift
        alone.
        """
        none = {name: np.empty((0, 0), dtype) for name, dtype in _TYPES.items()}
        for index in range(len(self.channels))[bands]:
            channel = self.channels[index]
            image, weights = clean[index], UNBLURRED
            if place is None:
                image, weights = self.blur.by_rows(image, channel.band)
            results = {name: values[index] for name, values in found.items()}
            more = none["radiance"] if added is None else added[index]
            written = lines or (0, len(image))
            channel.measure_rows(image, weights, more, frame, time_s, written, {**none, **results}, place or (0, 0))


def _part(pattern: NDArray[np.float32], place: tuple[int, int], shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Return the part of a pattern (Y, X), (Y, 1) or (0, 0) that the detectors of an image have."""
    if not pattern.size or place == (0, 0):
        return pattern
    columns = slice(place[1], place[1] + shape[1]) if pattern.shape[1] > 1 else slice(None)
    return np.ascontiguousarray(pattern[place[0] : place[0] + shape[0], columns])


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
        electrons, detector = self.electrons_per_radiance, self.detector
        self._require_noise()
        derived = {
            "noise_radiance": self.noise_radiance if electrons is None else None,
            "nedt": self.nedt_of(detector.deviation) if electrons else self.noise_radiance / self._per_kelvin or None,
            "nedt_temperature": self._number("nedt_temperature"),
            "read_noise": None if electrons is None else detector.deviation,
            "background_electrons": detector.dark or None,
            "photon_wavelength_um": self.photon_wavelength_um if self.photons_per_radiance else None,
            "photons_per_radiance": self.photons_per_radiance or None,
            "electrons_per_radiance": electrons,
            "saturation_temperature": self._saturation_K(),
            "signal_per_number": self.readout.step if self.readout.bits is not None else None,
        }
        if detector.step:
            per_number = detector.step / detector.per_radiance
            zero = detector.dark / detector.step + detector.offset
            derived |= {"radiance_per_number": per_number, "radiance_at_number_0": 0.0 - per_number * zero}
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
            return self._number("nedt") * self._per_kelvin
        return self._number("ner") if self.parameters.noise == "ner" else 0.0

    @cached_property
    def _per_kelvin(self) -> float:
        """Change of the radiance of a black body of ``nedt_temperature``, W m-2 sr-1 K-1."""
        return band_radiance_per_kelvin(self.band, self._number("nedt_temperature"))

    @cached_property
    def dark(self) -> float:
        """Electrons per integration without light from the scene: dark current, emission of optics and housing."""
        given, time_s = self.parameters, self.parameters.integration_time
        if self.electrons_per_radiance is None or time_s is None:
            return 0.0
        assert given.aperture_diameter is not None
        assert given.pixel_angle is not None
        optics = given.aperture_diameter, given.pixel_angle
        emitted = 0.0
        for kelvin, share in (
            (given.optics_temperature, 1.0 - self._number("transmission")),
            (given.housing_temperature, given.housing_etendue or 0.0),
        ):
            if kelvin is not None:
                photons = photons_per_radiance(*optics, share, photon_wavelength_um(self.band, kelvin))
                emitted += photons * band_radiance(self.band, kelvin)
        return (given.dark_current + emitted * self._number("quantum_efficiency")) * time_s

    def nedt_of(self, read_noise: float) -> float:
        """NEDT of counted electrons at ``nedt_temperature``, K: noise of shots, read-out and quantisation (1 / 12)."""
        per_radiance = self.electrons_per_radiance
        assert per_radiance is not None
        step = self.readout.step if self.readout.bits is not None else 0.0
        variance = self._shot_variance + read_noise**2 + step**2 / 12.0
        return math.sqrt(variance) / (per_radiance * self._per_kelvin)

    @property
    def _shot_variance(self) -> float:
        assert self.electrons_per_radiance is not None
        scene = self.electrons_per_radiance * band_radiance(self.band, self._number("nedt_temperature"))
        return scene + self.dark if self.parameters.shot_noise else 0.0

    @cached_property
    def _read_noise(self) -> float:
        """Read noise in electrons: what the NEDT leaves, unless it is given."""
        given = self.parameters
        if given.nedt is None or "read_noise" in given.model_fields_set:
            return given.read_noise
        others, wanted = self.nedt_of(0.0), self._number("nedt")
        per_kelvin = (self.electrons_per_radiance or 0.0) * self._per_kelvin
        return per_kelvin * math.sqrt(max(wanted**2 - others**2, 0.0))

    def _require_noise(self) -> None:
        """Raise a :class:`ScenarioError` if the stated NEDT is not that of the electrons."""
        given = self.parameters
        if self.electrons_per_radiance is None or given.nedt is None:
            return
        wanted, found = self._number("nedt"), self.nedt_of(self._read_noise)
        if abs(found / wanted - 1.0) <= (NEDT_AGREES if "read_noise" in given.model_fields_set else 1e-6):
            return
        what = "with read_noise it" if "read_noise" in given.model_fields_set else "without read noise it"
        raise self._problem(
            "nedt",
            f"{wanted:g} K at {self._number('nedt_temperature'):g} K in band '{self.band.name}', but {what} is "
            f"{found:.3g} K with {math.sqrt(self._shot_variance):.4g} electrons of shot noise; allowed: keys that "
            f"agree within {100 * NEDT_AGREES:g} %, from {found:.3g} K on, or more light or a longer integration_time",
        )

    def _saturation_K(self) -> float | None:
        """Temperature of the black body at which the range ends; None without a range, or above 20000 K."""
        read, per_radiance = self.readout, self.electrons_per_radiance
        ends = [] if read.full is None else [read.full - self.dark]
        if read.bits is not None:
            ends.append((2**read.bits - 1 - read.offset) * read.step - self.dark)
        most = min(ends, default=0.0) / (per_radiance or 1.0)
        coldest, hottest = (band_radiance(self.band, kelvin) for kelvin in (30.0, 15e3))
        return black_body_K(self.band, most) if coldest < most < hottest else None

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
        full = self._full_at_saturation(full)
        if given.bits is None:
            return Readout(full)
        if getattr(given, step_name) is not None:
            step = self._number(step_name)
        else:
            assert full is not None  # the parameters require one of both
            step = full / max(2**given.bits - 1 - given.number_offset, 1)
        return Readout(full, given.bits, step, given.number_offset)

    def _full_at_saturation(self, well: float | None) -> float | None:
        """Return the signal at ``saturation_temperature``, which a well must hold; the well's without it."""
        if self.parameters.saturation_temperature is None:
            return well
        kelvin, per_radiance = self._number("saturation_temperature"), self.electrons_per_radiance
        full = (per_radiance or 1.0) * band_radiance(self.band, kelvin) + self.dark
        if well is not None and per_radiance is not None and full > well * WELL_AGREES:
            left = (well - self.dark) / per_radiance
            hottest = (
                f"it is full at {black_body_K(self.band, left):.4g} K" if left > 0.0 else "the background fills it"
            )
            raise self._problem(
                "saturation_temperature",
                f"{kelvin:g} K in band '{self.band.name}' needs {full:.4g} electrons, and well_depth is {well:.4g}: "
                f"{hottest}; allowed: a colder one, a shorter integration_time, or a deeper well",
            )
        return full

    def _problem(self, name: str, message: str) -> ScenarioError:
        return ScenarioError([Problem(f"sensor.parameters.{name}", message)])

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
        time_s: float,
        lines: tuple[int, int],
        results: Mapping[str, NDArray[Any]],
        place: tuple[int, int] = (0, 0),
    ) -> None:
        """Write some rows of the results (Y, X) for an image (Y, X) at a place in the frame, and weights of blur."""
        keys = tuple(np.uint64(self._key(stage, frame)) for stage in ("rows", "shot"))
        names = ("radiance", "photon_rate", "digital_number", "saturated")
        written = (results[name] for name in names)
        pattern = (_part(of_frame, place, image.shape) for of_frame in self.pattern_at(time_s))
        corner = self.inputs.corner[0] + place[0], self.inputs.corner[1] + place[1]
        behind = (*pattern, self.detector, keys, corner, lines)
        if not measure(image, *weights, added, *behind, *written):
            raise too_many_electrons(float(image.max()) * self.detector.per_radiance + self.detector.dark)

    def pattern_at(self, time_s: float) -> tuple[NDArray[np.float32], ...]:
        """Return the pattern with the drift of all detectors since the last calibration."""
        gain, offset = self.pattern
        cycle_s = self.parameters.calibration_cycle
        if cycle_s is None:
            return gain, offset
        drift = self._number("drift") * self._per_kelvin * (self.electrons_per_radiance or 1.0)
        now = np.float32(drift * (time_s % cycle_s) / cycle_s)
        return gain, offset + now if offset.size else np.full((self.inputs.grid.rows, 1), now)

    @cached_property
    def detector(self) -> Detector:
        """Numbers of the band for the computation by rows."""
        given, read, per_radiance = self.parameters, self.readout, self.electrons_per_radiance
        counts = per_radiance is not None
        return Detector(
            per_radiance=1.0 if per_radiance is None else per_radiance,
            dark=self.dark,
            photons=self.photons_per_radiance,
            shot=float(counts and given.shot_noise),
            deviation=self._read_noise if counts else self.noise_radiance,
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
