"""Step of the spectrum of thickness at the pixel of examples from SEVIRI blocks, in dB.

    python make/step.py BLOCKS.nc [FIRST [EVERY]]

Lines through the spectrum at wavelengths of 2.8 to 10 and of 0.6 to 1.6 pixels are compared at 2 pixels: two skies of
128 pixels of the example at a quarter of its pixel, outside a scene.
"""

import math
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from hcss_skies.example import write_example
from hcss_skies.generator import ExampleClouds
from hcss_skies.importing import import_example
from hcss_skies.parameters import ExampleParameters

from hcss_twin.core.catalog import Catalog
from hcss_twin.providers import Grid, Motion
from hcss_twin.testing.samples import sample_cloud_inputs

SIDE, PARTS, BLOCKS = 512, 4, 22
STILL = Motion(0.0, (0.0, 0.0), math.inf, 1.0)


def step_dB(power: np.ndarray) -> float:
    """Return how far the line of short wavelengths is above that of long ones at 2 pixels of the example."""
    axes = np.fft.fftfreq(SIDE), np.fft.rfftfreq(SIDE)
    cycles, ends = PARTS * np.hypot(*np.meshgrid(*axes, indexing="ij")), []
    for longest, shortest in ((10.0, 2.8), (1.6, 0.6)):
        inside = (cycles >= 1.0 / longest) & (cycles <= 1.0 / shortest)
        line = np.polyfit(np.log2(cycles[inside]), 10.0 * np.log10(power[inside]), 1, w=1.0 / cycles[inside])
        ends.append(float(np.polyval(line, -1.0)))
    return ends[1] - ends[0]


def main() -> None:
    """Print strength, exponent and step of each block."""
    source, first, every = Path(sys.argv[1]), *(int(each) for each in [*sys.argv[2:], "0", "2"][:2])
    window = np.outer(np.hanning(SIDE), np.hanning(SIDE))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "block.nc"
        for block in range(first, BLOCKS, every):
            example = import_example(source, at={"block": block, "time": 1}).example
            write_example(path, example)
            power = np.zeros((SIDE, SIDE // 2 + 1))
            for seed in (0, 1):
                inputs = sample_cloud_inputs(seed=seed, catalog=Catalog(base=Path(folder)))
                inputs = replace(
                    inputs,
                    grid=Grid(SIDE, SIDE, example.pixel_size_m / PARTS),
                    motion=STILL,
                    layer=replace(inputs.layer, thickness_min_m=1e-3),
                )
                clouds = ExampleClouds(inputs, ExampleParameters(example=str(path)))
                sky = clouds.thickness_m(0.0, slice(0, SIDE), slice(0, SIDE)).astype(float)
                power += np.abs(np.fft.rfft2((sky - sky.mean()) * window)) ** 2
            print(f"{block:2d}  {example.detail}  {step_dB(power):+.2f} dB", flush=True)


if __name__ == "__main__":
    main()
