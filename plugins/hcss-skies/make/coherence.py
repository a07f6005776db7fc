"""Coherence of skies blended from SEVIRI blocks after 15, 30 and 45 min beside that of the blocks, by wavelength.

    python make/coherence.py BLOCKS.nc [--half 0|1]

Brightness temperature of ``ir_108`` at the three times of the file; skies have the texture of the example's clear sky
and temperature linear in height, and lose what the sensor blurs, as in the realism test (the importer took that from
the examples; ``--blur 0`` leaves it out). Each number is a mean over blocks after the mean motion between two frames.
"Up to 200 km" is the whole field without longer waves, of which a patch of an example of 256 pixels has none. The last
lines are the rms change of skies in a second, with and without blur.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import kinds
import netCDF4
import numpy as np
from hcss_evaluate.realism.coherence import coherence
from hcss_skies.example import write_example
from hcss_skies.importing import import_example
from scipy.ndimage import gaussian_filter

EDGES_KM = (0.0, 8.0, 16.0, 32.0, 64.0, 96.0, 200.0, 1e6)
NAMES = ("whole field", "up to 8", "8-16", "16-32", "32-64", "64-96", "96-200", "above 200", "up to 200 km")
PIXEL_KM, FIRST_S = 3.0, 3000.0


def of_sequences(sequences: list[tuple[list[np.ndarray], list[float]]]) -> dict[float, np.ndarray]:
    """Return correlations by lag (s) in the order of ``NAMES``."""
    bands = coherence(sequences, [edge_km / PIXEL_KM for edge_km in EDGES_KM])
    below = coherence(sequences, [0.0, 200.0 / PIXEL_KM])
    return {lag: np.append(values, below[lag][1]) for lag, values in bands.items()}


def main() -> None:
    """Measure both sides and print a table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("file", type=Path)
    parser.add_argument("--half", type=int, choices=(0, 1), help="Every second block only.")
    parser.add_argument("--blur", type=float, default=0.65, help="Of skies, pixels.")
    given = parser.parse_args()
    with netCDF4.Dataset(given.file) as file:
        kelvin = np.ma.filled(file["ir_108"][:].astype(float), np.nan)
        times = [60.0 * float(minutes) for minutes in file["time"][:]]
    blocks = range(len(kelvin)) if given.half is None else range(given.half, len(kelvin), 2)
    simulated, seconds = [], []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "block.nc"
        for block in blocks:
            write_example(path, import_example(given.file, at={"block": block, "time": 1}).example)
            frames = kinds.blended(path, block, [FIRST_S + time_s for time_s in (*times, 1.0)])
            change = frames.pop() - frames[0]
            both = [gaussian_filter(change, blur, mode="nearest") for blur in (given.blur, 0.0)]
            seconds.append([float(np.sqrt(np.mean(change**2))) for change in both])
            simulated.append(([gaussian_filter(frame, given.blur, mode="nearest") for frame in frames], times))
    measured = of_sequences([(list(kelvin[block]), times) for block in blocks])
    skies = of_sequences(simulated)
    print("min        " + "".join(f"{name:>14}" for name in NAMES))
    for lag, values in measured.items():
        for side, row in (("measured", values), ("blended", skies[lag]), ("differs", skies[lag] - values)):
            print(f"{lag / 60:3.0f} {side:8}" + "".join(f"{value:14.2f}" for value in row))
    for name, changes in zip(("with", "without"), np.transpose(seconds), strict=True):
        print(f"a second changes {changes.mean():.4f} K rms {name} blur, {changes.min():.4f} to {changes.max():.4f}")


if __name__ == "__main__":
    main()
