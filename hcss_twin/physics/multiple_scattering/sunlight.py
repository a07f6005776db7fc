"""Sunlight reflected and transmitted by homogeneous layers: adding-doubling over azimuth modes.

The Fourier series over azimuth of each layer ends where the remaining terms are negligible.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import ArrayLike

from hcss_twin.core.arrays import Array
from hcss_twin.physics import quadrature
from hcss_twin.physics.multiple_scattering.chains import AzimuthSeries, DoublingChains, Team
from hcss_twin.physics.multiple_scattering.directions import Directions, directions, gauss_streams
from hcss_twin.physics.multiple_scattering.doubling import solve_mode
from hcss_twin.physics.multiple_scattering.forward_peak import once_back, once_through, path_back, path_through
from hcss_twin.physics.multiple_scattering.layer import (
    LayerOperators,
    check_modes,
    checked_layers,
    checked_sun,
    mean_over_azimuth,
)
from hcss_twin.physics.multiple_scattering.phase_function import ScaledScattering, delta_m
from hcss_twin.physics.multiple_scattering.second_order import missing_second_order

LEAST_ORDER, ORDER_PER_OSCILLATION = 7, 1.0
"""Order of a polynomial over zenith angles: the second times half their range times the moments is added."""


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
    kept_moments: int | None = None,
    exact_orders: int = 2,
) -> tuple[Array, Array]:
    """Bidirectional reflectance and transmittance, sr-1: radiance over mu_sun times the sun's irradiance.

    Light scattered more than twice comes from delta-M scaled adding-doubling in ``modes`` terms of the Fourier series
    over azimuth. Reflected light scattered once or twice is exact, with the full phase function
    (:mod:`hcss_twin.physics.multiple_scattering.second_order`); transmitted light includes the whole forward peak
    (:mod:`hcss_twin.physics.multiple_scattering.forward_peak`), so direct light is exp(-tau / mu_sun) with the unscaled
    thickness.

    Layers of one wavenumber whose thicknesses differ by powers of 2 cost little more than one, as in
    :func:`hcss_twin.physics.multiple_scattering.layer.solve_layers`. With ``mode_tolerance`` 0 the other layers change
    a result by less than 1e-9 of it; otherwise rounding may also add or drop a mode.

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
        Maximum number of terms of the Fourier series, 1 to twice the streams.
    mode_tolerance : float
        The series of a layer ends after two modes in succession whose amplitudes are both at most this
        share of brdf and btdf so far, in every direction asked for. At least 0 and below 1; 0 sums all
        ``modes``. The error is a few times this share (docs/development/radiance.md).
    kept_moments : int, optional
        Moments of the phase function that delta-M keeps, at least ``modes``; default: twice the streams.
    exact_orders : int
        Orders of scattering of reflected light, 1 or 2, that do not depend on the streams; 1 for comparison with
        other codes of the same streams.

    Returns
    -------
    brdf, btdf : ndarray (T, V, P)

    Raises
    ------
    ValueError
        If a value is outside its range or shapes do not fit, or if a Henyey-Greenstein function has |g| above 0.998.
    """
    thickness, w, chi = checked_layers(optical_thickness, albedo, moments)
    mu, sun, azimuth = checked_sun(mu_view, mu_sun, relative_azimuth)
    check_modes(modes, streams, mode_tolerance)
    scaled = delta_m(thickness, w, chi, 2 * streams if kept_moments is None else kept_moments)
    toward, shares = _few_directions(mu, scaled.moments.shape[0])
    flat = (thickness.size, mu.size)
    brdf = once_back(scaled, w, chi, mu, sun, azimuth)
    if exact_orders > 1:
        brdf += missing_second_order(scaled, w, chi, streams, modes, mu, sun, azimuth)
    brdf = brdf.reshape(flat)
    btdf = once_through(scaled, w, chi, mu, sun, azimuth).reshape(flat)
    where = directions(np.array([sun]), gauss_streams(streams), toward)
    series = AzimuthSeries(scaled.thickness)
    with Team(threads) as team:
        for mode in range(modes):
            ordered = series.chains
            back, through = _more_than_once(where, scaled, mode, ordered, team)
            # The sunbeam travels away from the sun: its relative azimuth is the supplement.
            term = np.cos(mode * (np.pi - azimuth))
            small = np.full(ordered.cell.size, mode_tolerance > 0.0)
            for total, part in ((brdf, back), (btdf, through)):
                amplitude = ((1.0 if mode == 0 else 2.0) * part) @ shares
                total[ordered.cell] += amplitude * term
                small &= np.all(np.abs(amplitude) <= mode_tolerance * np.abs(total[ordered.cell]), axis=1)
            if series.end_where(small):
                break
    shape = (*thickness.shape, mu.size)
    return brdf.reshape(shape), btdf.reshape(shape)


def _few_directions(mu: Array, moments: int) -> tuple[Array, Array]:
    """Return cosines (D,) for which modes are solved, and the weights (D, P) of each in those at ``mu`` (P,).

    A mode is a smooth function of the zenith angle: where views are many, it is solved at Chebyshev points and
    interpolated. Toward 63 views within 13 deg the points leave 1e-7 of brdf and btdf.
    """
    distinct, of_view = np.unique(mu, return_inverse=True)
    angle = np.arccos(distinct)
    middle, half = 0.5 * (angle[0] + angle[-1]), 0.5 * (angle[0] - angle[-1])
    order = LEAST_ORDER + ceil(ORDER_PER_OSCILLATION * moments * half)
    if order + 1 >= distinct.size:
        return distinct, np.eye(distinct.size)[:, of_view]
    weights = quadrature.weights(order, (angle - middle) / half)
    return np.cos(middle + half * quadrature.nodes(order)), weights.T[:, of_view]


def _more_than_once(
    where: Directions, scaled: ScaledScattering, mode: int, ordered: DoublingChains, team: Team
) -> tuple[Array, Array]:
    """Solve one mode of ``ordered`` layers (n,).

    Returns
    -------
    back, through : ndarray (n, views)
        Kernels from the sun, without light scattered once.
    """
    views = where.mu.size - where.columns
    solved = solve_mode(where, scaled, ordered, mode, team, toward=views, sources=1)
    tau, sun, view = ordered.thickness[:, np.newaxis], where.mu[0], where.mu[where.columns :]
    once = np.s_[ordered.column, where.columns :, 0]
    return (
        solved.reflection[:, :, 0] - solved.other[once] * path_back(tau, view, sun),
        solved.transmission[:, :, 0] - solved.same[once] * path_through(tau, view, sun),
    )


VIEW, SUN = 0, 1


@dataclass(frozen=True)
class SunlitLayers:
    """Layers solved for diffuse light, sunlight and beams: T thicknesses, V wavenumbers, N streams.

    Attributes
    ----------
    layers : LayerOperators
        As :func:`hcss_twin.physics.multiple_scattering.layer.solve_layers` with view and sun as extra directions.
    brdf, btdf : ndarray (T, V)
        As :func:`solve_sun` for the view.
    beams : ndarray (M - 1, T, V, N, 2)
        As :func:`hcss_twin.physics.multiple_scattering.beams.transmit_beams` for beams of view and sun.
    """

    layers: LayerOperators
    brdf: Array
    btdf: Array
    beams: Array


def solve_sunlit_layers(
    optical_thickness: ArrayLike,
    albedo: ArrayLike,
    moments: ArrayLike,
    mu_view: float,
    mu_sun: float,
    relative_azimuth: float,
    streams: int,
    modes: int,
    beam_modes: int,
    threads: int | None = None,
    mode_tolerance: float = 1e-5,
) -> SunlitLayers:
    """Solve layers for diffuse light, for sunlight toward one view, and for both beams, from the same modes.

    Each azimuth mode is solved once, while ``solve_layers``, ``solve_sun`` and ``transmit_beams`` would each solve some
    of them. Results equal theirs, except that the series of a layer may end at another mode.

    Parameters
    ----------
    optical_thickness, albedo, moments, streams, threads
        As for ``solve_layers``.
    mu_view, mu_sun : float
        Cosines of the zenith angles, in (0, 1].
    relative_azimuth : float
        Angle between the bearings toward sensor and sun, radians in [0, pi]; pi is glint.
    modes : int
        Terms of the Fourier series toward the view, 1 to twice the streams.
    beam_modes : int
        Modes of the beams below this one; 1 to ``modes``.
    mode_tolerance : float
        As for ``solve_sun``; modes of beams also end, and are then 0, after two in succession that are at most this
        share of mode 0 along every stream.

    Raises
    ------
    ValueError
        If a value is outside its range or shapes do not fit.
    """
    thickness, w, chi = checked_layers(optical_thickness, albedo, moments)
    view, sun, azimuth = checked_sun([mu_view], mu_sun, [relative_azimuth])
    check_modes(modes, streams, mode_tolerance)
    if not 1 <= beam_modes <= modes:
        raise ValueError(f"beam_modes {beam_modes}: allowed 1 to {modes}, those of the sun")
    where = directions(np.array([view[0], sun]), gauss_streams(streams), np.empty(0))
    scaled = delta_m(thickness, w, chi, 2 * streams)
    brdf = once_back(scaled, w, chi, view, sun, azimuth)
    brdf += missing_second_order(scaled, w, chi, streams, modes, view, sun, azimuth)
    brdf = brdf.ravel()
    btdf = once_through(scaled, w, chi, view, sun, azimuth).ravel()
    beams = np.zeros((beam_modes - 1, thickness.size, streams, 2))
    series = AzimuthSeries(scaled.thickness)
    with Team(threads) as team:
        solved = solve_mode(where, scaled, series.chains, 0, team)
        layers = mean_over_azimuth(where, scaled, series.chains, solved)
        onward = np.max(np.abs(layers.transmission[..., 2:, :2]), axis=(2, 3)).ravel()
        for mode in range(modes):
            ordered = series.chains
            if mode > 0:
                solved = solve_mode(where, scaled, ordered, mode, team)
            cells, tau = ordered.cell, ordered.thickness
            small = np.full(cells.size, mode_tolerance > 0.0)
            once = np.s_[ordered.column, VIEW, SUN]
            # The sunbeam travels away from the sun: its relative azimuth is the supplement.
            term = np.cos(mode * (np.pi - azimuth[0]))
            for total, all_orders, once_scattered in (
                (brdf, solved.reflection, solved.other[once] * path_back(tau, view[0], sun)),
                (btdf, solved.transmission, solved.same[once] * path_through(tau, view[0], sun)),
            ):
                amplitude = (1.0 if mode == 0 else 2.0) * (all_orders[:, VIEW, SUN] - once_scattered)
                total[cells] += amplitude * term
                small &= np.abs(amplitude) <= mode_tolerance * np.abs(total[cells])
            if 0 < mode < beam_modes:
                beams[mode - 1, cells] = solved.transmission[:, 2:, :2]
                largest = np.max(np.abs(solved.transmission[:, 2:, :2]), axis=(1, 2))
                small &= largest <= mode_tolerance * onward[cells]
            if series.end_where(small):
                break
    shape = thickness.shape
    return SunlitLayers(
        layers, brdf.reshape(shape), btdf.reshape(shape), beams.reshape(beam_modes - 1, *shape, streams, 2)
    )
