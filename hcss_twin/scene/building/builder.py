"""Make providers from what a scenario names, and gather everything that is wrong on the way."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from hcss_twin.catalog import Catalog
from hcss_twin.errors import Problem, ScenarioError
from hcss_twin.physics.profile import Profile
from hcss_twin.registry.discovery import Entry
from hcss_twin.registry.guard import guard
from hcss_twin.registry.kinds import Kind
from hcss_twin.registry.registry import Registry
from hcss_twin.scene.building.blame import blamed_on


class Builder:
    """Resolves, constructs and guards providers, remembers which were used, and gathers what is wrong."""

    def __init__(self, registry: Registry) -> None:
        self._registry = registry
        self._problems: list[Problem] = []
        self.entries: dict[str, Entry] = {}

    def build(
        self, kind: Kind, name: str, inputs: Any, parameters: Mapping[str, Any], label: str = ""
    ) -> Any:
        """Make and guard a provider, and remember it under ``label``, by default its kind."""
        entry, values = self._resolved(kind, name, parameters)
        provider = guard(entry, self._registry.create(entry, inputs, values), inputs)
        self.entries[label or str(kind)] = entry
        return provider

    def bound_profile(self, name: str, parameters: Mapping[str, Any], catalog: Catalog) -> Profile | None:
        """Return the one profile a transmittance provider belongs to; None if it takes any."""
        entry, values = self._resolved(Kind.ATMOSPHERE, name, parameters)
        return self._registry.bound_profile(entry, values, catalog)

    def _resolved(self, kind: Kind, name: str, parameters: Mapping[str, Any]) -> tuple[Entry, Any]:
        entry = self._registry.resolve(kind, name)
        model = self._registry.parameters_model(entry)
        return entry, None if model is None else model.model_validate(dict(parameters))

    @contextmanager
    def blaming(self, field: str, parameters: Mapping[str, Any] | None = None) -> Iterator[None]:
        """Keep whatever a catalog or provider complains about, as :func:`blamed_on` words it."""
        try:
            with blamed_on(field, parameters):
                yield
        except ScenarioError as error:
            self._problems += error.problems

    def keep(self, problems: Iterable[Problem]) -> None:
        """Keep problems found elsewhere."""
        self._problems += problems

    def raise_problems(self) -> None:
        """Raise everything gathered."""
        if self._problems:
            raise ScenarioError(self._problems)
