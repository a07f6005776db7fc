"""Make the shipped examples: ``python plugins/hcss-skies/make/library.py``. Seeded; needs the plugin."""

from __future__ import annotations

import sys
import zlib
from pathlib import Path

import mechanisms as of
import numpy as np
from hcss_skies import library
from hcss_skies.example import make_example, write_example

PIXEL_M = 3000.0
CLEAR_M = 230.0  # 1.5 K

EXAMPLES = {
    "open-cells": (of.open_cells, (9.0, 0.5), (11.0, 0.42), (7.0, 0.55)),
    "closed-cells": (of.closed_cells, (13.0, 0.85), (18.0, 0.92), (9.0, 0.75)),
    "streets": (of.streets, (6.0, 0.5), (9.0, 0.6), (12.0, 0.4)),
    "trade-cumulus": (of.trade_cumulus, (900, 3.5), (600, 5.0), (1400, 2.5)),
    "stratus-sheet": (of.stratus_sheet, (0.9, 9.0), (0.75, 7.0), (0.97, 12.0)),
    "cirrus-fibres": (of.cirrus_fibres, (6.0, 0.6), (10.0, 0.5), (14.0, 0.75)),
    "anvils": (of.anvils, (40, 0.5), (22, 1.0), (70, 0.3)),
    "altocumulus": (of.altocumulus, (5.0, 0.6), (7.0, 0.45), (9.0, 0.75)),
    "multi-layer": (of.multi_layer, (8.0, 0.5), (12.0, 0.4), (6.0, 0.65)),
}
"""By kind: the mechanism, and the parameters of each example."""


def main(folder: Path) -> None:
    """Write all examples into a folder."""
    for kind, (mechanism, *variants) in EXAMPLES.items():
        for number, parameters in enumerate(variants, start=1):
            name = f"{kind}-{number}"
            rng = np.random.default_rng(zlib.crc32(name.encode()))
            opaque, excess = mechanism(rng, *parameters)
            example = make_example(
                opaque,
                500.0 * np.round(excess / 500.0),
                pixel_size_m=PIXEL_M,
                clear_m=CLEAR_M,
                kind=kind,
                source=f"made by plugins/hcss-skies/make ({mechanism.__name__}{parameters})",
                licence="BSD-3-Clause",
            )
            write_example(folder / f"{name}.nc", example)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(library.__file__).parent)
