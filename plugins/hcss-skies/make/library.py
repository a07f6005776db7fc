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
    "stratus-sheet": of.stratus_sheet,
    "cirrus-fibres": of.cirrus_fibres,
    "anvils": of.anvils,
    "altocumulus": of.altocumulus,
    "multi-layer": of.multi_layer,
}

# What all mechanisms have: how the wind draws clouds out, what the clear sea looks like.
_COMMON = {"stretch": (1.0, 4.0), "pixels": (0.0, 30.0), "sea": (10.0, 90.0), "haze": (0.0, 300.0)}
_LOW = {**_COMMON, "ragged": (0.2, 1.5), "veil": (0.02, 0.4), "height": (3000.0, 9000.0)}
_CELLS = {
    "sizes": (0.0, 0.8), "unequal": (0.0, 0.5), "patchiness": (0.1, 1.0), "front": (0.7, 4.0), "crack": (0.0, 2.0),
    "rough": (0.05, 0.7), "width": (0.03, 0.6), "slope": (0.0, 0.3), "grain": (0.0, 0.06), **_LOW,
}  # fmt: skip
# Of closed cells and streets, so that they look like them: wide cells, little bent or drawn out, little cirrus.
_LAYER = {
    **_CELLS, "eddies": (1.5, 10.0), "small": (0.0, 150.0), "slope": (0.04, 0.3), "dome": (0.3, 1.5),
    "relief": (0.0, 0.1), "stretch": (1.0, 1.6), "pixels": (2.0, 7.0), "haze": (0.0, 100.0), "veil": (0.01, 0.12),
}  # fmt: skip
_FIBRES = {
    "length": (4.0, 24.0), "cover": (0.2, 0.95), "width": (0.3, 4.0), "power": (0.7, 3.0), "rough": (0.0, 0.6),
    "sheet": (0.0, 3.0), "grouping": (0.2, 1.5),
}  # fmt: skip

LIMITS: dict[str, dict[str, tuple[float, float]]] = {
    "open-cells": {
        "cell": (5.0, 14.0), "regime": (0.1, 0.9), "lull": (0.0, 0.4), **_CELLS, "stretch": (1.0, 2.2),
        "pixels": (3.0, 14.0), "veil": (0.01, 0.12),
    },
    "closed-cells": {"cell": (10.0, 18.0), "regime": (0.2, 1.6), **_LAYER, "sizes": (0.15, 0.8), "veil": (0.01, 0.06)},
    "streets": {
        "roll": (5.0, 14.0), "puff": (0.4, 1.2), "length": (1.5, 6.0), "rolls": (0.03, 0.5), "regime": (-0.6, 1.2),
        **_LAYER, "grain": (0.0, 0.2), "sea": (10.0, 50.0),
    },
    "trade-cumulus": {
        "clusters": (300.0, 6000.0), "clustering": (0.3, 2.5), "largest": (2.0, 7.0), "soft": (0.5, 1.5),
        "halo": (0.0, 2.0), "rough": (0.1, 0.8), "least": (0.0, 1.0), "width": (0.3, 3.0),
        "small": (0.0, 150.0), **_LOW,
    },
    "stratus-sheet": {
        "cell": (5.0, 14.0), "cover": (0.5, 0.95), "width": (0.1, 2.0), "slope": (2.2, 3.4), "rough": (0.0, 0.6),
        "activity": (0.0, 1.5), "cells": (0.0, 1.0), "relief": (5.0, 120.0), **_COMMON,
    },
    "cirrus-fibres": {**_FIBRES, "low": (0.0, 2500.0), **_COMMON},
    "anvils": {
        "towers": (10.0, 90.0), "shear": (0.0, 2.0), "outflow": (0.0, 2.0), "rough": (0.1, 1.0), "opacity": (0.2, 1.5),
        "middle": (0.1, 0.9), "low": (0.0, 2500.0), "bumps": (0.0, 800.0), **_COMMON,
    },
    "altocumulus": {
        "wave": (4.0, 10.0), "slope": (2.0, 3.4), "rough": (0.0, 0.6), "rows": (0.1, 0.8), "cover": (0.2, 0.9),
        "width": (0.3, 3.0), **_COMMON,
    },
    "multi-layer": {
        **_FIBRES, "rows": (0.0, 0.6), "crumbs": (0.0, 0.4), "middle": (0.05, 0.8), "soft": (0.4, 3.0),
        "low": (300.0, 2500.0), "broken": (0.1, 0.8), "sheets": (0.1, 0.8), "thin": (0.05, 0.6), **_COMMON,
    },
}  # fmt: skip
"""By kind: the parameters of its mechanism, and the range in which ``tune.py`` searches each."""

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
    "stratus-sheet": {
        "cell": 5.67, "cover": 0.532, "width": 0.581, "slope": 2.93, "rough": 0.0416, "activity": 0.379,
        "cells": 0.4, "relief": 83.7, "stretch": 2.74, "pixels": 15.0, "sea": 51.0, "haze": 21.9,
    },
    "cirrus-fibres": {
        "length": 16.1, "cover": 0.697, "width": 1.25, "power": 2.25, "rough": 0.404, "sheet": 0.892,
        "grouping": 0.621, "low": 1410.0, "stretch": 1.97, "pixels": 11.6, "sea": 16.1, "haze": 53.3,
    },
    "anvils": {
        "towers": 49.1, "shear": 0.481, "outflow": 0.688, "rough": 0.74, "opacity": 0.715, "middle": 0.444,
        "low": 2430.0, "bumps": 631.0, "stretch": 2.84, "pixels": 11.6, "sea": 57.9, "haze": 53.4,
    },
    "altocumulus": {
        "wave": 6.4, "slope": 2.24, "rough": 0.316, "rows": 0.2, "cover": 0.737, "width": 1.06, "stretch": 1.9,
        "pixels": 12.0, "sea": 12.0, "haze": 10.9,
    },
    "multi-layer": {
        "length": 17.8, "cover": 0.405, "width": 2.44, "power": 1.49, "rough": 0.466, "sheet": 2.59,
        "grouping": 0.343, "rows": 0.155, "crumbs": 0.297, "middle": 0.102, "soft": 1.65, "low": 1200.0,
        "broken": 0.498, "sheets": 0.355, "thin": 0.064, "stretch": 2.18, "pixels": 9.07, "sea": 68.5, "haze": 123.0,
    },
}  # fmt: skip
"""By kind: parameters that ``tune.py`` chose; those of open cells and some of altocumulus, trade cumulus and streets
are by eye."""

_SCALES, _COVERS, _ANGLES = (1.0, 1.3, 0.8), (1.0, 0.85, 1.1), (0.2, 1.1, 2.3)
"""By example of a kind: the size of its organisation, its cover, and the direction of its wind."""


def made(kind: str, number: int, shape: dict[str, float]) -> Example:
    """Return an example of a kind from parameters of its mechanism; numbers 1 to 3 differ in scale, cover and wind."""
    rng = np.random.default_rng(zlib.crc32(f"{kind}-{number}".encode()))
    own = {**shape, "angle": _ANGLES[number - 1]}
    for name in ("cell", "roll", "length", "wave"):
        own[name] = own.get(name, 0.0) * _SCALES[number - 1]
    own["cover"] = min(own.get("cover", 0.0) * _COVERS[number - 1], 0.99)
    opaque, excess = MECHANISMS[kind](rng, **own)
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
