"""Columns of air for RRTMGP and for the band model: the same cells, temperatures and slant paths for both.

A path crosses the cells between two altitudes once or several times, at the zenith angles of its legs. Cells above
80 km can be hotter than RRTMGP's tables, and use their last temperature there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import netCDF4
import numpy as np
from numpy.typing import NDArray
from rrtmgp_gas_optics import Cells, GasOptics

from hcss_twin.models.atmosphere.band_model.absorber_density import LOSCHMIDT_CM3, LevelState
from hcss_twin.models.atmosphere.band_model.layers import LayeredAir, Layers
from hcss_twin.physics.profile import EARTH_RADIUS_M, GASES, Profile

Array = NDArray[np.float64]

QUADRATURE: Final = np.array(
    [0.1527534276, 0.1491729617, 0.1420961469, 0.1316886544, 0.1181945205, 0.1019300893, 0.0832767040, 0.0626720116,
     0.0424925000, 0.0046269894, 0.0038279891, 0.0030260086, 0.0022199750, 0.0014140010, 0.0005330000, 0.0000750000]
)  # fmt: skip
"""Share of a band's wavenumbers at each g-point."""

N2_SHARE: Final = 0.781
_UNUSED: Final = 13
"""Columns that layers scale with temperature, at the end."""


@dataclass(frozen=True)
class Slant:
    """A stack of cells and the slant factors of paths through it.

    Attributes
    ----------
    layers : Layers
        Amounts are air and the gases of ``GASES`` in amagat km, then pressure (Pa) and temperature (K) times air.
    factor : ndarray (P, M)
    """

    layers: Layers
    factor: Array

    def cells(self) -> Cells:
        """Return the cells of a vertical path for RRTMGP."""
        amount = self.layers.amount
        air, gases = amount[:, 0], amount[:, 1 : 1 + len(GASES)]
        dry = air - gases[:, GASES.index("h2o")]
        ratios = {gas: gases[:, k] / dry for k, gas in enumerate(GASES)}
        ratios["n2"] = N2_SHARE * air / dry
        pressure, temperature = (amount[:, 1 + len(GASES) + k] / air for k in range(2))
        return Cells(pressure, np.clip(temperature, 160.0, 355.0), dry * LOSCHMIDT_CM3 * 1e5, ratios)


class Column:
    """The air of a profile.

    Parameters
    ----------
    profile : Profile
        With all gases.
    """

    def __init__(self, profile: Profile) -> None:
        self.profile = profile
        air = profile.pressure_Pa / 101_325.0 * 273.15 / profile.temperature_K
        density = [air, *(air * profile.mixing_ratio[gas] for gas in GASES)]
        density += [air * profile.pressure_Pa, air * profile.temperature_K]
        columns = np.stack([*density, *[np.zeros_like(air)] * _UNUSED], axis=1)
        refractivity = 2.9e-4 * air
        state = LevelState(profile.altitude_m, profile.pressure_Pa, profile.temperature_K, refractivity, columns)
        self._air = LayeredAir(state, EARTH_RADIUS_M)

    def slant(self, lower_m: float, upper_m: float, zeniths_deg: Sequence[tuple[float, ...]]) -> Slant:
        """Return the cells between two altitudes, with the slant factors of paths: the sums of their legs."""
        layers = self._air.between(lower_m, upper_m)
        legs = [self._air.slant(layers, lower_m, np.array(each)).sum(axis=0) for each in zeniths_deg]
        return Slant(layers, np.stack(legs))


class Reference:
    """RRTMGP's band transmittances and radiances of paths through columns."""

    def __init__(self) -> None:
        self.thermal, self.solar = GasOptics("thermal"), GasOptics("solar")

    def transmittance(self, slant: Slant) -> tuple[Array, Array]:
        """Return transmittances (P, B) of thermal bands, weighted by wavenumber, and of solar bands, by sunlight."""
        cells = slant.cells()
        results = []
        for optics, weights in (
            (self.thermal, QUADRATURE / QUADRATURE.sum()),
            (self.solar, self.solar.solar_weights()),
        ):
            depth, _ = optics.evaluate(cells)
            results.append(np.sum(np.exp(-np.tensordot(slant.factor, depth, axes=1)) * weights, axis=-1))
        return results[0], results[1]

    def radiance(self, slant: Slant, surface_K: float) -> tuple[Array, Array]:
        """Return radiance to space of a black target in thermal bands, W m-2 sr-1, and its transmittance, (P, B).

        Layers are isothermal, as in the band model; transmittance is weighted with the target's emission.
        """
        depth, fraction = self.thermal.evaluate(slant.cells())
        assert fraction is not None
        first = slant.layers.first_cell
        fraction = fraction[first] / fraction[first].sum(axis=-1, keepdims=True)
        planck = self.thermal.planck(slant.layers.temperature_K)
        surface = self.thermal.planck(np.array([surface_K]))[0]
        radiance, transmittance = np.zeros((2, slant.factor.shape[0], depth.shape[1]))
        for row, factor in enumerate(slant.factor):
            by_layer = np.add.reduceat(factor[:, None, None] * depth, first, axis=0)
            beyond = np.concatenate((np.cumsum(by_layer[::-1], axis=0)[::-1], np.zeros_like(by_layer[:1])))
            open_ = np.exp(-beyond)
            emitted = np.sum((open_[1:] - open_[:-1]) * fraction, axis=-1)
            transmittance[row] = np.sum(open_[0] * fraction[0], axis=-1)
            radiance[row] = np.sum(emitted * planck, axis=0) + transmittance[row] * surface
        return radiance, transmittance


def evaluation_profiles(path: Path) -> list[Profile]:
    """Return the profiles of a file made by ``gas_evaluation_profiles.py``."""
    with netCDF4.Dataset(path) as file:
        columns = {name: variable[:] for name, variable in file.variables.items()}
        names = str(file.names).split(";")

    def row(name: str, number: int) -> Array:
        result: Array = columns[name][number].compressed().astype(float)
        return result

    return [
        Profile(
            name,
            row("altitude_m", number),
            row("pressure_Pa", number),
            row("temperature_K", number),
            {gas: row(gas, number) for gas in GASES},
        )
        for number, name in enumerate(names)
    ]


def scaled(profile: Profile, factors: dict[str, float]) -> Profile:
    """Return a profile with the amounts of gases multiplied."""
    ratios = {gas: ratio * factors.get(gas, 1.0) for gas, ratio in profile.mixing_ratio.items()}
    return replace(profile, mixing_ratio=ratios)
