"""Make the shipped examples: ``python plugins/hcss-skies/make/library.py``. Seeded; needs the plugin."""

from __future__ import annotations

import sys
import zlib
from pathlib import Path

import mechanisms as of
import numpy as np
from hcss_skies import library
from hcss_skies.example import Example, make_example, write_example

PIXEL_M = 3000.0
CLEAR_M = 230.0  # 1.5 K
VARIANTS = 3

MECHANISMS = {
    "open-cells": of.open_cells,
    "closed-cells": of.closed_cells,
    "streets": of.streets,
    "trade-cumulus": of.trade_cumulus,
    "anvils": of.anvils,
}

SHAPES: dict[str, dict[str, float]] = {
    "open-cells": {
        "cell": 7.8, "sizes": 0.1, "regime": 0.9, "patchiness": 0.652, "front": 1.46, "crack": 0.0355, "rough": 0.0741,
        "ragged": 0.848, "unequal": 0.148, "lull": 0.238, "width": 0.0798, "slope": 0.0022, "grain": 0.00819,
        "veil": 0.05, "height": 4310.0, "stretch": 1.24, "pixels": 9.34, "sea": 30.3, "haze": 2.69,
    },
    "closed-cells": {
        "cell": 10.1, "sizes": 0.196, "regime": 0.708, "patchiness": 0.527, "front": 2.34, "crack": 0.944,
        "dome": 0.62, "eddies": 1.5, "small": 0.0, "rough": 0.0654, "unequal": 0.107, "width": 0.123, "slope": 0.0524,
        "grain": 0.0236, "relief": 0.0083, "stretch": 1.05, "pixels": 5.84, "sea": 10.8, "haze": 0.681, "ragged": 0.75,
        "veil": 0.0406, "height": 3480.0,
    },
    "streets": {
        "roll": 6.59, "puff": 0.7, "length": 2.47, "rolls": 0.0653, "regime": 0.121, "sizes": 0.6, "unequal": 0.305,
        "patchiness": 0.479, "front": 2.13, "crack": 1.08, "rough": 0.325, "width": 0.11, "slope": 0.101, "grain": 0.12,
        "stretch": 1.41, "pixels": 5.6, "sea": 30.3, "haze": 19.4, "ragged": 0.716, "veil": 0.076, "height": 5510.0,
        "eddies": 5.06, "small": 38.7, "dome": 0.802, "relief": 0.0266,
    },
    "trade-cumulus": {
        "clusters": 1400.0, "clustering": 1.16, "largest": 4.53, "soft": 0.574, "halo": 0.434, "rough": 0.457,
        "least": 0.34, "width": 2.21, "small": 77.4, "stretch": 1.6, "pixels": 6.0, "sea": 15.3, "haze": 33.6,
        "ragged": 1.31, "veil": 0.16, "height": 5800.0,
    },
    "anvils": {
        "towers": 49.1, "shear": 0.481, "outflow": 0.688, "rough": 0.74, "opacity": 0.715, "middle": 0.444,
        "low": 2430.0, "bumps": 631.0, "stretch": 2.84, "pixels": 11.6, "sea": 57.9, "haze": 53.4,
    },
}  # fmt: skip
"""By kind: parameters that an evolution strategy chose (``scores.md``); those of open cells and some of trade cumulus
and streets are by eye."""

_SCALES, _COVERS, _ANGLES = (1.0, 1.3, 0.8), (1.0, 0.85, 1.1), (0.2, 1.1, 2.3)
"""By example of a kind: the size of its organisation, its cover, and the direction of its wind."""


def made(kind: str, number: int, shape: dict[str, float]) -> Example:
    """Return an example of a kind from parameters of its mechanism; numbers 1 to 3 differ in scale, cover and wind."""
    rng = np.random.default_rng(zlib.crc32(f"{kind}-{number}".encode()))
    of_number = {**shape, "angle": _ANGLES[number - 1]}
    for name in ("cell", "roll", "length", "wave"):
        of_number[name] = of_number.get(name, 0.0) * _SCALES[number - 1]
    of_number["cover"] = min(of_number.get("cover", 0.0) * _COVERS[number - 1], 0.99)
    opaque, excess = MECHANISMS[kind](rng, **of_number)
    return make_example(
        opaque,
        500.0 * np.round(excess / 500.0),
        pixel_size_m=PIXEL_M,
        clear_m=CLEAR_M,
        kind=kind,
        source=f"made by plugins/hcss-skies/make ({MECHANISMS[kind].__name__})",
        licence="BSD-3-Clause",
    )


def main(folder: Path) -> None:
    """Write all examples into a folder."""
    for kind, shape in SHAPES.items():
        for number in range(1, VARIANTS + 1):
            write_example(folder / f"{kind}-{number}.nc", made(kind, number, shape))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(library.__file__).parent)
