"""Our models of light on the cases of the benchmark: ``columns``, ``slant`` and ``source``.

As in scenes, the radiance of uniform clouds is that of plane-parallel columns, here of the file of the case, and what
the tiers add is the difference between broken and uniform cloud by their own method.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from hcss_light.bands import Group
from hcss_light.cases.case import Case
from hcss_light.scattered import share_and_change
from hcss_light.sea import Sea
from hcss_light.slices import HIGHEST_SLICE_OPTICAL_THICKNESS, LEAST_SLICES, Field, Slices, paths
from hcss_light.source import Direction, Particles, Surroundings
from hcss_light.stack import Stack
from hcss_light.stacked_source import StackedGroup, stacked_radiance, stacked_source
from hcss_light.transport import GroupLight
from hcss_light.voxels import LightError
from hcss_twin.providers import Array


def columns(case: Case, band: int, view: int) -> Array:
    """Return the radiance (X, Y) of independent columns."""
    return np.asarray(case.column_radiance[band, view][case.column_of])


def slant(case: Case, band: int, view: int) -> Array:
    """Return the radiance (X, Y) of slanted rays.

    Raises
    ------
    LightError
        If the case has several layers.
    """
    clouds = Clouds(case, band, view)
    if len(clouds.layers) > 1:
        raise LightError(f"model 'slant': case {case.name} has {len(clouds.layers)} layers; allowed: 1")
    return _of_one_layer(clouds, "slant")


def source(case: Case, band: int, view: int) -> Array:
    """Return the radiance (X, Y) of light that is scattered many times between the parts of broken cloud."""
    clouds = Clouds(case, band, view)
    return _of_one_layer(clouds, "source") if len(clouds.layers) == 1 else _of_layers(clouds)


MODELS: dict[str, Callable[[Case, int, int], Array]] = {"columns": columns, "slant": slant, "source": source}
"""Models by their name, which is a value of ``radiance.light``."""


@dataclass(frozen=True)
class CloudLayer:
    """One layer in slices: densities (Z, x, y) of the clouds, and (Z, 1, N) of the uniform ones."""

    slices: Slices
    level: NDArray[np.intp]
    """Level (Z,) of each slice."""
    particles: Particles
    density: Field
    uniform: Field


@dataclass(frozen=True)
class Clouds:
    """A case in one band, seen along one view, in slices."""

    case: Case
    band: int
    view: int

    @property
    def toward(self) -> Direction:
        """The view."""
        return self.case.views[self.view]

    @property
    def sun(self) -> Direction | None:
        """The sun, if it shines in the band."""
        return self.case.sun if self.case.is_sunlit(self.band) else None

    @cached_property
    def layers(self) -> list[CloudLayer]:
        """The layers from the lowest on."""
        return [self._layer(kind) for kind in np.unique(self.case.kind).tolist()]

    def _layer(self, kind: int) -> CloudLayer:
        case, band = self.case, self.band
        (levels,) = np.nonzero((case.kind == kind) & np.any(case.columns > 0.0, axis=0))
        edges = case.edges_m[levels[0] : levels[-1] + 2]
        relative, albedo, moments = case.relative[kind, band], case.albedo[kind, band], case.moments[kind, band]
        most = float(np.max(case.columns[:, levels]))
        particles = Particles(most * float(relative), float(albedo), moments)
        steepest = max([self.toward.zenith_deg, *([] if self.sun is None else [self.sun.zenith_deg])])
        height = float(edges[-1] - edges[0])
        needed = max(
            LEAST_SLICES,
            height * math.tan(math.radians(steepest)) / case.size_m[0],
            particles.scaled[0] * height / HIGHEST_SLICE_OPTICAL_THICKNESS,
        )
        # An even number of slices in each level, as layers above each other need.
        parts = 2 * math.ceil(needed / (2.0 * levels.size) - 1e-9)
        slices = Slices(float(edges[0]), float(edges[-1]), parts * levels.size, "base", case.size_m[0])
        level = np.repeat(levels, parts)
        density = np.moveaxis(case.extinction_m1[..., level] / most, 2, 0).astype(np.float32, order="C")
        uniform = (case.columns[:, level].T[:, None, :] / most).astype(np.float32, order="C")
        return CloudLayer(slices, level, particles, density, uniform)

    def around(self, level: NDArray[np.intp]) -> Surroundings:
        """Return the light around clouds in slices of these levels."""
        emitted = self.case.black(self.band, self.case.temperature_K[level])
        ground = float(self.case.black(self.band, self.case.surface_K))
        irradiance = 0.0 if self.sun is None else float(self.case.irradiance[self.band])
        return Surroundings(emitted, 0.0, ground, np.full(level.size, irradiance), np.zeros(level.size))

    def corrected(self, amounts_m: Array, total: Array, uniform: Array, dark: Array) -> Array:
        """Return the radiance of columns with the amounts (L, x, y) of cloud on lines of sight, and what is added.

        Parameters
        ----------
        total : ndarray (x, y)
            Of broken cloud by a tier.
        uniform, dark : ndarray (N,)
            Of uniform clouds by this tier, and of these without the sun.
        """
        known = [np.sum(layer.uniform, axis=0)[0] * layer.slices.height_m for layer in self.layers]
        nodes = [np.unique(np.round(amount, 6)) for amount in known]
        shape = [node.size for node in nodes]
        amount = [np.clip(own, node[0], node[-1]) for own, node in zip(amounts_m, nodes, strict=True)]
        places = np.stack(amount, axis=-1)
        tables = [
            RegularGridInterpolator(nodes, values.reshape(shape))(places)
            for values in (self.case.column_radiance[self.band, self.view], uniform, dark)
        ]
        share, change = share_and_change(total[None], tables[1][None], tables[2][None], np.zeros(1))
        return np.asarray((share * tables[0] + change)[0])


def _of_one_layer(clouds: Clouds, tier: str) -> Array:
    (layer,), view, reference = clouds.layers, clouds.toward, clouds.case.reference_m
    group = Group(layer.particles, clouds.around(layer.level), np.empty(0, dtype=np.intp))
    light = GroupLight(tier, layer.slices, group, view, clouds.sun, reference)
    sea, uniform = Sea(layer.slices, view, clouds.sun, reference).apart(), layer.uniform
    nothing = sea.paths(uniform, False)
    light.fit(uniform)
    of_uniform = light.apart(uniform, sea, nothing)
    dark = of_uniform if clouds.sun is None else light.at_night().apart(uniform, sea, nothing)
    amount, total = light.radiance(layer.density)
    return clouds.corrected(amount[None], total, of_uniform, dark)


def _of_layers(clouds: Clouds) -> Array:
    layers, view, sun = clouds.layers, clouds.toward, clouds.sun
    stack = Stack(tuple(layer.slices for layer in layers), (clouds.case.reference_m,) * len(layers), view)
    level = np.clip(np.searchsorted(clouds.case.edges_m, stack.middle_m) - 1, 0, clouds.case.kind.size - 1)
    group = StackedGroup(tuple(layer.particles for layer in layers), clouds.around(level))
    night = replace(group, around=replace(group.around, sunlight=np.zeros(stack.count)))

    def seen(own_stack: Stack, own: StackedGroup, densities: list[Field], lit: Direction | None, wide: int) -> Array:
        light = stacked_source(own_stack, densities, own, lit, None, wide)
        return stacked_radiance(own_stack, own_stack.optical(densities, own.scaled_m1), light, own.around.below)

    uniform, broken = [layer.uniform for layer in layers], [layer.density for layer in layers]
    of_uniform = seen(stack.apart(), group, uniform, sun, 1)[0]
    dark = of_uniform if sun is None else seen(stack.apart(), night, uniform, None, 1)[0]
    amounts, shifts = np.empty((len(layers), *broken[0].shape[1:])), stack.shifts(view)
    for amount, layer, part in zip(amounts, layers, stack.parts, strict=True):
        path = np.empty(layer.density.shape[1:], dtype=np.float32)
        paths(layer.density, layer.slices.height_m, shifts[part], path)
        amount[:] = path
    return clouds.corrected(amounts, seen(stack, group, broken, sun, 2), of_uniform, dark)
