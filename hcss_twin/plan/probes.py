"""Laws of the conformance kit on the providers of other packages that a scene selects, before its first frame.

Providers of this package are known good: its tests hold them to the whole kit. An error that a provider raises when it
is asked is no reason to refuse it, because the scene may not ask the same; it is counted.
"""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.cache import kept_result
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import HcssError, ProviderDefect
from hcss_twin.laws import clouds, conduct, questions_of, sensors
from hcss_twin.laws import laws_of as laws_of_kind
from hcss_twin.laws.law import Inapplicable, Law, LawBroken, law_name, meaning
from hcss_twin.laws.samples import BoundedScene, sample_radiance_inputs
from hcss_twin.physics.planck import planck
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.builder import Built
from hcss_twin.providers import Microphysics
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.providers.sensor import no_scene

WAVENUMBERS = 4
"""Wavenumbers of a call, evenly spaced in the bands of the scene."""

PIXELS = 96
"""Most rows and columns of a window of clouds."""

SEEDS = 16
"""Skies for the cloudy fraction."""

COVERAGE_TOLERANCE, STANDARD_ERRORS = 0.1, 3.5
"""Allowed difference of the mean cloudy fraction from the coverage, and standard errors of this mean in addition."""

SCENE_K = (260.0, 300.0)
"""Temperatures of black bodies of which the radiance is the lowest and highest that a sensor measures."""

IMAGES = (Kind.CLOUDS, Kind.ELEMENTS, Kind.SURFACES, Kind.SENSORS)
"""Kinds with windows of an image."""

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
class Sampled:
    """Of what a scene has: wavenumbers (V,), particles, and radiance (B,) of its coldest and warmest parts."""

    wavenumber_cm1: Array
    particles: tuple[Microphysics, ...]
    scene_W_m2_sr: tuple[Array, Array]


@dataclass(frozen=True)
class Probes:
    """Results of all probed providers."""

    results: tuple[Probed, ...] = ()


def probe_providers(
    assembly: Assembly, catalog: Catalog, spectral: bool, stages: Sequence[tuple[str, Built]] = ()
) -> Probes:
    """Hold the providers of other packages to the laws of their kinds, once for each version and parameters.

    Parameters
    ----------
    spectral : bool
        Whether the scene computes radiance; without, providers of radiance are not probed.
    stages : sequence of (str, Built)
        Labels and sensors.

    Raises
    ------
    ProviderDefect
        If a provider breaks a law that it does not name in ``expected_failures``; tells the law and the numbers.
    """
    foreign = {label: built for label, built in (*assembly.built.items(), *stages) if not built.entry.is_own}
    particles_of = tuple(dict.fromkeys(layer.microphysics for layer in assembly.layers))
    every = assembly.spectral_grid.wavenumber_cm1
    wavenumber_cm1 = every[np.unique(np.linspace(0, every.size - 1, WAVENUMBERS).astype(np.intp))]
    weights = assembly.spectral_grid.weights_cm1
    cold, warm = (np.sum(weights * planck(every, kelvin), axis=1) for kelvin in SCENE_K)
    sampled = Sampled(wavenumber_cm1, particles_of, (cold, warm))
    chosen = {label: list(laws_of(built, sampled, spectral)) for label, built in foreign.items()}
    parts = {
        "probes": {
            label: [built.code(catalog.shelf), str(built.parameters), _digest(built.inputs)]
            for label, built in foreign.items()
        },
        "sampled": _digest(sampled),
        "files": dict(catalog.used),
    }
    compute = partial(_probe_all, foreign, chosen)
    return kept_result(parts, catalog, compute, (Probes, Probed))


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


def laws_of(built: Built, sampled: Sampled, spectral: bool = True) -> Iterator[tuple[Law, Ask]]:
    """Laws of a provider, each with a function that asks the provider about it."""
    kind, provider, inputs = built.entry.kind, built.provider, built.inputs
    given: dict[str, Any] = {"wavenumber_cm1": sampled.wavenumber_cm1, "scene_W_m2_sr": sampled.scene_W_m2_sr}
    if kind is Kind.RADIANCE:
        inputs = replace(sample_radiance_inputs(), wind_from_deg=inputs.wind_from_deg)
    elif kind in IMAGES:
        provider, inputs = _smaller(built)
    given |= {"provider": provider, "inputs": inputs, "make": built.make}
    clouds_of: tuple[Any, ...] = (None,)
    if kind is Kind.OPTICS:
        clouds_of = tuple(cloud for cloud in sampled.particles if cloud.material in provider.declares.materials)
    if kind is not Kind.VARIABLES and (spectral or kind in (Kind.CLOUDS, Kind.SURFACES)):
        of_kind = list(laws_of_kind(kind, in_a_run=True).values())
        of_kind += [cloudy_fraction_is_the_coverage] if kind is Kind.CLOUDS else []
        for cloud in clouds_of:
            given |= {"cloud": cloud, "questions": _questions(kind, given | {"cloud": cloud})}
            for law in of_kind:
                names = law.__code__.co_varnames[: law.__code__.co_argcount]
                yield law, partial(law, **{name: given[name] for name in names if name in given})


def _smaller(built: Built) -> tuple[Any, Any]:
    """Return a provider of a smaller image, for a sensor with a scene at all instants, and its inputs."""
    inputs, grid = built.inputs, built.inputs.grid
    if built.entry.kind is Kind.SENSORS:
        instants = getattr(built.provider, "instants", None)
        inputs = replace(inputs, scene_at=no_scene if instants is None else BoundedScene(instants))
    inputs = replace(inputs, grid=replace(grid, rows=min(PIXELS, grid.rows), columns=min(PIXELS, grid.columns)))
    try:
        return built.make(inputs), inputs
    except HcssError:  # it needs an image of this size
        return built.provider, built.inputs


def _questions(kind: Kind, given: Mapping[str, Any]) -> tuple[conduct.Question, ...]:
    """Return calls of a provider with two sets of arguments each."""
    provider, inputs, two = given["provider"], given["inputs"], None
    if kind is Kind.SENSORS:
        scene = sensors.quarters(inputs, given["scene_W_m2_sr"])
        two = scene, scene[:, ::-1]
    spectral = {"wavenumber_cm1": given["wavenumber_cm1"], "cloud": given["cloud"]}
    return questions_of(kind, provider, inputs, two=two, **spectral)


def cloudy_fraction_is_the_coverage(make: Callable[[Any], Any], inputs: Any) -> None:
    """The mean over seeds is the layer's coverage, as far as clouds of this size show it in a window."""
    rows, columns = (min(PIXELS, size) for size in (inputs.grid.rows, inputs.grid.columns))
    inputs = replace(inputs, grid=replace(inputs.grid, rows=rows, columns=columns))
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
