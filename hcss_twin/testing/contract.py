"""Bases of the test classes of all kinds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import pytest

from hcss_twin.providers import Array
from hcss_twin.providers.common import check_options
from hcss_twin.providers.declarations import check_declaration
from hcss_twin.testing.law_tests import expect_failures
from hcss_twin.testing.samples import sample_wavenumbers


class ProviderContract:
    """Base of the test classes of all kinds.

    Attributes
    ----------
    expected_failures : mapping of str to str
        Laws that the provider is known to break, with the reason: usually that of the provider's own attribute.
    """

    expected_failures: ClassVar[Mapping[str, str]] = {}

    def __init_subclass__(cls) -> None:
        expect_failures(cls, vars(cls).get("expected_failures", {}))

    def make_provider(self, inputs: Any) -> Any:
        """Return the provider under test."""
        raise NotImplementedError("define make_provider(self, inputs)")

    @pytest.fixture
    def provider(self, inputs: Any) -> Any:
        """Provider made from ``inputs``."""
        return self.make_provider(inputs)

    def test_declaration_is_sound(self, provider: Any) -> None:
        """Names, ranges and optional attributes are known to the engine."""
        check_declaration(provider.declares)
        check_options(provider)


class SpectralContract(ProviderContract):
    """Base of the test classes of providers with spectral results."""

    @pytest.fixture
    def wavenumber_cm1(self, provider: Any) -> Array:
        """Wavenumbers of the calls; override to choose others."""
        return sample_wavenumbers(provider.declares)
