"""The cloud type stratocumulus has the horizontal statistics that were published for the real cloud."""

import math
from itertools import pairwise

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.providers import CloudInputs, Grid, Motion
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.cloud_types import PlaceLevels, resolve_layer
from hcss_twin.scenario.clouds import Layer

LEVELS = PlaceLevels(condensation_m=500.0, melting_m=3000.0, inversion_m=1000.0, tropopause_m=12_000.0)
STILL = Motion(0.0, (0.0, 0.0), math.inf, 1.0)


def generator(pixels, pixel_size_m, seed):
    catalog, registry = Catalog(), Registry.defaults_only()
    resolved = resolve_layer(Layer(type="stratocumulus", coverage=1.0), catalog, "clouds", LEVELS)
    grid = Grid(pixels, pixels, pixel_size_m)
    inputs = CloudInputs(resolved.layer, grid, STILL, seed, catalog, resolved.type_parameters)
    return registry.create(registry.resolve(Kind.CLOUDS, "fractal"), inputs)


def test_thickness_has_the_structure_function_of_overcast_marine_stratocumulus():
    """Lewis, Austin and Szczodrak (2004), abstract: the exponent of a passive tracer, 2/3, over two decades."""
    lags = np.array([2, 4, 8, 16, 32, 64, 100])  # 40 m to 2 km
    total = np.zeros(lags.size)
    for seed in range(6):
        frame = generator(400, 20.0, seed).thickness_m(0.0, slice(0, 400), slice(0, 400)).astype(float)
        for index, lag in enumerate(lags):
            total[index] += np.mean((frame[lag:] - frame[:-lag]) ** 2)
            total[index] += np.mean((frame[:, lag:] - frame[:, :-lag]) ** 2)
    slope = np.polyfit(np.log(lags), np.log(total), 1)[0]
    assert slope == pytest.approx(2 / 3, abs=0.06)


def test_most_variance_is_at_the_scale_of_mesoscale_cells():
    """Wood and Hartmann (2006), abstract: liquid water path varies mostly at 10 to 50 km."""
    size, window = 256, np.hanning(256)
    power = np.zeros((size, size))
    for seed in range(12):
        field = generator(size, 1000.0, seed).field(0.0, slice(0, size), slice(0, size))
        power += np.abs(np.fft.fft2((field - field.mean()) * window * window[:, None])) ** 2
    cycles = np.fft.fftfreq(size, 1.0)  # per km
    wavelength = 1.0 / np.maximum(np.hypot(cycles, cycles[:, None]), 1e-9)
    edges = np.geomspace(3.0, 128.0, 17)
    # Variance per logarithmic interval of wavelength: the sum over a ring.
    rings = [power[(wavelength >= low) & (wavelength < high)].sum() for low, high in pairwise(edges)]
    peak = np.sqrt(edges[:-1] * edges[1:])[int(np.argmax(rings))]
    # Intervals are a factor of 1.26 wide, and neighbours of the greatest hold nearly as much.
    assert 12.0 < peak < 25.0
    inside = power[(wavelength >= 10.0) & (wavelength <= 50.0)].sum()
    assert inside > 0.5 * power.sum()
