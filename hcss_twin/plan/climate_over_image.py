"""How far air and sea by climatology change over an image whose scenario has those of its centre everywhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError, ScenarioError
from hcss_twin.physics.geodesy import to_geographic
from hcss_twin.plan.accuracy import largest_kelvin
from hcss_twin.plan.air_over_field import AirOverField
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.few_columns import SAFETY_FACTOR, FewColumns, Omission
from hcss_twin.providers import ColumnSetting, Sun

__all__ = ["climate_over_image"]

ON_REQUEST = "on request"
"""Decision of the user: a scenario gives one place, and can give profiles of several."""

NEEDS = "profiles of several places and a map of the sea's temperature: no key computes it"


def climate_over_image(assembly: Assembly, columns: FewColumns, suns: Sequence[Sun | None]) -> Iterator[Omission]:
    """Yield the change of air and sea over the image, if a climatology gives either.

    The bound is that from the centre to a corner: the sum of those to an edge along either axis, which are nearly
    straight lines, with a safety factor for the curvature of wide images. The estimate is the rms of a straight line.
    """
    if assembly.climate_at is None or not (changes := list(_along_axes(assembly, columns, suns, assembly.climate_at))):
        return
    relative = np.max(np.sum(changes, axis=0), axis=(0, 1))
    kelvin = largest_kelvin(assembly.spectral_grid, relative, assembly.sea_temperature_K)
    corner = float(np.max(relative))
    yield Omission(
        "air and sea by place within the image",
        f"those of the climatology at its centre are everywhere; toward a corner they change by {kelvin:.2g} K",
        SAFETY_FACTOR * corner,
        corner / 3.0**0.5,
        f"rms over the image, at most; {kelvin:.2g} K toward a corner",
        NEEDS,
        ON_REQUEST,
    )


def _along_axes(
    assembly: Assembly,
    columns: FewColumns,
    suns: Sequence[Sun | None],
    climate_at: Callable[[float, float], AirOverField.Air],
) -> Iterator[Array]:
    """Yield the relative change of columns (S, C, B) to the edge along either axis, on a side with a climatology."""
    ends, model = columns.only(columns.ends), assembly.model
    settings = [assembly.setting(sun) for sun in suns]
    here = np.stack(ends.totals_in(model, settings))
    for east, north in ((1.0, 0.0), (0.0, 1.0)):
        for side in (1.0, -1.0):
            with suppress(CatalogError, ScenarioError):
                there = np.stack(ends.totals_in(model, _at(assembly, settings, climate_at, side * east, side * north)))
                yield np.abs(np.divide(there, here, out=np.ones_like(here), where=here > 0.0) - 1.0)
                break


def _at(
    assembly: Assembly,
    settings: Sequence[ColumnSetting],
    climate_at: Callable[[float, float], AirOverField.Air],
    x: float,
    y: float,
) -> list[ColumnSetting]:
    """Return the settings in air and over sea of a position, -1 to 1 from edge to edge."""
    grid = assembly.grid
    east, north = 0.5 * grid.pixel_size_m * np.array([x * grid.columns, y * grid.rows])
    latitude, longitude = to_geographic(np.array([east]), np.array([north]), *assembly.air_over_field.centre_deg)
    air = climate_at(float(latitude[0]), float(longitude[0]))
    sea, kelvin = air.sea_or(assembly.sea, assembly.sea_temperature_K)
    return [
        replace(
            setting,
            profile=air.profile,
            transmittance=air.transmittance,
            air_memory=None,
            sea=sea,
            sea_temperature_K=kelvin,
        )
        for setting in settings
    ]
