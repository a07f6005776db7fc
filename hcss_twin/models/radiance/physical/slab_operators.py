"""Operators of layers at given optical thicknesses, for several suns or views at once.

Diffuse light is solved once for all of them; sunlight that clouds scatter toward the sensor may have more streams.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.result_cache import ArrayMemory
from hcss_twin.models.radiance.physical.directions import VIEW, ColumnDirections
from hcss_twin.models.radiance.physical.numerics import Numerics
from hcss_twin.models.radiance.physical.operator_table import WINDOW, coarse_thickness, from_coarse
from hcss_twin.physics.multiple_scattering.beams import coupled_moments, solve_coupled_layers, transmit_beams
from hcss_twin.physics.multiple_scattering.layer import LayerOperators, joined, solve_layers
from hcss_twin.physics.multiple_scattering.phase_function import extended_moments
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun, solve_sunlit_layers
from hcss_twin.physics.multiple_scattering.two_stream import solve_layers_two_stream, solve_sun_two_stream

FEW_STREAMS, FEW_MOMENTS = 16, 24
"""Streams for sunlight that are solved at every thickness of the grid."""

PEAK_DEGREE = 16
"""Light scattered by a smaller angle than polynomials of this degree resolve, some 10 deg, still illuminates the air
below a cloud."""

SUN_REFLECTION = 5
"""Place of ``sun_reflection`` among the operators."""


def solves_alone(numerics: Numerics, where: ColumnDirections) -> bool:
    """Whether sunlight has the streams of diffuse light, which are solved for one sun at a time."""
    return (numerics.sun_streams, numerics.sun_moments) == (where.count, 2 * where.count)


@dataclass(frozen=True)
class SlabOperators:
    """Solution for directions that differ in the sun or in the view only.

    Attributes
    ----------
    numerics : Numerics
    closed_form : bool
        Whether clouds are solved by the two-stream closed form.
    memory : ArrayMemory
        Keeps sunlight for scenes with the same clouds.
    directions : sequence of ColumnDirections (S,)
    faint : sequence of ndarray of bool (S,)
        Where sunlight is faint (V,): the closed form with its error of about 15 % suffices for it.
    coupled : bool
        Whether other layers may lie above or below.
    views_at_once : tuple of (float, float)
        Cosine and azimuth relative to the sun of views whose sunlight is solved at once, for little more than one.
    """

    numerics: Numerics
    closed_form: bool
    memory: ArrayMemory
    directions: Sequence[ColumnDirections]
    faint: Sequence[NDArray[np.bool_]]
    coupled: bool
    views_at_once: tuple[tuple[float, float], ...] = ()

    @property
    def where(self) -> ColumnDirections:
        """One of the directions; all have its streams."""
        return self.directions[0]

    @cached_property
    def _one_view(self) -> bool:
        return all(direction.mu[VIEW] == self.where.mu[VIEW] for direction in self.directions)

    @cached_property
    def views(self) -> list[float]:
        """Cosines of the views: of one if they differ in the sun."""
        return [
            float(directions.mu[VIEW]) for directions in (self.directions[:1] if self._one_view else self.directions)
        ]

    @cached_property
    def suns(self) -> list[float]:
        """Cosines of the suns: of one if the views differ."""
        return [directions.mu_sun for directions in (self.directions if self._one_view else self.directions[:1])]

    def of(self, depth: Array, albedo: Array, moments: Array) -> list[tuple[Array, ...]]:
        """Return the operators for each of the directions, in the order of :class:`CloudSlab`.

        Parameters
        ----------
        depth : ndarray (T, V)
            Optical thickness.
        albedo : ndarray (V,)
        moments : ndarray (K, V)
        """
        is_lit = self.where.sun is not None and not self.closed_form
        coupled = self._coupled(depth, albedo, moments, self.numerics.turned_modes if is_lit else 0)
        operators = zip(self._new_operators(depth, albedo, moments), coupled, strict=True)
        return [tuple(chain.from_iterable(operator)) for operator in operators]

    def _new_operators(self, depth: Array, albedo: Array, moments: Array) -> Iterator[tuple[Array, ...]]:
        """Yield the operators of layers with optical thickness (T, V) for each solver."""
        solved, kernels, turned = self._solved(depth, albedo, moments)
        extras = solved.mu.size - self.where.count
        streams = range(extras, solved.mu.size)
        factor = 2.0 * np.pi * self.where.streams.mu * self.where.streams.weight

        @cache
        def diffuse(view: int) -> tuple[Array, ...]:
            rows = [view, *streams]
            # (T, V, D, N) -> (T, D, N, V)
            kernels = (kernel[:, :, rows, extras:] * factor for kernel in (solved.reflection, solved.transmission))
            shares = (share[:, :, rows] for share in (solved.emissivity, solved.far_share, solved.direct))
            return tuple(np.ascontiguousarray(np.moveaxis(operator, 1, -1)) for operator in (*shares, *kernels))

        for number, where in enumerate(self.directions):
            view, sun = number % len(self.views), len(self.views) + number % len(self.suns)
            back, through, beam = _sunlight(where, sun, solved, *kernels[number])
            lower = _to_lower_air(where, depth, albedo, moments)
            beams = turned[:, :, [view, sun]]
            beams[..., self.faint[number]] = 0.0
            yield *diffuse(view), back, through, beam, lower, beams

    def _coupled(self, depth: Array, albedo: Array, moments: Array, modes: int) -> Iterator[tuple[Any, ...]]:
        """Yield the last two operators of :class:`CloudSlab` for each solver, the last on a grid one row per octave."""
        step = self.numerics.per_octave if depth.shape[0] > WINDOW else 1
        of_octaves = np.arange(depth.shape[0]) % step == 0
        count, views, suns = self.where.count, self.views, self.suns
        modes = min(modes, coupled_moments(count))
        beams = np.zeros((depth.shape[0], modes if self.coupled else 0, 2, len(views) + len(suns), count, albedo.size))
        pairs = count * (count + 1) // 2
        between = np.zeros((np.count_nonzero(of_octaves), modes, 2, pairs, albedo.size), dtype=np.float32)
        bright = ~np.all(self.faint, axis=0)
        if modes and np.any(bright):
            layer, along = (albedo[bright], moments[:, bright]), np.array([*views, *suns])
            # Mode 0 matters beside other layers only.
            least = 0 if self.coupled else 1
            of_bright = np.zeros((*beams.shape[:-1], np.count_nonzero(bright)))
            for some, of_streams in ((of_octaves, True), (~of_octaves, False)):
                if not (of_streams or (self.coupled and np.any(some))):
                    continue
                solved = solve_coupled_layers(
                    depth[some][:, bright], *layer, along, count, modes, between_streams=of_streams, least_mode=least
                )
                if of_streams:
                    between[..., bright] = solved.streams.transpose(2, 0, 1, 4, 3)
                if self.coupled:
                    of_bright[some] = solved.beams.transpose(2, 0, 1, 5, 4, 3)
            beams[..., bright] = of_bright
        for number in range(len(self.directions)):
            own_beams = beams[:, :, :, [number % len(views), len(views) + number % len(suns)]]
            own_beams[..., self.faint[number]] = 0.0
            yield own_beams, between

    def _solved(self, depth: Array, albedo: Array, moments: Array) -> tuple[LayerOperators, Array, Array]:
        """Return diffuse operators, brdf and btdf (solvers, 2, T, V), and modes (T, M, views + suns, N, V).

        The modes are the diffuse transmission of view and sun beams toward the streams. Sunlight is 0 without a sun;
        its modes are 0 where it is faint.
        """
        where, numerics, extras = self.where, self.numerics, [*self.views, *self.suns]
        kernels = np.zeros((len(self.directions), 2, *depth.shape))
        turned = np.zeros((depth.shape[0], numerics.turned_modes - 1, len(extras), where.count, albedo.size))
        if where.sun is None:
            return self._layers(depth, albedo, moments, self.views), kernels, turned
        bright = ~np.all(self.faint, axis=0)
        if not np.any(bright):
            solved = self._layers(depth, albedo, moments, extras)
        else:
            solved = self._lit(depth, albedo, moments, extras, bright, kernels, turned)
        for direction, faint, kernel in zip(self.directions, self.faint, kernels, strict=True):
            if np.any(faint):
                toward = direction.mu[VIEW : VIEW + 1], direction.mu_sun, np.array([direction.relative_azimuth])
                layer = depth[:, faint], albedo[faint], moments[:, faint]
                kernel[:, :, faint] = np.stack(solve_sun_two_stream(*layer, *toward, streams=where.count))[..., 0]
        return solved, kernels, turned

    def _lit(
        self,
        depth: Array,
        albedo: Array,
        moments: Array,
        extras: Sequence[float],
        bright: NDArray[np.bool_],
        kernels: Array,
        turned: Array,
    ) -> LayerOperators:
        """Return diffuse operators, and write kernels and modes where the sun is ``bright``, as for :meth:`_solved`."""
        where, numerics, faint = self.where, self.numerics, ~bright
        layer = depth[:, bright], albedo[bright], moments[:, bright]
        if solves_alone(numerics, where):
            modes, turned_modes = numerics.azimuth_modes, numerics.turned_modes
            lit = solve_sunlit_layers(
                *layer, extras[0], where.mu_sun, where.relative_azimuth, where.count, modes, turned_modes
            )
            kernels[0, 0][:, bright], kernels[0, 1][:, bright] = lit.brdf, lit.btdf
            beams, solved = lit.beams, lit.layers
            if np.any(faint):
                solved = joined(solved, self._layers(depth[:, faint], albedo[faint], moments[:, faint], extras), bright)
        else:
            solved = self._layers(depth, albedo, moments, extras)
            kernels[..., bright] = self._toward_views(*layer)
            beams = transmit_beams(*layer, np.array(extras), where.count, numerics.turned_modes)
        turned[..., bright] = beams.transpose(1, 0, 4, 3, 2)
        return solved

    def _toward_views(self, depth: Array, albedo: Array, moments: Array) -> Array:
        """Return brdf and btdf (solvers, 2, T, V), for one view and all suns, or for one sun and all views.

        By reciprocity those of several suns are those of a sun in the direction of the view, toward the suns: all are
        solved at once. Many streams are solved at one thickness per octave: their difference from few streams is small
        and smooth.
        """
        views, suns = self.views, self.suns
        azimuths = [direction.relative_azimuth for direction in self.directions]
        one_view = len(suns) > 1 or not self.views_at_once
        source = views[0] if one_view else suns[0]
        wanted = list(zip(suns if one_view else views, azimuths, strict=True))
        every = wanted if one_view else self.views_at_once
        sizes = self.numerics.sun_streams, self.numerics.sun_moments, self.numerics.azimuth_modes
        digest = hashlib.sha256(repr((sizes, tuple(every), source)).encode())
        for array in (depth, albedo, moments):
            digest.update(np.ascontiguousarray(array).tobytes())

        def compute() -> tuple[Array, ...]:
            cosines, turned = zip(*every, strict=True)
            return (self._sunlight_between(depth, albedo, moments, cosines, source, turned),)

        return self.memory.get_or_compute(digest.digest(), compute)[0][[every.index(direction) for direction in wanted]]

    def _sunlight_between(
        self,
        depth: Array,
        albedo: Array,
        moments: Array,
        mu: Sequence[float],
        mu_source: float,
        azimuths: Sequence[float],
    ) -> Array:
        """Return brdf and btdf (P, 2, T, V) from one direction to P others."""
        numerics, toward = self.numerics, (np.array(mu), mu_source, np.array(azimuths))

        def solve(depth: Array, streams: int, kept: int, modes: int) -> Array:
            kernels = np.stack(solve_sun(depth, albedo, moments, *toward, streams, modes, kept_moments=kept))
            return np.moveaxis(kernels, -1, 0)

        most = numerics.sun_streams, numerics.sun_moments, numerics.azimuth_modes
        if numerics.sun_streams < 2 * FEW_STREAMS or depth.shape[0] <= WINDOW:
            return solve(depth, *most)
        few = solve(depth, FEW_STREAMS, FEW_MOMENTS, FEW_MOMENTS)
        coarse = coarse_thickness(depth, numerics.per_octave)
        more = solve(coarse, *most) - solve(coarse, FEW_STREAMS, FEW_MOMENTS, FEW_MOMENTS)
        result: Array = few + np.einsum("ts,mnsv->mntv", from_coarse(depth.shape[0], numerics.per_octave), more)
        return result

    def _layers(self, depth: Array, albedo: Array, moments: Array, extras: Sequence[float]) -> LayerOperators:
        solve = solve_layers_two_stream if self.closed_form else solve_layers
        return solve(depth, albedo, moments, np.array(extras), self.where.count)


def _to_lower_air(where: ColumnDirections, depth: Array, albedo: Array, moments: Array) -> Array:
    """Return the transmittance (T, V) of :attr:`CloudSlab.to_lower_air`."""
    if where.sun is None:
        return np.zeros_like(depth)
    peak = extended_moments(moments, PEAK_DEGREE + 1)[PEAK_DEGREE]
    slant = 1.0 / where.mu[VIEW] + 1.0 / where.mu_sun
    result: Array = np.exp(-depth * (1.0 - albedo * peak) * slant)
    return result


def _sunlight(
    where: ColumnDirections, sun: int, solved: LayerOperators, brdf: Array, btdf: Array
) -> tuple[Array, Array, Array]:
    """Return kernels (T, D, V) for reflected and transmitted sunlight, and the direct transmittance (T, V).

    ``sun`` is the place of the sun among the directions of the solution.
    """
    count, size = brdf.shape
    if where.sun is None:
        nothing = np.zeros((count, 1 + where.count, size))
        return nothing, nothing, np.zeros((count, size))
    streams = range(solved.mu.size - where.count, solved.mu.size)
    back, through = (
        np.concatenate((toward_view[..., None], kernels[:, :, streams, sun]), axis=-1)
        for toward_view, kernels in ((brdf, solved.reflection), (btdf, solved.transmission))
    )
    return np.moveaxis(back, 1, -1), np.moveaxis(through, 1, -1), solved.direct[:, :, sun]
