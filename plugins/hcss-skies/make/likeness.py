"""How often ``hcss match`` says that no fractal field looks like an image.

    python make/likeness.py BLOCKS.nc

Two parts of 160 x 160 pixels of each SEVIRI block, the shipped examples, and 40 fractal fields of random parameters are
matched without a search; the ratio of :class:`hcss_evaluate.matching.quantities.Likeness` is above 1.25 where the
command says so. Prints ratios by kind of cloud (``block-kinds.txt``).
"""

from __future__ import annotations

import sys
from pathlib import Path

import kinds
import netCDF4
import numpy as np
from hcss_evaluate.matching.match import match
from hcss_evaluate.matching.quantities import MAX_RATIO
from hcss_evaluate.matching.search import reference_cells
from hcss_evaluate.matching.structure import CloudImage, simulate_image
from hcss_evaluate.matching.target import Target
from hcss_skies.example import read_example
from hcss_skies.importing import CLEAR_K, clear_sky_K
from hcss_skies.library import shipped

from hcss_twin.models.clouds.fractal.parameters import FractalParameters

SIDE, FIELDS, PIXEL_M = 160, 40, 3000.0
LIKE = CloudImage(np.zeros((SIDE, SIDE), np.float32), PIXEL_M)


def ratio(field: np.ndarray) -> float:
    """Return the ratio of a field, 0 and less where clear."""
    level = np.where(field > 0.0, 1.0 + 254.0 * field / field.max(), 0.0).astype(np.float32)
    return match(Target(CloudImage(level, PIXEL_M), "image", ()), budget=0).likeness.ratio


def show(name: str, ratios: list[float]) -> None:
    """Print a line."""
    low, middle, high = np.quantile(ratios, (0.05, 0.5, 0.95))
    said = np.mean(np.array(ratios) > MAX_RATIO)
    print(f"{name:26} {len(ratios):3d} images, said so {said:.2f}; 5, 50, 95 %: {low:.2f} {middle:.2f} {high:.2f}")


def main() -> None:
    """Measure all and print."""
    source, rng, found = Path(sys.argv[1]), np.random.default_rng(0), []
    for number in range(FIELDS):
        cells = reference_cells(rng.uniform(3.0, 14.0, 2), LIKE)
        shape = FractalParameters(gamma=2.0, H=float(rng.uniform(0.2, 0.8)), L=cells, k=(0, 4))
        image = simulate_image(shape, float(rng.uniform(0.15, 0.9)), LIKE, 1000 * number + 5)
        found.append(ratio(image.level.astype(np.float64)))
    show("fractal fields", found)
    of_kind: dict[str, list[float]] = {}
    for path in shipped().values():
        example = read_example(path)
        field = (example.opaque_m[example.opaque] - example.clear_m)[:SIDE, :SIDE]
        of_kind.setdefault(f"example {example.kind}", []).append(ratio(field))
    blocks = kinds.blocks_of(source)
    with netCDF4.Dataset(source) as file:
        kelvin = np.ma.filled(file["ir_108"][:, 1].astype(float), np.nan)
    for number, block in enumerate(kelvin):
        for part in (block[:SIDE, :SIDE], block[-SIDE:, -SIDE:]):
            block_ratio = ratio(clear_sky_K(block) - CLEAR_K - part)
            for kind, members in blocks.items():
                if number in members:
                    of_kind.setdefault(f"SEVIRI {kind}", []).append(block_ratio)
    for kind in sorted(of_kind):
        show(kind, of_kind[kind])


if __name__ == "__main__":
    main()
