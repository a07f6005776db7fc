"""Emission, reflection and transmission operators of a cloud layer, which sum to one in every direction.

They are solved on a grid of thicknesses and interpolated; for few thicknesses, they are solved for these. In dense
spectra they are also interpolated in wavenumber.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cache
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.array_memory import ArrayMemory
from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.physical.air import Heights
from hcss_twin.models.radiance.physical.directions import VIEW, ColumnDirections
from hcss_twin.models.radiance.physical.layer_optics import LayerOptics
from hcss_twin.models.radiance.physical.numerics import Numerics
from hcss_twin.models.radiance.physical.operator_table import (
    WINDOW,
    OperatorTable,
    coarse_thickness,
    from_coarse,
    thickness_grid,
)
from hcss_twin.models.radiance.physical.spectral_steps import SpectralSteps, spectral_steps
from hcss_twin.physics.multiple_scattering.beams import solve_covered_layers, transmit_beams
from hcss_twin.physics.multiple_scattering.forward_peak import once_back_kernel, path_back
from hcss_twin.physics.multiple_scattering.layer import LayerOperators, joined, solve_layers
from hcss_twin.physics.multiple_scattering.phase_function import delta_m, extended_moments
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun, solve_sunlit_layers
from hcss_twin.physics.multiple_scattering.two_stream import solve_layers_two_stream, solve_sun_two_stream
from hcss_twin.providers import CloudLayer

FEW_STREAMS = 16
"""Streams for sunlight that are solved at every thickness of the grid."""

PEAK_DEGREE = 16
"""Light scattered by a smaller angle than polynomials of this degree resolve, some 10 deg, still illuminates the air
below a cloud."""

FEW_THICKNESSES = 3
"""As many thicknesses, each with its own chain of doublings, cost no more than a grid."""

MANY_VIEWS = 10
"""More views, of pixels with a thickness each, share one grid."""


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
    beam_reflection : ndarray (1 + M, 2, N, S)
        The same of reflection, from mode 0 on as in :class:`CoveredLayers`, for a layer below another one; for the
        uppermost, none.
    between_streams : ndarray (1 + M, 2, P, S)
        The same of reflection and transmission between the P pairs of streams of ``np.triu_indices``, float32.
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
    beam_reflection: Array
    between_streams: Array


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


SUN_REFLECTION = 5
"""Place of ``sun_reflection`` among the operators."""

UNLIT_WEIGHT = 0.3
"""Weight of changes of the properties where the sun is faint: reflection matters little beside emission."""

Faint = Sequence[NDArray[np.bool_]]
"""Where sunlight is faint (V,), for each of several solvers."""


class SlabSolver:
    """Solver for layers of one optics provider and one set of directions.

    Parameters
    ----------
    optics : LayerOptics
    numerics : Numerics
    wavenumber_cm1 : ndarray (V,)
    directions : ColumnDirections
    sun_share : callable
        Returns of wavenumbers (V,) the sunlight reflected by a white plane, relative to the Planck radiance of a cold
        sea.
    closed_form : bool
        Whether clouds are solved by the two-stream closed form.
    memory : ArrayMemory
        Keeps solved layers for scenes with the same clouds: they do not depend on sea and air.
    uppermost_m : float
        Top of the uppermost layer.
    """

    def __init__(
        self,
        optics: LayerOptics,
        numerics: Numerics,
        wavenumber_cm1: Array,
        directions: ColumnDirections,
        sun_share: Callable[[Array], Array],
        closed_form: bool,
        memory: ArrayMemory,
        uppermost_m: float,
    ) -> None:
        self._memory = memory
        self._uppermost_m = uppermost_m
        self._closed_form = closed_form
        self._sun_share = sun_share
        self._once: dict[CloudLayer, tuple[Array, Array]] = {}
        self._tables: dict[CloudLayer, tuple[SpectralSteps, OperatorTable]] = {}
        self._single: dict[tuple[CloudLayer, float], tuple[Array, ...]] = {}
        # Cosine and azimuth relative to the sun of views whose sunlight is solved at once, for little more than one.
        self.views_at_once: tuple[tuple[float, float], ...] = ()
        self._optics = optics
        self._numerics = numerics
        self._wavenumber = wavenumber_cm1
        self._directions = directions

    def solve(
        self,
        layer: CloudLayer,
        thickness_m: Array,
        top_K: Array,
        base_K: Array,
        together: Sequence[SlabSolver],
        toward: Sequence[SlabSolver] = (),
    ) -> list[CloudSlab]:
        """Return ``layer`` at every thickness, one column for each.

        For more than a few thicknesses, operators are solved once, on a logarithmic grid of thicknesses, and
        interpolated in ln(thickness); row sums are preserved, because the interpolation weights sum to one.

        Parameters
        ----------
        thickness_m : ndarray (T,)
            Above 0, each once.
        top_K, base_K : ndarray (T,)
            Temperatures of the two faces.
        together : sequence of SlabSolver
            This solver, and those that differ from it in the sun's position only and will be asked for the same layer:
            the diffuse light of all of them is solved once.
        toward : sequence of SlabSolver
            Solvers that differ in the view only, this one among them, if there is one sun: all of them are solved at
            once, and the memory keeps what solvers of the same views will ask for.
        """
        tops = layer.cloud_top_m(thickness_m)
        slabs = []
        for t, operators in enumerate(self._operators(layer, thickness_m.tolist(), together, toward)):
            thickness = float(thickness_m[t])
            *rows, back, through, beam, to_lower_air, turned, turned_back, between = operators
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
                    beam_reflection=turned_back,
                    between_streams=between,
                )
            )
        return slabs

    def _operators(
        self, layer: CloudLayer, thickness_m: list[float], together: Sequence[SlabSolver], toward: Sequence[SlabSolver]
    ) -> Iterator[tuple[Array, ...]]:
        """Yield the operators of each thickness, in the order of :class:`CloudSlab`."""
        known = [h for of, h in self._single if of == layer]
        many = len({*known, *thickness_m}) > FEW_THICKNESSES or len(self.views_at_once) > MANY_VIEWS
        if layer not in self._tables and many:
            grid = thickness_grid(layer.thickness_min_m, layer.thickness_max_m, self._numerics.per_octave)
            solvers = [each for each in together if layer not in each._tables]
            steps, solved = self._solve(layer, grid, solvers, toward)
            for solver, operators in zip(solvers, solved, strict=True):
                solver._tables[layer] = steps, OperatorTable(grid, operators, self._numerics.per_octave)
        known_table = self._tables.get(layer)
        within = (0.0, 0.0) if known_table is None else (known_table[1].least_m, known_table[1].most_m)
        beyond = [h for h in thickness_m if not within[0] <= h <= within[1]]
        new = [h for h in beyond if (layer, h) not in self._single]
        for some in (new[first : first + WINDOW] for first in range(0, len(new), WINDOW)):  # more would be a grid
            solvers = [each for each in together if any((layer, h) not in each._single for h in some)]
            own, every = self._solve(layer, np.array(some), solvers, toward)
            for solver, each in zip(solvers, every, strict=True):
                every_h = (tuple(array[n] for array in each) for n in range(len(some)))
                solver._single |= {
                    (layer, h): solver._spread(own, layer, h, of_h) for h, of_h in zip(some, every_h, strict=True)
                }
        for h in thickness_m:
            if known_table is None or h in beyond:
                yield self._single[layer, h]
            else:
                yield self._spread(known_table[0], layer, h, known_table[1].at(h))

    def _spread(
        self, steps: SpectralSteps, layer: CloudLayer, thickness_m: float, operators: tuple[Array, ...]
    ) -> tuple[Array, ...]:
        """Return operators at all wavenumbers; sunlight scattered once toward the view is not interpolated."""
        if steps.below is None:
            return operators
        result = tuple(map(steps.spread, operators))
        if self._directions.sun is not None:
            if layer not in self._once:
                self._once[layer] = self._scattered_once(layer, self._wavenumber)
            result[SUN_REFLECTION][0] += self._reflected_once(*self._once[layer], np.array([thickness_m]))[0]
        return result

    def _scattered_once(self, layer: CloudLayer, wavenumber_cm1: Array) -> tuple[Array, Array]:
        """Return the kernel (V,) of sunlight scattered once toward the view, and scaled extinction (V,), m-1."""
        own, where = self._optics.single_scattering(layer.microphysics, wavenumber_cm1), self._directions
        scaled = delta_m(own.extinction_m1[None], own.albedo, own.moments, self._numerics.sun_moments)
        toward = where.mu[VIEW : VIEW + 1], where.mu_sun, np.array([where.relative_azimuth])
        return once_back_kernel(scaled, own.albedo, own.moments, *toward)[:, 0], scaled.thickness[0]

    def _reflected_once(self, kernel: Array, extinction_m1: Array, thickness_m: Array) -> Array:
        """Return the reflectance (T, V) of sunlight scattered once toward the view, sr-1."""
        where = self._directions
        return kernel * path_back(thickness_m[:, None] * extinction_m1, where.mu[VIEW : VIEW + 1], where.mu_sun)

    def _is_faint(self, wavenumber_cm1: Array) -> NDArray[np.bool_]:
        """Whether the closed form with its error of about 15 % suffices for sunlight (V,)."""
        return (self._sun_share(wavenumber_cm1) <= self._numerics.faint_sun) | self._closed_form

    def _steps(self, layer: CloudLayer, solvers: Sequence[SlabSolver]) -> SpectralSteps:
        """Return the wavenumbers at which a layer is solved."""
        tolerance = 0.0 if self._closed_form else self._numerics.between_wavenumbers

        def properties(wavenumber_cm1: Array) -> Array:
            faint = np.stack([each._is_faint(wavenumber_cm1) for each in solvers])
            weight = np.where(np.all(faint, axis=0), UNLIT_WEIGHT, 1.0)
            return np.concatenate((weight * self._optics.curves(layer.microphysics, wavenumber_cm1), faint))

        return spectral_steps(self._wavenumber, properties, tolerance)

    def _solve(
        self, layer: CloudLayer, thickness_m: Array, solvers: Sequence[SlabSolver], toward: Sequence[SlabSolver]
    ) -> tuple[SpectralSteps, list[tuple[Array, ...]]]:
        """Return a layer's operators for each solver, with thickness as first axis, as in :class:`CloudSlab`."""
        every = toward or solvers
        steps = self._steps(layer, every)
        scattering = self._optics.single_scattering(layer.microphysics, steps.wavenumber_cm1)
        own = thickness_m[:, None] * scattering.extinction_m1, scattering.albedo, scattering.moments
        is_covered = layer.top_m < self._uppermost_m and not self._closed_form and self._directions.sun is not None
        digest = hashlib.sha256(repr((self._numerics, self._closed_form, is_covered, steps.below is None)).encode())
        faint = [each._is_faint(steps.wavenumber_cm1) for each in every]
        for each, own_faint in zip(every, faint, strict=True):
            where = each._directions
            digest.update(repr((where.sun, where.relative_azimuth)).encode())
            for array in (where.mu, own_faint):
                digest.update(array.tobytes())
        for array in own:
            digest.update(np.ascontiguousarray(array).tobytes())

        def compute() -> list[tuple[Array, ...]]:
            covered = self._covered(*own, every, faint, self._numerics.turned_modes if is_covered else 0)
            operators = zip(self._new_operators(*own, every, faint), covered, strict=True)
            result = [tuple(chain.from_iterable(each)) for each in operators]
            if steps.below is not None and self._directions.sun is not None:
                for each, arrays in zip(every, result, strict=True):
                    once = each._scattered_once(layer, steps.wavenumber_cm1)
                    arrays[SUN_REFLECTION][:, 0] -= each._reflected_once(*once, thickness_m)
            return result

        wanted = [every.index(each) for each in solvers]
        return steps, self._memory.get_or_compute_some(digest.digest(), wanted, compute)

    def _new_operators(
        self, depth: Array, albedo: Array, moments: Array, solvers: Sequence[SlabSolver], faint: Faint
    ) -> Iterator[tuple[Array, ...]]:
        """Yield the operators of layers with optical thickness (T, V) for each solver."""
        views, suns = _distinct(solvers)
        solved, kernels, turned = self._solved(depth, albedo, moments, solvers, faint)
        extras = solved.mu.size - self._directions.count
        streams = range(extras, solved.mu.size)
        factor = 2.0 * np.pi * self._directions.streams.mu * self._directions.streams.weight

        @cache
        def diffuse(view: int) -> tuple[Array, ...]:
            rows = [view, *streams]
            # (T, V, D, N) -> (T, D, N, V)
            kernels = (each[:, :, rows, extras:] * factor for each in (solved.reflection, solved.transmission))
            shares = (each[:, :, rows] for each in (solved.emissivity, solved.far_share, solved.direct))
            return tuple(np.ascontiguousarray(np.moveaxis(each, 1, -1)) for each in (*shares, *kernels))

        for number, solver in enumerate(solvers):
            view, sun = number % len(views), len(views) + number % len(suns)
            where = solver._directions
            back, through, beam = _sunlight(where, sun, solved, *kernels[number])
            lower = _to_lower_air(where, depth, albedo, moments)
            beams = turned[:, :, [view, sun]]
            beams[..., faint[number]] = 0.0
            yield *diffuse(view), back, through, beam, lower, beams

    def _covered(
        self, depth: Array, albedo: Array, moments: Array, solvers: Sequence[SlabSolver], faint: Faint, modes: int
    ) -> Iterator[tuple[Any, ...]]:
        """Yield the last two operators of :class:`CloudSlab` for each solver, on a grid one row per octave."""
        if depth.shape[0] > WINDOW:
            depth = depth[:: self._numerics.per_octave]
        count, (views, suns) = self._directions.count, _distinct(solvers)
        beams = np.zeros((depth.shape[0], modes, len(views) + len(suns), count, albedo.size))
        between = np.zeros((depth.shape[0], modes, 2, count * (count + 1) // 2, albedo.size), dtype=np.float32)
        bright = ~np.all(faint, axis=0)
        if modes and np.any(bright):
            own = depth[:, bright], albedo[bright], moments[:, bright]
            solved = solve_covered_layers(*own, np.array([*views, *suns]), count, modes)
            beams[..., bright] = solved.beams.transpose(1, 0, 4, 3, 2)
            between[..., bright] = solved.streams.transpose(2, 0, 1, 4, 3)
        for number in range(len(solvers)):
            own_beams = beams[:, :, [number % len(views), len(views) + number % len(suns)]]
            own_beams[..., faint[number]] = 0.0
            yield own_beams, between

    def _solved(
        self, depth: Array, albedo: Array, moments: Array, solvers: Sequence[SlabSolver], faint: Faint
    ) -> tuple[LayerOperators, Array, Array]:
        """Return diffuse operators, brdf and btdf (solvers, 2, T, V), and modes (T, M, views + suns, N, V).

        The modes are the diffuse transmission of view and sun beams toward the streams. Sunlight is 0 without a sun;
        its modes are 0 where it is faint.
        """
        where, numerics, (views, suns) = self._directions, self._numerics, _distinct(solvers)
        kernels, extras = np.zeros((len(solvers), 2, *depth.shape)), [*views, *suns]
        turned = np.zeros((depth.shape[0], numerics.turned_modes - 1, len(extras), where.count, albedo.size))
        if where.sun is None:
            return self._layers(depth, albedo, moments, views), kernels, turned
        bright = ~np.all(faint, axis=0)
        if not np.any(bright):
            solved = self._layers(depth, albedo, moments, extras)
        else:
            solved = self._lit(depth, albedo, moments, solvers, extras, bright, kernels, turned)
        for solver, own, kernel in zip(solvers, faint, kernels, strict=True):
            each = solver._directions
            if np.any(own):
                toward = each.mu[VIEW : VIEW + 1], each.mu_sun, np.array([each.relative_azimuth])
                layer = depth[:, own], albedo[own], moments[:, own]
                kernel[:, :, own] = np.stack(solve_sun_two_stream(*layer, *toward, streams=where.count))[..., 0]
        return solved, kernels, turned

    def _lit(
        self,
        depth: Array,
        albedo: Array,
        moments: Array,
        solvers: Sequence[SlabSolver],
        extras: Sequence[float],
        bright: NDArray[np.bool_],
        kernels: Array,
        turned: Array,
    ) -> LayerOperators:
        """Return diffuse operators, and write kernels and modes where the sun is ``bright``, as for :meth:`_solved`."""
        where, numerics, faint = self._directions, self._numerics, ~bright
        own = depth[:, bright], albedo[bright], moments[:, bright]
        if self.solves_alone:
            modes, turned_modes = numerics.azimuth_modes, numerics.turned_modes
            lit = solve_sunlit_layers(
                *own, extras[0], where.mu_sun, where.relative_azimuth, where.count, modes, turned_modes
            )
            kernels[0, 0][:, bright], kernels[0, 1][:, bright] = lit.brdf, lit.btdf
            beams, solved = lit.beams, lit.layers
            if np.any(faint):
                solved = joined(solved, self._layers(depth[:, faint], albedo[faint], moments[:, faint], extras), bright)
        else:
            solved = self._layers(depth, albedo, moments, extras)
            kernels[..., bright] = self._toward_views(*own, solvers)
            beams = transmit_beams(*own, np.array(extras), where.count, numerics.turned_modes)
        turned[..., bright] = beams.transpose(1, 0, 4, 3, 2)
        return solved

    @property
    def solves_alone(self) -> bool:
        """Whether sunlight has the streams of diffuse light, which are solved for one sun at a time."""
        numerics, streams = self._numerics, self._directions.count
        return (numerics.sun_streams, numerics.sun_moments) == (streams, 2 * streams)

    def _toward_views(self, depth: Array, albedo: Array, moments: Array, solvers: Sequence[SlabSolver]) -> Array:
        """Return brdf and btdf (solvers, 2, T, V), for one view and all suns, or for one sun and all views.

        By reciprocity those of several suns are those of a sun in the direction of the view, toward the suns: all are
        solved at once. Many streams are solved at one thickness per octave: their difference from few streams is small
        and smooth.
        """
        views, suns = _distinct(solvers)
        azimuths = [each._directions.relative_azimuth for each in solvers]
        one_view = len(suns) > 1 or not self.views_at_once
        source = views[0] if one_view else suns[0]
        own = list(zip(suns if one_view else views, azimuths, strict=True))
        every = own if one_view else self.views_at_once
        sizes = self._numerics.sun_streams, self._numerics.sun_moments, self._numerics.azimuth_modes
        digest = hashlib.sha256(repr((sizes, tuple(every), source)).encode())
        for array in (depth, albedo, moments):
            digest.update(np.ascontiguousarray(array).tobytes())

        def compute() -> tuple[Array, ...]:
            cosines, turned = zip(*every, strict=True)
            return (self._sunlight_between(depth, albedo, moments, cosines, source, turned),)

        return self._memory.get_or_compute(digest.digest(), compute)[0][[every.index(each) for each in own]]

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
        numerics, toward = self._numerics, (np.array(mu), mu_source, np.array(azimuths))

        def solve(depth: Array, streams: int, kept: int, modes: int) -> Array:
            kernels = np.stack(solve_sun(depth, albedo, moments, *toward, streams, modes, kept_moments=kept))
            return np.moveaxis(kernels, -1, 0)

        most = numerics.sun_streams, numerics.sun_moments, numerics.azimuth_modes
        if numerics.sun_streams < 2 * FEW_STREAMS or depth.shape[0] <= WINDOW:
            return solve(depth, *most)
        few = solve(depth, FEW_STREAMS, FEW_STREAMS, FEW_STREAMS)
        coarse = coarse_thickness(depth, numerics.per_octave)
        more = solve(coarse, *most) - solve(coarse, FEW_STREAMS, FEW_STREAMS, FEW_STREAMS)
        result: Array = few + np.einsum("ts,mnsv->mntv", from_coarse(depth.shape[0], numerics.per_octave), more)
        return result

    def _layers(self, depth: Array, albedo: Array, moments: Array, extras: Sequence[float]) -> LayerOperators:
        solve = solve_layers_two_stream if self._closed_form else solve_layers
        return solve(depth, albedo, moments, np.array(extras), self._directions.count)


def _distinct(solvers: Sequence[SlabSolver]) -> tuple[list[float], list[float]]:
    """Return cosines of the views and of the suns of solvers that differ in one of them only: one, or one for each."""
    every = [each._directions for each in solvers]
    one_view = all(each.mu[VIEW] == every[0].mu[VIEW] for each in every)
    views, suns = [float(each.mu[VIEW]) for each in every], [each.mu_sun for each in every]
    return (views[:1], suns) if one_view else (views, suns[:1])


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


def _closed(
    emissivity: Array, far: Array, direct: Array, reflection: Array, transmission: Array
) -> tuple[Array, Array, Array, Array, Array]:
    """Normalise row sums to one; clipping negative interpolated values changes them by about 1e-7."""
    whole = emissivity + direct + np.sum(reflection, axis=1) + np.sum(transmission, axis=1)
    emissivity, far, direct = (each / whole for each in (emissivity, far, direct))
    reflection, transmission = (each / whole[:, None] for each in (reflection, transmission))
    return emissivity, far, direct, reflection, transmission
