"""How much a texture of water vapour would change radiance, for the plan of a scene without one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcss_twin.plan.accuracy import largest_kelvin
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.few_columns import few_columns
from hcss_twin.plan.numerics import for_spectra
from hcss_twin.providers import Grid, Sun

DEFAULT_VAPOUR = 0.05
"""Relative standard deviation over some hundred km that the plan proposes: with it, brightness temperatures at
10.8 and 12.0 um have the structure functions of cloud-free pixels in 11 SEVIRI scenes."""

OUTER_M = 320e3
"""Wavelength of the largest structures."""


@dataclass(frozen=True)
class VapourSize:
    """Change of radiance by a standard deviation of the vapour, where it is largest.

    Attributes
    ----------
    relative : float
        In the band in which it is largest.
    kelvin : float
        Of the brightness temperature, in the band in which that is largest.
    """

    relative: float
    kelvin: float


def typical_vapour(grid: Grid) -> float:
    """Return the default standard deviation of the vapour within an image: r^(2/3) up to its size."""
    size_m = grid.pixel_size_m * max(grid.rows, grid.columns)
    share: float = min(1.0, size_m / OUTER_M) ** (1.0 / 3.0)
    return DEFAULT_VAPOUR * share


def size_of_vapour(assembly: Assembly, suns: Sequence[Sun | None], deviation: float) -> VapourSize:
    """Return what a standard deviation of the vapour changes, in clear sky if there is any.

    Parameters
    ----------
    suns : sequence of Sun or None
        Of some frames.
    deviation : float
        Relative to the vapour; 0 changes nothing.
    """
    assembly = for_spectra(assembly)
    columns, grid = few_columns(assembly), assembly.spectral_grid
    columns = columns.only(columns.ends[: 1 if columns.clear else None])
    drier = assembly.perturbed(0.0, 1.0 - deviation)
    before, after = (
        np.stack(columns.totals_in(scene.model, [scene.setting(sun) for sun in suns])) for scene in (assembly, drier)
    )
    change = np.abs(np.divide(after, before, out=np.ones_like(before), where=before > 0.0) - 1.0)
    relative = np.max(change, axis=(0, 1))
    return VapourSize(float(np.max(relative)), largest_kelvin(grid, relative, assembly.sea_temperature_K))
