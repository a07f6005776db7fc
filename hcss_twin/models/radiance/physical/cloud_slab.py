"""Emission, reflection and transmission operators of a cloud layer, which sum to one in every direction.

They are solved on a grid of thicknesses and interpolated; for few thicknesses, they are solved for these.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.array_memory import ArrayMemory
from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.physical.air import Heights
from hcss_twin.models.radiance.physical.directions import VIEW, ColumnDirections
from hcss_twin.models.radiance.physical.numerics import Numerics
from hcss_twin.physics.multiple_scattering.layer import LayerOperators, joined, solve_layers
from hcss_twin.physics.multiple_scattering.phase_function import extended_moments
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun, solve_sunlit_layers, transmit_beams
from hcss_twin.physics.multiple_scattering.two_stream import solve_layers_two_stream, solve_sun_two_stream
from hcss_twin.providers import CloudLayer, Optics

PER_OCTAVE = 3
"""Nodes per doubling of thickness; each costs a chain of doublings."""

FEW_STREAMS = 16
"""Streams for sunlight that are solved at every thickness of the grid."""

PEAK_DEGREE = 16
"""Light scattered by a smaller angle than polynomials of this degree resolve, some 10 deg, still illuminates the air
below a cloud."""

FEW_THICKNESSES = 3
"""As many thicknesses, each with its own chain of doublings, cost no more than a grid."""

_WINDOW = 10
"""Nodes of the interpolating polynomial; its error is 1e-6 of full reflection, as with 6 nodes at 6 per doubling."""


def thickness_grid(least_m: float, most_m: float) -> Array:
    """Return ascending thicknesses most 2^(n / 3) that extend beyond both ends by half a window.

    Parameters
    ----------
    least_m, most_m : float
        Range of thickness, above 0.
    """
    count = math.ceil(math.log2(most_m / least_m) * PER_OCTAVE)
    steps = np.arange(-count - _WINDOW // 2, _WINDOW // 2 + 1)
    return np.asarray(most_m * 2.0 ** (steps / PER_OCTAVE), dtype=np.float64)


@dataclass(frozen=True)
class OperatorTable:
    """Table of operators with thickness as first axis.

    Attributes
    ----------
    thickness_m : ndarray (G,)
        From :func:`thickness_grid`.
    operators : tuple of ndarray (G, ...)
    """

    thickness_m: Array
    operators: tuple[Array, ...]

    @cached_property
    def floors(self) -> tuple[Array, ...]:
        """Minimum of each operator, at most 0: polynomials undershoot where a cloud becomes opaque."""
        return tuple(np.minimum(np.min(each, axis=0), 0.0) for each in self.operators)

    @property
    def least_m(self) -> float:
        """Smallest thickness with a full window around it."""
        return float(self.thickness_m[_WINDOW // 2 - 1])

    @property
    def most_m(self) -> float:
        """Largest thickness with a full window around it."""
        return float(self.thickness_m[-_WINDOW // 2])

    def at(self, thickness_m: float) -> tuple[Array, ...]:
        """Return the operators of one thickness (...), by Lagrange's polynomial in ln(thickness)."""
        place = math.log2(thickness_m / float(self.thickness_m[0])) * PER_OCTAVE
        first = min(max(math.floor(place) - _WINDOW // 2 + 1, 0), self.thickness_m.size - _WINDOW)
        weights = _lagrange(place - first)
        return tuple(
            np.maximum(np.tensordot(weights, each[first : first + _WINDOW], axes=1), floor)
            for each, floor in zip(self.operators, self.floors, strict=True)
        )


def _from_octaves(count: int) -> Array:
    """Return the weights (T, S) that interpolate T thicknesses of a grid from every third of them."""
    known = -(-count // PER_OCTAVE)
    nodes = min(_WINDOW, known)
    weights = np.zeros((count, known))
    for row in range(count):
        first = min(max(math.floor(row / PER_OCTAVE) - nodes // 2 + 1, 0), known - nodes)
        weights[row, first : first + nodes] = _lagrange(row / PER_OCTAVE - first, nodes)
    return weights


def _lagrange(position: float, nodes: int = _WINDOW) -> Array:
    """Return the weights of the nodes 0, 1, ... at a position; they sum to one."""
    weights = np.ones(nodes)
    for i in range(nodes):
        for j in range(nodes):
            if i != j:
                weights[i] *= (position - j) / (i - j)
    result: Array = weights / weights.sum()
    return result


@dataclass(frozen=True)
class CloudSlab:
    """One layer of C columns; D directions (view and streams), N streams, V wavenumbers, S = C x V.

    Attributes
    ----------
    base_m, top_m : tuple of float (C,)
        Altitudes.
    top_temperature_K, base_temperature_K : tuple of float (C,)
    emissivity, far_share, direct : ndarray (D, S)
        As in :class:`LayerOperators`.
    reflection, transmission : ndarray (D, N, S)
        Contribution of each stream's radiance to the radiance toward a direction.
    sun_reflection, sun_transmission : ndarray (D, S)
        sr-1; toward the view at its azimuth, toward streams as azimuth mean; 0 without a sun.
    sun_direct : ndarray (S,)
        Direct transmittance for the sun; 0 without one.
    to_lower_air : ndarray (S,)
        Transmittance for sunlight that air below scatters into the view: both ways, light scattered in the forward peak
        included; 0 without a sun.
    beam_transmission : ndarray (M, 2, N, S)
        sr-1, azimuth modes from 1 on, of view and sun toward the streams; 0 where sunlight is negligible.
    """

    base_m: Heights
    top_m: Heights
    top_temperature_K: tuple[float, ...]
    base_temperature_K: tuple[float, ...]
    emissivity: Array
    far_share: Array
    direct: Array
    reflection: Array
    transmission: Array
    sun_reflection: Array
    sun_transmission: Array
    sun_direct: Array
    to_lower_air: Array
    beam_transmission: Array


def side_by_side(slabs: Sequence[CloudSlab]) -> CloudSlab:
    """Join the columns of several slabs into one."""
    first, *others = slabs
    if not others:
        return first
    together: dict[str, Any] = {}
    for field in fields(CloudSlab):
        values = [getattr(slab, field.name) for slab in slabs]
        of_columns = isinstance(values[0], tuple)
        together[field.name] = sum(values, ()) if of_columns else np.concatenate(values, axis=-1)
    return CloudSlab(**together)


class SlabSolver:
    """Solver for layers of one optics provider and one set of directions.

    Parameters
    ----------
    optics : Optics
    numerics : Numerics
    wavenumber_cm1 : ndarray (V,)
    directions : ColumnDirections
    sun_share : ndarray (V,)
        Sunlight reflected by a white plane, relative to the Planck radiance of the sea.
    closed_form : bool
        Whether clouds are solved by the two-stream closed form.
    memory : ArrayMemory
        Keeps solved layers for scenes with the same clouds: they do not depend on sea and air.
    """

    def __init__(
        self,
        optics: Optics,
        numerics: Numerics,
        wavenumber_cm1: Array,
        directions: ColumnDirections,
        sun_share: Array,
        closed_form: bool,
        memory: ArrayMemory,
    ) -> None:
        self._memory = memory
        self._closed_form = closed_form
        self._sun_share = sun_share
        self._tables: dict[CloudLayer, OperatorTable] = {}
        self._single: dict[tuple[CloudLayer, float], tuple[Array, ...]] = {}
        self._optics = optics
        self._numerics = numerics
        self._wavenumber = wavenumber_cm1
        self._directions = directions

    def solve(self, layer: CloudLayer, thickness_m: Array, top_K: Array, base_K: Array) -> list[CloudSlab]:
        """Return ``layer`` at every thickness, one column for each.

        For more than a few thicknesses, operators are solved once, on a logarithmic grid of thicknesses, and
        interpolated in ln(thickness); row sums are preserved, because the interpolation weights sum to one.

        Parameters
        ----------
        thickness_m : ndarray (T,)
            Above 0, each once.
        top_K, base_K : ndarray (T,)
            Temperatures of the two faces.
        """
        tops = layer.cloud_top_m(thickness_m)
        slabs = []
        for t, operators in enumerate(self._operators(layer, thickness_m.tolist())):
            thickness = float(thickness_m[t])
            *rows, back, through, beam, to_lower_air, turned = operators
            emissivity, far, direct, reflection, transmission = _closed(*rows)
            slabs.append(
                CloudSlab(
                    base_m=(float(tops[t]) - thickness,),
                    top_m=(float(tops[t]),),
                    top_temperature_K=(float(top_K[t]),),
                    base_temperature_K=(float(base_K[t]),),
                    emissivity=emissivity,
                    far_share=far,
                    direct=direct,
                    reflection=reflection,
                    transmission=transmission,
                    sun_reflection=back,
                    sun_transmission=through,
                    sun_direct=beam,
                    to_lower_air=to_lower_air,
                    beam_transmission=turned,
                )
            )
        return slabs

    def _operators(self, layer: CloudLayer, thickness_m: list[float]) -> Iterator[tuple[Array, ...]]:
        """Yield the operators of each thickness, in the order of :class:`CloudSlab`."""
        known = [h for of, h in self._single if of == layer]
        if layer not in self._tables and len({*known, *thickness_m}) > FEW_THICKNESSES:
            grid = thickness_grid(layer.thickness_min_m, layer.thickness_max_m)
            self._tables[layer] = OperatorTable(grid, self._solve(layer, grid))
        table = self._tables.get(layer)
        beyond = [h for h in thickness_m if table is None or not table.least_m <= h <= table.most_m]
        new = [h for h in beyond if (layer, h) not in self._single]
        if new:
            solved = self._solve(layer, np.array(new))
            self._single |= {(layer, h): tuple(each[n] for each in solved) for n, h in enumerate(new)}
        for h in thickness_m:
            yield self._single[layer, h] if table is None or h in beyond else table.at(h)

    def _solve(self, layer: CloudLayer, thickness_m: Array) -> tuple[Array, ...]:
        """Return the operators of a layer with thickness as first axis, in the order of :class:`CloudSlab`."""
        scattering = self._optics.single_scattering(layer.microphysics, self._wavenumber)
        depth = thickness_m[:, None] * scattering.extinction_m1
        solve = partial(self._new_operators, depth, scattering.albedo, scattering.moments)
        where, digest = self._directions, hashlib.sha256()
        for each in (depth, scattering.albedo, scattering.moments, where.mu, self._is_bright):
            digest.update(np.ascontiguousarray(each).tobytes())
        digest.update(repr((where.sun, where.relative_azimuth, self._numerics, self._closed_form)).encode())
        return self._memory.get_or_compute(digest.digest(), solve)

    @property
    def _is_bright(self) -> NDArray[np.bool_]:
        """Wavenumbers (V,) at which sunlight matters; at others the closed form with its error of 15 % suffices."""
        return (self._sun_share > self._numerics.faint_sun) & (not self._closed_form)

    def _new_operators(self, depth: Array, albedo: Array, moments: Array) -> tuple[Array, ...]:
        """Return the operators of layers with optical thickness (T, V), in the order of :class:`CloudSlab`."""
        where = self._directions
        solved, brdf, btdf, turned = self._solved(depth, albedo, moments)
        back, through, beam = self._sunlight(solved, brdf, btdf)
        lower = self._to_lower_air(depth, albedo, moments)
        extras = solved.mu.size - where.count
        view_and_streams = [VIEW, *range(extras, solved.mu.size)]
        factor = 2.0 * np.pi * where.streams.mu * where.streams.weight
        # (T, V, D, N) -> (T, D, N, V)
        reflection, transmission = (
            np.ascontiguousarray(np.moveaxis(each[:, :, view_and_streams, extras:] * factor, 1, -1))
            for each in (solved.reflection, solved.transmission)
        )
        emissivity, far, direct = (
            np.ascontiguousarray(np.moveaxis(each[:, :, view_and_streams], 1, -1))
            for each in (solved.emissivity, solved.far_share, solved.direct)
        )
        return emissivity, far, direct, reflection, transmission, back, through, beam, lower, turned

    def _to_lower_air(self, depth: Array, albedo: Array, moments: Array) -> Array:
        """Return the transmittance (T, V) of :attr:`CloudSlab.to_lower_air`."""
        where = self._directions
        if where.sun is None:
            return np.zeros_like(depth)
        peak = extended_moments(moments, PEAK_DEGREE + 1)[PEAK_DEGREE]
        slant = 1.0 / where.mu[VIEW] + 1.0 / where.mu_sun
        result: Array = np.exp(-depth * (1.0 - albedo * peak) * slant)
        return result

    def _solved(self, depth: Array, albedo: Array, moments: Array) -> tuple[LayerOperators, Array, Array, Array]:
        """Return diffuse operators; brdf and btdf (T, V) toward the view; and modes (T, M, 2, N, V).

        The modes are the diffuse transmission of view and sun beams toward the streams. Sunlight is 0 without a sun;
        its modes are 0 where it is faint.
        """
        where, numerics = self._directions, self._numerics
        brdf, btdf = np.zeros((2, *depth.shape))
        turned = np.zeros((depth.shape[0], numerics.turned_modes - 1, 2, where.count, albedo.size))
        if where.sun is None:
            return self._layers(depth, albedo, moments), brdf, btdf, turned
        bright = self._is_bright
        faint = ~bright
        view, sun, azimuth = where.mu[VIEW], where.mu_sun, where.relative_azimuth
        if np.any(faint):
            own = depth[:, faint], albedo[faint], moments[:, faint]
            both = solve_sun_two_stream(*own, np.array([view]), sun, np.array([azimuth]), streams=where.count)
            brdf[:, faint], btdf[:, faint] = (each[..., 0] for each in both)
        if not np.any(bright):
            return self._layers(depth, albedo, moments), brdf, btdf, turned
        own = depth[:, bright], albedo[bright], moments[:, bright]
        modes, turned_modes = numerics.azimuth_modes, numerics.turned_modes
        if (numerics.sun_streams, numerics.sun_moments) == (where.count, 2 * where.count):
            lit = solve_sunlit_layers(*own, view, sun, azimuth, where.count, modes, turned_modes)
            brdf[:, bright], btdf[:, bright] = lit.brdf, lit.btdf
            beams, solved = lit.beams, lit.layers
            if np.any(faint):
                solved = joined(solved, self._layers(depth[:, faint], albedo[faint], moments[:, faint]), bright)
        else:
            solved = self._layers(depth, albedo, moments)
            brdf[:, bright], btdf[:, bright] = self._toward_view(*own)
            beams = transmit_beams(*own, np.array([view, sun]), where.count, turned_modes)
        turned[..., bright] = beams.transpose(1, 0, 4, 3, 2)
        return solved, brdf, btdf, turned

    def _toward_view(self, depth: Array, albedo: Array, moments: Array) -> Array:
        """Return brdf and btdf (2, T, V) toward the view.

        Many streams are solved at one thickness per octave: their difference from few streams is small and smooth.
        """
        where, numerics = self._directions, self._numerics
        toward = np.array([where.mu[VIEW]]), where.mu_sun, np.array([where.relative_azimuth])

        def solve(depth: Array, streams: int, kept: int, modes: int) -> Array:
            return np.stack(solve_sun(depth, albedo, moments, *toward, streams, modes, kept_moments=kept))[..., 0]

        most = numerics.sun_streams, numerics.sun_moments, numerics.azimuth_modes
        if numerics.sun_streams < 2 * FEW_STREAMS or depth.shape[0] <= _WINDOW:
            return solve(depth, *most)
        few = solve(depth, FEW_STREAMS, FEW_STREAMS, FEW_STREAMS)
        more = solve(depth[::PER_OCTAVE], *most) - few[:, ::PER_OCTAVE]
        result: Array = few + np.einsum("ts,nsv->ntv", _from_octaves(depth.shape[0]), more)
        return result

    def _layers(self, depth: Array, albedo: Array, moments: Array) -> LayerOperators:
        where = self._directions
        extras = [where.mu[VIEW]] if where.sun is None else [where.mu[VIEW], where.mu_sun]
        solve = solve_layers_two_stream if self._closed_form else solve_layers
        return solve(depth, albedo, moments, np.array(extras), where.count)

    def _sunlight(self, solved: LayerOperators, brdf: Array, btdf: Array) -> tuple[Array, Array, Array]:
        """Return kernels (T, D, V) for reflected and transmitted sunlight, and the direct transmittance (T, V)."""
        count, size = brdf.shape
        if self._directions.sun is None:
            nothing = np.zeros((count, 1 + self._directions.count, size))
            return nothing, nothing, np.zeros((count, size))
        sun, streams = 1, range(2, solved.mu.size)
        back, through = (
            np.concatenate((toward_view[..., None], kernels[:, :, streams, sun]), axis=-1)
            for toward_view, kernels in ((brdf, solved.reflection), (btdf, solved.transmission))
        )
        return np.moveaxis(back, 1, -1), np.moveaxis(through, 1, -1), solved.direct[:, :, sun]


def _closed(
    emissivity: Array, far: Array, direct: Array, reflection: Array, transmission: Array
) -> tuple[Array, Array, Array, Array, Array]:
    """Normalise row sums to one; clipping negative interpolated values changes them by about 1e-7."""
    whole = emissivity + direct + np.sum(reflection, axis=1) + np.sum(transmission, axis=1)
    emissivity, far, direct = (each / whole for each in (emissivity, far, direct))
    reflection, transmission = (each / whole[:, None] for each in (reflection, transmission))
    return emissivity, far, direct, reflection, transmission
