"""Monte Carlo as a tier, ``reference``, for scenes with several cloud layers; as :mod:`hcss_light.photons` for one."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from hcss_light.photons import PILOT, highest_sun, photons_of
from hcss_light.reference import levels_of, radiance_of_layers
from hcss_light.slices import Field
from hcss_light.stacked_light import WHOLE, StackedSource, Window
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Sun
from hcss_twin.providers.light import LightInputs


class StackedReference(StackedSource):
    """Light in several layers of broken cloud, tier ``reference``.

    Raises
    ------
    LightError
        If the image has too many points, or photons for its accuracy would be too many.
    """

    cost: ClassVar[float] = math.inf

    def __init__(self, inputs: LightInputs) -> None:
        super().__init__(inputs)
        self.reach_of_light = ((0, 0), (0, 0))
        self._photons, self._noise = photons_of(inputs, self._noise_of_one_photon)

    def expected_errors(self) -> list[float]:
        """Return the noise (B,), rms over pixels relative to the mean radiance."""
        return [float(each) for each in self._noise]

    @staticmethod
    def check(plan: Plan, tables: RadianceTables, frame: int) -> dict[str, Any]:
        """Return nothing: the light is Monte Carlo itself."""
        return {}

    @property
    def edges_m(self) -> tuple[Array, ...]:
        """Altitudes at which the shares of heights of each layer are asked."""
        return tuple(levels_of(each).edges_m for each in self.stack.layers)

    def at(self, sun: Sun | None) -> StackedPhotons:  # type: ignore[override]
        """Return the light at one instant."""
        return StackedPhotons(self, self._inputs, sun, self._photons)

    def _noise_of_one_photon(self) -> Array:
        """Return the standard deviation (B,) of photons over their mean, among clouds of all thicknesses."""
        draw = np.random.default_rng(22)
        most = np.array([each.layer.thickness_max_m for each in self._inputs.stack])[:, None, None]
        shape = most.size, 8, 8
        thickness = draw.uniform(0.0, most, shape) * (draw.random(shape) < 0.5)
        light = StackedPhotons(self, self._inputs, highest_sun(self._inputs), PILOT)
        mean, error = light.radiance(thickness.astype(np.float32), None, np.argwhere(np.ones((4, 4))), 0)
        return np.asarray(np.sqrt(np.mean(error**2, axis=0) * PILOT) / np.mean(mean, axis=0))


class StackedPhotons:
    """Light at one instant."""

    def __init__(self, transport: StackedSource, inputs: LightInputs, sun: Sun | None, photons: int) -> None:
        self._layers = [levels_of(each) for each in transport.stack.layers]
        self._inputs, self._sun, self._photons = inputs, sun, photons

    def radiance(
        self, thickness_m: Field, shares: Sequence[Field | None] | None, points: NDArray[np.intp], seed: int
    ) -> tuple[Array, Array]:
        """Return the radiance (N, B) of points among clouds (L, y, x), and its standard error."""
        given = zip(self._layers, thickness_m, shares or [None] * len(thickness_m), strict=True)
        layers = [(slices, slices.density(own, self._inputs.shape, share)) for slices, own, share in given]
        return radiance_of_layers(self._inputs, layers, points, self._sun, self._photons, seed)

    def correct(
        self, thickness_m: Field, shares: Sequence[Field | None] | None = None, inner: Window = WHOLE
    ) -> tuple[Array, Array, Array]:
        """Return no cloud (L, y, x), no share of the tables (B, y, x), and Monte Carlo radiance (B, y, x).

        Photons are drawn by the clouds, so that a square has the same bits wherever it is computed.
        """
        inside = np.zeros(thickness_m.shape[1:], dtype=bool)
        inside[*inner] = True
        seed = int.from_bytes(hashlib.sha256(thickness_m.tobytes()).digest()[:3])
        mean, _ = self.radiance(thickness_m, shares, np.argwhere(inside), seed)
        size = thickness_m[0][*inner].shape
        seen = mean.T.reshape(-1, *size)
        return np.zeros((len(thickness_m), *size)), np.zeros_like(seen), seen
