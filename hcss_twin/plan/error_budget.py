"""The total error of a scene: that of the engine, of its numerics, and what each provider states of itself.

Contributions (:mod:`hcss_twin.plan.error_contributions`) have different causes and unknown signs, so that the total is
the root of their sum of squares. It counts known contributions only, and is a lower limit where others are unknown.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from hcss_twin.plan.error_contributions import (
    CLEAR,
    CLOUDY,
    MOSTLY_KNOWN,
    Contribution,
    WeightedBand,
    contributions_of,
    stated_errors,
)
from hcss_twin.plan.few_columns import OMISSION_SHARE, Omission
from hcss_twin.plan.plan import Plan

ENGINE, NUMERICS = "engine", "numerics"
"""Contributions that "computed as specified" is about: tables and interpolation; streams, modes and grids."""

COLUMNS, SIDES = "plane-parallel clouds", "clouds with sides"
"""Error of independent columns, and that of the light between them which takes its place."""

ALTITUDE = "altitude of cloud by place"
"""Unknown error of clouds whose top follows from the air, but not from an inversion."""


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


def beyond_accuracy(plan: Plan) -> tuple[str, ...]:
    """Return what a plan cannot compute beyond its share of the accuracy, with its size and what it would need."""
    return _told(plan, lambda omission: not omission.decision)


def left_out(plan: Plan, budget: ErrorBudget) -> tuple[str, ...]:
    """Return what was decided to be left out beyond its share of the accuracy, with its size and the key that adds it.

    The user switches effects off, the plan leaves out what takes too long, and light between columns comes on request.
    """
    return (*_told(plan, lambda omission: bool(omission.decision)), *budget.beyond(plan.accuracy.relative))


def _told(plan: Plan, wanted: Callable[[Omission], bool]) -> tuple[str, ...]:
    limit = OMISSION_SHARE * plan.accuracy.relative
    left = [omission for omission in plan.omissions if omission.exceeds(limit) and wanted(omission)]
    return tuple(
        f"{omission.what} {_percent(omission.size)} ({omission.sense or 'at most, any pixel'}"
        f"{f'; {omission.decision}' if omission.decision else ''}), needs {omission.needs}"
        for omission in sorted(left, key=lambda omission: -(omission.size or 0.0))
    )


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
    for layer, cloudy in zip(plan.layers, assembly.cloudy_layers, strict=True):
        if not cloudy:
            continue  # no pixel has this cloud
        top = layer.temperature_K
        kelvin = float(assembly.profile.temperature_at(layer.top_m)) if top is None else top
        classes[layer.name] = (CLOUDY, kelvin)
    stated = {
        "gas": stated_errors(assembly.transmittance),
        "sea": stated_errors(assembly.sea),
        "radiance model": stated_errors(assembly.model),
    }
    stated |= {filled.field: filled.errors for filled in assembly.filled_in if filled.errors}
    unmeasured = {filled.unmeasured for filled in assembly.filled_in}
    for surfaces in assembly.surfaces:
        stated["surfaces"] = stated_errors(surfaces.provider)
    particles = {
        layer.name: stated_errors(optics_of_layer)
        for layer, optics_of_layer in zip(plan.layers, assembly.optics_of_layers, strict=True)
    }
    cells = {}
    for of, (kind, kelvin) in classes.items():
        errors_of = {**stated, "particles": particles.get(of)}
        for index, band in enumerate(plan.bands):
            scale = WeightedBand(plan, index, kelvin)
            error = plan.accuracy.relative if engine is None else engine.get(band.name)
            measured = "at most" if engine is None else "largest"
            cells[of, band.name] = (
                Contribution(ENGINE, error, scale.kelvin(error), 1.0, measured),
                Contribution(NUMERICS, numeric, scale.kelvin(numeric), 1.0, "largest"),
                *(
                    contribution
                    for name, errors in errors_of.items()
                    for contribution in contributions_of(plan, name, errors, of, kind, scale)
                    if band.name not in plan.light.expected_rms or contribution.name != COLUMNS
                ),
            )
            if band.name in plan.light.expected_rms and kind == CLOUDY:
                rms, name = plan.light.expected_rms[band.name], SIDES if plan.light.varies else COLUMNS
                cells[of, band.name] += (Contribution(name, rms, scale.kelvin(rms), 1.0, "rms"),)
            if of in unmeasured:
                cells[of, band.name] += (Contribution(ALTITUDE),)
    return ErrorBudget(cells)
