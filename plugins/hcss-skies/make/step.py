"""Step of the spectrum of thickness at the pixel of examples from SEVIRI blocks, in dB, and what makes it.

    python make/step.py BLOCKS.nc [FIRST [EVERY]] [--blur PIXELS] [--cell-blur PIXELS] [--strength A]
        [--clear-sky example]

Lines through the spectrum at wavelengths of 2.8 to 10 and of 0.6 to 1.6 pixels are compared at 2 pixels: two skies of
128 pixels of the example at a quarter of its pixel, outside a scene. Options replace the blur of the sensor that the
importer removes from the image (.65 pixels) and from the image that gives the detail (.5), the strength of the detail,
and keep the texture of clear sky, so that no cloud ends at a threshold. The second number is the slope of the long
waves in the spectrum of the image itself, density against wavenumber; the third the share of clear pixels.
"""

import argparse
import math
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from hcss_author import sample_cloud_inputs
from hcss_skies.detail_of_image import fit_detail
from hcss_skies.example import Detail, make_example, write_example
from hcss_skies.generator import ExampleClouds
from hcss_skies.importing import BLUR_PIXELS, CELL_BLUR_PIXELS, CLEAR_K, clear_sky_K, sharpened
from hcss_skies.parameters import ExampleParameters
from hcss_skies.planes import read_plane

from hcss_twin.core.catalog import Catalog
from hcss_twin.providers import Grid, Motion

SIDE, PARTS, BLOCKS = 512, 4, 22
STILL = Motion(0.0, (0.0, 0.0), math.inf, 1.0)
PIXEL_M, LAPSE_K_M = 3000.0, 6.5e-3


def line_dB(power: np.ndarray, cycles: np.ndarray, longest: float, shortest: float) -> tuple[float, float]:
    """Return the power of a line through wavelengths (pixels) at 2 pixels, and its slope in powers of wavenumber."""
    inside = (cycles >= 1.0 / longest) & (cycles <= 1.0 / shortest)
    line = np.polyfit(np.log2(cycles[inside]), 10.0 * np.log10(power[inside]), 1, w=1.0 / cycles[inside])
    return float(np.polyval(line, -1.0)), float(line[0] / (10.0 * math.log10(2.0)))


def cycles_of(side: int, parts: int) -> np.ndarray:
    """Return wavenumbers of ``rfft2`` in cycles per pixel of the example."""
    axes = np.fft.fftfreq(side), np.fft.rfftfreq(side)
    cycles: np.ndarray = parts * np.hypot(*np.meshgrid(*axes, indexing="ij"))
    return cycles


def windowed_power(field: np.ndarray) -> np.ndarray:
    """Return the power of a square field without its mean, with a Hann window."""
    window = np.outer(np.hanning(len(field)), np.hanning(len(field)))
    power: np.ndarray = np.abs(np.fft.rfft2((field - field.mean()) * window)) ** 2
    return power


def step_dB(power: np.ndarray) -> float:
    """Return how far the line of short wavelengths is above that of long ones at 2 pixels of the example."""
    cycles = cycles_of(SIDE, PARTS)
    return line_dB(power, cycles, 1.6, 0.6)[0] - line_dB(power, cycles, 10.0, 2.8)[0]


def main() -> None:
    """Print strength, exponent and step of each block."""
    parser = argparse.ArgumentParser()
    parser.add_argument("file", type=Path)
    parser.add_argument("first", type=int, nargs="?", default=0)
    parser.add_argument("every", type=int, nargs="?", default=2)
    parser.add_argument("--blur", type=float, default=BLUR_PIXELS)
    parser.add_argument("--cell-blur", type=float, default=CELL_BLUR_PIXELS)
    parser.add_argument("--strength", type=float)
    parser.add_argument("--clear-sky", default="uniform", choices=("uniform", "example"))
    given = parser.parse_args()
    steps = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "block.nc"
        for block in range(given.first, BLOCKS, given.every):
            kelvin = read_plane(given.file, "ir_108", {"block": block, "time": 1}).kelvin
            warm = clear_sky_K(kelvin)
            height = (warm - sharpened(kelvin, given.blur)) / LAPSE_K_M
            clear_m = CLEAR_K / LAPSE_K_M
            fitted = fit_detail(warm - sharpened(kelvin, given.cell_blur), height * LAPSE_K_M - CLEAR_K)
            assert fitted is not None
            detail = fitted if given.strength is None else Detail(given.strength, fitted.exponent)
            example = make_example(
                height, None, pixel_size_m=PIXEL_M, clear_m=clear_m, kind="block", source="", licence="", detail=detail
            )
            write_example(path, example)
            power = np.zeros((SIDE, SIDE // 2 + 1))
            for seed in (0, 1):
                inputs = sample_cloud_inputs(seed=seed, catalog=Catalog(base=Path(folder)))
                inputs = replace(
                    inputs,
                    grid=Grid(SIDE, SIDE, PIXEL_M / PARTS),
                    motion=STILL,
                    layer=replace(inputs.layer, thickness_min_m=1e-3),
                )
                of = ExampleParameters(example=str(path), clear_sky=given.clear_sky)
                power += windowed_power(ExampleClouds(inputs, of).thickness_m(0.0, slice(0, SIDE), slice(0, SIDE)))
            steps.append(step_dB(power))
            slope = line_dB(windowed_power(np.maximum(height, clear_m)), cycles_of(len(height), 1), 10.0, 2.8)[1]
            print(
                f"{block:2d}  strength {detail.strength:.2f}, exponent {detail.exponent:.2f}, slope {slope:+.2f}, "
                f"clear {np.mean(height < clear_m):.2f}: {steps[-1]:+.2f} dB",
                flush=True,
            )
    print(f"mean {np.mean(steps):+.2f} dB, from {min(steps):+.2f} to {max(steps):+.2f}")


if __name__ == "__main__":
    main()
