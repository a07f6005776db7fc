"""Solver of one cloud layer: operators on grids of thickness and of wavenumber, interpolated to those asked for.

For few thicknesses, operators are solved for these.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.result_cache import ArrayMemory
from hcss_twin.models.radiance.physical.cloud_slab import CloudSlab, LayerOptics, closed
from hcss_twin.models.radiance.physical.directions import VIEW, ColumnDirections
from hcss_twin.models.radiance.physical.numerics import Numerics
from hcss_twin.models.radiance.physical.operator_table import (
    WINDOW,
    OperatorTable,
    SpectralSteps,
    spectral_steps,
    thickness_grid,
)
from hcss_twin.models.radiance.physical.slab_operators import SUN_REFLECTION, SlabOperators, solves_alone
from hcss_twin.physics.multiple_scattering.forward_peak import once_back_kernel, path_back
from hcss_twin.physics.multiple_scattering.phase_function import delta_m, extended_moments
from hcss_twin.providers import CloudLayer

FEW_THICKNESSES = 3
"""As many thicknesses, each with its own chain of doublings, cost no more than a grid."""

MANY_WAVENUMBERS = 256
"""Spectra of so many are asked for again, at other thicknesses: a grid for all costs twice as much as one."""

MANY_VIEWS = 10
"""More views, of pixels with a thickness each, share one grid."""

KEPT_MOMENTS = 129
"""Moments for light that the sea mirrors; the last one is the share of the forward peak."""

UNLIT_WEIGHT = 0.3
"""Weight of changes of the properties where the sun is faint: reflection matters little beside emission."""


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
    coupled : bool
        Whether other layers may lie above or below.
    memory : ArrayMemory
        Keeps solved layers for scenes with the same clouds: they do not depend on sea and air.
    """

    def __init__(
        self,
        optics: LayerOptics,
        numerics: Numerics,
        wavenumber_cm1: Array,
        directions: ColumnDirections,
        sun_share: Callable[[Array], Array],
        closed_form: bool,
        coupled: bool,
        memory: ArrayMemory,
    ) -> None:
        self._memory = memory
        self._closed_form, self._coupled = closed_form, coupled
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

    @property
    def solves_alone(self) -> bool:
        """Whether it is solved without those that differ from it in the sun."""
        return solves_alone(self._numerics, self._directions)

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
        scattering = self._optics.single_scattering(layer.microphysics, self._wavenumber)
        moments = extended_moments(scattering.moments, KEPT_MOMENTS if self._directions.sun is not None else 0)
        slabs = []
        for t, operators in enumerate(self._operators(layer, thickness_m.tolist(), together, toward)):
            thickness = float(thickness_m[t])
            *rows, back, through, beam, to_lower_air, turned, coupled, between = operators
            emissivity, far, direct, reflection, transmission = closed(*rows)
            slabs.append(
                CloudSlab(
                    base_m=(max(float(tops[t]) - thickness, 0.0),),  # rounding of a fog as deep as its top is high
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
                    coupled_beams=coupled,
                    between_streams=between,
                    optical_thickness=thickness * scattering.extinction_m1,
                    albedo=scattering.albedo,
                    moments=moments,
                )
            )
        return slabs

    def _operators(
        self, layer: CloudLayer, thickness_m: list[float], together: Sequence[SlabSolver], toward: Sequence[SlabSolver]
    ) -> Iterator[tuple[Array, ...]]:
        """Yield the operators of each thickness, in the order of :class:`CloudSlab`."""
        known = [h for of, h in self._single if of == layer]
        many = len({*known, *thickness_m}) > FEW_THICKNESSES or len(self.views_at_once) > MANY_VIEWS
        many = many or self._wavenumber.size > MANY_WAVENUMBERS
        if layer not in self._tables and many:
            grid = thickness_grid(layer.thickness_min_m, layer.thickness_max_m, self._numerics.per_octave)
            solvers = [solver for solver in together if layer not in solver._tables]
            steps, solved = self._solve(layer, grid, solvers, toward)
            for solver, operators in zip(solvers, solved, strict=True):
                solver._tables[layer] = steps, OperatorTable(grid, operators, self._numerics.per_octave)
        known_table = self._tables.get(layer)
        within = (0.0, 0.0) if known_table is None else (known_table[1].least_m, known_table[1].most_m)
        beyond = [h for h in thickness_m if not within[0] <= h <= within[1]]
        new = [h for h in beyond if (layer, h) not in self._single]
        for some in (new[first : first + WINDOW] for first in range(0, len(new), WINDOW)):  # more would be a grid
            solvers = [solver for solver in together if any((layer, h) not in solver._single for h in some)]
            steps, every = self._solve(layer, np.array(some), solvers, toward)
            for solver, operators in zip(solvers, every, strict=True):
                every_h = (tuple(array[n] for array in operators) for n in range(len(some)))
                solver._single |= {
                    (layer, h): solver._spread(steps, layer, h, of_h) for h, of_h in zip(some, every_h, strict=True)
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
        scattering, where = self._optics.single_scattering(layer.microphysics, wavenumber_cm1), self._directions
        scaled = delta_m(
            scattering.extinction_m1[None], scattering.albedo, scattering.moments, self._numerics.sun_moments
        )
        toward = where.mu[VIEW : VIEW + 1], where.mu_sun, np.array([where.relative_azimuth])
        return once_back_kernel(scaled, scattering.albedo, scattering.moments, *toward)[:, 0], scaled.thickness[0]

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
            faint = np.stack([solver._is_faint(wavenumber_cm1) for solver in solvers])
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
        layers = thickness_m[:, None] * scattering.extinction_m1, scattering.albedo, scattering.moments
        digest = hashlib.sha256(repr((self._numerics, self._closed_form, self._coupled, steps.below is None)).encode())
        faint = [solver._is_faint(steps.wavenumber_cm1) for solver in every]
        for solver, own_faint in zip(every, faint, strict=True):
            where = solver._directions
            digest.update(repr((where.sun, where.relative_azimuth)).encode())
            for array in (where.mu, own_faint):
                digest.update(array.tobytes())
        for array in layers:
            digest.update(np.ascontiguousarray(array).tobytes())

        def compute() -> list[tuple[Array, ...]]:
            where = [solver._directions for solver in every]
            solution = SlabOperators(
                self._numerics, self._closed_form, self._memory, where, faint, self._coupled, self.views_at_once
            )
            result = solution.of(*layers)
            if steps.below is not None and self._directions.sun is not None:
                for solver, arrays in zip(every, result, strict=True):
                    once = solver._scattered_once(layer, steps.wavenumber_cm1)
                    arrays[SUN_REFLECTION][:, 0] -= solver._reflected_once(*once, thickness_m)
            return result

        wanted = [every.index(solver) for solver in solvers]
        return steps, self._memory.get_or_compute_some(digest.digest(), wanted, compute)
