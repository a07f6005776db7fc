"""Tier ``slant`` in several cloud layers: emission along the line of sight, and sunlight by sums of exponentials.

As :mod:`hcss_light.sums` for one layer. Each layer has weights of its own, from uniform columns of it alone; on both of
its straight paths light is also weakened by the other layers.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hcss_light.slices import Field, direct_sunlight, march
from hcss_light.source import Direction
from hcss_light.stack import Stack
from hcss_light.stacked_source import StackedGroup
from hcss_light.sums import RATES
from hcss_twin.providers import Array


def emitted_radiance(stack: Stack, depth: Field, group: StackedGroup) -> Array:
    """Return the radiance (y, x) of emission alone, of an absorbing optical thickness (Z, y, x)."""
    none = np.zeros((0, *depth.shape[1:]), dtype=np.float32)
    return _marched(stack, depth, none, group.around.emitted, group.around.below)


def stacked_integrals(stack: Stack, depth: Field, to_sun: Field, sunlight: Array) -> Array:
    """Return the integral (L, C, y, x) of each term over the clouds of each layer.

    Parameters
    ----------
    depth, to_sun : ndarray (Z, y, x)
        Optical thickness of each voxel, and of the path from it to the sun (:func:`sun_depth`).
    sunlight : ndarray (Z,)
    """
    result = np.empty((len(stack.parts), RATES.size, *depth.shape[1:]))
    none = np.zeros(stack.count)
    for rate, integrals in zip(RATES.tolist(), result.swapaxes(0, 1), strict=True):
        reached = np.exp(-rate * to_sun) * sunlight.astype(np.float32)[:, None, None]
        for part, integral in zip(stack.parts, integrals, strict=True):
            of_layer = np.zeros_like(reached)
            of_layer[part] = reached[part]
            integral[:] = _marched(stack, (rate * depth).astype(np.float32), of_layer, none, 0.0)
    return result


def sun_depth(stack: Stack, depth: Field, sun: Direction) -> Field:
    """Return the optical thickness (Z, y, x) of the path from each voxel to the sun, of its mean transmission."""
    result, shifts = np.empty_like(depth), stack.shifts(sun)
    direct_sunlight(depth, 1.0, 1.0, float(sun.vector[2]), shifts - shifts[0], True, result)
    return result


def of_sun_alone(group: StackedGroup) -> StackedGroup:
    """Return a group of which only sunlight in clouds is left."""
    dark = replace(group.around, emitted=np.zeros_like(group.around.emitted), sky=0.0, below=0.0, glint=0.0)
    return replace(group, around=dark)


def _marched(stack: Stack, depth: Field, source: Field, of_height: Array, below: float) -> Array:
    radiance = np.empty(depth.shape[1:], dtype=np.float32)
    march(depth, source, of_height, 1.0, 1.0, float(stack.view.vector[2]), stack.shifts(stack.view), below, radiance)
    return radiance.astype(np.float64)
