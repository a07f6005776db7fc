"""Optics of the cloud layers: the scene's provider, or one of a layer's own."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import Problem, ProviderError, ScenarioError, choose_from
from hcss_twin.plan.builder import Builder, numbered
from hcss_twin.plan.clouds import AssembledLayer
from hcss_twin.providers import Microphysics, Optics, OpticsDeclaration, OpticsInputs, SingleScattering
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.clouds import OpticsSection
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scenario.section_types import selected


class LayerOptics:
    """Optics of a scene whose layers have different providers; each is asked for the particles of its layers.

    Particles are told apart by material and sizes; their number does not matter.

    Parameters
    ----------
    optics : sequence of Optics (L,)
        Of each layer.
    particles : sequence of Microphysics (L,)
        Of each layer; equal ones have the same optics.

    Attributes
    ----------
    declares : OpticsDeclaration
        Materials of all providers, and the wavenumbers that all of them allow.
    """

    def __init__(self, optics: Sequence[Optics], particles: Sequence[Microphysics]) -> None:
        self._of = {_single(cloud): provider for cloud, provider in zip(particles, optics, strict=True)}
        every = [provider.declares for provider in optics]
        ranges = [declaration.valid["wavenumber_cm1"] for declaration in every if "wavenumber_cm1" in declaration.valid]
        common = (max(low for low, _ in ranges), min(high for _, high in ranges)) if ranges else None
        self.declares = OpticsDeclaration(
            valid={} if common is None else {"wavenumber_cm1": common},
            materials=frozenset().union(*(declaration.materials for declaration in every)),
        )

    def single_scattering(self, cloud: Microphysics, wavenumber_cm1: Array) -> SingleScattering:
        """Return the bulk properties that the provider of these particles gives.

        Raises
        ------
        ProviderError
            If no layer of the scene has such particles.
        """
        provider = self._of.get(_single(cloud))
        if provider is None:
            known = ", ".join(f"'{particles.material}'" for particles in self._of)
            raise ProviderError(f"particles of '{cloud.material}' asked for are those of no layer; allowed: {known}")
        return provider.single_scattering(cloud, wavenumber_cm1)


def _single(cloud: Microphysics) -> Microphysics:
    return replace(cloud, number_density_m3=1.0)


@dataclass(frozen=True)
class ParticleOptics:
    """Optics of a scene.

    Attributes
    ----------
    optics : Optics
        Of the particles of every layer.
    of_layers : tuple of Optics (L,)
        The provider of each layer.
    fields : tuple of str (L,)
        Scenario field that selects it.
    names : mapping of Optics to str
        Each provider in use, with its name.
    """

    optics: Optics
    of_layers: tuple[Optics, ...]
    fields: tuple[str, ...]
    names: Mapping[Optics, str]


def default_optics(builder: Builder, scenario: Scenario, catalog: Catalog) -> Optics | None:
    """Build the scene's optics provider; None if it has a problem, or all layers have optics of their own."""
    layers = scenario.clouds.layers
    optics: Optics | None = None
    if layers and all(layer.optics is not None for layer in layers):
        return None
    with builder.collect_problems("optics.provider", scenario.optics.parameters):
        name = selected(scenario.optics, "provider")
        optics = builder.build(Kind.OPTICS, name, OpticsInputs(catalog), scenario.optics.parameters)
    return optics


def particle_optics(
    builder: Builder, scenario: Scenario, catalog: Catalog, layers: Sequence[AssembledLayer], default: Optics | None
) -> ParticleOptics | None:
    """Build the layers' own optics and check that each has the material of its layer.

    Parameters
    ----------
    layers : sequence of AssembledLayer
        From the lowest to the highest.
    default : Optics or None
        Of :func:`default_optics`.
    """
    chosen = [assembled.section.optics or scenario.optics for assembled in layers]
    made: dict[str, Optics | None] = {_key(scenario.optics): default}
    fields = [
        f"{assembled.field}.optics.provider" if assembled.section.optics else "optics.provider" for assembled in layers
    ]
    different = len({_key(section) for section in chosen})
    for index, (section, field) in enumerate(zip(chosen, fields, strict=True)):
        key = _key(section)
        if made.get(key) is None and field != "optics.provider":
            with builder.collect_problems(field, section.parameters):
                label = numbered(Kind.OPTICS, index, different)
                name, inputs = selected(section, "provider"), OpticsInputs(catalog)
                made[key] = builder.build(Kind.OPTICS, name, inputs, section.parameters, label)
    every = [made.get(_key(section)) for section in chosen]
    of_layers = tuple(provider for provider in every if provider is not None)
    if len(of_layers) < len(layers) or not (layers or default):
        return None
    for layer, section, optics in zip(layers, chosen, of_layers, strict=True):
        with builder.collect_problems(layer.field):
            _require_material(layer, optics, selected(section, "provider"))
    names = {provider: selected(section, "provider") for section, provider in zip(chosen, of_layers, strict=True)}
    if len(set(of_layers)) <= 1:
        only = (*of_layers, default)[0]
        assert only is not None
        return ParticleOptics(only, of_layers, tuple(fields), names)
    with builder.collect_problems(layers[-1].field):
        _require_different(layers, of_layers, names)
    particles = [assembled.layer.microphysics for assembled in layers]
    return ParticleOptics(LayerOptics(of_layers, particles), of_layers, tuple(fields), names)


def _key(section: OpticsSection) -> str:
    return json.dumps([selected(section, "provider"), section.parameters], sort_keys=True, default=str)


def _require_material(layer: AssembledLayer, optics: Optics, name: str) -> None:
    material, materials = layer.layer.microphysics.material, sorted(optics.declares.materials)
    if material not in materials:
        key = "type" if layer.section.material is None else "material"
        whose = f"is what '{layer.section.type}' is made of, and" if key == "type" else "is"
        message = (
            f"'{material}' {whose} no material of optics provider '{name}'; {choose_from(material, materials)}; or "
            f"another provider for this layer, {layer.field}.optics.provider"
        )
        raise ScenarioError([Problem(f"{layer.field}.{key}", message)])


def _require_different(layers: Sequence[AssembledLayer], optics: Sequence[Optics], names: Mapping[Optics, str]) -> None:
    """Reject equal particles with different optics."""
    known: dict[Microphysics, Optics] = {}
    for layer, provider in zip(layers, optics, strict=True):
        first = known.setdefault(_single(layer.layer.microphysics), provider)
        if first is not provider:
            message = (
                f"'{names[provider]}' with its parameters is not the optics of another layer with equal particles; "
                f"allowed: those of that layer, '{names[first]}' with its parameters"
            )
            raise ScenarioError([Problem(f"{layer.field}.optics.provider", message)])
