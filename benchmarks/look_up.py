"""Speed of the look-up kernels and of brightness temperature against the same in numpy, in one run on one thread.

::

    python benchmarks/look_up.py
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from hcss_twin.core.arrays import Array
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.radiance_tables import DenseTable
from hcss_twin.engine.tables.tensor_train import TensorTrain
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.models.radiance.spectral_grid import SpectralBand, SpectralGrid

SIDE = 800
NODES, UPPER_NODES = 588, 150
RANGE_M, UPPER_RANGE_M = (10.0, 2934.0), (50.0, 4000.0)
RANK, VIEWS = 6, 9

Thickness = NDArray[np.float32]


def best_s(call: Callable[[], object], repeats: int = 15) -> float:
    """Shortest of some runs, in seconds."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return min(times)


def sky(range_m: tuple[float, float], blur: float, seed: int) -> Thickness:
    """A frame, half of it cloudy."""
    field = gaussian_filter(np.random.default_rng(seed).standard_normal((SIDE, SIDE)), blur)
    low, high = range_m
    scaled = np.minimum(field / (4 * field.std()), 1.0)
    return np.where(field > 0, low + (high - low) * scaled, 0.0).astype(np.float32)


def one_layer(nodes: Array, clear: Array, cloudy: Array) -> DenseTable:
    """Return the table of clear sky (C,) and clouds (N, C)."""
    return DenseTable(clear[None], (nodes,), TensorTrain((np.vstack((clear, cloudy)).T[:, None, :, None],)))


def several(random: np.random.Generator, nodes: Sequence[Array], channels: int, rank: int, states: int) -> DenseTable:
    """Return a table of random matrices for several layers, or several states."""
    ranks = [states, *([rank] * (len(nodes) - 1)), 1]
    cores = (random.random((channels, ranks[k], 1 + of.size, ranks[k + 1])) for k, of in enumerate(nodes))
    return DenseTable(random.random((states, channels)), tuple(nodes), TensorTrain(tuple(cores)))


def in_numpy(table: DenseTable, thickness_m: Thickness) -> NDArray[np.float32]:
    """Search once, interpolate each channel: what the kernel replaced."""
    thickness = thickness_m.astype(np.float64).ravel()
    cloudy = np.flatnonzero(thickness > 0)
    nodes, values = table.nodes_m[0], table.columns.cores[0][:, 0, 1:, 0]
    inside = np.clip(thickness[cloudy], nodes[0], nodes[-1])
    index = np.clip(np.searchsorted(nodes, inside, side="right") - 1, 0, nodes.size - 2)
    part = (inside - nodes[index]) / (nodes[index + 1] - nodes[index])
    radiance = np.empty((table.channels, thickness.size), dtype=np.float32)
    radiance[:] = table.clear[0][:, None]
    for plane, row in zip(radiance, values, strict=True):
        plane[cloudy] = row[index] + part * (row[index + 1] - row[index])
    return radiance.reshape(-1, *thickness_m.shape)


def temperature() -> None:
    """Print the cost of brightness temperature, by logarithms as in version 0.1 and by the bits of the radiance."""
    grid = SpectralGrid.dense([SpectralBand("lwir", np.array([8.0, 14.0]), np.ones(2))], None)
    inverse = BrightnessTemperature(grid, ["lwir"])
    radiance = (20.0 + 0.01 * sky(RANGE_M, 4.0, 1))[None]
    logarithms = inverse._from_logarithm(0, radiance[0].astype(np.float64))
    np.testing.assert_allclose(inverse(radiance)[0], logarithms, atol=1e-4)
    seconds = [
        best_s(lambda: inverse._from_logarithm(0, radiance[0].astype(np.float64)), 5),
        best_s(lambda: inverse(radiance)),
    ]
    cells = [each / SIDE**2 * 1e9 for each in seconds]
    print(f"brightness temperature, nanoseconds per value: {cells[0]:.1f} by logarithms, {cells[1]:.2f} by bits")


def main() -> None:
    random = np.random.default_rng(0)
    nodes, upper = np.geomspace(*RANGE_M, NODES), np.geomspace(*UPPER_RANGE_M, UPPER_NODES)
    low, high = sky(RANGE_M, 4.0, 1), sky(UPPER_RANGE_M, 8.0, 2)
    views = random.random((SIDE, SIDE, 1, VIEWS))
    print(f"{SIDE} x {SIDE} points; nanoseconds per point, all channels; layers with matrices of {RANK} rows")
    names = ("channels", "numpy", "kernel", "of 2 x 2", "of 8 x 8", "nine views", "two layers", "three")
    print("".join(f"{name:>12}" for name in names))
    for channels in (3, 18):
        one = one_layer(nodes, random.random(channels), random.random((NODES, channels)))
        nine, two, three = (
            several(random, axes, channels, RANK, states)
            for axes, states in (([nodes], VIEWS), ([nodes, upper], 1), ([nodes, nodes, upper], 1))
        )
        radiance = np.empty((channels, SIDE, SIDE), dtype=np.float32)
        LookUp(one).fill(radiance, [low])
        np.testing.assert_array_equal(radiance, in_numpy(one, low))
        seconds = [
            best_s(lambda one=one: in_numpy(one, low), 5),
            *(best_s(lambda one=one, n=n, out=radiance: LookUp(one).fill(out, [low], n)) for n in (1, 2, 8)),
            best_s(lambda nine=nine, out=radiance: LookUp(nine).fill(out, [low], weights=views)),
            best_s(lambda two=two, out=radiance: LookUp(two).fill(out, [low, high])),
            best_s(lambda three=three, out=radiance: LookUp(three).fill(out, [low, low, high])),
        ]
        cells = [each / SIDE**2 * 1e9 for each in seconds]
        print(f"{channels:12}" + "".join(f"{each:12.1f}" for each in cells))


if __name__ == "__main__":
    main()
    temperature()
