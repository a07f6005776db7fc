"""What transports of light in broken clouds have in common, for one layer and for several."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from hcss_light.source import Direction
from hcss_light.stated import stated_errors
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Sun
from hcss_twin.providers.light import LightInputs

FAINT = 1e-3
"""Share of sunlight in the radiance of uniform cloud below which it counts as none."""

SPREADING = 1.0
"""Light that clouds scatter and emit is taken from up to so many heights of the layer aside."""

MOST_SPREADING = 24
"""The same limit in points."""

LOWEST_SUN_DEG = 85.0
"""Below it sunlight is that of uniform cloud: its rays would cross the whole image."""


class ScatteredLight:
    """Base of the transports, whose interface :class:`hcss_twin.providers.light.LightTransport` describes.

    Parameters
    ----------
    inputs : LightInputs
        Of the lowest layer.

    Raises
    ------
    LightError
        If view or sun are so slanted that too many slices are needed.
    """

    tier: ClassVar[str] = "source"
    cost: ClassVar[float] = 10.0

    def __init__(self, inputs: LightInputs) -> None:
        self._inputs = inputs
        shone = inputs.sun_zenith_deg <= LOWEST_SUN_DEG
        zenith, azimuth = inputs.sun_zenith_deg[shone].tolist(), inputs.sun_azimuth_deg[shone].tolist()
        self._suns = [Direction(*angles) for angles in zip(zenith, azimuth, strict=True)]
        self._steepest_deg = max([inputs.view.zenith_deg, *zenith])
        self._heights = [cloud.layer.thickness_max_m / inputs.point_m for cloud in inputs.stack]
        self._optical = []
        for layer_cloud in inputs.stack:
            cloud = layer_cloud.optics.single_scattering(layer_cloud.layer.microphysics, layer_cloud.wavenumber_cm1)
            thickest = np.max(cloud.extinction_m1 * (1.0 - cloud.albedo * cloud.moments[1] ** 2))
            self._optical.append(float(thickest) * layer_cloud.layer.thickness_max_m)

    @property
    def _spread(self) -> int:
        """Points around others that send light to them, without the shift of rays along view and sun."""
        return min(math.ceil(SPREADING * max(self._heights)), MOST_SPREADING)

    @property
    def farthest_m(self) -> float:
        """Largest height of cloud above or below where lines of sight meet the columns of their own points."""
        lowest, highest = self._inputs, self._inputs.stack[-1]
        ends = highest.layer.top_m - lowest.reference_m, lowest.reference_m - lowest.layer.base_m
        return max(ends)

    def over_views(self, plan: Plan) -> tuple[list[float], str]:
        """Return the errors to expect over an image whose view varies, and a note about its directions.

        Raises
        ------
        LightError
            If directions that are constant in squares would be too wrong.
        """
        from hcss_light.tiles import Tiles  # not for parallel views

        tiles, inputs = Tiles(plan, self), self._inputs
        views = dict.fromkeys((inputs.view, *tiles.corners))
        errors = [type(self)(replace(inputs, view=view)).expected_errors() for view in views]
        text = (
            f"directions of the view are constant in squares of {tiles.side} pixels: lines of sight are displaced by "
        )
        return np.max(errors, axis=0).tolist(), text + f"up to {tiles.displaced:.2g} points at the top of the clouds"

    @property
    def through_sea(self) -> bool:
        """Whether lines of sight are those through the points of the sea, all of the clouds above."""
        return self._inputs.reference_m < self._inputs.layer.base_m

    @staticmethod
    def check(plan: Plan, tables: RadianceTables, frame: int) -> dict[str, Any]:
        """Return how some pixels of a frame compare with Monte Carlo, for the certificate."""
        from hcss_light.comparison import check  # not for plans alone

        return check(plan, tables, frame)

    def expected_errors(self) -> list[float]:
        """Return the error (B,) to expect: rms over pixels, relative to the mean radiance."""
        columns, *others = self._differences
        of_tier = 0.0 if self.tier == "source" else others[0]
        return stated_errors(self._inputs, columns, self._of_slant(others), of_tier)

    def errors_of_columns(self) -> list[float]:
        """Return the same of independent columns."""
        columns, *others = self._differences
        return stated_errors(self._inputs, columns, self._of_slant(others), columns)

    def _of_slant(self, others: list[Array]) -> Array | None:
        """Return the difference of ``slant`` from ``source``, on which their errors depend in one layer."""
        return others[0] if others and len(self._inputs.stack) == 1 else None

    @cached_property
    def _differences(self) -> list[Array]:
        """How much (B,) columns, and the tier ``slant`` if there, differ from ``source``: rms over mean."""
        raise NotImplementedError


def shining(sun: Sun | None) -> Sun | None:
    """Return a sun that is high enough to light broken clouds; else None."""
    return None if sun is None or sun.zenith_deg > LOWEST_SUN_DEG else sun


def share_and_change(total: Array, uniform: Array, dark: Array, air: Array) -> tuple[Array, Array]:
    """Return which share of the tables counts, and what is added to it, each (B, y, x).

    Parameters
    ----------
    total, uniform, dark : ndarray (B, y, x)
        Radiance of broken cloud, of uniform cloud, and of this at night, by the same method.
    air : ndarray (B,)
        Sunlight that the air above the clouds scatters: the tables have it, and it is not shaded.
    """
    sunlight = uniform - dark
    lit = sunlight > FAINT * uniform
    share = np.where(lit, np.clip((total - dark) / np.where(lit, sunlight, 1.0), 0.0, 1.0), 1.0)
    return share, total - share * uniform + (1.0 - share) * air[:, None, None]
