"""The sea below several cloud layers: their shadows, and what of them it mirrors; see :mod:`hcss_light.sea`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcss_light.sea import STEP, Sea, add_paths, between
from hcss_light.slices import RAYS, Field, march
from hcss_light.source import Direction
from hcss_light.stack import Stack
from hcss_light.stacked_source import StackedGroup
from hcss_twin.providers import Array


@dataclass(frozen=True)
class StackedPaths:
    """Cloud over the sea points of lines of sight; ``to_sun_m`` (L, R, y, x), ``densities`` of each layer."""

    to_sun_m: Field | None
    densities: tuple[Field, ...]


class StackedSea:
    """Geometry of the sea points of lines of sight below a stack.

    Parameters
    ----------
    step : int
        Points from one column of cloud to the next that the sea mirrors.
    """

    def __init__(self, stack: Stack, sun: Direction | None, step: int = STEP) -> None:
        self._stack, self._sun, self._step = stack, sun, step
        of_layers = [
            Sea(slices, stack.view, sun, reference)
            for slices, reference in zip(stack.layers, stack.references_m, strict=True)
        ]
        self._moves = [layer.to_sun for layer in of_layers]
        self.reach: tuple[tuple[int, int], ...] = tuple(
            map(tuple, np.max([layer.reach for layer in of_layers], axis=0).tolist())
        )

    def paths(self, densities: Sequence[Field], shaded: bool) -> StackedPaths:
        """Return the cloud over the sea points of lines of sight through points of clouds (Z, y, x) of each layer."""
        to_sun = None
        if shaded and self._sun is not None:
            to_sun = np.zeros((len(densities), RAYS, *densities[0].shape[1:]), dtype=np.float32)
            for path, density, moves, slices in zip(to_sun, densities, self._moves, self._stack.layers, strict=True):
                # A sun so low that its shadows come from too far casts none of this layer.
                if moves is not None:
                    add_paths(density, moves, path)
                    path *= np.float32(slices.height_m)
        step = self._step
        return StackedPaths(to_sun, tuple(np.ascontiguousarray(density[:, ::step, ::step]) for density in densities))

    def change(self, paths: StackedPaths, group: StackedGroup, shape: Sequence[int]) -> Array:
        """Return what clouds change (y, x) in the radiance of the sea of a group of wavenumbers."""
        result, around, stack = np.zeros(tuple(shape)), group.around, self._stack
        if paths.to_sun_m is not None and around.glint > 0.0 and self._sun is not None:
            up = float(self._sun.vector[2])
            depth = np.tensordot(np.array(group.scaled_m1, dtype=np.float32) / up, paths.to_sun_m, axes=1)
            result -= around.glint * (1.0 - np.mean(np.exp(-depth), axis=0))
        if around.mirrored is not None:
            # The ray of the flat sea rises on the other side: the lowest slice comes first.
            depth = np.ascontiguousarray(stack.optical(paths.densities, group.absorbing_m1)[::-1])
            seen, nothing = np.empty(depth.shape[1:], dtype=np.float32), np.zeros((0, 1, 1), dtype=np.float32)
            shifts = stack.shifts(Direction(stack.view.zenith_deg, stack.view.azimuth_deg + 180.0))
            across = float(stack.view.vector[2])
            mirrored = around.mirrored[::-1].copy()
            march(depth, nothing, mirrored, 1.0, 1.0, across, shifts[::-1] / self._step, 0.0, seen)
            if self._step == 1:
                return result + seen
            rows, columns = between(depth.shape[1], shape[0]), between(depth.shape[2], shape[1])
            result += rows @ seen @ columns.T
        return result
