"""The total error of a scene: that of the engine, of its numerics, and what each provider states of itself.

Each provider may state how far it is from the best reference known, by wavelength and column
(:class:`hcss_twin.providers.ModelError`). A figure of a band is the mean of those of its wavelengths, weighted with the
radiance of a black body at the temperature of the class: errors inside a band are taken as fully correlated.
Contributions have different causes and unknown signs, so that the total is the root of their sum of squares. It counts
known contributions only, and is a lower limit where others are unknown.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.optics.size_distribution import DENSITY_KG_M3
from hcss_twin.physics.planck import planck
from hcss_twin.plan.few_columns import OMISSION_SHARE
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import ModelError

ENGINE, NUMERICS = "engine", "numerics"
"""Contributions for which ``PASSED`` stands: tables and interpolation; streams, modes and grids."""

COLUMNS, SIDES = "plane-parallel clouds", "clouds with sides"
"""Error of independent columns, and that of the light between them which takes its place."""

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


@dataclass(frozen=True)
class ErrorBudget:
    """Contributions by class (``clear``, or the name of a cloud layer) and band."""

    contributions: Mapping[tuple[str, str], tuple[Contribution, ...]]

    def total(self, cell: tuple[str, str]) -> tuple[float, float]:
        """Return the root sum of squares of the known contributions of a class and band, relative and in kelvin.

        It is a total only if none is :meth:`unknown`; otherwise the error is at least that.
        """
        known = [contribution for contribution in self.contributions[cell] if contribution.relative is not None]
        relative, kelvin = (
            [getattr(contribution, unit) or 0.0 for contribution in known] for unit in ("relative", "kelvin")
        )
        return math.hypot(*relative), math.hypot(*kelvin)

    def unknown(self, cell: tuple[str, str]) -> list[str]:
        """Return what is unknown of a class and band."""
        return [contribution.unknown for contribution in self.contributions[cell] if contribution.unknown]

    def as_dict(self) -> dict[str, dict[str, Any]]:
        """Return total and contributions by class and band, as JSON values; ``at_least`` where part is unknown."""
        told: dict[str, dict[str, Any]] = {}
        for (of, band), contributions in self.contributions.items():
            relative, kelvin = self.total((of, band))
            unknown = self.unknown((of, band))
            name = "at_least" if unknown else "total"
            told.setdefault(of, {})[band] = {
                name: relative,
                f"{name}_K": kelvin,
                "unknown": unknown,
                "contributions": [
                    {**vars(contribution), "sources": list(contribution.sources)} for contribution in contributions
                ],
            }
        return told

    @property
    def lines(self) -> tuple[str, ...]:
        """Return a line for each class and band: the total, then its contributions, the largest first."""
        return tuple(f"{of} {band}: {self._cell(of, band)}" for of, band in self.contributions)

    @property
    def totals(self) -> tuple[str, ...]:
        """Return a line for each class: the total of each band, its largest contribution, and what is unknown."""
        by_class: dict[str, list[str]] = {}
        unknown: dict[str, dict[str, None]] = {}
        for (of, band), contributions in self.contributions.items():
            largest = max(contributions, key=lambda contribution: contribution.relative or 0.0)
            by_class.setdefault(of, []).append(f"{band} {self._total((of, band))} mostly {largest.name}")
            unknown.setdefault(of, {}).update(
                {contribution.name: None for contribution in contributions if contribution.unknown}
            )
        return tuple(
            f"{of} {', '.join(parts)}" + (f"; unknown: {', '.join(unknown[of])}" if unknown[of] else "")
            for of, parts in by_class.items()
        )

    def _total(self, cell: tuple[str, str]) -> str:
        return ("at least " if self.unknown(cell) else "") + _size(*self.total(cell))

    def _cell(self, of: str, band: str) -> str:
        contributions = sorted(self.contributions[of, band], key=lambda contribution: -(contribution.relative or 0.0))
        parts = [
            f"{contribution.name} {_size(contribution.relative, contribution.kelvin)}{_remark(contribution)}"
            for contribution in contributions
            if contribution.relative is not None
        ]
        unknown = self.unknown((of, band))
        tail = f", unknown: {', '.join(unknown)}" if unknown else ""
        return f"{self._total((of, band))}: {', '.join(parts)}{tail}"

    def beyond(self, accuracy: float) -> tuple[str, ...]:
        """Return what the chosen models leave out beyond the accuracy though a key would add it, largest first."""
        worst: dict[tuple[str, str], tuple[float, str]] = {}
        for (of, band), contributions in self.contributions.items():
            for contribution in contributions:
                relative = contribution.relative
                if contribution.needs and relative is not None and relative > OMISSION_SHARE * accuracy:
                    size = _size(relative, contribution.kelvin)
                    text = f"{contribution.name} {size} in {of} {band}, needs {contribution.needs}"
                    key = (contribution.name, contribution.needs)
                    worst[key] = max(worst.get(key, (0.0, "")), (relative, text))
        return tuple(text for _, text in sorted(worst.values(), reverse=True))


def _size(relative: float | None, kelvin: float | None) -> str:
    return f"{_percent(relative)} ({kelvin or 0.0:.2g} K)"


def _percent(relative: float | None) -> str:
    percent = 100.0 * (relative or 0.0)
    return f"{percent:.0f} %" if percent >= 10.0 else f"{percent:.2g} %"


def _remark(contribution: Contribution) -> str:
    """Say of which part of a band a figure is, and whether it is from notes."""
    partly = "" if contribution.known > MOSTLY_KNOWN else f" of {100.0 * contribution.known:.0f} % of the band"
    return f"{partly}{'' if contribution.recomputed else ' (notes)'}"


def beyond_accuracy(plan: Plan, budget: ErrorBudget) -> tuple[str, ...]:
    """Return what a plan leaves out beyond its share of the accuracy, with its size and what it would need."""
    limit = OMISSION_SHARE * plan.accuracy.relative
    left = [
        omission
        for omission in plan.omissions
        if omission.needs and omission.bound is not None and omission.bound > limit
    ]
    texts = [
        f"{omission.what} {_percent(omission.size)} ({omission.sense or 'any pixel'}), needs {omission.needs}"
        for omission in sorted(left, key=lambda omission: -(omission.size or 0.0))
    ]
    return (*texts, *budget.beyond(plan.accuracy.relative))


def error_budget(plan: Plan, engine: Mapping[str, float] | None = None) -> ErrorBudget:
    """Return the budget of a scene.

    Parameters
    ----------
    engine : mapping of str to float, optional
        Relative error of each band, as measured; default: the accuracy asked for.
    """
    numeric = plan.numerics.error + plan.grid_refinement.error
    assembly = plan.assembly
    classes = {CLEAR: (CLEAR, assembly.sea_temperature_K)} if assembly.has_clear_sky else {}
    for layer in plan.layers:
        top = layer.temperature_K
        kelvin = float(assembly.profile.temperature_at(layer.top_m)) if top is None else top
        classes[layer.name] = (CLOUDY, kelvin)
    stated = {
        "gas": _stated(assembly.transmittance),
        "sea": _stated(assembly.sea),
        "radiance model": _stated(assembly.model),
    }
    if assembly.surfaces is not None:
        stated["surfaces"] = _stated(assembly.surfaces.provider)
    particles = {
        layer.name: _stated(optics_of_layer)
        for layer, optics_of_layer in zip(plan.layers, assembly.optics_of_layers, strict=True)
    }
    cells = {}
    for of, (kind, kelvin) in classes.items():
        errors_of = {**stated, "particles": particles.get(of)}
        for index, band in enumerate(plan.bands):
            scale = _Band(plan, index, kelvin)
            error = plan.accuracy.relative if engine is None else engine.get(band.name)
            measured = "at most" if engine is None else "largest"
            cells[of, band.name] = (
                Contribution(ENGINE, error, scale.kelvin(error), 1.0, measured),
                Contribution(NUMERICS, numeric, scale.kelvin(numeric), 1.0, "largest"),
                *(
                    contribution
                    for name, errors in errors_of.items()
                    for contribution in _of_provider(plan, name, errors, of, kind, scale)
                    if plan.light is None or contribution.name != COLUMNS
                ),
            )
            if plan.light is not None and kind == CLOUDY:
                sides = plan.light.expected_rms[band.name]
                cells[of, band.name] += (Contribution(SIDES, sides, scale.kelvin(sides), 1.0, "rms"),)
    return ErrorBudget(cells)


def _stated(provider: Any) -> Sequence[ModelError] | None:
    stated = getattr(provider, "model_errors", None)
    return None if stated is None else stated()


class _Band:
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


def _of_provider(
    plan: Plan, name: str, errors: Sequence[ModelError] | None, of: str, kind: str, band: _Band
) -> Iterable[Contribution]:
    """Yield the contributions of one provider to a class and band; an unknown one if it states nothing for it."""
    if not errors:
        if kind in _UNSTATED[name]:
            yield Contribution(name)
        return
    sunlight, zenith_deg = (None, plan.sun_matters), plan.view.zenith_deg
    columns = {"", kind, of, *(layer.microphysics.material for layer in plan.layers if layer.name == of)}
    is_stated = name == "radiance model" or kind not in _UNSTATED[name]  # some models add nothing to clear sky
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
