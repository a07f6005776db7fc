"""Errors of catalogs and providers, told as problems of the scenario's keys."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from hcss_twin.errors import CatalogError, Problem, ProviderError, ScenarioError


@contextmanager
def blamed_on(field: str) -> Iterator[None]:
    """Name the scenario's field in whatever a catalog or provider complains about."""
    try:
        yield
    except (CatalogError, ProviderError) as error:
        raise ScenarioError([Problem(field, str(error))]) from error
