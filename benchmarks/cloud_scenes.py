"""What the cloud benchmarks have in common: the generator under test and its parameters."""

from __future__ import annotations

from typing import Any

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import CloudInputs, Grid, Motion
from hcss_twin.scenario.cloud_types import PlaceLevels, resolve_layer
from hcss_twin.scenario.clouds import Layer

TYPES = ("stratus", "stratocumulus", "cumulus", "cirrus", "paper-simulated")
PIXEL_M = 20.0
LEVELS = PlaceLevels(condensation_m=500.0, melting_m=3000.0, inversion_m=1500.0, tropopause_m=12_000.0)
"""Of no particular place: only the shapes of clouds matter here."""
REFERENCE_M = 16_000.0

# The motion of the shipped scenarios: the platform moves 50 pixels a frame.
MOTION = Motion(1000.0, (10.0, 0.0), 1800.0, 1.0)


def shape_of(kind: str) -> dict[str, Any]:
    """Return gamma, H, L and k of a cloud type."""
    return dict(resolve_layer(Layer(type=kind, coverage=0.5), Catalog(), "clouds", LEVELS).type_parameters)


def make_generator(
    kind: str, pixels: int, *, seed: int = 1, threads: int = 1, pixel_m: float = PIXEL_M
) -> FractalClouds:
    """Return a new generator of square frames."""
    catalog = Catalog()
    resolved = resolve_layer(Layer(type=kind, coverage=0.5), catalog, "clouds", LEVELS)
    inputs = CloudInputs(resolved.layer, Grid(pixels, pixels, pixel_m), MOTION, seed, catalog, resolved.type_parameters)
    return FractalClouds(inputs, FractalParameters(), threads)


def cells_per_pixel(shape: dict[str, Any], octave: int, axis: int, pixel_m: float = PIXEL_M) -> float:
    """Return lattice cells per pixel of an octave, along x (axis 0) or y (axis 1)."""
    return float(shape["L"][axis] * shape["gamma"] ** octave * pixel_m / REFERENCE_M)


def digits(value: float) -> str:
    """Return three digits without an exponent."""
    return f"{value:.3g}" if value < 100.0 else f"{value:.0f}"
