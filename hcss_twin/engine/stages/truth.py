"""Truth variables: the state of the clouds in each pixel."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.variables import (
    ELEMENT,
    LAYER,
    SEA_TEMPERATURE,
    SHADOW_MASK,
    SURFACE_CLASS,
    SURFACE_TEMPERATURE,
    WATER_VAPOUR_FACTOR,
)
from hcss_twin.engine.stages.stage import FramePart, PartWindow, Stage
from hcss_twin.physics.profile import Profile
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, pixel_sums
from hcss_twin.providers import CloudLayer

Thickness = NDArray[np.float32]

TOPS = ("cloud_top_altitude", "cloud_top_temperature")

FILLED = (
    "cloud_mask",
    "cloud_fraction",
    "cloud_thickness",
    "cloud_layer_thickness",
    "cloud_optical_thickness",
    *TOPS,
    *(SHADOW_MASK, "sea_slope_x", "sea_slope_y", SURFACE_CLASS, SURFACE_TEMPERATURE),
    *(SEA_TEMPERATURE, WATER_VAPOUR_FACTOR),
)
"""Truth variables of which the engine knows the values, besides those of elements; the last seven from other stages."""


TopsAt = Callable[[float, Window], NDArray[np.float32]]
"""Returns the altitudes of cloud tops at the points of a window of the image at a time."""


class Truth(Stage):
    """Computes the requested truth variables of a part of one frame, window by window.

    Parameters
    ----------
    tops_m : mapping of int to callable
        Of layers whose tops vary, as :data:`TopsAt`.

    Raises
    ------
    ValueError
        If nothing in the engine fills a requested truth variable.
    """

    title = "truth variables"
    writes = ("truth",)

    def __init__(self, plan: Plan, tops_m: Mapping[int, TopsAt] = MappingProxyType({})) -> None:
        self._layers = plan.layers
        self._profile = plan.assembly.profile
        self._samples = plan.samples_per_pixel
        self._sizes = {"band": len(plan.bands), LAYER: len(plan.layers)}
        self._shapes = {
            spec.name: (tuple(dim for dim in spec.dims if dim != "time"), spec.dtype)
            for spec in plan.computed
            if spec.kind == "truth"
        }
        for name in self._shapes:
            if name not in FILLED and name != ELEMENT and not name.startswith(f"{ELEMENT}_"):
                raise ValueError(f"truth variable '{name}': the engine has no values for it (engine/stages/truth.py)")
        self._missing = [spec.name for spec in plan.computed if spec.kind == "truth" and spec.may_be_missing]
        needs_optics = "cloud_optical_thickness" in self._shapes
        self._extinction = [_band_extinction(plan, layer) for layer in plan.layers if needs_optics]
        self._tops_m = tops_m

    def begin(self, part: FramePart) -> None:
        """Create the variables of the part, initialised to clear sky without elements."""
        sizes = {**self._sizes, "y": part.radiance.shape[1], "x": part.radiance.shape[2]}
        part.truth |= {
            name: np.zeros(tuple(sizes[dim] for dim in dims), dtype) for name, (dims, dtype) in self._shapes.items()
        }
        for name in self._missing:
            part.truth[name][:] = np.nan

    def apply(self, part: FramePart, window: PartWindow) -> None:
        """Fill a window of the part."""
        if not self._layers or not self._shapes:
            return
        thickness_m, inside = window.thickness_m, window.inside
        cloudy_points = ~window.clear
        count = pixel_sums(cloudy_points, self._samples) if self._samples > 1 else cloudy_points
        means = [self._mean(thickness) for thickness in thickness_m]
        total = means[0] if len(means) == 1 else np.sum(means, axis=0, dtype=np.float32)
        for name in self._shapes:
            values = part.truth[name][..., inside[0], inside[1]]
            match name:
                case "cloud_mask":
                    values[:] = count > 0
                case "cloud_fraction":
                    values[:] = count / self._samples**2
                case "cloud_thickness":
                    values[:] = total
                case "cloud_layer_thickness":
                    values[:] = means
                case "cloud_optical_thickness":
                    for extinction, mean in zip(self._extinction, means, strict=True):
                        values += extinction[:, None, None] * mean
        if any(name in self._shapes for name in TOPS):
            self._fill_tops(part, window, count)

    def _mean(self, thickness_m: Thickness) -> Thickness:
        """Mean thickness of each pixel, including its clear part."""
        if self._samples == 1:
            return thickness_m
        return (pixel_sums(thickness_m, self._samples) / self._samples**2).astype(np.float32)

    def _fill_tops(self, part: FramePart, window: PartWindow, count: NDArray[Any]) -> None:
        tops_m = {layer: of_layer(part.time_s, window.window) for layer, of_layer in self._tops_m.items()}
        top, temperature = highest_cloud(self._layers, self._profile, window.thickness_m, tops_m)
        for name, values in zip(TOPS, (top, temperature), strict=True):
            if name not in self._shapes:
                continue
            if self._samples > 1:
                sums = pixel_sums(np.nan_to_num(values), self._samples)
                values = np.divide(sums, count, out=np.full(sums.shape, np.nan), where=count > 0)
            part.truth[name][window.inside] = values


def highest_cloud(
    layers: Sequence[CloudLayer],
    profile: Profile,
    thickness_m: Sequence[Thickness],
    tops_m: Mapping[int, NDArray[np.float32]] = MappingProxyType({}),
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Altitude (m) and temperature (K) of the highest cloud top at each point, NaN where clear.

    Parameters
    ----------
    layers : sequence of CloudLayer
        From the lowest to the highest.
    thickness_m : sequence of ndarray (y, x)
        Thickness of each layer.
    tops_m : mapping of int to ndarray (y, x)
        Altitudes of the tops of layers whose tops vary.
    """
    shape = thickness_m[0].shape
    top, temperature = np.full(shape, np.nan), np.full(shape, np.nan)
    for index, (layer, thickness) in enumerate(zip(layers, thickness_m, strict=True)):
        cloudy = thickness > 0
        if not np.any(cloudy):
            continue
        of_layer = layer.cloud_top_m(thickness[cloudy].astype(np.float64))
        top[cloudy] = tops_m[index][cloudy] if index in tops_m else of_layer
        temperature[cloudy] = (
            profile.temperature_at(top[cloudy]) if layer.temperature_K is None else layer.temperature_K
        )
    return top, temperature


def _band_extinction(plan: Plan, layer: CloudLayer) -> NDArray[np.float32]:
    """Extinction at each band's central wavelength, (B,), m-1."""
    centres = np.array([1e4 / band.central_um for band in plan.bands])
    ascending, position = np.unique(centres, return_inverse=True)
    properties = plan.assembly.optics.single_scattering(layer.microphysics, ascending)
    return properties.extinction_m1[position].astype(np.float32)
