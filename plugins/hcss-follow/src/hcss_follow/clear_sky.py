"""Temperature of the sea and water vapour from clear pixels at 10.8 and 12.0 um: their joint posterior, by emcee.

Each pair explains the two channels to some degree: a warmer sea under more vapour looks like a colder one under less.
The forward model is the scene's own clear column on a grid of both, between which it is interpolated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import hcss_twin
from hcss_twin.providers import Array, HcssError, planck

CLEAR_K = 1.0
"""Pixels count as clear if no more than this below the warmest of their surroundings."""

ENOUGH = 1000
"""Clear pixels that a fit should have."""

CHANNEL_K, PRIOR_SEA_K, PRIOR_VAPOUR = 0.25, 2.0, 0.3
"""Standard deviations: of a channel's calibration and the model's gas, and of the climatology's sea and (natural
logarithm of) vapour."""

_SEA_K = np.linspace(-6.0, 6.0, 3)
_DRIEST, _WETTEST, _LESS, _SCALES = 0.4, 2.0, 0.92, 4
"""Range of the vapour's scale, and by which factor the wettest is reduced until the air of the plan holds it."""

_WALKERS, _STEPS, _BURNT, _SEED = 24, 1200, 400, 7


@dataclass(frozen=True)
class Table:
    """Brightness temperature of the clear sky by the temperature of the sea and the scale of the vapour.

    Attributes
    ----------
    sea_K, scales : ndarray (S,), (V,)
    grid_K : ndarray (S, V, B)
    bands : tuple of str
    """

    sea_K: Array
    scales: Array
    grid_K: Array
    bands: tuple[str, ...]

    @property
    def climatology_K(self) -> float:
        """Temperature of the sea of the climatology."""
        return float(self.sea_K[self.sea_K.size // 2])

    def kelvin(self, at: Array) -> Array:
        """Return brightness temperatures (N, B) at (N, 2): bilinear, in the logarithm of the scale."""
        position = np.interp(at[:, 0], self.sea_K, np.arange(self.sea_K.size))
        other = np.interp(np.log(at[:, 1]), np.log(self.scales), np.arange(self.scales.size))
        i, j = (
            np.minimum(position.astype(int), self.sea_K.size - 2),
            np.minimum(other.astype(int), self.scales.size - 2),
        )
        fi, fj = (position - i)[:, None], (other - j)[:, None]
        low = (1.0 - fj) * self.grid_K[i, j] + fj * self.grid_K[i, j + 1]
        high = (1.0 - fj) * self.grid_K[i + 1, j] + fj * self.grid_K[i + 1, j + 1]
        result: Array = (1.0 - fi) * low + fi * high
        return result


@dataclass(frozen=True)
class ClearSky:
    """What the clear sky says of sea and vapour.

    Attributes
    ----------
    draws : ndarray (N, 2)
        Of the posterior: temperature of the sea in K, scale of the vapour.
    predicted_K : ndarray (N, B)
        Brightness temperature of the clear sky in the scenario's bands.
    bands : tuple of str
    pixels : int
        That were clear.
    table : Table
    """

    draws: Array
    predicted_K: Array
    bands: tuple[str, ...]
    pixels: int
    table: Table

    def warm_sea_K(self, kelvin: float) -> float:
        """Return the temperature of the sea with a brightness temperature in the first band; vapour: the median."""
        vapour = float(np.median(self.draws[:, 1]))
        sea_K = np.array([self.table.sea_K[0], self.table.sea_K[-1]])
        seen = self.table.kelvin(np.stack([sea_K, np.full(2, vapour)], axis=1))[:, 0]
        return float(sea_K[0] + (kelvin - seen[0]) * (sea_K[1] - sea_K[0]) / (seen[1] - seen[0]))

    @property
    def notes(self) -> tuple[str, ...]:
        """Why not to trust it; mostly empty."""
        if self.pixels >= ENOUGH:
            return ()
        return (f"sea and vapour: {self.pixels} clear pixels; expected: {ENOUGH} or more",)


def clear_pixels(kelvin: NDArray[np.floating], clear_K: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Return which pixels are clear, by brightness temperature and the map of the clear sky."""
    done: NDArray[np.bool_] = kelvin > clear_K - CLEAR_K
    return done


def fit_clear_sky(scenario: Mapping[str, Any], measured_K: Sequence[float], pixels: int) -> ClearSky:
    """Return the posterior for the mean brightness temperatures of clear pixels.

    Parameters
    ----------
    scenario : mapping
        Place, time, view and bands; those measured come first.
    measured_K : sequence of float
        One or two.
    """
    table = clear_sky_table(scenario)
    draws = posterior(table, measured_K)
    return ClearSky(draws, table.kelvin(draws), table.bands, pixels, table)


def clear_sky_table(scenario: Mapping[str, Any]) -> Table:
    """Return the brightness temperatures of the clear sky of a scenario."""
    start = hcss_twin.make_plan(hcss_twin.Scenario.from_dict(_clear(scenario, None, 1.0)))
    sea = float(start.assembly.sea_temperature_K)
    scales = np.geomspace(_DRIEST, _wettest(scenario), _SCALES)
    seen = [[_clear_K(_clear(scenario, sea + by, scale)) for scale in scales] for by in _SEA_K]
    return Table(sea + _SEA_K, scales, np.array([[kelvin for _, kelvin in row] for row in seen]), seen[0][0][0])


def posterior(table: Table, measured_K: Sequence[float]) -> Array:
    """Return draws (N, 2) of sea and vapour for brightness temperatures in the first bands of a table."""
    import emcee

    sea, scales, count = table.climatology_K, table.scales, len(measured_K)

    def log_posterior(at: Array) -> Array:
        inside = (np.abs(at[:, 0] - sea) < _SEA_K[-1]) & (at[:, 1] > scales[0]) & (at[:, 1] < scales[-1])
        safe = np.where(inside[:, None], at, [sea, 1.0])
        misfit = ((table.kelvin(safe)[:, :count] - np.array(measured_K)) / CHANNEL_K) ** 2
        prior = ((safe[:, 0] - sea) / PRIOR_SEA_K) ** 2 + (np.log(safe[:, 1]) / PRIOR_VAPOUR) ** 2
        return np.where(inside, -0.5 * (misfit.sum(axis=1) + prior), -np.inf)

    rng = np.random.default_rng(_SEED)
    vapour = np.exp(rng.uniform(np.log(scales[0]), np.log(scales[-1]), _WALKERS))  # inside the limits
    first = np.stack([sea + rng.normal(0.0, 0.5, _WALKERS), vapour], axis=1)
    sampler = emcee.EnsembleSampler(_WALKERS, 2, log_posterior, vectorize=True)
    sampler.random_state = np.random.RandomState(_SEED).get_state()
    sampler.run_mcmc(first, _STEPS)
    draws: Array = sampler.get_chain(discard=_BURNT, thin=4, flat=True)
    return draws


def _wettest(scenario: Mapping[str, Any]) -> float:
    """Return a scale of the vapour that the plan allows: limits of the sampler are those of the scene."""
    scale = _WETTEST
    while True:
        try:
            hcss_twin.make_plan(hcss_twin.Scenario.from_dict(_clear(scenario, None, scale)))
        except hcss_twin.ScenarioError:
            scale *= _LESS
            if scale < 1.0:
                raise
        else:
            return scale


def _clear(scenario: Mapping[str, Any], sea_K: float | None, scale: float) -> dict[str, Any]:
    """Return a scenario without clouds, with a sea and a vapour."""
    made = {key: value for key, value in scenario.items() if key not in ("clouds", "frames", "output", "slant")}
    made["image"] = {"rows": 1, "columns": 1, "pixel_size": 1000.0}
    made["atmosphere"] = {**scenario.get("atmosphere", {}), "water_vapour_scale": scale}
    made["sea"] = {} if sea_K is None else {"temperature": sea_K}
    return made


def _clear_K(scenario: Mapping[str, Any]) -> tuple[tuple[str, ...], Array]:
    """Return names and brightness temperatures of the bands of a clear scene."""
    spectra = hcss_twin.column_spectra(hcss_twin.Scenario.from_dict(dict(scenario)))
    kelvin = np.linspace(200.0, 340.0, 1401)
    black = planck(spectra.wavenumber_cm1, kelvin[:, None]) @ spectra.weights_cm1.T
    seen = spectra.radiance[0] @ spectra.weights_cm1.T
    if not np.all((seen > black[0]) & (seen < black[-1])):
        raise HcssError("clear sky: brightness temperatures outside 200 to 340 K")
    return spectra.bands, np.array([np.interp(s, b, kelvin) for s, b in zip(seen, black.T, strict=True)])
