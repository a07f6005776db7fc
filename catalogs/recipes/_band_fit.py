"""Fit the band model to RRTMGP's results in one band after another.

Least squares on band means alone leave much undetermined: weak gases, and the absorption within a band. So every number
has a prior and limits, errors count in units of what is allowed, and the choices below keep the fit near MODTRAN where
RRTMGP's means cannot tell. In the bands of ``STRUCTURED`` the structure is fitted too; elsewhere a contrast made whole
bands better, but the absorption within them worse against MODTRAN (655-750 and, beyond a limit, 2250-2390 cm-1).
"""

from __future__ import annotations

from typing import Final

import numpy as np
from _fitted_bands import CONTINUA_OF, UNCHANGED, Bands, Term
from _training_paths import Paths
from scipy.optimize import least_squares

from hcss_twin.core.arrays import Array
from hcss_twin.models.atmosphere.band_model.absorption import CONTINUA
from hcss_twin.physics.planck import planck

ALLOWED_T, ALLOWED_L, ALLOWED_SUN = 0.005, 0.006, 0.03
"""Errors that count as one: of transmittance, radiance (relative) and sunlight (relative, where 2 % arrive)."""

SUN_K: Final = 5777.0

KEPT: Final = {1800: ("co2",), 2080: ("co2",)}
"""Gases that keep LOWTRAN7's coefficients, by the lower limit of the band: fitted, CO2 misses MODTRAN by more."""

KEPT_CONTINUUM: Final = (2680, 3250)
"""Bands that keep LOWTRAN7's continua, which are within 20 % of MODTRAN's above 3000 cm-1; fitted: 2 and 3 times."""

NADIR: Final = {700: (20.0, 10.0, 5.0), 2390: (100.0, 3.0, 1.0), 2680: (15.0, 15.0, 15.0)}
"""Weights of the errors of nadir paths from the sea to space: of radiance with unscaled and with scaled gases, and of
transmittance. Other paths weigh 1; with equal weights, nadir radiance was .4 % high at 700 to 820 cm-1 and 1 to 3 % low
in the other two."""

HORIZONTAL: Final = {2390: 5.0, 2680: 5.0}
"""Weights of horizontal paths at the sea."""

MOIST: Final = {820: 14.0, 980: 14.0, 1080: 14.0}
"""Weights of warm horizontal paths at the sea, which follow LOWTRAN7's mean transmittance: through 5 km of tropical air
in 8-14 um it is that of MODTRAN to .2 %, but 8 % more than RRTMGP's, whose newer self continuum is stronger."""

WARM_K: Final = 290.0
"""Air of MOIST paths is warmer; LOWTRAN7's foreign continuum makes drier air too opaque. In these bands the two tables
of the self continuum, for 296 and 260 K, have factors of their own, so that colder air still follows RRTMGP."""

KEPT_EXPONENT: Final = (2250,)
"""Bands where the exponent of the amount of CO2 is kept: steeper wings miss MODTRAN and make the largest step larger,
flatter ones miss the absorption of short paths."""

KEPT_WITHIN: Final = 1e-3

STRUCTURED: Final = (1180, 2080, 2250, 2390, 2680, 3250)
"""Bands in which tilt and contrast are fitted too: 6 numbers of ``Term`` instead of 4."""

LOWEST_CONTRAST: Final = {2250: float(np.log(0.92))}
"""With less contrast, the absorption of short paths falls below that of MODTRAN."""

LOWEST: Final = (-5.0, -1.2, -1.0, -3.0, -1.0, -0.7)
HIGHEST: Final = (3.0, 0.0, 1.0, 3.0, 1.0, 0.9)
WIDTH: Final = (1.5, 0.4, 0.4, 1.5, 0.4, 0.3)
"""Limits of the fitted numbers, and their usual size."""

