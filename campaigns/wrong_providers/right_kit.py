"""A right provider and the kit class that makes it, as the engine uses it."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import hcss_author
import pytest

from hcss_twin.providers.registry import Registry
from hcss_twin.providers.registry.guard import guard

REPOSITORY = Path(__file__).parents[2]

for folder in ("tests/contract", "plugins/hcss-examples/src"):
    sys.path.insert(0, str(REPOSITORY / folder))

discovered = cache(Registry.discover)

WAVENUMBERS = 4
"""Wavenumbers of a call; the cost of most laws is in proportion to them."""


@dataclass(frozen=True)
class Right:
    """A right provider: its name, kind and what it is, and a function that makes its kit class for a folder of files.

    ``cheap``: the kit takes about a second.
    """

    name: str
    kind: str
    sentence: str
    kit: Callable[[Path], type]
    cheap: bool = True


def builtin(kind, name, inputs, **parameters):
    """A provider of this package behind its guard, as the engine uses it."""
    registry = discovered()
    entry = registry.resolve(kind, f"hcss-twin/{name}")
    provider = registry.create(entry, inputs, registry.parameters_model(entry)(**parameters))
    return guard(entry, provider, inputs)


class Few:
    """Few wavenumbers."""

    @pytest.fixture
    def wavenumber_cm1(self, provider):
        return hcss_author.sample_wavenumbers(provider.declares, WAVENUMBERS)


CONTRACTS = {
    "clouds": hcss_author.CloudGeneratorContract,
    "sea": hcss_author.SeaModelContract,
    "optics": hcss_author.OpticsContract,
    "atmosphere": hcss_author.TransmittanceContract,
    "radiance": hcss_author.RadianceModelContract,
    "sensors": hcss_author.SensorContract,
    "elements": hcss_author.ElementContract,
    "surfaces": hcss_author.SurfaceContract,
    "variables": hcss_author.VariableContract,
}

WITH_SPECTRA = ("sea", "optics", "atmosphere", "radiance")


def kit(kind, make, inputs=None, **members):
    """Return a function that makes a kit class for providers ``make(inputs)``, with other members if given."""
    bases = (Few, CONTRACTS[kind]) if kind in WITH_SPECTRA else (CONTRACTS[kind],)
    own = {"make_provider": lambda self, given: make(given), **members}
    if inputs is not None:
        own["inputs"] = pytest.fixture(lambda self: inputs())
    return lambda folder: type("TestProvider", bases, dict(own))
