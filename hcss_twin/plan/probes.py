"""Laws of the conformance kit on the providers of other packages that a scene selects, before its first frame.

Providers of this package are known good: its tests hold them to the whole kit. An error that a provider raises when it
is asked is no reason to refuse it, because the scene may not ask the same; it is counted.
"""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.cache import PLANS, recall_or_compute, result_key
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import HcssError, ProviderDefect
from hcss_twin.laws import atmosphere, clouds, particles, radiance, sea
from hcss_twin.laws.law import Inapplicable, Law, LawBroken, law_name, meaning
from hcss_twin.laws.samples import sample_radiance_inputs
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.builder import Built
from hcss_twin.providers import Microphysics
from hcss_twin.providers.registry.specs import Kind

WAVENUMBERS = 4
"""Wavenumbers of a call, evenly spaced in the bands of the scene."""

PIXELS = 96
"""Most rows and columns of a window of clouds."""

SEEDS = 16
"""Skies for the cloudy fraction."""

COVERAGE_TOLERANCE, STANDARD_ERRORS = 0.1, 3.5
"""Allowed difference of the mean cloudy fraction from the coverage, and standard errors of this mean in addition."""

LAWS: Mapping[Kind, tuple[Law, ...]] = {
    Kind.ATMOSPHERE: atmosphere.LAWS,
    Kind.SEA: sea.LAWS,
    Kind.OPTICS: particles.LAWS,
    Kind.RADIANCE: radiance.LAWS,
}
"""Laws of spectral providers; those of a sensor need radiances that suit it, and elements have no law of size."""

Ask = Callable[[], None]


@dataclass(frozen=True)
class Probed:
    """How a provider fared.

    Attributes
    ----------
    label : str
        Kind, numbered if there are several.
    passed, not_applicable : int
        Number of laws.
    expected : tuple of str
        Broken laws that the provider declares in ``expected_failures``, each with its reason.
    unanswered : tuple of str
        Laws about which the provider could not be asked, because it raised an error.
    """

    label: str
    passed: int
    not_applicable: int
    expected: tuple[str, ...] = ()
    unanswered: tuple[str, ...] = ()

    @property
    def count(self) -> dict[str, int]:
        """Number of laws of each outcome that occurs."""
        every = {
            "passed": self.passed,
            "expected failure": len(self.expected),
            "not applicable": self.not_applicable,
            "not answered": len(self.unanswered),
        }
        return {outcome: number for outcome, number in every.items() if number}


@dataclass(frozen=True)
class Probes:
    """Results of all probed providers."""

    results: tuple[Probed, ...] = ()


def probe_providers(assembly: Assembly, catalog: Catalog, spectral: bool) -> Probes:
    """Hold the providers of other packages to the laws of their kinds, once for each version and parameters.

    Parameters
    ----------
    spectral : bool
        Whether the scene computes radiance; without, only cloud generators are probed.

    Raises
    ------
    ProviderDefect
        If a provider breaks a law that it does not name in ``expected_failures``; tells the law and the numbers.
    """
    foreign = {label: built for label, built in assembly.built.items() if not built.entry.is_own}
    particles_of = tuple(dict.fromkeys(layer.microphysics for layer in assembly.layers))
    every = assembly.spectral_grid.wavenumber_cm1
    wavenumber_cm1 = every[np.unique(np.linspace(0, every.size - 1, WAVENUMBERS).astype(np.intp))]
    chosen = {label: list(laws_of(built, wavenumber_cm1, particles_of, spectral)) for label, built in foreign.items()}
    parts = {
        "probes": {
            label: [assembly.code[label], str(foreign[label].parameters), _digest(foreign[label].inputs)]
            for label in foreign
        },
        "wavenumbers": _digest(wavenumber_cm1),
        "particles": _digest(particles_of),
        "files": dict(catalog.used),
    }
    compute = partial(_probe_all, foreign, chosen)
    return recall_or_compute(PLANS, result_key(parts, catalog.shelf), catalog, compute, (Probes, Probed))


def _probe_all(built: Mapping[str, Built], laws: Mapping[str, list[tuple[Law, Ask]]]) -> Probes:
    return Probes(tuple(probe(label, built[label], asked) for label, asked in laws.items() if asked))


