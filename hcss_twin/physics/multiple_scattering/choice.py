"""How many streams and azimuth modes, chosen by the error they make on samples of the layers at hand."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hcss_twin.core.arrays import Array
from hcss_twin.physics.multiple_scattering.checks import checked_cosines, checked_layers
from hcss_twin.physics.multiple_scattering.layer import solve_layers
from hcss_twin.physics.multiple_scattering.sun import solve_sun

STREAMS = (4, 8, 16, 32)
"""Numbers of streams per hemisphere to choose from."""


@dataclass(frozen=True)
class Choice:
    """The smallest number that keeps the tolerance, or the largest allowed if none does.

    Attributes
    ----------
    count : int
        The number chosen.
    difference : float
        What it was measured to change, in the terms of the tolerance.
    passed : bool
        Whether ``difference`` keeps the tolerance.
    tried : tuple of (int, float)
        All numbers tried, ascending, with their differences.
    """

    count: int
    difference: float
    passed: bool
    tried: tuple[tuple[int, float], ...]


def choose_streams(
    optical_thickness: ArrayLike,
    albedo: ArrayLike,
    moments: ArrayLike,
    mu: ArrayLike,
    tolerance: float,
    counts: Sequence[int] = STREAMS,
    threads: int | None = None,
) -> Choice:
    """Streams for thermal light: each number is compared with twice as many.

    The difference is the largest, over layers and directions, in emissivity, in far share, and in the
    share of isotropic light that is reflected or transmitted toward ``mu``.

    Parameters
    ----------
    optical_thickness, albedo : array_like (S,)
        Sample layers.
    moments : array_like (K, S)
        Their phase functions.
    mu : array_like (M,)
        Directions that matter.
    tolerance : float
        Largest difference allowed, above 0.
    counts : sequence of int
        Numbers to choose from, ascending.

    Raises
    ------
    ValueError
        If a value is outside its range or shapes do not fit.
    """
    layers = _samples(optical_thickness, albedo, moments)
    directions = checked_cosines("mu", mu)

    def shares(count: int) -> list[Array]:
        found = solve_layers(*layers, directions, count, threads)
        flux = 2.0 * np.pi * found.mu * found.weight
        few = slice(0, directions.size)
        transmitted = found.transmission[..., few, :] @ flux + found.direct[..., few]
        reflected = found.reflection[..., few, :] @ flux
        return [found.emissivity[..., few], found.far_share[..., few], reflected, transmitted]

    def difference(fine: list[Array], coarse: list[Array]) -> float:
        return max(float(np.max(np.abs(f - c), initial=0.0)) for f, c in zip(fine, coarse, strict=True))

    return _first(shares, difference, [(count, 2 * count) for count in counts], tolerance)


def choose_sun_streams(
    optical_thickness: ArrayLike,
    albedo: ArrayLike,
    moments: ArrayLike,
    mu_view: ArrayLike,
    mu_sun: Sequence[float],
    relative_azimuth: ArrayLike,
    tolerance: float,
    counts: Sequence[int] = STREAMS,
    threads: int | None = None,
) -> Choice:
    """Streams for sunlight, with all azimuth modes: each number is compared with twice as many.

    The difference is the largest in reflectance over the layer's largest reflectance for that sun, and in
    transmittance over the largest reflectance or transmittance. Samples and errors as for
    :func:`choose_streams`; directions as for :func:`hcss_twin.physics.multiple_scattering.sun.solve_sun`, for
    each of ``mu_sun``.
    """
    layers = _samples(optical_thickness, albedo, moments)

    def sunlight(count: int) -> list[Array]:
        return _sunlight(layers, mu_view, mu_sun, relative_azimuth, count, 2 * count, threads)

    return _first(sunlight, _relative, [(count, 2 * count) for count in counts], tolerance)


def choose_modes(
    optical_thickness: ArrayLike,
    albedo: ArrayLike,
    moments: ArrayLike,
    mu_view: ArrayLike,
    mu_sun: Sequence[float],
    relative_azimuth: ArrayLike,
    streams: int,
    tolerance: float,
    threads: int | None = None,
) -> Choice:
    """Azimuth modes: 1, 2, 4, ... are compared with all that ``streams`` allow, twice their number.

    The difference is that of :func:`choose_sun_streams`, as are samples, directions and errors.
    """
    layers = _samples(optical_thickness, albedo, moments)
    every = 2 * streams
    counts = [2**power for power in range(every.bit_length()) if 2**power < every] + [every]

    def sunlight(modes: int) -> list[Array]:
        return _sunlight(layers, mu_view, mu_sun, relative_azimuth, streams, modes, threads)

    return _first(sunlight, _relative, [(count, every) for count in counts], tolerance)


def _samples(optical_thickness: ArrayLike, albedo: ArrayLike, moments: ArrayLike) -> tuple[Array, Array, Array]:
    thickness = np.asarray(optical_thickness, dtype=np.float64)
    if thickness.ndim != 1 or thickness.size == 0:
        raise ValueError(f"optical_thickness: shape {thickness.shape} given, allowed: (S,) with S from 1")
    return checked_layers(thickness[np.newaxis], albedo, moments)


def _sunlight(
    layers: tuple[Array, Array, Array],
    mu_view: ArrayLike,
    mu_sun: Sequence[float],
    azimuth: ArrayLike,
    streams: int,
    modes: int,
    threads: int | None,
) -> list[Array]:
    """Reflectances and transmittances (suns, V, P)."""
    found = [solve_sun(*layers, mu_view, sun, azimuth, streams, modes, threads, 0.0) for sun in mu_sun]
    return [np.concatenate([brdf for brdf, _ in found]), np.concatenate([btdf for _, btdf in found])]


def _relative(fine: list[Array], coarse: list[Array]) -> float:
    largest = np.max(fine[0], axis=-1, keepdims=True)
    scales = (largest, np.maximum(largest, np.max(fine[1], axis=-1, keepdims=True)))
    worst = 0.0
    for f, c, scale in zip(fine, coarse, scales, strict=True):
        lit = np.broadcast_to(scale > 0.0, f.shape)
        ratio = np.abs(f - c) / np.where(scale > 0.0, scale, 1.0)
        worst = max(worst, float(np.max(ratio[lit], initial=0.0)))
    return worst


def _first(
    solve: Callable[[int], list[Array]],
    difference: Callable[[list[Array], list[Array]], float],
    pairs: list[tuple[int, int]],
    tolerance: float,
) -> Choice:
    """Smallest first number of a pair whose solution differs from that of the second by the tolerance."""
    if not tolerance > 0.0:
        raise ValueError(f"tolerance {tolerance:g}: allowed above 0")
    if not pairs or any(before >= after for (before, _), (after, _) in itertools.pairwise(pairs)):
        raise ValueError(f"counts {[count for count, _ in pairs]}: allowed whole numbers, ascending")
    solved: dict[int, list[Array]] = {}
    tried: list[tuple[int, float]] = []
    for count, finer in pairs:
        for number in (count, finer):
            if number not in solved:
                solved[number] = solve(number)
        measured = difference(solved[finer], solved[count])
        tried.append((count, measured))
        if measured <= tolerance:
            break
    return Choice(tried[-1][0], tried[-1][1], tried[-1][1] <= tolerance, tuple(tried))
