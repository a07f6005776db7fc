"""Draw the degraded image of Fig. 17 of the HCSS paper: cirrus in 2.7-3.0 um, clean and as measured.

::

    python docs/figures/degraded_cirrus.py [docs/images/degraded_cirrus.png]

Runs the shipped scenario ``degraded-cirrus``. Needs matplotlib.
"""

from __future__ import annotations

import sys
from pathlib import Path

from hcss_paper.figure_17_degraded_cirrus import drawn

from hcss_twin import Scenario, sense, simulate

PICTURE = Path(__file__).parents[1] / "images" / "degraded_cirrus.png"
NOISE = 7e-4
"""Of the shipped scenario, W m-2 sr-1."""


def draw(scenario: Scenario, path: Path) -> Path:
    """Draw the whole image and a part of it, clean above and measured below."""
    clean = simulate(scenario)
    figure = drawn(clean, sense(clean, scenario), NOISE)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=80)
    return path


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURE
    sys.stdout.write(f"{draw(Scenario.load('degraded-cirrus'), target)}\n")
