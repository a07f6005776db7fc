"""What homogeneous layers make of beams: diffuse transmission along the streams, by azimuth modes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hcss_twin.multiple_scattering.chains import chains
from hcss_twin.multiple_scattering.checks import checked_cosines, checked_layers
from hcss_twin.multiple_scattering.parallel import Team
from hcss_twin.multiple_scattering.phase_function import delta_m
from hcss_twin.multiple_scattering.scattering_kernels import directions
from hcss_twin.multiple_scattering.streams import gauss_streams
from hcss_twin.multiple_scattering.whole_mode import solve_mode

Array = NDArray[np.float64]


def transmit_beams(
    optical_thickness: ArrayLike,
    albedo: ArrayLike,
    moments: ArrayLike,
    mu_beams: ArrayLike,
    streams: int,
    modes: int,
    threads: int | None = None,
) -> Array:
    """Diffuse transmission of beams toward the streams in the azimuth modes from 1 on.

    With T_m the mode m (0 is that of :func:`hcss_twin.multiple_scattering.layer.solve_layers`), a beam of
    irradiance E across the layer leaves on the other side as E [T_0 + 2 sum T_m cos(m psi)], psi being the azimuth from
    the beam's own direction. Light in the forward peak taken off by delta-M counts as direct. By reciprocity it is also
    what streams send into the beam's direction.

    Parameters
    ----------
    optical_thickness, albedo, moments, streams, threads
        As for ``solve_layers``.
    mu_beams : array_like (B,)
        Cosines of the beams' zenith angles, in (0, 1].
    modes : int
        Modes up to this one, not included; 1 to twice the streams.

    Returns
    -------
    ndarray (modes - 1, T, V, N, B)
        sr-1.

    Raises
    ------
    ValueError
        If a value is outside its range or shapes do not fit.
    """
    thickness, w, chi = checked_layers(optical_thickness, albedo, moments)
    beams = checked_cosines("mu_beams", mu_beams)
    if not 1 <= modes <= 2 * streams:
        raise ValueError(f"modes {modes}: allowed 1 to {2 * streams}, twice the streams")
    where = directions(beams, gauss_streams(streams), np.empty(0))
    scaled = delta_m(thickness, w, chi, 2 * streams)
    found = chains(scaled.thickness, np.ones(thickness.shape, dtype=np.bool_))
    result = np.empty((modes - 1, thickness.size, streams, beams.size))
    with Team(threads) as team:
        for mode in range(1, modes):
            solved = solve_mode(where, scaled, found, mode, team, toward=streams, sources=beams.size)
            result[mode - 1, found.cell] = solved.transmission
    return result.reshape(modes - 1, *thickness.shape, streams, beams.size)
