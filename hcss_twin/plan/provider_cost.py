"""What providers of other packages will cost: the calls that a scene is likely to make, times their measured seconds.

The numbers of calls are those counted in runs of the scenario ``stratus``; others differ by a factor of about two.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import HcssError
from hcss_twin.physics.paths import to_space
from hcss_twin.plan.builder import Built
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import length
from hcss_twin.providers.registry.specs import Kind

MANY = 16
"""Wavenumbers of the larger measured call."""

PATHS = 64
"""Paths of a measured call of a transmittance provider."""


@dataclass(frozen=True)
class Calls:
    """What a scene asks of one member: number of calls, wavenumbers as a multiple of the scene's, paths of a call."""

    calls: int
    spectra: float
    paths: int = 1


_GATHERING = ("physical", "physical-two-stream")
"""Radiance models that ask for the paths of many columns at once."""

_CALLS: Mapping[Kind, tuple[Calls, Calls]] = {
    Kind.ATMOSPHERE: (Calls(39, 13.0, 1000), Calls(109, 27.0, 20)),
    Kind.SEA: (Calls(134, 29.0), Calls(77, 20.0)),
    Kind.OPTICS: (Calls(9, 1.3), Calls(19, 3.8)),
}
"""By kind: with radiance models that gather paths, and with others."""


@dataclass(frozen=True)
class ProviderCost:
    """Predicted cost of a provider.

    Attributes
    ----------
    label : str
        Kind, numbered if there are several.
    member : str
    calls : int
        Number of calls.
    seconds : float
        Of all of them.
    """

    label: str
    member: str
    calls: int
    seconds: float


def provider_costs(plan: Plan) -> tuple[ProviderCost, ...]:
    """Predict the cost of each provider of another package, from a few measured calls; none if it refuses these."""
    return tuple(
        cost
        for label, built in plan.assembly.built.items()
        if not built.entry.is_own
        for cost in _cost(plan, label, built)
    )


def _cost(plan: Plan, label: str, built: Built) -> Iterator[ProviderCost]:
    try:
        if built.entry.kind is Kind.CLOUDS:
            rows, columns = (slice(0, length(pixels)) for pixels in plan.extent)
            frames = plan.frame_times_s.size
            one = _seconds(lambda: built.provider.thickness_m(float(plan.frame_times_s[0]), rows, columns))
            yield ProviderCost(label, "thickness_m", frames, frames * one)
        elif built.entry.kind in _CALLS and plan.needs_radiance:
            yield _spectral(plan, label, built)
    except HcssError:
        return


def _spectral(plan: Plan, label: str, built: Built) -> ProviderCost:
    """Seconds = calls x a + wavenumbers x b, or wavenumbers x paths x c, each from calls of two sizes."""
    grid = plan.spectral_grid.wavenumber_cm1
    some = grid[np.unique(np.linspace(0, grid.size - 1, MANY).astype(np.intp))]
    asked = _CALLS[built.entry.kind][plan.assembly.entries["radiance"].name not in _GATHERING]
    name, ask = _member(plan, built)
    one, many = (_seconds(lambda nu=nu: ask(nu, 1)) for nu in (some[:1], some))  # type: ignore[misc]
    per_wavenumber = max(many - one, 0.0) / max(some.size - 1, 1)
    seconds = asked.calls * max(one - per_wavenumber, 0.0) + asked.spectra * grid.size * per_wavenumber
    if asked.paths > 1:
        for_paths = max(_seconds(lambda: ask(some, PATHS)) - many, 0.0) / (some.size * (PATHS - 1))
        seconds += asked.spectra * grid.size * asked.paths * for_paths
    return ProviderCost(label, name, asked.calls, seconds)


def _member(plan: Plan, built: Built) -> tuple[str, Callable[[Array, int], object]]:
    provider = built.provider
    match built.entry.kind:
        case Kind.ATMOSPHERE:
            zenith = plan.view.zenith_deg
            return "transmittance", lambda nu, count: provider.transmittance(
                nu, [to_space(float(low), zenith) for low in np.linspace(0.0, 10e3, count)]
            )
        case Kind.SEA:
            mu = np.linspace(0.1, 1.0, PATHS)
            return "brdf", lambda nu, count: provider.brdf(nu, mu, mu, np.full(mu.size, 1.0))
        case _:
            particles = plan.layers[0].microphysics if plan.layers else None
            return "single_scattering", lambda nu, count: particles and provider.single_scattering(particles, nu)


def _seconds(call: Callable[[], object]) -> float:
    """Return the time of the faster of two calls: the first may compile or import."""
    times = []
    for _ in range(2):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return min(times)
