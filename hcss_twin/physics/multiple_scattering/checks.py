"""Refusals of input the solvers cannot mean."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hcss_twin.core.arrays import Array


def checked_layers(optical_thickness: ArrayLike, albedo: ArrayLike, moments: ArrayLike) -> tuple[Array, Array, Array]:
    """Return the properties of layers as float64 arrays (T, V), (V,), (K, V).

    Raises
    ------
    ValueError
        Naming the argument, what was given and what is allowed.
    """
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
    require("moments[0]", chi[0], chi[0] == 1.0, "1", 1.0)
    require("moments", chi[1:], np.abs(chi[1:]) < 1.0, "above -1 and below 1")
    return thickness, w, chi


def checked_cosines(name: str, mu: ArrayLike) -> Array:
    """Return cosines of zenith angles (M,).

    Raises
    ------
    ValueError
        If one is not above 0 and at most 1, or the array has not one dimension.
    """
    values = np.asarray(mu, dtype=np.float64)
    if values.ndim != 1:
        raise ValueError(f"{name}: shape {values.shape} given, allowed: one dimension")
    require(name, values, (values > 0.0) & (values <= 1.0), "above 0, to 1")
    return values


def checked_sun(mu_view: ArrayLike, mu_sun: float, relative_azimuth: ArrayLike) -> tuple[Array, float, Array]:
    """Return directions of view (P,), cosine of the sun and relative azimuths (P,).

    Raises
    ------
    ValueError
        If a cosine is not above 0 and at most 1, an azimuth not from 0 to pi, or shapes differ.
    """
    mu = checked_cosines("mu_view", mu_view)
    sun = checked_cosines("mu_sun", [mu_sun])
    azimuth = np.asarray(relative_azimuth, dtype=np.float64)
    if azimuth.shape != mu.shape:
        raise ValueError(f"relative_azimuth: shape {azimuth.shape} given, allowed: {mu.shape} as mu_view")
    good = (azimuth >= 0.0) & (azimuth <= np.pi)
    require("relative_azimuth", azimuth, good, "0 to pi", *_nearest(azimuth, 0.0, np.pi))
    return mu, float(sun[0]), azimuth


def check_modes(modes: int, streams: int, mode_tolerance: float) -> None:
    """Refuse azimuth modes and tolerances of a Fourier series that have no meaning.

    Raises
    ------
    ValueError
        If there are not 1 to twice the streams modes, or the tolerance is not from 0, below 1.
    """
    if not 1 <= modes <= 2 * streams:
        raise ValueError(
            f"modes {modes}: allowed 1 to {2 * streams}, twice the streams; "
            f"closest is {min(max(modes, 1), 2 * streams)}"
        )
    if not 0.0 <= mode_tolerance < 1.0:
        closest = "" if not np.isfinite(mode_tolerance) or mode_tolerance > 0.0 else "; closest is 0"
        raise ValueError(f"mode_tolerance {mode_tolerance:g}: allowed from 0, below 1{closest}")


def require(name: str, values: Array, good: NDArray[np.bool_], allowed: str, *closest: float) -> None:
    """Raise unless all is good.

    Raises
    ------
    ValueError
        Naming the first wrong value, what is allowed and, where given, the closest valid value.
    """
    if not np.all(good):
        wrong = values[~good][0]
        hint = f"; closest is {closest[0]:g}" if closest and np.isfinite(wrong) else ""
        raise ValueError(f"{name} {wrong:g}: allowed {allowed}{hint}")


def _nearest(values: Array, low: float, high: float) -> tuple[float]:
    wrong = values[~((values >= low) & (values <= high))]
    return (low if wrong.size and wrong[0] < low else high,)
