"""Levels of numerical accuracy of the physical model, from which the engine chooses by error.

With N streams, Gauss's rule integrates products of two kernels exactly only if they have N moments: where the phase
function is sharply peaked, N moments are nearer the truth than 2 N, and cost less; for droplets 8 streams need 16.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from hcss_twin.models.parameters import AZIMUTH_MODES, STREAMS, SUN_STREAMS, PhysicalParameters

SUBLAYERS = 2
"""Parts of each layer where no numerical level says how many, and of the coarse layers beside sunlight."""

MORE_MIRROR_STREAMS = 8
"""With 14 streams at all levels, thin clouds over a sea under 3 to 17 m/s are within 5e-4 of discrete ordinates."""


@dataclass(frozen=True)
class Numerics:
    """Sizes of the numerical solution.

    Attributes
    ----------
    streams : int
        Gauss streams per hemisphere for diffuse light and sky radiance, with twice as many moments.
    sun_streams, sun_moments : int
        Streams, and moments of the phase function, for sunlight that clouds scatter toward the sensor.
    azimuth_modes : int
        Most terms of its Fourier series over azimuth.
    turned_modes : int
        Most azimuth modes of sunlight between cloud and sea: under a thin cloud over a calm sea, fewer than twice the
        streams break off the series where it still oscillates.
    faint_sun : float
        Sunlight below this share of a cold sea's emission is scattered in closed form, with an error of 15 %.
    sublayers : int
        Parts of each layer of the air for its emission; even.
    scattered_sublayers : int
        The same for emission that is scattered before it reaches the sensor, from fewer levels; see also
        ``steep_sublayers``.
    between_wavenumbers : float
        Error of cloud operators that dense spectra interpolate in wavenumber; 0 solves every wavenumber.
    per_octave : int
        Thicknesses per doubling at which layers are solved; operators are interpolated between them.
    """

    streams: int
    sun_streams: int
    sun_moments: int
    azimuth_modes: int
    turned_modes: int
    faint_sun: float
    sublayers: int = SUBLAYERS
    scattered_sublayers: int = SUBLAYERS
    between_wavenumbers: float = 0.0
    per_octave: int = 3

    @property
    def steep_sublayers(self) -> int:
        """Parts of each layer for emission that is scattered, where Planck's law is steep and there is no sunlight."""
        return self.sublayers + MORE_STEEP_SUBLAYERS

    @property
    def mirror_streams(self) -> int:
        """Streams for light that the sea mirrors once, with twice as many moments and modes."""
        return self.streams + MORE_MIRROR_STREAMS


# Sizes grow from level to level: the difference of two levels misses one that does not. Sublayers are few steps only,
# because the wavenumbers of the tables are chosen three levels below: below 3 um, where Planck's law is steep, two of
# them leave 3e-4 of the radiance, four 2e-5, six 4e-6, and such errors have other spectra than the radiance. Where it
# is not steep, two are within 6e-5.
LEVELS = (
    Numerics(4, 6, 9, 9, 8, 0.015, 4, 2, 1e-4),
    Numerics(6, 8, 12, 12, 12, 0.01, 4, 2, 1e-4),
    Numerics(8, 12, 18, 18, 16, 0.005, 4, 2, 1e-4),
    Numerics(10, 16, 24, 24, 20, 0.004, 4, 2, 1e-4),
    Numerics(12, 24, 36, 36, 24, 0.001, 6, 4),
    Numerics(16, 32, 48, 48, 32, 0.0005, 6, 4),
    Numerics(20, 48, 72, 72, 40, 0.0002, 6, 6),
    Numerics(24, 64, 96, 96, 48, 0.0, 10, 8),
)

MORE_STEEP_SUBLAYERS = 2
"""More sublayers for light that is scattered afterwards, from fewer levels, where Planck's law is steep and no sunlight
outshines it: with four in all, deep convection at 2.6 um errs by 1.6e-4, with six by 0.8e-4."""


COARSEST: dict[str, Any] = {"between_wavenumbers": 2e-3, "per_octave": 2}
"""Values of the coarsest level if sunlight is as coarse: its spectra serve accuracies of about 1e-3 and larger."""


def levels(parameters: PhysicalParameters, sunlight_steps: int = 0) -> tuple[Numerics, ...]:
    """Return the levels from the coarsest to the finest; the last is a reference only.

    Sizes that a scenario states are the only level beside the next finer one.

    Parameters
    ----------
    sunlight_steps : int
        How many levels finer sunlight toward the sensor is than all else; not beyond the finest.
    """
    stated = parameters.streams, parameters.sun_streams, parameters.sun_moments, parameters.azimuth_modes
    if all(size is None for size in stated):
        finer = [LEVELS[min(level + sunlight_steps, len(LEVELS) - 1)] for level in range(len(LEVELS))]
        first, *others = (
            replace(numerics, sun_streams=sun.sun_streams, sun_moments=sun.sun_moments, azimuth_modes=sun.azimuth_modes)
            for numerics, sun in zip(LEVELS, finer, strict=True)
        )
        return (first if sunlight_steps else replace(first, **COARSEST)), *others
    streams, sun_streams = parameters.streams or STREAMS, parameters.sun_streams or SUN_STREAMS
    modes = parameters.azimuth_modes or AZIMUTH_MODES
    moments = parameters.sun_moments or sun_streams
    stated_numerics = Numerics(streams, sun_streams, moments, min(modes, moments), min(modes, 2 * streams, 8), 0.015)
    next_finer = (level for level in LEVELS if level.streams > streams and level.sun_streams > sun_streams)
    return stated_numerics, next(
        next_finer, replace(LEVELS[-1], streams=32, sun_streams=96, sun_moments=96, azimuth_modes=96)
    )
