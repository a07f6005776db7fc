"""Peers of the radiance tables: the spectrum of every pixel by itself, at all wavenumbers or at fewer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.radiance.reference import reference_radiance
from hcss_twin.radiance.spectral_grid import SpectralGrid, dense_grid
from hcss_twin.scene.plan import Plan

Array = NDArray[np.float64]

_SEED = 20_240_420


def random_columns(plan: Plan, count: int) -> Array:
    """Thickness (N, L) at random points of the first frame, clear and cloudy as they come."""
    random = np.random.default_rng(_SEED)
    samples, time_s = plan.samples_per_pixel, float(plan.frame_times_s[0])
    size = plan.grid.rows * samples, plan.grid.columns * samples
    row, column = (random.integers(0, each, count).tolist() for each in size)
    found = np.zeros((count, len(plan.layers)))
    for index, (layer, generator) in enumerate(zip(plan.layers, plan.generators, strict=True)):
        whole = None
        if not generator.declares.tileable:
            whole = generator.thickness_m(time_s, slice(0, size[0]), slice(0, size[1]))
        for point, (y, x) in enumerate(zip(row, column, strict=True)):
            if whole is None:
                value = float(generator.thickness_m(time_s, slice(y, y + 1), slice(x, x + 1))[0, 0])
            else:
                value = float(whole[y, x])
            if value > 0:
                # What single precision puts beyond the limits is taken for them, as in the look-up.
                found[point, index] = min(max(value, layer.thickness_min_m), layer.thickness_max_m)
    return found


def every_nth(plan: Plan, step: int) -> SpectralGrid:
    """Grid of every so manieth wavenumber of the provider's own, with the edges of the bands."""
    return dense_grid(plan.bands, plan.spectral_grid.wavenumber_cm1[::step])


def even_wavelengths(plan: Plan, count: int) -> SpectralGrid:
    """Grid of so many wavelengths per band, evenly spaced, whatever the provider's own is."""
    inside = [1e4 / np.linspace(band.lower_um, band.upper_um, count) for band in plan.bands]
    return dense_grid(plan.bands, np.unique(np.concatenate(inside)))


def integrate(plan: Plan, grid: SpectralGrid, columns: Array, together: int = 1) -> Array:
    """Band radiance (N, B) of columns (N, L), each by itself or so many cloudy ones together."""
    sun = plan.sun_at(float(plan.frame_times_s[0]))
    return reference_radiance(plan.model, grid, columns, sun, together)


def points_of_scene(plan: Plan) -> int:
    """Points of all frames that have a column."""
    return plan.frame_times_s.size * plan.grid.rows * plan.grid.columns * plan.samples_per_pixel**2
