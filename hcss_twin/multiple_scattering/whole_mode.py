"""One azimuth mode of layers, solved for pairs of directions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.multiple_scattering.chains import Chains
from hcss_twin.multiple_scattering.doubling import solve_chains
from hcss_twin.multiple_scattering.parallel import Team
from hcss_twin.multiple_scattering.phase_function import ScaledScattering
from hcss_twin.multiple_scattering.scattering_kernels import Directions, scattering_kernels

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SolvedMode:
    """One mode of the layers of chains, in their order: n layers, toward R directions, from S.

    Attributes
    ----------
    reflection, transmission : ndarray (n, R, S)
        sr-1.
    emissivity, far_share : ndarray (n, R)
        Without meaning but for mode 0.
    same, other : ndarray (V, D, C)
        The kernels of scattering they come from, for the wavenumbers that have layers.
    """

    reflection: Array
    transmission: Array
    emissivity: Array
    far_share: Array
    same: Array
    other: Array


def solve_mode(
    where: Directions,
    scaled: ScaledScattering,
    found: Chains,
    mode: int,
    team: Team,
    toward: int | None = None,
    sources: int | None = None,
) -> SolvedMode:
    """Solve one mode of the layers of ``found``.

    Parameters
    ----------
    toward, sources : int, optional
        How many of the last directions results are wanted for, and from how many of the first; by default all
        D and all C.
    """
    few = ScaledScattering(
        scaled.thickness[:, found.wavenumber],
        scaled.albedo[found.wavenumber],
        scaled.co_albedo[found.wavenumber],
        scaled.moments[:, found.wavenumber],
        scaled.peak[found.wavenumber],
    )
    same, other = scattering_kernels(where, few, mode)
    rows = where.mu.size if toward is None else toward
    columns = where.columns if sources is None else sources
    count = found.cell.size
    reflection, transmission = np.empty((count, rows, columns)), np.empty((count, rows, columns))
    emitted = np.empty((2, count, rows))
    place = np.arange(count)

    def part(start: int, step: int) -> None:
        solve_chains(
            (same, other, few.co_albedo),
            (where.mu, where.scale),
            (place, found.column, found.thickness, found.doublings, found.first),
            (where.beams, int(mode == 0)),
            (start, step),
            (reflection, transmission, emitted),
        )

    team.run(part, found.first.size - 1)
    return SolvedMode(reflection, transmission, emitted[0], emitted[1], same, other)
