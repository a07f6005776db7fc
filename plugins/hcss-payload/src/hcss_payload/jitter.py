"""Jitter of the line of sight, as a function of time alone."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hcss_payload.checks import PayloadError, require_within
from hcss_twin.providers import Array

PER_OCTAVE = 16
"""Sinusoids per octave: every octave holds the same number of them, wherever it begins."""


@dataclass(frozen=True)
class JitterLine:
    """One vibration.

    Parameters
    ----------
    frequency_hz : float
        Of the vibration.
    amplitude_rad : (float, float, float)
        Around x, y and z of the body.
    phase_rad : float
        At time 0.
    """

    frequency_hz: float
    amplitude_rad: tuple[float, float, float]
    phase_rad: float = 0.0

    def __post_init__(self) -> None:
        require_within("jitter.lines.frequency_hz", self.frequency_hz, 0.0, 1e5, "Hz")
        for value in self.amplitude_rad:
            require_within("jitter.lines.amplitude_rad", value, -0.1, 0.1, "rad")


@dataclass(frozen=True)
class Jitter:
    """Small turns with a power spectral density f^-exponent between two frequencies, and lines.

    A sum of sinusoids at logarithmically spaced frequencies with random phases, each with the power of its interval.
    The same time always gives the same turn, in any order of calls.

    Parameters
    ----------
    rms_rad : (float, float, float)
        Root mean square of the turns around x, y and z of the body, without lines.
    lowest_hz, highest_hz : float
        Limits of the spectrum.
    exponent : float
        Of the power spectral density; 0 is white.
    lines : tuple of JitterLine
        Vibrations of single frequencies.
    seed : int
        Of the phases.
    """

    rms_rad: tuple[float, float, float] = (0.0, 0.0, 0.0)
    lowest_hz: float = 0.1
    highest_hz: float = 100.0
    exponent: float = 2.0
    lines: tuple[JitterLine, ...] = ()
    seed: int = 0

    def __post_init__(self) -> None:
        for value in self.rms_rad:
            require_within("jitter.rms_rad", value, 0.0, 0.1, "rad")
        require_within("jitter.lowest_hz", self.lowest_hz, 1e-6, 1e5, "Hz")
        require_within("jitter.highest_hz", self.highest_hz, 1e-6, 1e5, "Hz")
        require_within("jitter.exponent", self.exponent, -2.0, 6.0)
        require_within("jitter.seed", self.seed, 0, 2**63 - 1)
        if self.highest_hz < 1.1 * self.lowest_hz:
            raise PayloadError(
                f"jitter.highest_hz: {self.highest_hz:g} Hz with lowest_hz {self.lowest_hz:g} Hz; allowed: from "
                f"{1.1 * self.lowest_hz:g} Hz on, or a line for a single frequency"
            )

    def at(self, time_s: float | Array) -> Array:
        """Return the turns (..., 3) in rad around x, y and z of the body at times (...)."""
        frequency, amplitude, phase = self._sinusoids
        angle = 2.0 * np.pi * np.asarray(time_s)[..., None, None] * frequency[:, None] + phase
        turns: Array = np.sum(amplitude * np.sin(angle), axis=-2)
        return turns

    @property
    def largest_rad(self) -> float:
        """Largest turn to expect: six times the root mean square of all axes, and the amplitudes of the lines."""
        lines = sum(float(np.linalg.norm(line.amplitude_rad)) for line in self.lines)
        return 6.0 * float(np.linalg.norm(self.rms_rad)) + lines

    def moved_rad(self, time_s: float) -> float:
        """Return the largest change to expect within a time: three times its root mean square, of all axes."""
        frequency, amplitude, _ = self._sinusoids
        swing = np.sin(np.pi * np.minimum(frequency * time_s, 0.5))
        return 3.0 * float(np.sqrt(2.0 * np.sum((swing[:, None] * amplitude) ** 2)))

    @cached_property
    def _sinusoids(self) -> tuple[Array, Array, Array]:
        """Frequencies (K,), amplitudes (K, 3) and phases (K, 3); each has the mean square of its interval."""
        count = int(np.ceil(PER_OCTAVE * np.log2(self.highest_hz / self.lowest_hz)))
        edges = np.geomspace(self.lowest_hz, self.highest_hz, count + 1)
        # The integral of f^-exponent over an interval, relative to that over all of them.
        power = np.log(edges) if self.exponent == 1.0 else edges ** (1.0 - self.exponent) / (1.0 - self.exponent)
        share = np.diff(power) / (power[-1] - power[0])
        amplitude = np.sqrt(2.0 * share)[:, None] * np.array(self.rms_rad)
        phase = np.random.default_rng(self.seed).uniform(0.0, 2.0 * np.pi, amplitude.shape)
        return (
            np.concatenate((np.sqrt(edges[1:] * edges[:-1]), [line.frequency_hz for line in self.lines])),
            np.concatenate((amplitude, np.reshape([line.amplitude_rad for line in self.lines], (-1, 3)))),
            np.concatenate((phase, np.reshape([[line.phase_rad] * 3 for line in self.lines], (-1, 3)))),
        )
