"""Levels of numerical accuracy of the physical model, from which the engine chooses by error.

With N streams, Gauss's rule integrates products of two kernels exactly only if they have N moments: where the phase
function is sharply peaked, N moments are nearer the truth than 2 N, and cost less; for droplets 8 streams need 16.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from hcss_twin.models.parameters import AZIMUTH_MODES, STREAMS, SUN_STREAMS, PhysicalParameters
from hcss_twin.models.radiance.physical.air import SUBLAYERS


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
        Sunlight below this share of the sea's emission is scattered in closed form, with an error of 15 %.
    sublayers : int
        Parts of each layer of the air for its emission; even.
    closure_order : int
        Number of changes of direction up to which gas absorption is exact, in columns with one cloud. The error is
        1.3e-4 of the radiance for 1, and 1.6e-5 for 2. Columns with two clouds use 1, since 2 takes four times as long.
    """

    streams: int
    sun_streams: int
    sun_moments: int
    azimuth_modes: int
    turned_modes: int
    faint_sun: float
    sublayers: int = SUBLAYERS
    closure_order: int = 1


# Every size grows from level to level: the difference of two levels would miss one that does not. Two sublayers leave
# 3e-5 of the radiance: less than the tolerances for which the search starts below the levels with four.
LEVELS = (
    Numerics(4, 6, 6, 6, 8, 0.015),
    Numerics(6, 8, 8, 8, 12, 0.01),
    Numerics(8, 12, 12, 12, 16, 0.005),
    Numerics(10, 16, 16, 16, 20, 0.004),
    Numerics(12, 24, 24, 24, 24, 0.001, 4, 2),
    Numerics(16, 32, 32, 32, 32, 0.0005, 4, 2),
    Numerics(20, 48, 48, 48, 40, 0.0002, 4, 2),
    Numerics(24, 64, 64, 64, 48, 0.0, 6, 2),
)


def levels(parameters: PhysicalParameters) -> tuple[Numerics, ...]:
    """Return the levels from the coarsest to the finest; the last is a reference only.

    Sizes that a scenario states are the only level beside the next finer one.
    """
    order = parameters.closure_order
    known = LEVELS if order is None else tuple(replace(each, closure_order=order) for each in LEVELS)
    stated = parameters.streams, parameters.sun_streams, parameters.azimuth_modes
    if stated == (None, None, None):
        return known
    streams, sun_streams = parameters.streams or STREAMS, parameters.sun_streams or SUN_STREAMS
    modes = parameters.azimuth_modes or AZIMUTH_MODES
    turned = min(modes, 2 * streams, 8)
    own = replace(known[0], streams=streams, sun_streams=sun_streams, sun_moments=2 * sun_streams, azimuth_modes=modes)
    own = replace(own, turned_modes=turned)
    finer = (each for each in known if each.streams > streams and each.sun_streams > sun_streams)
    return own, next(finer, replace(known[-1], streams=32, sun_streams=96, sun_moments=96, azimuth_modes=96))
