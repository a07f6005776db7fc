"""Monte Carlo as a tier, ``reference``: small images of clouds with sides whose only error is noise.

Photons start from every point, as many as ``radiance.light_accuracy`` requires. The clouds around a square of points
are continued periodically, as in ``hcss reference``.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import numpy as np

from hcss_light.reference import levels_of, reference_radiance
from hcss_light.scattered import LOWEST_SUN_DEG, ScatteredLight
from hcss_light.slices import Field, Slices
from hcss_light.stage import stage
from hcss_light.transport import SourceLight
from hcss_light.voxels import LightError
from hcss_twin.engine.stages.light import LightStage
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Sun
from hcss_twin.providers.light import LightInputs

MOST_POINTS = 4096
"""Points of all frames; each takes seconds by day."""

ACCURACY, PILOT = 0.01, 400
"""Noise without ``radiance.light_accuracy``, and photons of the points that tell how many it needs."""

MOST_PHOTONS = 1_000_000


def photons_of(inputs: LightInputs, noise_of_one: Callable[[], Array]) -> tuple[int, Array]:
    """Return the photons of each point that the scene's accuracy needs, and their noise (B,).

    Raises
    ------
    LightError
        If the image has more than :data:`MOST_POINTS` points, or photons for its accuracy would be too many.
    """
    if inputs.points > MOST_POINTS:
        raise LightError(
            f"Monte Carlo of {inputs.points} points (pixels, their points and frames); allowed: {MOST_POINTS}; "
            "closest is 'source'"
        )
    noise = noise_of_one()
    allowed = ACCURACY if inputs.accuracy is None else inputs.accuracy
    needed = math.ceil((float(np.max(noise)) / allowed) ** 2)
    if needed > MOST_PHOTONS:
        least = float(np.max(noise)) / math.sqrt(MOST_PHOTONS)
        raise LightError(
            f"radiance.light_accuracy = {allowed:g} needs {needed} photons for each point; allowed: "
            f"{MOST_PHOTONS}, which reach {least:.2g}"
        )
    photons = max(needed, PILOT)
    return photons, noise / math.sqrt(photons)


def highest_sun(inputs: LightInputs) -> Sun | None:
    """Return the highest sun of all frames; None without one."""
    shone = np.flatnonzero(inputs.sun_zenith_deg <= LOWEST_SUN_DEG)
    if not shone.size:
        return None
    highest = shone[np.argmin(inputs.sun_zenith_deg[shone])]
    return Sun(float(inputs.sun_zenith_deg[highest]), float(inputs.sun_azimuth_deg[highest]), 1.0)


class PhotonLight(ScatteredLight):
    """Base of the tier ``reference``, for one layer and for several.

    Raises
    ------
    LightError
        If the image has more than :data:`MOST_POINTS` points, or photons for its accuracy would be too many.
    """

    cost: ClassVar[float] = math.inf

    def __init__(self, inputs: LightInputs) -> None:
        super().__init__(inputs)
        self._photons, self._noise = photons_of(inputs, self._noise_of_one_photon)

    def _noise_of_one_photon(self) -> Array:
        """Return the standard deviation (B,) of photons over their mean, among clouds of all thicknesses."""
        draw, most = np.random.default_rng(22), [cloud.layer.thickness_max_m for cloud in self._inputs.stack]
        shape = len(most), 8, 8
        thickness = draw.uniform(0.0, np.reshape(most, (-1, 1, 1)), shape) * (draw.random(shape) < 0.5)
        points, sun = np.argwhere(np.ones((4, 4))).astype(np.float64), highest_sun(self._inputs)
        mean, error = self._pilot(thickness.astype(np.float32), points, sun)
        return np.asarray(np.sqrt(np.mean(error**2, axis=0) * PILOT) / np.mean(mean, axis=0))

    def _pilot(self, thickness_m: Field, points: Array, sun: Sun | None) -> tuple[Array, Array]:
        """Return the radiance (N, B) of points among clouds (L, y, x), and its standard error."""
        raise NotImplementedError

    def expected_errors(self) -> list[float]:
        """Return the noise (B,), rms over pixels relative to the mean radiance."""
        return [float(noise) for noise in self._noise]

    @staticmethod
    def check(plan: Plan, tables: RadianceTables, frame: int) -> dict[str, Any]:
        """Return nothing: the light is Monte Carlo itself."""
        return {}


class ReferenceLight(PhotonLight, SourceLight):
    """Light in one layer of broken clouds, tier ``reference``."""

    knows_surfaces: ClassVar[bool] = False

    def __init__(self, inputs: LightInputs) -> None:
        super().__init__(inputs)
        self.reach = self.sea_reach

    @classmethod
    def stage(cls, plan: Plan, tables: RadianceTables) -> LightStage:
        """Return the computation of frames, each for itself."""
        return stage(plan, tables, False)

    @property
    def edges_m(self) -> Array:
        """Altitudes at which the shares of heights are asked."""
        return levels_of(self.slices).edges_m

    def at(self, sun: Sun | None) -> InstantPhotons:  # type: ignore[override]
        """Return the light at one instant."""
        return InstantPhotons(self._inputs, self.slices, self.reach, sun, self._photons)

    def _pilot(self, thickness_m: Field, points: Array, sun: Sun | None) -> tuple[Array, Array]:
        return reference_radiance(self._inputs, self.slices, thickness_m[0], points, sun, PILOT)


class InstantPhotons:
    """Light at one instant; see :class:`hcss_twin.providers.light.InstantLight`."""

    def __init__(
        self, inputs: LightInputs, slices: Slices, reach: tuple[tuple[int, int], ...], sun: Sun | None, photons: int
    ) -> None:
        self._inputs, self._slices, self._reach, self._sun, self._photons = inputs, slices, reach, sun, photons

    def over_sea(self, thickness_m: Field, shares: Field | None = None) -> list[Array]:
        """Return nothing: photons see the sea."""
        return []

    def correct(
        self, thickness_m: Field, shares: Field | None = None, over_sea: Sequence[Array] = ()
    ) -> tuple[Array, Array, Array]:
        """Return no cloud (y, x), no share of the tables (B, y, x), and Monte Carlo radiance (B, y, x)."""
        amount, total = self.seen(thickness_m, shares)
        return amount, *self.beside_columns(total, amount, shares)

    def seen(
        self, thickness_m: Field, shares: Field | None = None, over_sea: Sequence[Array] = ()
    ) -> tuple[Array, Array]:
        """Return no cloud (y, x), and Monte Carlo radiance (B, y, x).

        Photons are drawn by the clouds, so that a square has the same bits wherever it is computed.
        """
        inside = np.zeros(thickness_m.shape, dtype=bool)
        rows, columns = (slice(low, -high) for low, high in self._reach)
        inside[rows, columns] = True
        seed = int.from_bytes(hashlib.sha256(thickness_m.tobytes()).digest()[:3])
        radiance = np.zeros((self._inputs.weights_cm1.shape[0], *thickness_m.shape))
        points = np.argwhere(inside).astype(np.float64)
        mean, _ = reference_radiance(
            self._inputs, self._slices, thickness_m, points, self._sun, self._photons, seed, shares
        )
        radiance[:, inside] = mean.T
        return np.zeros(thickness_m.shape), radiance

    @staticmethod
    def beside_columns(total: Array, amount_m: Array, shares: Field | None) -> tuple[Array, Array]:
        """Return no share of the tables, and all radiance (B, y, x)."""
        return np.zeros_like(total), total
