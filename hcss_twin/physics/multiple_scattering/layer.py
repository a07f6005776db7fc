"""Operators of homogeneous layers for diffuse light, by delta-M adding-doubling: the mean over azimuth.

The input checks shared by all solvers are at the end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.physics.multiple_scattering.chains import DoublingChains, Team, chains
from hcss_twin.physics.multiple_scattering.directions import Directions, directions, gauss_streams
from hcss_twin.physics.multiple_scattering.doubling import SolvedMode, solve_mode
from hcss_twin.physics.multiple_scattering.phase_function import ScaledScattering, delta_m


@dataclass(frozen=True)
class LayerOperators:
    """Reflection, transmission and emission of layers: T thicknesses, V wavenumbers, D directions.

    Extra directions come first, then the streams. A homogeneous layer looks the same from both faces.

    Attributes
    ----------
    mu, weight : ndarray (D,)
        Cosines of the zenith angle and weights of the quadrature, 0 for extras.
    reflection, transmission : ndarray (T, V, D, D)
        Diffuse kernels, the mean over azimuth, sr-1, symmetric: I_out(i) = 2 pi sum over j of mu_j
        weight_j kernel[..., i, j] I_in(j); a beam of irradiance E0 across it gives mu_j E0
        kernel[..., i, j]. Light in the forward peak removed by delta-M counts as direct.
    direct : ndarray (T, V, D)
        exp(-tau' / mu) with the scaled tau'.
    emissivity : ndarray (T, V, D)
        Of an isothermal layer, at either face: 1 - direct - row sums of both kernels.
    far_share : ndarray (T, V, D)
        Weight of the Planck radiance at the far face where it is linear in optical depth: the top
        emits (emissivity - far_share) B(top) + far_share B(base).
    """

    mu: Array
    weight: Array
    reflection: Array
    transmission: Array
    direct: Array
    emissivity: Array
    far_share: Array


def solve_layers(
    optical_thickness: ArrayLike,
    albedo: ArrayLike,
    moments: ArrayLike,
    mu_extra: ArrayLike,
    streams: int,
    threads: int | None = None,
) -> LayerOperators:
    """Solve layers for light that does not depend on azimuth.

    Layers of one wavenumber whose thicknesses differ by powers of 2, to 1e-12, are solved by one chain of doublings: h,
    h / 2, h / 4 and so on cost little more than h. Other layers in the same call change a result by less than 1e-9.

    Parameters
    ----------
    optical_thickness : array_like (T, V)
        Of extinction, finite, 0 or more.
    albedo : array_like (V,)
        Of single scattering, 0 to 1 inclusive.
    moments : array_like (K, V)
        Legendre moments of the phase function, ``moments[0]`` = 1, ``moments[1]`` = g; K = 2 stands for
        the Henyey-Greenstein function.
    mu_extra : array_like (M,)
        Additional cosines, in (0, 1], at which operators are computed.
    streams : int
        Directions per hemisphere, N.
    threads : int, optional
        Default: one for each processor available to this process, at most 8. Results do not depend on it.

    Raises
    ------
    ValueError
        If a value is outside its range or shapes do not fit.
    """
    thickness, w, chi = checked_layers(optical_thickness, albedo, moments)
    extra = checked_cosines("mu_extra", mu_extra)
    where = directions(extra, gauss_streams(streams), np.empty(0))
    scaled = delta_m(thickness, w, chi, 2 * streams)
    ordered = chains(scaled.thickness, np.ones(thickness.shape, dtype=np.bool_))
    with Team(threads) as team:
        solved = solve_mode(where, scaled, ordered, 0, team)
    return mean_over_azimuth(where, scaled, ordered, solved)


def mean_over_azimuth(
    where: Directions, scaled: ScaledScattering, ordered: DoublingChains, solved: SolvedMode
) -> LayerOperators:
    """Return mode 0, solved for ``ordered`` layers, as operators of layers (T, V)."""
    shape, size = scaled.thickness.shape, where.mu.size

    def placed(values: Array, *further: int) -> Array:
        result = np.empty_like(values)
        result[ordered.cell] = values
        return result.reshape(*shape, *further)

    return LayerOperators(
        where.mu,
        where.weight,
        placed(solved.reflection, size, size),
        placed(solved.transmission, size, size),
        np.exp(-scaled.thickness[..., np.newaxis] / where.mu),
        placed(solved.emissivity, size),
        placed(solved.far_share, size),
    )


def joined(some: LayerOperators, others: LayerOperators, chosen: NDArray[np.bool_]) -> LayerOperators:
    """Return layers at all wavenumbers: ``some`` where ``chosen`` (V,) is true, ``others`` elsewhere."""

    def both(first: Array, second: Array) -> Array:
        result = np.empty((first.shape[0], chosen.size, *first.shape[2:]))
        result[:, chosen], result[:, ~chosen] = first, second
        return result

    return LayerOperators(
        some.mu,
        some.weight,
        both(some.reflection, others.reflection),
        both(some.transmission, others.transmission),
        both(some.direct, others.direct),
        both(some.emissivity, others.emissivity),
        both(some.far_share, others.far_share),
    )


def checked_layers(optical_thickness: ArrayLike, albedo: ArrayLike, moments: ArrayLike) -> tuple[Array, Array, Array]:
    """Return the properties of layers as float64 arrays (T, V), (V,), (K, V)."""
    thickness = np.asarray(optical_thickness, dtype=np.float64)
    w = np.asarray(albedo, dtype=np.float64)
    chi = np.asarray(moments, dtype=np.float64)
    if w.ndim != 1:
        raise ValueError(f"albedo: shape {w.shape} given, allowed: (V,)")
    if thickness.ndim != 2 or thickness.shape[1] != w.size:
        raise ValueError(f"optical_thickness: shape {thickness.shape} given, allowed: (T, {w.size})")
    if chi.ndim != 2 or chi.shape[0] < 2 or chi.shape[1] != w.size:
        raise ValueError(f"moments: shape {chi.shape} given, allowed: (K, {w.size}) with K from 2")
    require("optical_thickness", thickness, (thickness >= 0.0) & np.isfinite(thickness), "finite, from 0", 0.0)
    require("albedo", w, (w >= 0.0) & (w <= 1.0), "0 to 1", *_nearest(w, 0.0, 1.0))
    # A provider's sums may have rounding errors; the conformance kit for optics allows the same tolerance.
    require("moments[0]", chi[0], np.abs(chi[0] - 1.0) <= 1e-9, "1", 1.0)
    if np.any(chi[0] != 1.0):
        chi = np.concatenate((np.ones_like(chi[:1]), chi[1:]))
    require("moments", chi[1:], np.abs(chi[1:]) < 1.0, "above -1 and below 1")
    return thickness, w, chi


def checked_cosines(name: str, mu: ArrayLike) -> Array:
    """Return cosines of zenith angles (M,) in (0, 1]."""
    values = np.asarray(mu, dtype=np.float64)
    if values.ndim != 1:
        raise ValueError(f"{name}: shape {values.shape} given, allowed: one dimension")
    require(name, values, (values > 0.0) & (values <= 1.0), "above 0, to 1")
    return values


def checked_sun(mu_view: ArrayLike, mu_sun: float, relative_azimuth: ArrayLike) -> tuple[Array, float, Array]:
    """Return cosines of the views (P,) and of the sun in (0, 1], and relative azimuths (P,) in [0, pi]."""
    mu = checked_cosines("mu_view", mu_view)
    sun = checked_cosines("mu_sun", [mu_sun])
    azimuth = np.asarray(relative_azimuth, dtype=np.float64)
    if azimuth.shape != mu.shape:
        raise ValueError(f"relative_azimuth: shape {azimuth.shape} given, allowed: {mu.shape} as mu_view")
    good = (azimuth >= 0.0) & (azimuth <= np.pi)
    require("relative_azimuth", azimuth, good, "0 to pi", *_nearest(azimuth, 0.0, np.pi))
    return mu, float(sun[0]), azimuth


def check_modes(modes: int, streams: int, mode_tolerance: float) -> None:
    """Require 1 to 2 ``streams`` azimuth modes, and a tolerance of the Fourier series in [0, 1)."""
    if not 1 <= modes <= 2 * streams:
        raise ValueError(
            f"modes {modes}: allowed 1 to {2 * streams}, twice the streams; "
            f"closest is {min(max(modes, 1), 2 * streams)}"
        )
    if not 0.0 <= mode_tolerance < 1.0:
        closest = "" if not np.isfinite(mode_tolerance) or mode_tolerance > 0.0 else "; closest is 0"
        raise ValueError(f"mode_tolerance {mode_tolerance:g}: allowed from 0, below 1{closest}")


def require(name: str, values: Array, good: NDArray[np.bool_], allowed: str, *closest: float) -> None:
    """Raise ValueError unless all are good, with the first wrong value and, where given, the closest valid one."""
    if not np.all(good):
        wrong = values[~good][0]
        hint = f"; closest is {closest[0]:g}" if closest and np.isfinite(wrong) else ""
        raise ValueError(f"{name} {wrong:g}: allowed {allowed}{hint}")


def _nearest(values: Array, low: float, high: float) -> tuple[float]:
    wrong = values[~((values >= low) & (values <= high))]
    return (low if wrong.size and wrong[0] < low else high,)
