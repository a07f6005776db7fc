"""How much the fractal dimension changes by what the generator skips.

The full sum of eq 2 has a closed form: the expected variogram of an octave is 2 (1 - rho), where rho is the
autocorrelation of the unit-variance cubic interpolation, averaged over the phase in the cell. The fractal
dimension is that of the variogram at lags 1 and 2, FD = 3 - log2(g(2) / g(1)) / 2, with g the mean over x and y.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from cloud_scenes import TYPES, cells_per_pixel, make_generator, shape_of

from hcss_twin.models.clouds.fractal.octaves import NEAREST_FROM

PIXELS = 800
SEEDS = 12
SIZES_M = (5.0, 20.0, 50.0, 100.0)
_PHASES = 2000


def accuracy() -> None:
    """Print the fractal dimension of the full sum, its change by skipping, and what the generator gives."""
    print(
        f"Fractal dimension of V, variogram at lags 1 and 2. White: octaves of {NEAREST_FROM:g} or more cells per "
        f"pixel replaced by white noise of their variance; dropped: left out. Measured: {SEEDS} seeds of {PIXELS} x "
        f"{PIXELS} pixels, +- standard error.\n"
    )
    print("| type | pixel, m | full sum | white - full | dropped - full | measured - full |")
    print("|---|---|---|---|---|---|")
    for kind in TYPES:
        for size in SIZES_M:
            full = dimension(*expected(kind, size, "full"))
            white, dropped = (dimension(*expected(kind, size, how)) - full for how in ("white", "dropped"))
            values = measured(kind, size)
            change, error = values.mean() - full, values.std(ddof=1) / math.sqrt(SEEDS)
            print(f"| {kind} | {size:g} | {full:.4f} | {white:+.5f} | {dropped:+.4f} | {change:+.4f} +- {error:.4f} |")


def dimension(first: float, second: float) -> float:
    """Return the fractal dimension from the variogram at lags 1 and 2."""
    return 3.0 - 0.5 * math.log2(second / first)


def expected(kind: str, pixel_m: float, how: str) -> tuple[float, float]:
    """Return the expected variogram of eq 2 at lags 1 and 2, up to a factor."""
    shape = shape_of(kind)
    found = []
    for lag in (1, 2):
        total = 0.0
        for octave in range(shape["k"][0], shape["k"][1] + 1):
            power = shape["gamma"] ** (-2.0 * shape["H"] * octave)
            for axis in (0, 1):
                cells = cells_per_pixel(shape, octave, axis, pixel_m)
                if cells >= NEAREST_FROM and how != "full":
                    total += power if how == "white" else 0.0
                else:
                    total += power * (1.0 - correlation(lag * cells))
        found.append(total)
    return found[0], found[1]


def correlation(distance: float) -> float:
    """Return the correlation of two points ``distance`` cells apart on one axis, averaged over where they lie."""
    if distance >= 4.0:
        return 0.0
    phase = (np.arange(_PHASES) + 0.5)[:, None] / _PHASES
    nodes = np.arange(-3, 9)[None, :]
    here, there = keys(phase - nodes), keys(phase + distance - nodes)
    norm = np.sqrt((here**2).sum(axis=1) * (there**2).sum(axis=1))
    return float(np.mean((here * there).sum(axis=1) / norm))


def keys(distance: Any) -> Any:
    """Return Keys' cubic convolution kernel, a = -1/2."""
    d = np.abs(distance)
    inner = 1.5 * d**3 - 2.5 * d**2 + 1.0
    outer = -0.5 * d**3 + 2.5 * d**2 - 4.0 * d + 2.0
    return np.where(d < 1.0, inner, np.where(d < 2.0, outer, 0.0))


def measured(kind: str, pixel_m: float) -> np.ndarray:
    """Return the fractal dimension of one frame of each seed."""
    values, window = [], slice(0, PIXELS)
    for seed in range(SEEDS):
        frame = make_generator(kind, PIXELS, seed=seed, pixel_m=pixel_m).field(0.0, window, window)
        plane = np.asarray(frame, dtype=np.float64)
        variogram = [
            np.mean((plane[lag:] - plane[:-lag]) ** 2) + np.mean((plane[:, lag:] - plane[:, :-lag]) ** 2)
            for lag in (1, 2)
        ]
        values.append(dimension(*variogram))
    return np.array(values)
