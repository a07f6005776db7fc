"""Columns of air, clouds and sea, each a stack of gaps between interfaces.

Columns of one scene share sea, air and sun and differ in their clouds. Columns with the same layers are computed
together, because for a single column the call overhead would exceed the arithmetic. Arrays end with an axis S = C x V:
all V wavenumbers of the first of C columns, then of the second, and so on.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.physical.air import Air, Heights
from hcss_twin.models.radiance.physical.cloud_slab import CloudSlab
from hcss_twin.models.radiance.physical.composite_paths import CompositePaths
from hcss_twin.models.radiance.physical.directions import ColumnDirections
from hcss_twin.models.radiance.physical.sea_surface import SeaSurface
from hcss_twin.physics.paths import SPACE, Leg, Path, to_space


@dataclass(frozen=True)
class SceneColumns:
    """C columns with the same layers: air, clouds, sea and space.

    Gap m is the air above cloud m (counted from the top, from 0) or above the sea.

    Attributes
    ----------
    count : int
        C.
    air : Air
    directions : ColumnDirections
    slabs : tuple of CloudSlab
        From the highest to the lowest.
    sea : SeaSurface
    sea_source : ndarray (S,)
        Planck radiance of the sea.
    space : ndarray (S,)
        Radiance of the sky beyond the atmosphere.
    received : ndarray (S,)
        Solar irradiance on a horizontal plane outside the atmosphere, mu0 E0; 0 without a sun.
    scattered_sublayers : int
        Parts of each layer of air for its emission that is scattered afterwards.
    """

    count: int
    air: Air
    directions: ColumnDirections
    slabs: tuple[CloudSlab, ...]
    sea: SeaSurface
    sea_source: Array
    space: Array
    received: Array
    scattered_sublayers: int

    def gap_m(self, gap: int) -> tuple[Heights, Heights]:
        """Return altitudes of the lower and upper end of a gap."""
        upper = (SPACE,) * self.count if gap == 0 else self.slabs[gap - 1].base_m
        lower = self.slabs[gap].top_m if gap < len(self.slabs) else self.sea_level_m
        return lower, upper

    @property
    def sea_level_m(self) -> Heights:
        """Altitude of the sea in each column: 0."""
        return (0.0,) * self.count

    def crossed(self, path: Callable[[int], Path]) -> CompositePaths:
        """Return one composite path for each column, given a function of the column number."""
        return self.air.crossed([[path(number) for number in range(self.count)]])

    def slab_emission(self, index: int, from_above: bool) -> Array:
        """Return the emission of a cloud toward each direction, (D, S), from one of its faces."""
        slab = self.slabs[index]
        near, far = slab.top_temperature_K, slab.base_temperature_K
        if not from_above:
            near, far = far, near
        black = self.air.black_bodies
        result: Array = (slab.emissivity - slab.far_share) * black(near) + slab.far_share * black(far)
        return result

    def sun_on_slab(self, index: int, from_above: bool) -> tuple[Array, CompositePaths]:
        """Return the sunlight that a cloud scatters toward each direction, (D, S), and the sun's path to it.

        It includes the direct transmittance of the clouds above, but not that of the air.
        """
        slab = self.slabs[index]
        kernel = slab.sun_reflection if from_above else slab.sun_transmission
        lower = slab.top_m if from_above else slab.base_m
        return kernel * (self.received * self._sun_through(index)), self._sun_path(lower)

    def sun_on_sea(self) -> tuple[Array, CompositePaths]:
        """Return the sunlight that the sea reflects toward each direction, (D, S), and the sun's path to it."""
        return self.sea.sun * (self.received * self._sun_through(len(self.slabs))), self._sun_path(self.sea_level_m)

    def inside(self, index: int, number: int, zenith_deg: float) -> Leg:
        """Return the leg through the air inside a cloud of one column."""
        slab = self.slabs[index]
        return Leg(slab.base_m[number], slab.top_m[number], zenith_deg)

    def _sun_through(self, count: int) -> Array:
        """Return the direct transmittance (S,) of the ``count`` highest clouds for the sun."""
        result = np.ones_like(self.received)
        for slab in self.slabs[:count]:
            result = result * slab.sun_direct
        return result

    def _sun_path(self, lower_m: Heights) -> CompositePaths:
        sun = self.directions.sun
        if sun is None:
            return self.crossed(lambda _: Path())
        return self.crossed(lambda number: to_space(lower_m[number], sun.zenith_deg))
