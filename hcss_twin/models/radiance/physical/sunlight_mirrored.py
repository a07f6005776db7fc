"""Sunlight that clouds scatter forward and the sea mirrors, with the forward peak that few streams count as direct.

Light that clouds transmit along N streams has 2 N moments of the phase function; the peak beyond them travels with the
beam. A glint is hardly wider than that peak, so that neighbouring numbers of streams agree by chance and are all wrong
(by 2e-3 of the radiance under thin fog, wind 17 m/s, view 71 deg). The light that the sea mirrors is computed again
here along more streams, F, and the difference is added:

    sum over modes m of (2 - delta_m0) cos(m phi) D(view) (R + R B R) D(sun),    D = t + X

with the modes of the sea's BRDF R, direct transmission t, and light X that clouds transmit diffusely. Scattering once
or through small angles has a closed form for any number of moments
(:mod:`hcss_twin.physics.multiple_scattering.forward_peak`); light scattered more often is smooth, and interpolated
between the N streams. B is what clouds reflect down to the sea again: they scatter it forward where both directions are
near the horizon. Light scattered once is summed over the F streams, what more orders add over the N streams, which
contain mode 0.

The difference is at most some percent of the radiance: it crosses the air as direct light does, and is linear between
some of the wavenumbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import pi

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.physical.cloud_slab import CloudSlab
from hcss_twin.models.radiance.physical.directions import VIEW, ColumnDirections
from hcss_twin.models.radiance.physical.sea_surface import ReflectionModes, SeaSurface, expanded, hats
from hcss_twin.physics.multiple_scattering.beams import coupled_moments
from hcss_twin.physics.multiple_scattering.directions import Streams, gauss_streams, normalised_legendre
from hcss_twin.physics.multiple_scattering.forward_peak import path_back, path_through
from hcss_twin.providers import SeaModel

SPACING_CM1 = 40.0
"""Distance of the wavenumbers between which the difference is linear."""

DARK = 1e-4
"""Columns where the sea adds less than this share to the sunlight that the clouds reflect are left as they are."""

DENSE = 48
"""Streams over which the BRDF is integrated to find what facets reflect twice."""

BACK_MODES, LEAST_BACK = 32, 1e-4
"""Most modes of light that the sea mirrors twice; they end after two in succession that are below this share of all.

