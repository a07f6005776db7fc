"""Light scattered many times in several cloud layers; as :mod:`hcss_light.source` for one.

Each layer has its own particles. Light that one layer emits or scatters reaches the other through the gas between them;
direct sunlight is weakened by all layers on its way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hcss_light.bands import Group, groups_of_bands
from hcss_light.orders import DIRECTIONS, EVEN, block_means, directions, henyey_greenstein_at, successive_orders
from hcss_light.slices import Field, direct_sunlight, march
from hcss_light.source import (
    BLOCK_OPTICAL_THICKNESS,
    FINE_ORDERS,
    LOW_ALBEDO,
    Direction,
    Particles,
    Surroundings,
    fine_source,
    means,
    orders_of,
)
from hcss_light.stack import Stack
from hcss_twin.providers import Array, Sun
from hcss_twin.providers.light import LightInputs


@dataclass(frozen=True)
class StackedGroup:
    """Wavenumbers of a band: particles of each layer, and the light around and between the slices of all."""

    particles: tuple[Particles, ...]
    around: Surroundings

    @property
    def scaled_m1(self) -> list[float]:
        """Extinction of each layer without the forward peak of scattering."""
        return [particle.scaled[0] for particle in self.particles]

    @property
    def absorbing_m1(self) -> list[float]:
        """Extinction of each layer by absorption alone."""
        return [particle.absorbing_m1 for particle in self.particles]


def stacked_groups(inputs: LightInputs, stack: Stack, sun: Sun | None) -> list[list[StackedGroup]]:
    """Return the groups of each band; the layer whose clouds vary most within the bands divides them."""
    layers = [
        groups_of_bands(cloud, slices.middle_m, sun) for cloud, slices in zip(inputs.stack, stack.layers, strict=True)
    ]
    divided = max(layers, key=lambda bands: sum(map(len, bands)))
    layers = [
        groups_of_bands(cloud, slices.middle_m, sun, divided)
        for cloud, slices in zip(inputs.stack, stack.layers, strict=True)
    ]
    clear = np.ones(stack.count, dtype=bool)
    for part in stack.parts:
        clear[part] = False
    edges, between = stack.edges_m, list[tuple[slice, list[list[Group]]]]()
    for first in np.flatnonzero(clear & ~np.roll(clear, 1)).tolist():
        last = first + int(np.argmin(clear[first:]))
        air = replace(inputs.layer, base_m=float(edges[first]), top_m=float(edges[last]), temperature_K=None)
        own_part = slice(first, last)
        groups_of_air = groups_of_bands(replace(inputs, layer=air), stack.middle_m[own_part], sun, divided)
        between.append((own_part, groups_of_air))
    result = []
    for band in range(len(divided)):
        groups = []
        for number in range(len(divided[band])):
            own_of = [(part, layer[band][number].around) for part, layer in zip(stack.parts, layers, strict=True)]
            every = [*own_of, *((part, groups_of_air[band][number].around) for part, groups_of_air in between)]
            joined = {}
            for name in ("emitted", "sunlight", "gas_m1", "mirrored"):
                joined[name] = np.zeros(stack.count)
                for part, around in every:
                    joined[name][part] = getattr(around, name)
            lowest, highest = own_of[0][1], own_of[-1][1]
            around = Surroundings(sky=highest.sky, below=lowest.below, glint=lowest.glint, **joined)
            groups.append(StackedGroup(tuple(layer[band][number].particles for layer in layers), around))
        result.append(groups)
    return result


def stacked_source(
    stack: Stack,
    densities: Sequence[Field],
    group: StackedGroup,
    sun: Direction | None,
    sunlight: Field | None = None,
    wide: int = 2,
) -> Field:
    """Return the source function (Z, y, x) toward the view: emission, and light scattered once and more.

    Parameters
    ----------
    densities : sequence of ndarray (Z, y, x)
        Of each layer.
    sunlight : ndarray (Z, y, x), optional
        Direct sunlight in each voxel, from :func:`stacked_sunlight`; by default clouds are continued periodically.
    wide : int
        Points along the sides of the blocks on which light is computed first.
    """
    around, view = group.around, stack.view
    flight, scaled = directions(), [particle.scaled for particle in group.particles]
    depth = stack.optical(densities, group.scaled_m1)
    lit = sun is not None and bool(np.any(around.sunlight > 0.0))
    light = np.zeros((0, *depth.shape[1:]), dtype=np.float32)
    if lit and sun is not None:
        light = stacked_sunlight(stack, depth, sun) if sunlight is None else sunlight
        light = light * around.sunlight.astype(np.float32)[:, None, None]
    of_sun, toward = np.zeros((2, len(scaled), DIRECTIONS))
    once = np.zeros(len(scaled))
    for number, (particle, (extinction, albedo, asymmetry)) in enumerate(zip(group.particles, scaled, strict=True)):
        toward[number] = henyey_greenstein_at(flight @ view.vector, asymmetry)
        toward[number] *= albedo / np.sum(toward[number])
        if lit and sun is not None:
            phase = henyey_greenstein_at(flight @ -sun.vector, asymmetry)
            of_sun[number] = phase * albedo / (4.0 * math.pi) * DIRECTIONS / np.sum(phase)
            angle = float(np.clip(-sun.vector @ view.vector, -1.0, 1.0))
            once[number] = (
                particle.albedo * particle.phase(angle) / (4.0 * math.pi) * particle.extinction_m1 / extinction
            )
    emission = around.emitted * (1.0 - np.array([albedo for _, albedo, _ in scaled])[stack.kind])
    slant = 1.0 / np.abs(flight[:, 2]) - np.sign(flight[:, 2]) / view.vector[2]
    coupled = np.stack([particle.exchanged[0] for particle in group.particles])
    turn = group.particles[0].exchanged[1]
    result, start = np.zeros((0, 1, 1), dtype=np.float32), np.zeros((DIRECTIONS, 0), dtype=np.float32)
    number_of, before = np.zeros((1, 1, 1), dtype=np.int32), (1, 1)
    for high, broad, count in _sizes(stack, scaled, wide):
        coarse, shone = (depth, light) if (high, broad) == (1, 1) else block_means(depth, light, high, broad)
        heights = stack.edges_m[high::high] - stack.edges_m[:-high:high]
        moves = np.stack([stack.entries(direction, high) for direction in flight]) / broad
        begin = (0.5 + np.arange(count * DIRECTIONS).reshape(count, DIRECTIONS, 1, 1) * EVEN) % 1.0
        first = moves[:, :1].copy()
        first[: DIRECTIONS // 2] = moves[: DIRECTIONS // 2, -1:]
        displaced = np.floor(moves - first + begin).astype(np.int64) % np.array(coarse.shape[1:])
        opaque, gas_m1 = (means(profile, high) for profile in (around.emitted, around.gas_m1))
        result, start, number_of = successive_orders(
            coarse,
            stack.kind[::high].copy(),
            high / np.abs(flight[:, 2]),
            coupled,
            turn,
            toward,
            means(emission, high),
            opaque,
            of_sun,
            shone,
            displaced,
            np.exp(-gas_m1 * heights * slant[:, None]).astype(np.float32),
            around.sky,
            around.below - around.glint,
            start,
            number_of,
            *before,
        )
        before = high, broad
    source, up = np.zeros_like(depth), 1.0 if sun is None else float(sun.vector[2])
    for part, own_once in zip(stack.parts, once.tolist(), strict=True):
        coarse = result[part.start // before[0] : part.stop // before[0]]
        own_light = light[part] if lit else light
        across = 1.0 / float(view.vector[2])
        fine_source(depth[part], own_light, coarse, *before, emission[part], own_once, across, 1.0 / up, source[part])
    return source


def stacked_sunlight(stack: Stack, depth: Field, sun: Direction) -> Field:
    """Return the direct transmission (Z, y, x) of sunlight to each voxel, through all layers above it."""
    result = np.empty_like(depth)
    shifts = stack.shifts(sun)
    direct_sunlight(depth, 1.0, 1.0, float(sun.vector[2]), shifts - shifts[0], False, result)
    return result


def stacked_radiance(stack: Stack, depth: Field, source: Field, below: float) -> Array:
    """Return the radiance (y, x) of lines of sight through all layers, of an optical thickness (Z, y, x)."""
    radiance, none = np.empty(depth.shape[1:], dtype=np.float32), np.zeros(stack.count)
    march(depth, source, none, 1.0, 1.0, float(stack.view.vector[2]), stack.shifts(stack.view), below, radiance)
    return radiance.astype(np.float64)


def _sizes(stack: Stack, scaled: Sequence[tuple[float, float, float]], wide: int) -> list[tuple[int, int, int]]:
    """Return slices and points along the sides of the blocks on which light is computed in turn, and the orders."""
    thickest = max(properties[0] * layer.height_m for properties, layer in zip(scaled, stack.layers, strict=True))
    albedo = max(properties[1] for properties in scaled)
    blocks = 2 if 2.0 * thickest <= BLOCK_OPTICAL_THICKNESS else 1, wide, orders_of(albedo)
    return [blocks] if albedo < LOW_ALBEDO else [blocks, (1, 1, FINE_ORDERS)]
