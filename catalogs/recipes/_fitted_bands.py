"""The fitted band model: LOWTRAN7's channels, changed for each gas in each RRTMGP band.

RRTMGP knows only means over bands, so the spectral structure within a band stays LOWTRAN7's, and what is fitted is a
few numbers for each gas (``Term``) and a factor for each continuum. Gases that RRTMGP lacks in a band keep LOWTRAN7's
coefficients there and take no part in the fit. Bands are blended linearly at their edges, because optical depth must
not jump there.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import exp, log
from typing import Any, Final

import numpy as np
from _training_paths import Paths
from numpy.typing import NDArray
from rrtmgp_gas_optics import G_POINTS, GasOptics

from hcss_twin.core.arrays import Array
from hcss_twin.models.atmosphere.band_model.absorption import CONTINUA, TRACE_GASES, BandModelCoefficients

EDGES_CM1: Final = (
    500, 630, 700, 820, 980, 1080, 1180, 1390, 1480, 1800, 2080, 2250, 2390, 2680, 3250, 4000, 4650, 5150, 6150, 7700,
    8050, 12850,
)  # fmt: skip
"""Of the fitted bands; RRTMGP's thermal bands to 3250 cm-1 and its solar bands from 2680 cm-1."""

THERMAL_BELOW_CM1: Final = 3250
BLEND_CM1: Final = {630: 10.0, 700: 10.0, 820: 10.0, 980: 10.0, 2390: 50.0}
"""Width of the blend at edges of bands; at others 25 cm-1."""

KEPT_CM1: Final = ((2070, 2105),)
"""Where all gases keep LOWTRAN7's coefficients, as fitted ones miss MODTRAN by more; the blend is 10 cm-1 wide."""

CONTINUA_OF: Final = {
    "self": ("water_self",),
    "cold": ("water_self_260",),
    "foreign": ("water_foreign",),
    "n2": ("nitrogen",),
    "o2": ("oxygen", "oxygen_linear", "oxygen_quadratic"),
}


@dataclass(frozen=True)
class Term:
    """One term of a gas in a band, relative to LOWTRAN7's.

    Factors on strength and on the exponent of amount; changes of the exponents of pressure and temperature; tilt of
    ln(strength) across the band; factor on C' beside that of the exponent of amount.
    """

    strength: float = 1.0
    amount: float = 1.0
    pressure: float = 0.0
    temperature: float = 0.0
    tilt: float = 0.0
    contrast: float = 1.0

    @classmethod
    def from_numbers(cls, numbers: Array) -> Term:
        """Return the term of logarithms (of factors) and plain numbers."""
        values = [float(each) for each in numbers]
        return cls(float(np.exp(values[0])), float(np.exp(values[1])), *values[2:5], *map(exp, values[5:]))

    def numbers(self) -> list[float]:
        """Return the numbers that are fitted."""
        return [*map(log, (self.strength, self.amount)), self.pressure, self.temperature, self.tilt, log(self.contrast)]


UNCHANGED: Final = Term()


