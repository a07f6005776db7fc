"""Errors of catalogs and providers, told as problems of the scenario's keys."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from hcss_twin.errors import CatalogError, Problem, ProviderError, ScenarioError


@contextmanager
def blamed_on(field: str, parameters: Mapping[str, Any] | None = None) -> Iterator[None]:
    """Name the scenario's field in whatever a catalog or provider complains about.

    A complaint that quotes the value of one of a provider's ``parameters`` is about that parameter.
    """
    try:
        yield
    except (CatalogError, ProviderError) as error:
        message = str(error)
        section = field.rpartition(".")[0]
        for key, value in (parameters or {}).items():
            if isinstance(value, str) and value and f"'{value}'" in message:
                field = f"{section}.parameters.{key}"
        raise ScenarioError([Problem(field, message)]) from error
