"""Radiance of frames of a scene with several cloud layers, on squares of a lattice fixed to the image."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from hcss_light.stage import Window, require_one_shape, shares_of
from hcss_twin.engine.stages.light import LightStage
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array


class StackedStage(LightStage):
    """Each frame is computed for itself; see :class:`~hcss_twin.engine.stages.light.LightStage`."""

    def __init__(self, plan: Plan, tables: RadianceTables) -> None:
        super().__init__(plan, tables)
        self._numbers = plan.cloudy_layers
        for number in self._numbers:
            require_one_shape(plan, number)

    def _square(self, extent: Window, clouds: Any) -> tuple[Array, Array, Array]:
        """Return amounts (L, y, x), share and change of radiance (B, y, x) of the points of a square."""
        assert self._instant is not None
        time_s = self._instant[0]
        assert isinstance(time_s, float)  # the key of frames of a grid on the ground
        plan, samples = self._plan, self._plan.samples_per_pixel
        transport: Any = self._transport
        near = [tuple(-(-points // samples) for points in both) for both in transport.reach_of_light]
        window = self.around(extent, self._reach)
        layers = clouds.thickness_m(window)
        thickness = [layers[number] for number in self._numbers]
        shares = [
            shares_of(plan, number, time_s, window, layer_thickness, edges)
            for number, layer_thickness, edges in zip(self._numbers, thickness, transport.edges_m, strict=True)
        ]
        inner = [
            slice((far - low) * samples, (far + span.stop - span.start + high) * samples)
            for span, (far, _), (low, high) in zip(extent, self._reach, near, strict=True)
        ]
        light: Any = self._instant[2]
        amount, share, change = light.correct(np.stack(thickness), shares, inner)
        cut = [
            slice(low * samples, (low + span.stop - span.start) * samples)
            for span, (low, _) in zip(extent, near, strict=True)
        ]
        return amount[:, *cut].copy(), share[:, *cut].copy(), change[:, *cut].copy()

    def _looked_up(self, look_up: Any, amount_m: Array, channels: int) -> Array:
        """Return the radiance (C, y, x) of columns; below the thinnest cloud of each layer it is linear."""
        result = np.zeros((channels, *amount_m.shape[1:]))
        values = np.empty((channels, *amount_m.shape[1:]), dtype=np.float32)
        for cloudy in product((False, True), repeat=len(self._numbers)):
            weight = np.ones(amount_m.shape[1:])
            layers = [np.zeros(amount_m.shape[1:], dtype=np.float32)] * len(self._plan.layers)
            for number, layer_amount, present in zip(self._numbers, amount_m, cloudy, strict=True):
                layer = self._plan.layers[number]
                part = np.minimum(layer_amount / layer.thickness_min_m, 1.0)
                weight *= part if present else 1.0 - part
                if present:
                    layers[number] = np.clip(layer_amount, layer.thickness_min_m, layer.thickness_max_m).astype(
                        np.float32
                    )
            look_up.fill(values, layers)
            result += weight * values
        return result
