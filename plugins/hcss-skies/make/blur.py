"""How well a classifier tells blended skies by how much of the blur their examples lose: ``make/blur.py BLOCKS.nc``.

Skies of all SEVIRI blocks, temperature linear in height, against these blocks: AUC of the forest, z-scored, for both
halves of the blocks, with a Gaussian of .65 (the importer's), .57 and .5 pixel removed. Steps: ``step.py --blur``.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import kinds
import netCDF4
import numpy as np
from hcss_skies.example import make_example, write_example
from hcss_skies.importing import CLEAR_K, clear_sky_K, sharpened


def main() -> None:
    """Print a line for each blur and half."""
    with netCDF4.Dataset(sys.argv[1]) as file:
        kelvin = np.ma.filled(file["ir_108"][:, 1].astype(float), np.nan)
    clear_m = CLEAR_K / kinds.LAPSE_K_M
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "block.nc"
        for blur in (0.65, 0.57, 0.5):
            skies = []
            for number, image in enumerate(kelvin):
                height = (clear_sky_K(image) - sharpened(image, blur)) / kinds.LAPSE_K_M
                example = make_example(
                    height, None, pixel_size_m=3000.0, clear_m=clear_m, kind="block", source="", licence=""
                )
                write_example(path, example)
                skies.append(kinds.blended(path, number)[0])
            for half in (0, 1):
                own = list(range(half, len(kelvin), 2))
                found = kinds.told([kelvin[n] for n in own], [skies[n] for n in own], own, own)
                kinds.show(f"{blur} pixel, half {half}", found, 2)


if __name__ == "__main__":
    main()
