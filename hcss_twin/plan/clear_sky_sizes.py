"""How much textures of the sea's temperature and of water vapour change radiance: what the plan skips and states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcss_twin.core.units import kelvin_of
from hcss_twin.physics.planck import planck
from hcss_twin.plan.accuracy import largest_kelvin
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.few_columns import SKIP_SHARE, few_columns
from hcss_twin.plan.numerics import for_spectra
from hcss_twin.providers import Grid, Sun
from hcss_twin.scenario.scenario import Scenario

RAREST = 5.0
"""Standard deviations of a texture that no pixel exceeds: of a normal distribution, one in two million does."""

DEFAULT_K = 0.3
"""Standard deviation of the sea's temperature over some hundred km where a scenario gives none. That of clear pixels in
10.8 um SEVIRI images (3 km) is .15 to .49 K over some 200 km, by place and night, of which water vapour is a part."""

DEFAULT_VAPOUR = 0.05
"""Relative standard deviation over some hundred km that the plan proposes: with it, brightness temperatures at
10.8 and 12.0 um have the structure functions of cloud-free pixels in 11 SEVIRI scenes."""

OUTER_M = 320e3
"""Wavelength of the largest structures."""


@dataclass(frozen=True)
class TextureSize:
    """Change of radiance by a standard deviation of a texture, in the band in which it is largest.

    Attributes
    ----------
    largest : float
        Relative, in any column.
    relative : float
        In clear sky, if there is any.
    kelvin : float
        As ``relative``, of the brightness temperature.
    """

    largest: float
    relative: float
    kelvin: float


def typical_sea_K(grid: Grid) -> float:
    """Return the default standard deviation of the sea's temperature within an image: k^-2 up to its size."""
    size_m = grid.pixel_size_m * max(grid.rows, grid.columns)
    deviation_K: float = DEFAULT_K * min(1.0, size_m / OUTER_M) ** 0.5
    return deviation_K


def change_by_sea(assembly: Assembly, warmer_K: float) -> float:
    """Return the relative change of a black body as warm as the sea, at the shortest wavelength of the bands.

    No pixel changes by more: what air, clouds and sunlight add does not change.
    """
    shortest, sea_K = 1e4 / min(band.lower_um for band in assembly.bands), assembly.sea_temperature_K
    warmer, sea = planck(np.array([shortest]), np.array([[sea_K + warmer_K], [sea_K]]))[:, 0]
    return float(warmer / sea - 1.0)


def is_faint(scenario: Scenario, assembly: Assembly, deviation_K: float) -> bool:
    """Whether no pixel changes by more than its share of the accuracy by a texture of the sea.

    A pixel's brightness temperature changes by less than the sea's temperature does.
    """
    kelvin = kelvin_of(scenario.accuracy)
    if kelvin is not None:
        return RAREST * deviation_K <= SKIP_SHARE * kelvin
    return RAREST * change_by_sea(assembly, deviation_K) <= SKIP_SHARE * float(scenario.accuracy)


def typical_vapour(grid: Grid) -> float:
    """Return the default standard deviation of the vapour within an image: r^(2/3) up to its size."""
    size_m = grid.pixel_size_m * max(grid.rows, grid.columns)
    share: float = min(1.0, size_m / OUTER_M) ** (1.0 / 3.0)
    return DEFAULT_VAPOUR * share


def size_of_texture(
    assembly: Assembly, suns: Sequence[Sun | None], warmer_K: float = 0.0, vapour_factor: float = 1.0
) -> TextureSize:
    """Return what a standard deviation of the sea's temperature or of the vapour changes.

    Clear sky may change least: there less emission of warm air makes up for more of the sea, and beside clouds not.

    Parameters
    ----------
    suns : sequence of Sun or None
        Of some frames.
    warmer_K, vapour_factor : float
        Change of the sea, and factor of the vapour.
    """
    assembly = for_spectra(assembly)
    columns, grid = few_columns(assembly), assembly.spectral_grid
    if vapour_factor == 1.0:  # clouds hide a part of the sea, and add nothing that its temperature changes
        columns = columns.only(columns.ends[: 1 if columns.clear else None])
    before, after = (
        np.stack(columns.totals_in(scene.model, [scene.setting(sun) for sun in suns]))
        for scene in (assembly, assembly.perturbed(warmer_K, vapour_factor))
    )
    change = np.abs(np.divide(after, before, out=np.ones_like(before), where=before > 0.0) - 1.0)
    relative = np.max(change[:, : 1 if columns.clear else None], axis=(0, 1))
    kelvin = largest_kelvin(grid, relative, assembly.sea_temperature_K)
    return TextureSize(float(np.max(change)), float(np.max(relative)), kelvin)
