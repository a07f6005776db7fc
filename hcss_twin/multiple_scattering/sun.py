"""Sunlight reflected and transmitted by homogeneous layers: adding-doubling over azimuth modes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from hcss_twin.multiple_scattering.checks import checked_layers, checked_sun
from hcss_twin.multiple_scattering.doubling import solve_layer
from hcss_twin.multiple_scattering.forward_peak import once_back, once_through
from hcss_twin.multiple_scattering.parallel import in_threads
from hcss_twin.multiple_scattering.phase_function import delta_m
from hcss_twin.multiple_scattering.scattering_kernels import directions, scattering_kernels
from hcss_twin.multiple_scattering.single_scattering import path_back, path_through
from hcss_twin.multiple_scattering.streams import gauss_streams

Array = NDArray[np.float64]


def solve_sun(
    optical_thickness: ArrayLike,
    albedo: ArrayLike,
    moments: ArrayLike,
    mu_view: ArrayLike,
    mu_sun: float,
    relative_azimuth: ArrayLike,
    streams: int,
    modes: int,
    threads: int | None = None,
) -> tuple[Array, Array]:
    """Bidirectional reflectance and transmittance, sr-1: radiance over mu_sun times the sun's irradiance.

    Light scattered more than once comes from delta-M scaled adding-doubling in ``modes`` terms of the
    Fourier series over azimuth. Reflected light scattered once is exact, with the full phase function;
    transmitted light has its whole forward peak (:mod:`hcss_twin.multiple_scattering.forward_peak`), so
    that direct light beside it is exp(-tau / mu_sun), with the thickness as given.

    Parameters
    ----------
    optical_thickness, albedo, moments, streams, threads
        As for :func:`hcss_twin.multiple_scattering.layer.solve_layers`.
    mu_view : array_like (P,)
        Cosines of the zenith angles at which the light leaves: upward from the face that the sun shines
        on, downward from the other.
    mu_sun : float
        Cosine of the solar zenith angle, in (0, 1].
    relative_azimuth : array_like (P,)
        Angle between the bearings toward sensor and sun, radians in [0, pi]; pi is glint.
    modes : int
        Terms of the Fourier series, 1 to twice the streams.

    Returns
    -------
    brdf, btdf : ndarray (T, V, P)

    Raises
    ------
    ValueError
        If a value is outside its range or shapes do not fit, or if a Henyey-Greenstein function has |g|
        above 0.995.
    """
    thickness, w, chi = checked_layers(optical_thickness, albedo, moments)
    mu, sun, azimuth = checked_sun(mu_view, mu_sun, relative_azimuth)
    quadrature = gauss_streams(streams)
    if not 1 <= modes <= 2 * streams:
        raise ValueError(
            f"modes {modes}: allowed 1 to {2 * streams}, twice the streams; "
            f"closest is {min(max(modes, 1), 2 * streams)}"
        )
    scaled = delta_m(thickness, w, chi, 2 * streams)
    distinct, of_view = np.unique(mu, return_inverse=True)
    brdf = once_back(scaled, w, chi, mu, sun, azimuth)
    btdf = once_through(scaled, w, chi, mu, sun, azimuth)
    where = directions(np.array([sun]), quadrature, distinct)
    kernels = [scattering_kernels(where, scaled, mode) for mode in range(modes)]
    same, other = np.stack([one[0] for one in kernels]), np.stack([one[1] for one in kernels])
    shape = (modes, *thickness.shape, distinct.size)
    back, through = np.empty(shape), np.empty(shape)

    def part(start: int, step: int) -> None:
        toward = (where.mu, where.scale)
        out = (back, through)
        _solve_all((same, other), scaled.thickness, scaled.co_albedo, toward, start, step, out)

    in_threads(part, thickness.size, threads)
    # What the modes hold of light scattered once is taken out again.
    tau = scaled.thickness[..., np.newaxis]
    back -= other[:, np.newaxis, :, where.columns :, 0] * path_back(tau, distinct, sun)
    through -= same[:, np.newaxis, :, where.columns :, 0] * path_through(tau, distinct, sun)
    for mode in range(modes):
        # The sunbeam travels away from the sun: its azimuth difference is the supplement.
        term = (1.0 if mode == 0 else 2.0) * np.cos(mode * (np.pi - azimuth))
        brdf += back[mode][..., of_view] * term
        btdf += through[mode][..., of_view] * term
    return brdf, btdf


@njit(cache=True, nogil=True)
def _solve_all(
    kernels: tuple[Any, Any],
    thickness: Any,
    co_albedo: Any,
    directions: tuple[Any, Any],
    start: int,
    step: int,
    out: tuple[Any, Any],
) -> None:
    """Solve every ``step``-th layer from ``start`` on, in the order of the flattened (T, V)."""
    same, other = kernels
    mu, scale = directions
    back, through = out
    modes, columns, views = same.shape[0], thickness.shape[1], back.shape[3]
    first = mu.size - views
    for cell in range(start, thickness.size, step):
        t, v = cell // columns, cell % columns
        for mode in range(modes):
            # Of no use here: what the layer emits.
            r, d, _, _ = solve_layer(
                same[mode, v], other[mode, v], thickness[t, v], mu, scale, co_albedo[v], 1, mode == 0
            )
            for i in range(views):
                back[mode, t, v, i] = r[first + i, 0]
                through[mode, t, v, i] = d[first + i, 0]
