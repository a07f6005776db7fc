"""Clouds around single pixels of a plan, for Monte Carlo: one layer, or several above each other."""

from __future__ import annotations

from typing import Any

import numpy as np

from hcss_light.reference import levels_of, radiance_of_layers
from hcss_light.slices import Slices
from hcss_light.stage import shares_of
from hcss_twin.engine.stream import FrameClouds
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Sun
from hcss_twin.providers.light import LightInputs


class SampledClouds:
    """Clouds of a plan on levels at least as thin as the slices of the tier ``source``."""

    def __init__(self, plan: Plan, inputs: LightInputs) -> None:
        self._plan, self._inputs = plan, inputs
        self._slices, self._reach = slices_and_reach(inputs)

    def radiance(
        self, pixel: tuple[int, int], time_s: float, clouds: FrameClouds, sun: Sun | None, photons: int, seed: int
    ) -> tuple[Array, Array]:
        """Return the radiance (1, B) of a pixel by Monte Carlo, and its standard error."""
        rows, columns = (
            slice(at - before, at + 1 + after) for at, (before, after) in zip(pixel, self._reach, strict=True)
        )
        thickness, layers = clouds.thickness_m((rows, columns)), []
        for own, slices in zip(self._inputs.stack, self._slices, strict=True):
            cloud = thickness[own.number]
            shares = shares_of(self._plan, own.number, time_s, (rows, columns), cloud, slices.edges_m)
            layers.append((slices, slices.density(cloud, own.shape, shares)))
        inside = np.array([[each[0] for each in self._reach]])
        return radiance_of_layers(self._inputs, layers, inside, sun, photons, seed)


def slices_and_reach(inputs: LightInputs) -> tuple[list[Slices], Any]:
    """Return the levels of each layer, and rows and columns of points around others whose clouds matter to them."""
    if inputs.above is None:
        from hcss_light.transport import SourceLight

        light = SourceLight(inputs)
        return [levels_of(light.slices)], light.sea_reach
    from hcss_light.stacked_light import StackedSource  # not for one layer

    stacked = StackedSource(inputs)
    return [levels_of(each) for each in stacked.stack.layers], stacked.reach
