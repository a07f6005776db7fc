"""Contributions to the error of a class and band: their form, and those that follow from what providers state.

Each provider may state how far it is from the best reference known, by wavelength and column
(:class:`hcss_twin.providers.ModelError`). A figure of a band is the mean of those of its wavelengths, weighted with the
radiance of a black body at the temperature of the class: errors inside a band are taken as fully correlated.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.optics.size_distribution import DENSITY_KG_M3
from hcss_twin.physics.planck import planck
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import ModelError

CLEAR, CLOUDY = "clear", "cloudy"

LEAST_KNOWN, MOSTLY_KNOWN = 0.05, 0.95
"""Share of a band with figures up to which they say nothing of the band, and from which they say all."""

_UNSTATED = {
    "gas": (CLEAR, CLOUDY),
    "particles": (CLOUDY,),
    "sea": (CLEAR,),
    "surfaces": (CLEAR,),
    "radiance model": (CLEAR, CLOUDY),
}
"""Contributions of providers that state nothing, and the classes that they change."""


@dataclass(frozen=True)
class Contribution:
    """Error of one cause in one class and band.

    Attributes
    ----------
    relative, kelvin : float or None
        Of the band radiance, and of the brightness temperature; None: unknown.
    known : float
        Share of the band's radiance at wavelengths with a figure; the rest is taken as equal to it.
    statistic : str
        ``at most``, ``rms`` or ``largest``.
    sources : tuple of str
    recomputed : bool
        Whether a command of this package computes every figure again; False: some are from notes.
    needs : str
        Key and value that avoid the error, if there are any.
    """

    name: str
    relative: float | None = None
    kelvin: float | None = None
    known: float = 0.0
    statistic: str = ""
    sources: tuple[str, ...] = ()
    recomputed: bool = True
    needs: str = ""

    @property
    def unknown(self) -> str:
        """What of it is unknown: its name, if need be with the share of the band; empty if all is known."""
        if self.relative is None:
            return self.name
        return "" if self.known > MOSTLY_KNOWN else f"{self.name} in {100.0 * (1.0 - self.known):.0f} % of the band"


def stated_errors(provider: Any) -> Sequence[ModelError] | None:
    """Return what a provider states of its errors; None if it states nothing."""
    stated = getattr(provider, "model_errors", None)
    return None if stated is None else stated()


class WeightedBand:
    """Wavelengths of one band, weighted with the radiance of a black body."""

    def __init__(self, plan: Plan, index: int, temperature_K: float) -> None:
        wavenumber, weights = plan.spectral_grid.wavenumber_cm1, plan.spectral_grid.weights_cm1[index]
        inside = np.flatnonzero(weights)
        self.wavelength_um: Array = 1e4 / wavenumber[inside]
        around = temperature_K + np.array([[-0.5], [0.0], [0.5]])
        low, middle, high = planck(wavenumber[inside][None], around) * weights[inside]
        self.shortest_um, self.longest_um = float(self.wavelength_um.min()), float(self.wavelength_um.max())
        self.weights: Array = middle / np.sum(middle)
        self.per_kelvin = float(np.log(np.sum(high) / np.sum(low)))

    def kelvin(self, relative: float | None) -> float | None:
        """Return the error of the brightness temperature."""
        return None if relative is None else relative / self.per_kelvin

    def mean(self, errors: Iterable[ModelError]) -> tuple[float | None, float]:
        """Return the mean error of the wavelengths with a figure, and their share; the largest figure counts."""
        at = np.full(self.wavelength_um.size, np.nan)
        for error in errors:
            relative = error.relative if error.relative is not None else (error.kelvin or 0.0) * self.per_kelvin
            inside = (self.wavelength_um >= error.lower_um) & (self.wavelength_um <= error.upper_um)
            at[inside] = np.fmax(at[inside], relative)
        known = ~np.isnan(at)
        share = float(np.sum(self.weights[known]))
        return (float(self.weights[known] @ at[known]) / share if share > LEAST_KNOWN else None), share


def contributions_of(
    plan: Plan, name: str, errors: Sequence[ModelError] | None, of: str, kind: str, band: WeightedBand
) -> Iterable[Contribution]:
    """Yield the contributions of one provider to a class and band; an unknown one if it states nothing for it."""
    if not errors:
        if kind in _UNSTATED.get(name, ()):
            yield Contribution(name)
        return
    sunlight, zenith_deg = (None, plan.sun_matters), plan.view.zenith_deg
    columns = {"", kind, of, *(layer.microphysics.material for layer in plan.layers if layer.name == of)}
    is_stated = name == "radiance model" or kind not in _UNSTATED.get(name, ())  # some models add nothing to clear sky
    for cause in dict.fromkeys(error.name for error in errors):
        every = [error for error in errors if error.name == cause and error.path == "up"]
        # What is known for other clouds only is unknown here, unless it is of another material.
        others = set() if kind == CLEAR else {error.column for error in every} - {CLEAR}
        if cause != name:
            others -= DENSITY_KG_M3.keys()
        if not any(error.column in columns | others for error in every):
            continue
        fitting = [
            error
            for error in every
            if error.column in columns
            and error.sunlight in sunlight
            and error.zenith_deg[0] <= zenith_deg <= error.zenith_deg[1]
            and error.lower_um <= band.longest_um
            and error.upper_um >= band.shortest_um
        ]
        is_stated = True
        relative, share = band.mean(fitting)
        yield Contribution(
            cause,
            relative,
            band.kelvin(relative),
            share,
            fitting[0].statistic if fitting else "",
            tuple(dict.fromkeys(error.source for error in fitting)),
            all(error.command for error in fitting),
            next((error.needs for error in fitting if error.needs), ""),
        )
    if not is_stated:  # only other paths or columns
        yield Contribution(name)
