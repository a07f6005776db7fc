"""What the cloud benchmarks have in common: the generator under test and its parameters."""

from __future__ import annotations

from typing import Any

from hcss_twin.catalog import Catalog
from hcss_twin.providers import CloudInputs, Grid, Motion
from hcss_twin.registry.kinds import Kind
from hcss_twin.registry.registry import Registry
from hcss_twin.scenario.cloud_types import resolve_layer
from hcss_twin.scenario.models import Layer

TYPES = ("stratus", "stratocumulus", "cumulus", "cirrus", "simulated")
PIXEL_M = 20.0
REFERENCE_M = 16_000.0

# The motion of the shipped scenarios: the platform moves 50 pixels a frame.
MOTION = Motion(1000.0, (10.0, 0.0), 1800.0, 1.0)


def shape_of(kind: str) -> dict[str, Any]:
    """Return gamma, H, L and k of a cloud type."""
    return dict(resolve_layer(Layer(type=kind, coverage=0.5), Catalog(), "clouds").type_parameters)


def make_generator(
    kind: str, pixels: int, *, seed: int = 1, threads: int = 1, pixel_m: float = PIXEL_M
) -> Any:
    """Return a new generator of square frames, or None where it cannot use that many threads."""
    catalog, registry = Catalog(), Registry.defaults_only()
    resolved = resolve_layer(Layer(type=kind, coverage=0.5), catalog, "clouds")
    inputs = CloudInputs(
        resolved.layer, Grid(pixels, pixels, pixel_m), MOTION, seed, catalog, resolved.type_parameters
    )
    generator = registry.create(registry.resolve(Kind.CLOUDS, "fractal"), inputs)
    return generator if set_threads(generator, threads) else None


def set_threads(generator: Any, threads: int) -> bool:
    """Give the generator a number of threads: THE ONE PLACE where the benchmarks do so.

    Returns
    -------
    bool
        Whether it now runs on that many.
    """
    if hasattr(generator, "threads"):
        generator.threads = threads
        return True
    return threads == 1


def cells_per_pixel(shape: dict[str, Any], octave: int, axis: int, pixel_m: float = PIXEL_M) -> float:
    """Return lattice cells per pixel of an octave, along x (axis 0) or y (axis 1)."""
    return float(shape["L"][axis] * shape["gamma"] ** octave * pixel_m / REFERENCE_M)


def digits(value: float) -> str:
    """Return three digits without an exponent."""
    return f"{value:.3g}" if value < 100.0 else f"{value:.0f}"