PRIOR: Final = 0.03
"""Weight of the usual sizes against all errors."""


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
        self.edge = low
        unscaled, scaled, transmittance = NADIR.get(low, (1.0, 1.0, 1.0))
        kind = self.emitting.kind
        self.nadir = (
            np.where(kind == "nadir", unscaled, np.where(kind == "scaled", scaled, 1.0)),
            np.where(kind == "", 1.0, transmittance),
        )
        self.thermal_band = self._band_of("thermal", low, high)
        self.solar_band = self._band_of("solar", low, high)
        bands.forget()
        near = [k for k in range(len(bands.bands)) if k != number and bands.share[k, nodes].any()]
        self.fixed = []
        for paths in (self.emitting, self.dark):
            if self.thermal_band is None and paths is self.emitting:
                paths = self._ends(paths)
            self.fixed.append((paths, sum(bands.depth(k, paths, nodes, only_fitted=False) for k in near)))
        self.horizontal = (self.dark.kind == "horizontal") & (self.dark.surface_K > WARM_K)
        self.moist = self._lowtran7() if low in MOIST else None
        if self.thermal_band is not None:
            paths = self.emitting
            self.layer = np.float32(planck(v[nodes], paths.temperature_K[:, :, None]) * self.step_cm1)
            self.ground = np.float32(planck(v[nodes], paths.surface_K[:, None]) * self.step_cm1)

    def _lowtran7(self) -> Array:
        """Return the mean transmittance (N,) of the horizontal paths with LOWTRAN7's coefficients."""
        given, paths = Bands(self.bands.given), self.dark
        rows = {name: getattr(paths, name)[self.horizontal] for name in ("pressure", "cold", "continua", "boundary")}
        amount = {gas: values[self.horizontal] for gas, values in paths.amount.items()}
        some = Paths(**{**paths.__dict__, **rows, "amount": amount})
        near = [k for k in range(len(given.bands)) if given.share[k, self.nodes].any()]
        depth = sum(given.depth(k, some, self.nodes, only_fitted=False) for k in near)
        result: Array = np.exp(-depth[:, -1]) @ self.weights
        return result

    @staticmethod
    def _ends(paths: Paths) -> Paths:
        """Return paths with emission without their inner boundaries."""
        last = {"continua": paths.continua[:, -1:], "boundary": paths.boundary[:, -1:]}
        return Paths(**{**paths.__dict__, **last})

    def _band_of(self, spectrum: str, low: int, high: int) -> int | None:
        limits = [tuple(band) for band in self.bands.optics[spectrum].band_cm1]
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
                of_radiance, of_transmittance = self.nadir
                error = (emitted + ground.sum(1)) / known["radiance"][:, self.thermal_band] - 1.0
                parts.append(of_radiance * error / ALLOWED_L)
                mean = ground.sum(1) / self.ground.sum(1)
                parts.append(of_transmittance * (mean - known["thermal"][:, self.thermal_band]) / ALLOWED_T)
            elif self.thermal_band is not None:
                wanted = known["thermal"][:, self.thermal_band]
                error = seen[:, -1] @ self.weights - wanted
                if self.edge in HORIZONTAL:
                    error[self.horizontal] *= HORIZONTAL[self.edge]
                if self.moist is not None:
                    error[self.horizontal] = MOIST[self.edge] * (seen[self.horizontal, -1] @ self.weights - self.moist)
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
            and (name != "cold" or edge in MOIST)
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
            high[size * k + 1] = -float(np.log(min(largest, 0.99)))
            if gas == "co2" and edge in KEPT_EXPONENT:
                low[size * k + 1], high[size * k + 1] = -KEPT_WITHIN, KEPT_WITHIN
        width = np.array([*WIDTH[:size]] * len(gases) + [0.5] * len(continua))

        def apply(values: Array) -> None:
            for k, gas in enumerate(gases):
                bands.gas[number][gas] = Term.from_numbers(values[size * k : size * (k + 1)])
            for name, value in zip(continua, values[size * len(gases) :], strict=True):
                bands.continuum[number][name] = float(np.exp(value))
            if "self" in continua and "cold" not in continua:
                bands.continuum[number]["cold"] = bands.continuum[number]["self"]

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
