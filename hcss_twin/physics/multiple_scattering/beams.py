"""Azimuth modes of beams of light: what a cloud transmits toward surfaces and clouds below, and what these scatter.

Diffuse light is solved as a mean over azimuth; light that a thin cloud scatters forward still comes from near the sun.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.physics.multiple_scattering.chains import AzimuthSeries, Team, chains
from hcss_twin.physics.multiple_scattering.directions import directions, gauss_streams
from hcss_twin.physics.multiple_scattering.doubling import solve_mode
from hcss_twin.physics.multiple_scattering.forward_peak import once_back_modes, path_back
from hcss_twin.physics.multiple_scattering.layer import check_modes, checked_cosines, checked_layers
from hcss_twin.physics.multiple_scattering.phase_function import delta_m


def transmit_beams(
    optical_thickness: ArrayLike,
    albedo: ArrayLike,
    moments: ArrayLike,
    mu_beams: ArrayLike,
    streams: int,
    modes: int,
    threads: int | None = None,
    mode_tolerance: float = 1e-5,
) -> Array:
    """Diffuse transmission of beams toward the streams in the azimuth modes from 1 on.

    With T_m the mode m (0 is that of :func:`hcss_twin.physics.multiple_scattering.layer.solve_layers`), a beam of
    irradiance E across the layer leaves on the other side as E [T_0 + 2 sum T_m cos(m psi)], psi being the azimuth from
    the beam's own direction. Light in the forward peak removed by delta-M counts as direct. By reciprocity it is also
    what streams send into the beam's direction.

    Parameters
    ----------
    optical_thickness, albedo, moments, streams, threads
        As for ``solve_layers``.
    mu_beams : array_like (B,)
        Cosines of the beams' zenith angles, in (0, 1].
    modes : int
        Modes below this one; 1 to twice the streams.
    mode_tolerance : float
        The series of a layer ends, and further modes are 0, after two modes in succession that are at most this share
        of mode 1 along every stream; 0 solves all ``modes``. At least 0 and below 1.

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
    check_modes(modes, streams, mode_tolerance)
    where = directions(beams, gauss_streams(streams), np.empty(0))
    scaled = delta_m(thickness, w, chi, 2 * streams)
    series = AzimuthSeries(scaled.thickness)
    result = np.zeros((modes - 1, thickness.size, streams, beams.size))
    onward = np.zeros(thickness.size)
    with Team(threads) as team:
        for mode in range(1, modes):
            ordered = series.chains
            solved = solve_mode(where, scaled, ordered, mode, team, toward=streams, sources=beams.size)
            result[mode - 1, ordered.cell] = solved.transmission
            largest = np.max(np.abs(solved.transmission), axis=(1, 2))
            if mode == 1:
                onward[ordered.cell] = largest
            small = (largest <= mode_tolerance * onward[ordered.cell]) & (mode_tolerance > 0.0)
            if series.end_where(small):
                break
    return result.reshape(modes - 1, *thickness.shape, streams, beams.size)


def coupled_moments(streams: int) -> int:
    """Moments of layers that scatter each other's light: Gauss's rule integrates products of two kernels.

    With twice as many as streams, ice over water reflects up to 5 % too much or too little with 12 streams, and 1.5 %
    with 24; with 1.5 times as many 0.07 and 0.01 %.
    """
    return 3 * streams // 2


@dataclass(frozen=True)
class CoupledLayers:
    """Azimuth modes from 0 on of layers that scatter each other's light.

    T thicknesses, V wavenumbers, N streams, B beams, as for :func:`transmit_beams`, but with :func:`coupled_moments`.
    Reflection by a layer does not depend on the face. Mode 0 is only the difference from
    :func:`hcss_twin.physics.multiple_scattering.layer.solve_layers`.

    Attributes
    ----------
    beams : ndarray (M, 2, T, V, N, B)
        Reflection and diffuse transmission of beams toward the streams.
    streams : ndarray of float32 (M, 2, T, V, P)
        The same between two streams; both are symmetric, with P pairs as ``np.triu_indices``. Light that reaches a
        layer along streams was scattered before: single precision suffices.
    """

    beams: Array
    streams: NDArray[np.float32]


