"""Monte Carlo as a tier, ``reference``, for scenes with several cloud layers; as :mod:`hcss_light.photons` for one."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hcss_light.photons import PILOT, PhotonLight
from hcss_light.reference import levels_of, radiance_of_layers
from hcss_light.slices import Field
from hcss_light.stacked_light import WHOLE, StackedSource, Window
from hcss_twin.providers import Array, Sun
from hcss_twin.providers.light import LightInputs


class StackedReference(PhotonLight, StackedSource):
    """Light in several layers of broken cloud, tier ``reference``."""

    knows_surfaces: ClassVar[bool] = False

    def __init__(self, inputs: LightInputs) -> None:
        super().__init__(inputs)
        self.reach_of_light = ((0, 0), (0, 0))

    @property
    def edges_m(self) -> tuple[Array, ...]:
        """Altitudes at which the shares of heights of each layer are asked."""
        return tuple(levels_of(layer).edges_m for layer in self.stack.layers)

    def at(self, sun: Sun | None) -> StackedPhotons:  # type: ignore[override]
        """Return the light at one instant."""
        return StackedPhotons(self, self._inputs, sun, self._photons)

    def _pilot(self, thickness_m: Field, points: Array, sun: Sun | None) -> tuple[Array, Array]:
        light = StackedPhotons(self, self._inputs, sun, PILOT)
        return light.radiance(thickness_m, None, points.astype(np.intp), 0)


class StackedPhotons:
    """Light at one instant."""

    def __init__(self, transport: StackedSource, inputs: LightInputs, sun: Sun | None, photons: int) -> None:
        self._layers = [levels_of(layer) for layer in transport.stack.layers]
        self._inputs, self._sun, self._photons = inputs, sun, photons

    def radiance(
        self, thickness_m: Field, shares: Sequence[Field | None] | None, points: NDArray[np.intp], seed: int
    ) -> tuple[Array, Array]:
        """Return the radiance (N, B) of points among clouds (L, y, x), and its standard error."""
        given = zip(self._layers, thickness_m, shares or [None] * len(thickness_m), strict=True)
        layers = [
            (slices, slices.density(layer_thickness, self._inputs.shape, share))
            for slices, layer_thickness, share in given
        ]
        return radiance_of_layers(self._inputs, layers, points, self._sun, self._photons, seed)

    def correct(
        self, thickness_m: Field, shares: Sequence[Field | None] | None = None, inner: Window = WHOLE
    ) -> tuple[Array, Array, Array]:
        """Return no cloud (L, y, x), no share of the tables (B, y, x), and Monte Carlo radiance (B, y, x)."""
        amount, total = self.seen(thickness_m, shares, inner)
        return amount, *self.beside_columns(total, amount, shares)

    def seen(
        self, thickness_m: Field, shares: Sequence[Field | None] | None = None, inner: Window = WHOLE
    ) -> tuple[Array, Array]:
        """Return no cloud (L, y, x), and Monte Carlo radiance (B, y, x).

        Photons are drawn by the clouds, so that a square has the same bits wherever it is computed.
        """
        inside = np.zeros(thickness_m.shape[1:], dtype=bool)
        inside[*inner] = True
        seed = int.from_bytes(hashlib.sha256(thickness_m.tobytes()).digest()[:3])
        mean, _ = self.radiance(thickness_m, shares, np.argwhere(inside), seed)
        size = thickness_m[0][*inner].shape
        return np.zeros((len(thickness_m), *size)), mean.T.reshape(-1, *size)

    @staticmethod
    def beside_columns(total: Array, amount_m: Array, shares: Sequence[Field | None] | None) -> tuple[Array, Array]:
        """Return no share of the tables, and all radiance (B, y, x)."""
        return np.zeros_like(total), total
