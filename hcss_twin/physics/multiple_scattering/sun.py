"""Azimuth series of layers, each of which ends where the rest is negligible.

Sunlight reflected and transmitted by homogeneous layers: adding-doubling over azimuth modes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.physics.multiple_scattering.chains import Chains, Team, chains
from hcss_twin.physics.multiple_scattering.checks import check_modes, checked_layers, checked_sun
from hcss_twin.physics.multiple_scattering.directions import Directions, directions, gauss_streams
from hcss_twin.physics.multiple_scattering.doubling import solve_mode
from hcss_twin.physics.multiple_scattering.forward_peak import once_back, once_through, path_back, path_through
from hcss_twin.physics.multiple_scattering.phase_function import ScaledScattering, delta_m


class AzimuthSeries:
    """Layers whose series have not ended: one does where two modes in succession are small.

    Parameters
    ----------
    thickness : ndarray (T, V)
        Optical thickness.

    Attributes
    ----------
    chains : Chains
        Of the layers that still need a mode.
    """

    def __init__(self, thickness: Array) -> None:
        self._thickness = thickness
        self._going = np.ones(thickness.shape, dtype=np.bool_)
        # Whose mode before was small.
        self._quiet = np.zeros(thickness.size, dtype=np.bool_)
        self.chains = chains(thickness, self._going)

    def end_where(self, small: NDArray[np.bool_]) -> bool:
        """Say of which layers of ``chains`` (n,) a mode was small, and return whether all series have ended."""
        cells = self.chains.cell
        ended = small & self._quiet[cells]
        self._quiet[cells] = small
        if np.any(ended):
            self._going.flat[cells[ended]] = False
            self.chains = chains(self._thickness, self._going)
        return bool(np.all(ended))


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
    mode_tolerance: float = 1e-5,
) -> tuple[Array, Array]:
    """Bidirectional reflectance and transmittance, sr-1: radiance over mu_sun times the sun's irradiance.

    Light scattered more than once comes from delta-M scaled adding-doubling in ``modes`` terms of the
    Fourier series over azimuth. Reflected light scattered once is exact, with the full phase function;
    transmitted light has its whole forward peak (:mod:`hcss_twin.physics.multiple_scattering.forward_peak`), so
    that direct light beside it is exp(-tau / mu_sun), with the thickness as given.

    Layers of one wavenumber whose thicknesses differ by powers of 2 cost little more than one, as in
    :func:`hcss_twin.physics.multiple_scattering.layer.solve_layers`. With ``mode_tolerance`` 0 a layer differs by
    less than 1e-9 of itself from what it is alone; with another also by a mode, where rounding decides.

    Parameters
    ----------
    optical_thickness, albedo, moments, streams, threads
        As for :func:`hcss_twin.physics.multiple_scattering.layer.solve_layers`.
    mu_view : array_like (P,)
        Cosines of the zenith angles at which the light leaves: upward from the face that the sun shines
        on, downward from the other.
    mu_sun : float
        Cosine of the solar zenith angle, in (0, 1].
    relative_azimuth : array_like (P,)
        Angle between the bearings toward sensor and sun, radians in [0, pi]; pi is glint.
    modes : int
        Terms of the Fourier series, 1 to twice the streams: the most that are summed.
    mode_tolerance : float
        The series of a layer ends after two modes in succession whose amplitudes are both at most this
        share of brdf and btdf so far, in every direction asked for. At least 0 and below 1; 0 sums all
        ``modes``. The error is a few times this share (docs/multiple-scattering.md).

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
    check_modes(modes, streams, mode_tolerance)
    scaled = delta_m(thickness, w, chi, 2 * streams)
    distinct, of_view = np.unique(mu, return_inverse=True)
    flat = (thickness.size, mu.size)
    brdf = once_back(scaled, w, chi, mu, sun, azimuth).reshape(flat)
    btdf = once_through(scaled, w, chi, mu, sun, azimuth).reshape(flat)
    where = directions(np.array([sun]), quadrature, distinct)
    series = AzimuthSeries(scaled.thickness)
    with Team(threads) as team:
        for mode in range(modes):
            found = series.chains
            back, through = _more_than_once(where, scaled, mode, found, team)
            # The sunbeam travels away from the sun: its azimuth difference is the supplement.
            term = np.cos(mode * (np.pi - azimuth))
            small = np.full(found.cell.size, mode_tolerance > 0.0)
            for total, part in ((brdf, back), (btdf, through)):
                amplitude = ((1.0 if mode == 0 else 2.0) * part)[:, of_view]
                total[found.cell] += amplitude * term
                small &= np.all(np.abs(amplitude) <= mode_tolerance * np.abs(total[found.cell]), axis=1)
            if series.end_where(small):
                break
    shape = (*thickness.shape, mu.size)
    return brdf.reshape(shape), btdf.reshape(shape)


def _more_than_once(
    where: Directions, scaled: ScaledScattering, mode: int, found: Chains, team: Team
) -> tuple[Array, Array]:
    """Solve one mode of the layers of ``found``, in their order.

    Returns
    -------
    back, through : ndarray (n, views)
        Kernels from the sun without what they hold of light scattered once.
    """
    views = where.mu.size - where.columns
    solved = solve_mode(where, scaled, found, mode, team, toward=views, sources=1)
    tau, sun, view = found.thickness[:, np.newaxis], where.mu[0], where.mu[where.columns :]
    once = np.s_[found.column, where.columns :, 0]
    return (
        solved.reflection[:, :, 0] - solved.other[once] * path_back(tau, view, sun),
        solved.transmission[:, :, 0] - solved.same[once] * path_through(tau, view, sun),
    )
