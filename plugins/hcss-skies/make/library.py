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
_CELLULAR = {
    "patchiness": (0.1, 0.6), "crack": (0.0, 0.6), "rough": (0.02, 0.5), "relief": (0.0, 0.4), "lull": (0.0, 0.6),
    "width": (0.08, 0.8), "grain": (0.0, 0.2),
}  # fmt: skip
_FIBRES = {
    "length": (4.0, 24.0), "cover": (0.2, 0.95), "width": (0.3, 4.0), "power": (0.7, 3.0), "rough": (0.0, 0.6),
    "sheet": (0.0, 3.0), "grouping": (0.2, 1.5),
}  # fmt: skip

LIMITS: dict[str, dict[str, tuple[float, float]]] = {
    "open-cells": {"cell": (6.0, 14.0), "regime": (0.1, 0.9), **_CELLULAR, **_COMMON,
        "pixels": (3.0, 14.0), "stretch": (1.0, 2.2),
    },
    "closed-cells": {"cell": (8.0, 20.0), "regime": (0.9, 1.7), **_CELLULAR, **_COMMON,
        "pixels": (3.0, 14.0), "stretch": (1.0, 2.2),
    },
    "streets": {
        "roll": (5.0, 14.0), "cover": (0.2, 0.8), "width": (0.2, 3.0), "rolls": (0.2, 2.0), "rough": (0.1, 1.5),
        "slope": (2.0, 3.4), **_COMMON,
    },
    "trade-cumulus": {
        "clusters": (300.0, 3000.0), "clustering": (0.3, 2.5), "largest": (2.0, 7.0), "soft": (0.5, 1.5),
        "halo": (0.0, 2.0), "rough": (0.1, 0.8), "least": (0.0, 1.0), **_COMMON,
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
    "multi-layer": {**_FIBRES, "rows": (0.0, 0.6), "middle": (0.1, 0.8), "low": (0.0, 2500.0), **_COMMON},
}  # fmt: skip
"""By kind: the parameters of its mechanism, and the range in which ``tune.py`` searches each."""

SHAPES: dict[str, dict[str, float]] = {
    "open-cells": {
        "cell": 6.96, "regime": 0.437, "patchiness": 0.588, "crack": 0.127, "rough": 0.2, "relief": 0.305,
        "lull": 0.214, "width": 0.174, "grain": 0.101, "stretch": 1.2, "pixels": 6.0, "sea": 86.7, "haze": 112.0,
    },
    "closed-cells": {
        "cell": 8.74, "regime": 1.25, "patchiness": 0.457, "crack": 0.0572, "rough": 0.158, "relief": 0.128,
        "lull": 0.0142, "width": 0.0824, "grain": 0.0636, "stretch": 1.37, "pixels": 6.92, "sea": 53.3, "haze": 13.8,
    },
    "streets": {
        "roll": 7.49, "cover": 0.516, "width": 0.748, "rolls": 0.546, "rough": 0.654, "slope": 2.49, "stretch": 1.79,
        "pixels": 3.66, "sea": 64.1, "haze": 120.0,
    },
    "trade-cumulus": {
        "clusters": 1380.0, "clustering": 1.08, "largest": 4.0, "soft": 1.04, "halo": 0.728, "rough": 0.38,
        "least": 0.27, "stretch": 2.26, "pixels": 6.47, "sea": 40.0, "haze": 149.0,
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
        "length": 13.8, "cover": 0.515, "width": 2.39, "power": 1.36, "rough": 0.24, "sheet": 1.16,
        "grouping": 0.633, "rows": 0.169, "middle": 0.443, "low": 832.0, "stretch": 2.34, "pixels": 3.53,
        "sea": 47.1, "haze": 267.0,
    },
}  # fmt: skip
"""By kind: parameters that ``tune.py`` chose in 30 to 50 steps; some of altocumulus and open cells are by eye."""

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
