"""The same sky seen in pixels of 5, 20 and 50 m: does a coarse sensor see the mean of the fine one?

Needs ``image.samples_per_pixel`` and clouds that keep one threshold for the whole field
(``clouds.coverage_mode = "field"``); says so where the engine does not know them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from cloud_scenes import TYPES

import hcss_twin
from hcss_twin.core.errors import ScenarioError

GROUND_M = 8000.0
FINE_M = 5.0
COARSE_M = (20.0, 50.0)
SAMPLES = (1, 2, 4)
COVERAGE = 0.5


def one_sky() -> None:
    """Print rms and mean difference of coarse pixels from block means of fine ones."""
    print(
        f"{GROUND_M / 1e3:g} km of one sky, coverage {COVERAGE:g}; coarse pixels minus block means of {FINE_M:g} m "
        "pixels: mean +- rms. Volume is thickness averaged over the whole pixel. With 4 samples "
        f"a side, 20 m pixels are made of the very points of {FINE_M:g} m pixels: 0 there says that it is one sky.\n"
    )
    print("| type | pixel, m | samples per side | volume, m | of the mean | cloud fraction |")
    print("|---|---|---|---|---|---|")
    for kind in TYPES:
        try:
            fine = volume_and_fraction(sky(kind, FINE_M, 1))
            for pixel_m in COARSE_M:
                truth = [blocks(plane, round(pixel_m / FINE_M)) for plane in fine]
                for samples in SAMPLES:
                    coarse = volume_and_fraction(sky(kind, pixel_m, samples))
                    volume, fraction = (found - true for found, true in zip(coarse, truth, strict=True))
                    share = 100.0 * rms(volume) / truth[0].mean()
                    print(
                        f"| {kind} | {pixel_m:g} | {samples} | {volume.mean():+.2f} +- {rms(volume):.2f} "
                        f"| {share:.1f} % | {fraction.mean():+.4f} +- {rms(fraction):.4f} |"
                    )
        except ScenarioError as error:
            print(f"\nnot possible with this version: {error}")
            return


def sky(kind: str, pixel_m: float, samples: int) -> Any:
    """Return a cube of one frame of the same ground."""
    pixels = round(GROUND_M / pixel_m)
    return hcss_twin.simulate(
        hcss_twin.Scenario.load(
            "stratus",
            {
                "clouds.type": kind,
                "clouds.coverage": COVERAGE,
                "clouds.coverage_mode": "field",
                "image.rows": pixels,
                "image.columns": pixels,
                "image.pixel_size": pixel_m,
                "image.samples_per_pixel": samples,
                "frames.count": 1,
                "bands": ["lwir"],
                "output.variables": ["truth"],
            },
        )
    )


def volume_and_fraction(cube: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return thickness averaged over whole pixels, and cloud fraction: THE ONE PLACE that knows their names."""
    thickness = cube["cloud_thickness"].isel(time=0).to_numpy().astype(np.float64)
    if "cloud_fraction" in cube:
        fraction = cube["cloud_fraction"].isel(time=0).to_numpy().astype(np.float64)
    else:
        fraction = (thickness > 0.0).astype(np.float64)
    return thickness, fraction


def blocks(plane: np.ndarray, side: int) -> np.ndarray:
    """Return means over blocks of ``side`` x ``side`` pixels."""
    rows, columns = (size // side for size in plane.shape)
    return plane[: rows * side, : columns * side].reshape(rows, side, columns, side).mean(axis=(1, 3))


def rms(values: np.ndarray) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))
