"""Cost of analysis and members: processor time for each 256 x 256 pixels, and memory, by the side of made images.

``python benchmarks/cost.py --sides 384 1024 2048``. Members are those after the first, at 15 min, in tiles of 512 x 512
pixels, as the generator asks for them.
"""

import argparse
import resource
import subprocess
import sys
import time
from datetime import timedelta

import numpy as np
from hcss_follow.analysis import Image, analyse
from hcss_follow.sky import FollowedSky
from scipy.ndimage import gaussian_filter
from sequences import MARGIN, START

TILE, LEAD_S = 512, 900.0


def images(side):
    """Return two images of broken cloud, 15 min apart, moved by two pixels."""
    noise = gaussian_filter(np.random.default_rng(1).normal(size=(side, side)).astype(np.float32), 3.0, mode="wrap")
    return [
        Image(
            290.0 - 12.0 * np.clip(np.roll(noise / noise.std(), 2 * n, 1), 0.0, None), START + n * timedelta(minutes=15)
        )
        for n in range(2)
    ]


def member(state, number):
    """Compute a member inside the margin, tile by tile, keeping none."""
    sky, total = FollowedSky(state, 1, number), 0.0
    rows, columns = state.shape
    for i in range(MARGIN, rows - MARGIN, TILE):
        for j in range(MARGIN, columns - MARGIN, TILE):
            sides = (i, rows), (j, columns)
            y, x = (np.arange(at, min(at + TILE, side - MARGIN)) - 0.5 * (side - 1) for at, side in sides)
            total += float(sky.at(LEAD_S, y, x)[..., 0].sum(dtype=np.float64))
    return total


def measure(side):
    """Print the cost of one side."""
    of, inside = (side / 256.0) ** 2, ((side - 2 * MARGIN) / 256.0) ** 2
    analyse(images(64), pixel_size_m=3000.0, latitude=0.0, longitude=0.0)  # compiles
    given = images(side)
    start = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    began = time.process_time()
    state = analyse(given, pixel_size_m=3000.0, latitude=0.0, longitude=0.0)
    analysed = time.process_time() - began
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    member(state, 0)
    spent = []
    for number in range(1, 4):
        began = time.process_time()
        member(state, number)
        spent.append(time.process_time() - began)
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(
        f"{side} x {side}: analysis {analysed / of:.3f} s and member {min(spent) / inside:.3f} s of 256 x 256; memory "
        f"{start / 1024:.0f} MiB with the images, {after / 1024:.0f} with the state, {most / 1024:.0f} with members",
        flush=True,
    )


def main():
    """Measure each side in a process of its own, since memory counts from the largest so far."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--sides", nargs="+", type=int, default=[384, 1024, 2048])
    arguments.add_argument("--one", type=int, help=argparse.SUPPRESS)
    given = arguments.parse_args()
    if given.one:
        measure(given.one)
    else:
        for side in given.sides:
            subprocess.run([sys.executable, __file__, "--one", str(side)], check=True)


if __name__ == "__main__":
    main()