It is at most some percent of what the sea mirrors once. Under 10 m/s, five or six modes are enough.
"""


@dataclass(frozen=True)
class Mirror:
    """What the sea reflects along F streams, at U of the wavenumbers.

    Attributes
    ----------
    places : ndarray of int (U,)
    weights : ndarray (U, V)
        Of these in all wavenumbers.
    fine : ReflectionModes
        Modes from 0 on, along F streams.
    mean : ReflectionModes
        Mode 0 along the N streams of the columns, folded from the F streams onto the second ones.
    exact : ReflectionModes
        The same, folded from many streams.
    direct : ndarray (U,)
        BRDF of the glint, sr-1.
    """

    places: NDArray[np.intp]
    weights: Array
    fine: ReflectionModes
    mean: ReflectionModes
    exact: ReflectionModes
    direct: Array

    @property
    def streams(self) -> Streams:
        """The F streams."""
        return gauss_streams(self.fine.view.shape[1])


def blind_mirror(wavenumber_cm1: Array, sea: SeaModel, count: int, streams: int) -> Mirror:
    """Return the mirror of a sea along as many ``streams`` and ``count`` of the columns, without a view and a sun."""
    places = _spaced(wavenumber_cm1)
    spaced_cm1, few, fine = wavenumber_cm1[places], gauss_streams(count), gauss_streams(streams).mu
    first, second = np.triu_indices(streams)
    pairs = expanded(sea, spaced_cm1, fine[first], fine[second], 2 * streams)
    between = np.empty((2 * streams, streams, streams, spaced_cm1.size))
    between[:, first, second] = between[:, second, first] = pairs
    weights = np.stack([np.interp(wavenumber_cm1, spaced_cm1, row) for row in np.eye(spaced_cm1.size)])
    mean, exact = (_folded(sea, spaced_cm1, few.mu, few, number)[None] for number in (streams, DENSE))
    none, dark = np.zeros_like(between[:, 0]), np.zeros_like(mean[:, 0])
    return Mirror(
        places,
        weights,
        ReflectionModes(none, none, between),
        ReflectionModes(dark, dark, mean),
        ReflectionModes(dark, dark, exact),
        np.zeros(spaced_cm1.size),
    )


def unlit_mirror(blind: Mirror, sea: SeaModel, wavenumber_cm1: Array, where: ColumnDirections) -> Mirror:
    """Return the mirror, completed for the view of ``where``."""
    spaced_cm1, fine, toward = wavenumber_cm1[blind.places], blind.streams.mu, where.mu[VIEW : VIEW + 1]
    view = expanded(sea, spaced_cm1, np.repeat(toward, fine.size), fine, 2 * fine.size)
    mean, exact = (_folded(sea, spaced_cm1, toward, where.streams, number) for number in (fine.size, DENSE))
    return replace(
        blind,
        fine=replace(blind.fine, view=view),
        mean=replace(blind.mean, view=mean),
        exact=replace(blind.exact, view=exact),
    )


def _folded(sea: SeaModel, wavenumber_cm1: Array, toward: Array, few: Streams, count: int) -> Array:
    """Return mode 0 (P, N, V) toward cosines (P,) along N streams, folded onto these from more streams."""
    many = gauss_streams(count)
    out, into = (cosines.ravel() for cosines in np.meshgrid(toward, many.mu, indexing="ij"))
    mean = expanded(sea, wavenumber_cm1, out, into, 1, 2 * count).reshape(toward.size, count, -1)
    onto = (_weight(many)[:, None] * _polynomials(many.mu, few.mu)) / _weight(few)
    folded: Array = np.einsum("jfv,fn->jnv", mean, onto)
    return folded


def sunlit_mirror(
    unlit: Mirror, sea: SeaModel, wavenumber_cm1: Array, where: ColumnDirections, surface: SeaSurface
) -> Mirror:
    """Return the mirror, completed for the sun of ``where`` and for light that only ``surface`` has.

    That is diffuse light that facets reflect twice, which is not in the BRDF: it is smooth, and has mode 0 only.
    """
    spaced_cm1, fine, few = wavenumber_cm1[unlit.places], unlit.streams.mu, where.streams.mu
    sun = expanded(sea, spaced_cm1, fine, np.full(fine.size, where.mu_sun), 2 * fine.size)
    mean = expanded(sea, spaced_cm1, few, np.full(few.size, where.mu_sun), 1)
    toward = (np.array([value]) for value in (where.mu[VIEW], where.mu_sun, where.relative_azimuth))
    twice = surface.reflection[..., unlit.places] / _weight(where.streams)[:, None]
    twice -= np.concatenate((unlit.exact.view, unlit.exact.between[0]))
    onto, view, between = hats(fine, few), unlit.fine.view.copy(), unlit.fine.between.copy()
    view[0] += onto @ twice[VIEW]
    between[0] += np.einsum("fj,gk,jkv->fgv", onto, onto, twice[VIEW + 1 :], optimize=True)
    return Mirror(
        unlit.places,
        unlit.weights,
        ReflectionModes(view, sun, between),
        ReflectionModes(unlit.mean.view + twice[VIEW], mean, unlit.mean.between + twice[VIEW + 1 :]),
        unlit.exact,
        sea.brdf(spaced_cm1, *toward)[0],
    )


def _spaced(wavenumber_cm1: Array) -> NDArray[np.intp]:
    """Return places of wavenumbers (V,) at some distance from each other, with both ends of each gap."""
    chosen = [0]
    for number in range(1, wavenumber_cm1.size):
        after = wavenumber_cm1[min(number + 1, wavenumber_cm1.size - 1)]
        last = number == wavenumber_cm1.size - 1
        if last or after - wavenumber_cm1[chosen[-1]] > SPACING_CM1:
            chosen.append(number)
    return np.array(chosen, dtype=np.intp)


def mirrored(
    slabs: Sequence[CloudSlab],
    where: ColumnDirections,
    mirror: Mirror,
    sea: ReflectionModes,
    beams: Array,
    direct: Array,
) -> Array:
    """Return what N streams lack of light that the sea mirrors once, over the received sunlight, without air.

    Parameters
    ----------
    slabs : sequence of CloudSlab
        From the highest to the lowest, of C columns at V wavenumbers.
    where : ColumnDirections
    mirror : Mirror
    sea : ReflectionModes
        Modes from 1 on (M - 1, ..., V) along the N streams.
    beams : ndarray (M, 2, N, C x V)
        Diffuse transmission of all clouds, of view and sun toward the streams.
    direct : ndarray (2, C x V)
        Direct transmission.

    Returns
    -------
    ndarray (2, C x V)
        Light that clouds scattered on its way down, and light that reached the sea directly.
    """
    count, some = mirror.weights.shape[1], mirror.places
    columns = direct.shape[-1] // count

    def at_places(values: Array) -> Array:
        return values.reshape(*values.shape[:-1], columns, count)[..., some]

    lit = np.any(beams[1:], axis=(0, 1, 2))
    result = np.zeros((2, columns, count))
    beams, direct = at_places(beams), at_places(direct)
    modes = ReflectionModes(
        *(
            np.concatenate((mean, surface[..., some]))
            for mean, surface in (
                (mirror.mean.view, sea.view),
                (mirror.mean.sun, sea.sun),
                (mirror.mean.between, sea.between),
            )
        )
    )
    before, *few = _reflected_once(where.streams, modes, where, direct, beams, mirror.direct)
    seen = np.sum([at_places(slab.sun_reflection[VIEW]) for slab in slabs], axis=0)
    bright = np.any(np.abs(np.sum(before, axis=0)) > DARK * np.abs(seen), axis=-1)
    if not np.any(bright) or not np.any(lit):
        return result.reshape(2, -1)
    layers = [
        _Layer(*(at_places(values)[..., bright, :] for values in properties))
        for properties in ((x.optical_thickness, x.albedo, x.moments, x.between_streams[:, 0]) for x in slabs)
    ]
    beams, direct = beams[..., bright, :], direct[:, bright]
    fine, more = mirror.streams, np.empty((mirror.fine.view.shape[0], 2, mirror.streams.mu.size, *direct.shape[1:]))
    within = np.empty_like(direct)
    for beam, mu in enumerate((float(where.mu[VIEW]), where.mu_sun)):
        within[beam], more[:, beam] = _transmitted(layers, mu, fine, where.streams, beams[:, beam])
    after, *risen = _reflected_once(fine, mirror.fine, where, within, more, mirror.direct)
    after[0] += _again(layers, where, fine, *risen, all_orders=False)
    after[0] += _again(layers, where, where.streams, *(light[:, :, bright] for light in few), all_orders=True)
    result[:, bright] = (after - before[:, bright]) @ mirror.weights
    added: Array = result.reshape(2, -1) * lit
    return added


@dataclass(frozen=True)
class _Layer:
    """A cloud in C columns at U wavenumbers.

    Attributes
    ----------
    thickness, albedo : ndarray (C, U)
        Optical thickness, and albedo of single scattering.
    moments : ndarray (K, C, U)
    reflection : ndarray (M, P, C, U)
        As the first of :attr:`CloudSlab.between_streams`.
    """

    thickness: Array
    albedo: Array
    moments: Array
    reflection: Array

    def scaled(self, count: int) -> Array:
        """Return the optical thickness (C, U) without the peak beyond ``count`` moments."""
        result: Array = self.thickness * (1.0 - self.albedo * self.moments[count])
        return result

    def backward(self, mu: Array, mode: int) -> Array:
        """Return a mode (F, F, U), of bearings, of the phase function from directions (F,) upward to downward."""
        moments = self.moments[:, 0]  # those of any column
        count = moments.shape[0] - 1
        degree = np.arange(count)
        series = ((2 * degree + 1) * (-1.0) ** degree)[:, None] * (moments[:count] - moments[count])
        values = _legendre(tuple(mu.tolist()), mode, count)
        pairs = (values[:, :, None] * values[:, None]).reshape(count, -1)
        result: Array = (pairs.T @ series).reshape(mu.size, mu.size, -1)
        return result

    def between(self, mode: int, streams: int) -> Array:
        """Return a mode (N, N, C, U) of the reflection of all orders, of bearings: light travels away from its own."""
        result = np.empty((streams, streams, *self.reflection.shape[2:]))
        first, second = np.triu_indices(streams)
        result[first, second] = result[second, first] = (-1.0) ** mode * self.reflection[mode]
        return result


@lru_cache(maxsize=1024)
def _legendre(mu: tuple[float, ...], mode: int, count: int) -> Array:
    return normalised_legendre(np.array(mu), mode, count)


def _weight(streams: Streams) -> Array:
    return 2.0 * pi * streams.mu * streams.weight


def _polynomials(mu: Array, nodes: Array) -> Array:
    """Return the polynomials (P, N) at cosines (P,) that are 1 at one node and 0 at the others."""
    result = np.ones((mu.size, nodes.size))
    for n, node in enumerate(nodes):
        others = np.delete(nodes, n)
        result[:, n] = np.prod((mu[:, None] - others) / (node - others), axis=1)
    return result


def _turns(where: ColumnDirections, modes: int) -> Array:
    turns: Array = 2.0 * np.cos(np.arange(modes) * where.relative_azimuth)
    turns[0] = 1.0
    return turns


def _reflected_once(
    streams: Streams, sea: ReflectionModes, where: ColumnDirections, direct: Array, beams: Array, glint: Array
) -> tuple[Array, Array, Array]:
    """Return light that the sea mirrors once, (2, C, U), as :func:`mirrored`.

    Also the modes (M, N, C, U) of light from the sun that rises from the sea, and the same of the view.
    """
    modes, weight = min(sea.view.shape[0], beams.shape[0]), _weight(streams)[:, None, None]
    turns = _turns(where, modes)[:, None, None, None]
    between = np.moveaxis(sea.between[:modes], -1, 1)  # (M, U, N, N)

    def from_sea(beam: int, surface_modes: Array) -> tuple[Array, Array]:
        onto = np.moveaxis(beams[:modes, beam] * weight, -1, 1)  # (M, U, N, C)
        return direct[beam] * surface_modes[:modes, :, None], np.moveaxis(between @ onto, 1, -1)

    of_direct, of_scattered = from_sea(1, sea.sun)
    left = turns * weight * beams[:modes, 0]
    scattered = direct[0] * np.sum(turns * weight * sea.view[:modes, :, None] * beams[:modes, 1], axis=(0, 1))
    scattered = scattered + np.sum(left * of_scattered, axis=(0, 1))
    glinting = direct[0] * direct[1] * glint + np.sum(left * of_direct, axis=(0, 1))
    direct_view, scattered_view = from_sea(0, sea.view)
    return np.stack((scattered, glinting)), direct_view + scattered_view, of_direct + of_scattered


def _transmitted(layers: Sequence[_Layer], mu: float, fine: Streams, few: Streams, beams: Array) -> tuple[Array, Array]:
    """Return direct (C, U) and diffuse transmission (M, F, C, U) of a beam, given (m, N, C, U) along N streams."""
    many, kept = 2 * fine.mu.size, 2 * few.mu.size
    at = fine.mu[:, None, None]
    whole, scaled = (np.sum([layer.scaled(count) for layer in layers], axis=0) for count in (many, kept))
    # As in hcss_twin.physics.multiple_scattering.forward_peak, with the peak beyond F streams in the direct light: mean
    # slant paths, times what makes single scattering exact where they differ, sinh(half) / half.
    rate, half = 0.5 * (1.0 / at + 1.0 / mu), 0.5 * scaled * np.abs(1.0 / at - 1.0 / mu)
    slow = np.sum(
        [layer.thickness * (1.0 - layer.albedo * layer.moments[:many]) for layer in layers], axis=0
    )  # (L, C, U)
    slow[:kept] = scaled
    exact = np.where(half > 0.0, -np.expm1(-2.0 * half) / np.where(half > 0.0, 2.0 * half, 1.0), 1.0) / rate
    left = np.exp(np.minimum(half - rate * slow[:, None], 0.0))
    series = (left - np.exp(np.minimum(half - rate * whole, 0.0))) * exact  # (L, F, C, U)
    series[:kept] += _once(layers, mu, at, kept)
    result = _summed(series, fine.mu, mu, many)
    scattered_more = beams - _summed(_once(layers, mu, few.mu[:, None, None], kept), few.mu, mu, beams.shape[0])
    sines = [np.sqrt(1.0 - streams.mu**2) for streams in (fine, few)]
    even = _polynomials(fine.mu, few.mu)
    # Odd modes are a polynomial times the sine.
    for parity, weights in enumerate((even, even * sines[0][:, None] / sines[1])):
        result[parity : beams.shape[0] : 2] += np.einsum("fn,mncu->mfcu", weights, scattered_more[parity::2])
    return np.exp(-whole / mu), result


def _once(layers: Sequence[_Layer], mu: float, at: Array, kept: int) -> Array:
    """Return moments (L, P, C, U) of light that one of the clouds scatters once by its truncated phase function."""
    depths = [layer.scaled(kept) for layer in layers]
    result = np.zeros((kept, at.shape[0], *depths[0].shape))
    for number, layer in enumerate(layers):
        peak = layer.moments[kept]
        strength = layer.albedo * (layer.moments[:kept] - peak) / (1.0 - layer.albedo * peak)
        above, below = sum(depths[:number], np.zeros(())), sum(depths[number + 1 :], np.zeros(()))
        path = path_through(depths[number], at, mu) * np.exp(-above / mu - below / at)
        result += strength[:, None] * path
    return result


def _summed(series: Array, at: Array, mu: float, modes: int) -> Array:
    """Return the azimuth modes (M, P, C, U) of a kernel with moments (L, P, C, U)."""
    count, points = series.shape[:2]
    degree = 2.0 * np.arange(count) + 1.0
    values = np.stack([_legendre((*at.tolist(), mu), mode, count) for mode in range(modes)])
    factors = values[:, :, :-1] * values[:, :, -1:] * (degree[:, None] / (4.0 * pi * at * mu))  # (M, L, P)
    flat = series.reshape(count, points, -1).transpose(1, 0, 2)
    result = factors.transpose(2, 0, 1) @ flat  # (P, M, C x U)
    return result.transpose(1, 0, 2).reshape(modes, points, *series.shape[2:])


def _again(
    layers: Sequence[_Layer], where: ColumnDirections, streams: Streams, view: Array, sun: Array, *, all_orders: bool
) -> Array:
    """Return the light (C, U) that clouds scatter once from sea to sea, in the modes from 1 on.

    Parameters
    ----------
    streams : Streams
        F.
    view, sun : ndarray (M, F, C, U)
        Modes of the light that rises from the sea.
    all_orders : bool
        Whether to return what all orders of scattering add to it; F is then N.
    """
    modes, kept = min(view.shape[0], BACK_MODES), coupled_moments(where.count)
    if all_orders:
        modes = min(modes, kept)
    turns, weight = _turns(where, modes), _weight(streams)[:, None, None]
    one, other = streams.mu[:, None, None, None], streams.mu[:, None, None]
    crossed, below = [], np.zeros(view.shape[2:])
    for layer in reversed(layers):
        depth = layer.scaled(kept)
        through = np.exp(-below * (1.0 / one + 1.0 / other))
        strength = layer.albedo / (1.0 - layer.albedo * layer.moments[kept]) / (4.0 * pi * one * other)
        crossed.append((layer, through, path_back(depth[None, None], one, other) * strength))
        below = below + depth
    result = np.zeros(view.shape[2:])
    going, quiet = np.ones(len(result), dtype=np.bool_), np.zeros(len(result), dtype=np.bool_)
    for mode in range(1, modes):
        back = np.zeros(())
        for layer, through, once in crossed:
            kernel = layer.backward(streams.mu, mode)[:, :, None] * once
            if all_orders:
                kernel = layer.between(mode, streams.mu.size) - kernel
            back = back + kernel * through
        falling = np.sum(back * (weight * sun[mode]), axis=1)
        # Without the factor of the bearing, which may be nearly 0 for two modes.
        more = np.sum(weight * view[mode] * falling, axis=0)
        result[going] += turns[mode] * more[going]
        small = np.max(np.abs(more), axis=1) <= LEAST_BACK * np.max(np.abs(result), axis=1)
        going, quiet = going & ~(small & quiet), small
        if not np.any(going):
            break
    return result