class Bands:
    """The fitted model in all bands.

    Attributes
    ----------
    optics : dict of str to GasOptics
        RRTMGP's tables, ``thermal`` and ``solar``.
    gas : list of dict of str to Term
        By band, last those of ``KEPT_CM1``; a gas that is missing has LOWTRAN7's coefficients.
    continuum : list of dict of str to float
        Factors by band.
    """

    def __init__(self, coefficients: BandModelCoefficients) -> None:
        self.given = coefficients
        self.optics = {name: GasOptics(name) for name in ("thermal", "solar")}
        self._kept: dict[Any, list[tuple[Term, Any]]] = {}
        self.wavenumber_cm1 = coefficients.wavenumber_cm1
        self.fitted = list(pairwise(EDGES_CM1))
        self.bands = [*self.fitted, *KEPT_CM1]
        self.gas: list[dict[str, Term]] = [{} for _ in self.bands]
        self.continuum: list[dict[str, float]] = [{} for _ in self.bands]
        self.share = self._shares()
        self.has = [self._gases_of(*band) for band in self.fitted]
        for low, high in KEPT_CM1:
            self.has.append(next(self.has[k] for k, band in enumerate(self.fitted) if low + high < 2 * band[1]))

    def _shares(self) -> Array:
        """Return the weight of each band at each wavenumber, (bands, V); beyond the last band its edge counts."""
        shares = np.zeros((len(self.bands), self.wavenumber_cm1.size))
        for number, edges in enumerate(self.fitted):
            ramps = []
            for edge in edges:
                ramps.append(np.clip((self.wavenumber_cm1 - edge) / BLEND_CM1.get(edge, 25.0) + 0.5, 0.0, 1.0))
            if edges[0] == EDGES_CM1[0]:
                ramps[0] = np.ones_like(ramps[0])
            shares[number] = ramps[0] - ramps[1]
        for number, (low, high) in enumerate(KEPT_CM1, len(self.fitted)):
            inside = np.minimum(self.wavenumber_cm1 - low, high - self.wavenumber_cm1)
            kept = np.clip(inside / 10.0 + 0.5, 0.0, 1.0)
            shares *= 1.0 - kept
            shares[number] = kept
        return shares

    def _gases_of(self, low: int, high: int) -> set[str]:
        """Return the gases and continua that RRTMGP has in a band."""
        optics = self.optics["thermal" if high <= THERMAL_BELOW_CM1 else "solar"]
        number = next(k for k, band in enumerate(optics.band_cm1) if tuple(band) == (low, high))
        table = optics._table
        found = {optics._gases[k] for k in table["key_species"][number].ravel()} - {"dry_air"}
        for side in ("lower", "upper"):
            for first, _, gas, _, density, _ in optics._minor[side]:
                if first == G_POINTS * number:
                    found.add(f"{gas} continuum" if density and gas != "h2o" else gas)
        renamed = {"n2 continuum": "n2", "o2 continuum": "o2 continuum"}
        return {renamed.get(gas, gas) for gas in found} | {"self", "cold", "foreign"}

    def rows(self, number: int) -> dict[int, list[int]]:
        """Return the LOWTRAN7 channels with absorption where a band counts: numbers, by fitted or not."""
        inside = self.share[number] > 0.0
        given = self.given
        some = [k for k in range(given.exponent.size) if given.absorption[k, inside].any()]
        fitted = [k for k in some if given.channel_gas[k] in self.has[number]]
        return {1: fitted, 0: [k for k in some if k not in fitted]}

    def forget(self) -> None:
        """Free the remembered optical depths: the next band has other nodes."""
        self._kept.clear()

    def _remembered(self, number: int, channel: int, term: Term, paths: Paths, nodes: NDArray[np.intp]) -> Any:
        """Return the optical depth of a term; the last two of each channel are kept, as slopes vary one at a time."""
        key = (number, channel, id(paths), nodes.tobytes())
        kept = self._kept.setdefault(key, [])
        for known, depth in kept:
            if known == term:
                return depth
        given = self.given
        cells = paths.amount[given.channel_gas[channel]] * paths.pressure ** (
            given.pressure_exponent[channel] + term.pressure
        )
        cells = cells * paths.cold ** (given.temperature_exponent[channel] + term.temperature)
        total = np.concatenate((np.zeros((cells.shape[0], 1)), np.cumsum(cells, axis=1)), axis=1)
        amount = np.take_along_axis(total, paths.boundary, axis=1) ** (given.exponent[channel] * term.amount)
        spectrum = self.spectrum(number, channel, term)[nodes]
        depth = amount.astype(np.float32)[:, :, None] * spectrum.astype(np.float32)
        self._kept[key] = [*kept[-1:], (term, depth)]
        return depth

    def spectrum(self, number: int, channel: int, term: Term) -> Array:
        """Return the coefficients of a channel in a band, weighted with the share of the band, (V,)."""
        low, high = self.bands[number]
        across = np.clip((2.0 * self.wavenumber_cm1 - low - high) / (high - low), -1.0, 1.0)
        given = self.given.absorption[channel]
        powers = np.where(given > 0.0, given, 1.0) ** (term.amount * term.contrast) * (given > 0.0)
        result: Array = term.strength * powers * np.exp(term.tilt * across) * self.share[number]
        return result

    def depth(self, number: int, paths: Paths, nodes: NDArray[np.intp], *, only_fitted: bool) -> Array:
        """Return optical depths (N, B, V) at the nodes from the terms of one band, weighted with its share."""
        given = self.given
        result = np.zeros((*paths.boundary.shape, nodes.size), dtype=np.float32)
        kinds = self.rows(number)
        for channel in kinds[1] + ([] if only_fitted else kinds[0]):
            gas = given.channel_gas[channel]
            if gas in TRACE_GASES:
                continue
            if not given.absorption[channel, nodes].any():
                continue
            result += self._remembered(number, channel, self.gas[number].get(gas, UNCHANGED), paths, nodes)
        factors = np.ones(len(CONTINUA))
        factors[[CONTINUA.index(each) for each in ("rayleigh", "ozone_visible", "nitric_acid")]] = 0.0
        for name, members in CONTINUA_OF.items():
            present = ("o2 continuum" if name == "o2" else name) in self.has[number]
            for each in members:
                factors[CONTINUA.index(each)] = self.continuum[number].get(name, 1.0) if present else 0.0
        coefficients = given.absorption[given.exponent.size :, nodes] * factors[:, None] * self.share[number, nodes]
        used = coefficients.any(axis=1)
        result += paths.continua[:, :, used].astype(np.float32) @ coefficients[used].astype(np.float32)
        return result
