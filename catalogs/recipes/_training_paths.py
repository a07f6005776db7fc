"""Paths through perturbed model atmospheres, with RRTMGP's results: what the band model is fitted to.

In the model atmospheres the gases hardly vary, or vary together, so a fit to them alone could not tell one gas from
another. Here temperature, humidity and ozone are perturbed, and the amount of each gas is scaled independently. The
profiles and the seed are not those of ``gas_evaluation_profiles.py``, which judge the fit.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from _gas_columns import Column, Reference, Slant, scaled
from gas_evaluation_profiles import perturbed
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.band_model.absorber_density import _ATM_CM_PER_KM, LOSCHMIDT_CM3, level_state
from hcss_twin.models.atmosphere.band_model.absorption import CONTINUA, BandModelCoefficients
from hcss_twin.models.atmosphere.band_model.layers import LayeredAir
from hcss_twin.models.atmosphere.cloud_top import SURFACE_TEMPERATURE_K
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.parameters import BandModelParameters
from hcss_twin.physics.paths import SPACE
from hcss_twin.physics.profile import EARTH_RADIUS_M, GASES, Profile

SEED: Final = 7
SETS: Final = 3
"""Sets of gases of each training profile; the first is unscaled."""

HEIGHTS_M: Final = (0.0, 1500.0, 3000.0, 6000.0, 10_000.0)
ZENITHS_DEG: Final = ((0.0,), (55.0,), (77.0,))
PARTS_M: Final = ((0.0, 300.0), (0.0, 1000.0), (0.0, 3000.0), (2000.0, 6000.0))
PART_ZENITHS_DEG: Final = ((0.0,), (75.0,))
HORIZONTAL_M: Final = (1000.0, 5000.0)
"""Lengths of horizontal paths at the sea, through the model atmospheres with unscaled gases."""

THIN_M: Final = 10.0
"""Their air is that of a vertical path so long."""

SUNS_DEG: Final = ((20.0, 0.0), (40.0, 60.0), (70.0, 20.0), (75.0, 60.0))
SUN_HEIGHTS_M: Final = (0.0, 3000.0, 8000.0)
LEVELS_M: Final = 1e3 * np.array(
    [0, 0.5, 1, 1.5, 2, 3, 4, 5, 6, 8, 10, 12, 14, 17, 20, 24, 28, 33, 40, 50, 65, 85, 120], dtype=float
)
"""Of the training profiles."""


def training() -> Iterator[Profile]:
    """Yield 12 perturbed model atmospheres, each with three sets of gases."""
    random = np.random.default_rng(SEED)
    catalog = Catalog()
    for name in SURFACE_TEMPERATURE_K:
        for number in range(2):
            base = thinned(perturbed(load_profile(name, catalog), random, f"{name} {number}"))
            yield base
            for _ in range(SETS - 1):
                factors = {gas: float(random.choice((0.02, 1.0, 2.0))) for gas in ("co2", "ch4", "n2o", "o3", "co")}
                yield scaled(base, factors | {"h2o": float(random.choice((0.02, 1.0, 1.6)))})


def thinned(profile: Profile) -> Profile:
    """Return a profile at ``LEVELS_M``: the fit needs many columns rather than fine layers."""
    at = profile.altitude_m

    def between(values: Array) -> Array:
        return np.exp(np.interp(LEVELS_M, at, np.log(values)))

    ratios = {gas: between(ratio) for gas, ratio in profile.mixing_ratio.items()}
    return Profile(profile.name, LEVELS_M, between(profile.pressure_Pa), profile.temperature_at(LEVELS_M), ratios)


@dataclass
class Paths:
    """Paths of one kind through all training columns, cells from the top downward, padded with nothing.

    Attributes
    ----------
    amount : dict of str to ndarray (N, M)
        Gas amounts of the cells in units of the band model, neither scaled with pressure nor temperature.
    pressure, cold : ndarray (N, M)
        p / p0 and T0 / T of the cells.
    continua : ndarray (N, B, 10)
        Cumulative amounts at the boundaries.
    boundary : ndarray of int (N, B)
        Number of cells above each layer boundary; one boundary, the lowest, for paths without emission.
    temperature_K : ndarray (N, B - 1)
        Of the layers.
    surface_K : ndarray (N,)
    kind : ndarray of str (N,)
        ``nadir`` from the sea to space or ``horizontal`` with unscaled gases; ``scaled``, nadir with scaled ones; else
        empty.
    reference : dict of str to ndarray (N, bands)
        Transmittance ``thermal`` and ``solar``, and ``radiance``.
    """

    amount: dict[str, Array]
    pressure: Array
    cold: Array
    continua: Array
    boundary: NDArray[np.intp]
    temperature_K: Array
    surface_K: Array
    kind: NDArray[np.str_]
    reference: dict[str, Array]


def _amounts(slant: Slant) -> tuple[dict[str, Array], Array, Array]:
    columns = slant.layers.amount
    air = columns[:, 0]
    unit = dict.fromkeys(GASES, _ATM_CM_PER_KM) | {"h2o": 0.1 * 2.989e-17 * LOSCHMIDT_CM3}
    gases = {gas: unit[gas] * columns[:, 1 + k] for k, gas in enumerate(GASES)}
    pressure, temperature = (columns[:, 1 + len(GASES) + k] / air for k in range(2))
    return gases, pressure / 101_325.0, 273.15 / temperature


def _kind(emitting: bool, low_m: float, zeniths_deg: tuple[float, ...], scaled_gases: bool) -> str:
    if emitting and low_m == 0.0 and zeniths_deg == (0.0,):
        return "scaled" if scaled_gases else "nadir"
    return ""


def make_paths(emitting: bool, coefficients: BandModelCoefficients, reference: Reference) -> Paths:
    """Return all training paths with emission to space, or all others."""
    kept: list[dict[str, Any]] = []
    parameters = BandModelParameters(aerosol="none")
    for number, profile in enumerate(training()):
        scaled_gases = number % SETS != 0
        column = Column(profile)
        air = LayeredAir(level_state(profile, coefficients, parameters), EARTH_RADIUS_M)
        groups = (
            [(low, SPACE, ZENITHS_DEG) for low in HEIGHTS_M]
            if emitting
            else [(*part, PART_ZENITHS_DEG) for part in PARTS_M] + [(low, SPACE, SUNS_DEG) for low in SUN_HEIGHTS_M]
        )
        if not emitting and not scaled_gases:
            groups.append((0.0, THIN_M, ((0.0,),)))
        for low, high, zeniths in groups:
            slant = column.slant(low, high, zeniths)
            horizontal = high == THIN_M
            if horizontal:
                slant = Slant(slant.layers, slant.factor * np.array(HORIZONTAL_M)[:, None] / THIN_M)
            surface = float(profile.temperature_at(low))
            thermal, solar = reference.transmittance(slant)
            known = {"thermal": thermal, "solar": solar}
            if emitting:
                known["radiance"], known["thermal"] = reference.radiance(slant, surface)
            gases, pressure, cold = _amounts(slant)
            channels = len(coefficients.channel_gas)
            continua = air.between(low, high).amount[:, channels : channels + len(CONTINUA)]
            first = slant.layers.first_cell
            cells = pressure.size
            above = cells - np.append(first, cells)[::-1] if emitting else np.array([cells])
            for row, factor in enumerate(slant.factor):
                total = np.concatenate(
                    (np.zeros((1, len(CONTINUA))), np.cumsum((factor[:, None] * continua)[::-1], axis=0))
                )
                kept.append(
                    {
                        "amount": {gas: (factor * values)[::-1] for gas, values in gases.items()},
                        "pressure": pressure[::-1], "cold": cold[::-1], "continua": total[above], "boundary": above,
                        "kind": "horizontal" if horizontal else _kind(emitting, low, zeniths[row], scaled_gases),
                        "temperature": slant.layers.temperature_K[::-1], "surface": surface,
                        "reference": {name: values[row] for name, values in known.items()},
                    }
                )  # fmt: skip
    cells = max(each["pressure"].size for each in kept)
    ends = max(each["boundary"].size for each in kept)

    def padded(values: list[Any], size: int, fill: float | None) -> Any:
        """Stack rows of different lengths, with ``fill`` or their last value beyond the end."""
        rows = []
        for value in values:
            more = [(0, size - value.shape[0]), *[(0, 0)] * (value.ndim - 1)]
            rows.append(np.pad(value, more, mode="edge") if fill is None else np.pad(value, more, constant_values=fill))
        return np.stack(rows)

    return Paths(
        {gas: padded([each["amount"][gas] for each in kept], cells, 0.0) for gas in GASES},
        padded([each["pressure"] for each in kept], cells, 1.0),
        padded([each["cold"] for each in kept], cells, 1.0),
        padded([each["continua"] for each in kept], ends, None),
        padded([each["boundary"] for each in kept], ends, None),
        padded([each["temperature"] for each in kept], ends - 1, None) if emitting else np.zeros((len(kept), 0)),
        np.array([each["surface"] for each in kept]),
        np.array([each["kind"] for each in kept]),
        {name: np.stack([each["reference"][name] for each in kept]) for name in kept[0]["reference"]},
    )