def probe(label: str, built: Built, laws: list[tuple[Law, Ask]]) -> Probed:
    """Ask a provider about laws; raises ``ProviderDefect`` if it breaks one that it does not name."""
    excused = expected_failures(built.provider, built.entry.label)
    passed, inapplicable, expected, unanswered = 0, 0, [], []
    for law, ask in laws:
        name = law_name(law)
        try:
            ask()
        except LawBroken as numbers:
            if name not in excused:
                raise ProviderDefect(
                    f"{built.entry.label} breaks the law '{name}' ({meaning(law).rstrip('.')}): {numbers}; no frame "
                    f"was computed; 'hcss check {built.entry.name}' tries all laws"
                ) from numbers
            expected.append(f"{name}: {excused[name]} ({numbers})")
        except Inapplicable:
            inapplicable += 1
        except ProviderDefect as error:
            if isinstance(error.__cause__, ProviderDefect | None):  # it broke its contract; others are exceptions
                raise
            unanswered.append(f"{name}: {error}")
        except HcssError as error:
            unanswered.append(f"{name}: {error}")
        else:
            passed += 1
    return Probed(label, passed, inapplicable, tuple(dict.fromkeys(expected)), tuple(dict.fromkeys(unanswered)))


def expected_failures(provider: Any, label: str) -> dict[str, str]:
    """Return the reason of each law that a provider declares to break, by the law's name in words.

    Raises
    ------
    ProviderDefect
        If the declaration is not a mapping of text to text.
    """
    declared = getattr(provider, "expected_failures", {})
    if not isinstance(declared, Mapping) or not all(
        isinstance(text, str) for pair in declared.items() for text in pair
    ):
        raise ProviderDefect(f"{label}: expected_failures is {declared!r}; expected a mapping of laws to reasons")
    return {name.replace("_", " "): reason for name, reason in declared.items()}


def laws_of(
    built: Built, wavenumber_cm1: Array, particles_of: tuple[Microphysics, ...], spectral: bool = True
) -> Iterator[tuple[Law, Ask]]:
    """Laws of a provider, each with a function that asks the provider about it."""
    kind = built.entry.kind
    if kind is Kind.CLOUDS:
        yield from _cloud_laws(built)
    if kind not in LAWS or not spectral:
        return
    given: dict[str, Any] = {"provider": built.provider, "inputs": built.inputs, "make": built.make}
    given["wavenumber_cm1"] = wavenumber_cm1
    if kind is Kind.RADIANCE:
        given["inputs"] = replace(sample_radiance_inputs(), wind_from_deg=built.inputs.wind_from_deg)
    materials = built.provider.declares.materials if kind is Kind.OPTICS else ()
    for cloud in [cloud for cloud in particles_of if cloud.material in materials] if kind is Kind.OPTICS else (None,):
        for law in LAWS[kind]:
            if law.__name__ != "declared_range_is_usable_to_its_ends":  # the scene may not need the ends
                names = law.__code__.co_varnames[: law.__code__.co_argcount]
                yield (
                    law,
                    partial(
                        law, **{name: value for name, value in (given | {"cloud": cloud}).items() if name in names}
                    ),
                )


def _cloud_laws(built: Built) -> Iterator[tuple[Law, Ask]]:
    inputs, provider = built.inputs, built.provider
    small = replace(
        inputs, grid=replace(inputs.grid, rows=min(inputs.grid.rows, PIXELS), columns=min(inputs.grid.columns, PIXELS))
    )
    law, seen = clouds.thickness_stays_within_the_layer, small if provider.declares.tileable else inputs
    yield law, partial(law, provider, seen, clouds.TIMES_S if provider.declares.tileable else clouds.TIMES_S[:1])
    yield cloudy_fraction_is_the_coverage, partial(cloudy_fraction_is_the_coverage, built.make, small)


def cloudy_fraction_is_the_coverage(make: Callable[[Any], Any], inputs: Any) -> None:
    """The mean over seeds is the layer's coverage, as far as clouds of this size show it in a window."""
    coverage = inputs.layer.coverage
    if not 0.0 < coverage < 1.0 or clouds.own_coverage(make(inputs)) is not None:
        raise Inapplicable("the sky is all clear or all cloud, or the coverage is that of an image")
    fields = [clouds.whole(make(replace(inputs, seed=seed)), inputs) for seed in range(1, SEEDS + 1)]
    share = np.mean(np.stack(fields) > 0.0, axis=(1, 2))
    if np.all((share == 0.0) | (share == 1.0)):
        raise Inapplicable("every window is all clear or all cloud: clouds are larger")
    spread = STANDARD_ERRORS * float(np.std(share, ddof=1)) / np.sqrt(SEEDS)
    clouds.cloudy_fraction_is(coverage, fields, COVERAGE_TOLERANCE + spread)


def _digest(value: Any) -> Any:
    """Return inputs as JSON values; arrays as hashes; without catalogs, functions, seeds and other providers."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {
            field.name: _digest(getattr(value, field.name))
            for field in dataclasses.fields(value)
            if field.name != "seed"
        }
    if isinstance(value, np.ndarray):
        return hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
    if isinstance(value, Mapping):
        return {str(key): _digest(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_digest(item) for item in value]
    return value if isinstance(value, str | int | float | None) else type(value).__name__