def solve_coupled_layers(
    optical_thickness: ArrayLike,
    albedo: ArrayLike,
    moments: ArrayLike,
    mu_beams: ArrayLike,
    streams: int,
    modes: int,
    threads: int | None = None,
    mode_tolerance: float = 1e-5,
    between_streams: bool = True,
    least_mode: int = 0,
) -> CoupledLayers:
    """Solve how layers scatter light that others scattered, or will.

    Reflected light scattered once is exact, with the full phase function: the truncated series of a sharply peaked
    function oscillates by more than the function is backward.

    Parameters
    ----------
    optical_thickness, albedo, moments, mu_beams, streams, modes, threads
        As for :func:`transmit_beams`; there are no more modes than moments.
    mode_tolerance : float
        The series of a layer ends after two modes in succession in which reflection and transmission of beams are at
        most this share of mode 1.
    between_streams : bool
        Whether to return what is scattered between streams.
    least_mode : {0, 1}
        Modes below it are not solved, and 0.

    Raises
    ------
    ValueError
        As for :func:`transmit_beams`.
    """
    thickness, w, chi = checked_layers(optical_thickness, albedo, moments)
    beams = checked_cosines("mu_beams", mu_beams)
    check_modes(modes, streams, mode_tolerance)
    where = directions(beams, gauss_streams(streams), np.empty(0))
    modes = min(modes, coupled_moments(streams))
    scaled = delta_m(thickness, w, chi, coupled_moments(streams))
    once = once_back_modes(scaled, w, chi, where, modes)
    series = AzimuthSeries(scaled.thickness)
    first, second = np.triu_indices(streams if between_streams else 0)
    sources = where.columns if between_streams else beams.size
    of_beams = np.zeros((modes, 2, thickness.size, streams, beams.size))
    between = np.zeros((modes, 2, thickness.size, first.size), dtype=np.float32)
    onward = np.zeros(thickness.size)
    unscaled = 1.0 / (where.scale[beams.size :, None] * where.scale)
    with Team(threads) as team:
        for mode in range(least_mode, modes):
            ordered = series.chains
            solved = solve_mode(where, scaled, ordered, mode, team, streams, sources)
            missing = (once[mode, ordered.wavenumber] - solved.other[:, beams.size :] * unscaled)[..., :sources]
            path = path_back(ordered.thickness[:, None, None], where.mu[beams.size :, None], where.mu[:sources])
            kernels = missing[ordered.column] * path + solved.reflection, solved.transmission
            largest = np.maximum(*(np.max(np.abs(x[..., : beams.size]), axis=(1, 2)) for x in kernels))
            if mode == 0:
                more = delta_m(thickness, w, chi, 2 * streams)
                same = chains(more.thickness, np.ones(thickness.shape, dtype=np.bool_))
                known = solve_mode(where, more, same, 0, team, streams, sources)
                order = np.argsort(same.cell)[ordered.cell]
                kernels = kernels[0] - known.reflection[order], kernels[1] - known.transmission[order]
            for beam, pair, kernel in zip(of_beams[mode], between[mode], kernels, strict=True):
                beam[ordered.cell] = kernel[:, :, : beams.size]
                pair[ordered.cell] = kernel[:, first, beams.size + second]
            if mode == 1:
                onward[ordered.cell] = largest
            small = (largest <= mode_tolerance * onward[ordered.cell]) & (mode_tolerance > 0.0) & (mode > 0)
            if series.end_where(small):
                break
    shape = thickness.shape
    return CoupledLayers(
        of_beams.reshape(modes, 2, *shape, streams, beams.size), between.reshape(modes, 2, *shape, first.size)
    )
