"""One azimuth mode of layers, solved for all pairs of directions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.multiple_scattering.chains import Chains
from hcss_twin.multiple_scattering.doubling import solve_chains
from hcss_twin.multiple_scattering.parallel import in_threads
from hcss_twin.multiple_scattering.phase_function import ScaledScattering
from hcss_twin.multiple_scattering.scattering_kernels import Directions, scattering_kernels

Array = NDArray[np.float64]


def solve_mode(
    where: Directions, scaled: ScaledScattering, found: Chains, mode: int, threads: int | None
) -> tuple[Array, Array, Array]:
    """Solve one mode of all layers (T, V) of ``found``; D directions, which are beams or streams.

    Returns
    -------
    reflection, transmission : ndarray (T V, D, D)
        sr-1.
    emitted : ndarray (2, T V, D)
        Emissivity and far share; without meaning but for mode 0.
    """
    same, other = scattering_kernels(where, scaled, mode)
    count, size = scaled.thickness.size, where.mu.size
    reflection, transmission = np.empty((count, size, size)), np.empty((count, size, size))
    emitted = np.empty((2, count, size))

    def part(start: int, step: int) -> None:
        solve_chains(
            (same, other, scaled.co_albedo),
            (where.mu, where.scale),
            (found.cell, found.column, found.thickness, found.doublings, found.first),
            (where.beams, int(mode == 0)),
            (start, step),
            (reflection, transmission, emitted),
        )

    in_threads(part, found.first.size - 1, threads)
    return reflection, transmission, emitted
