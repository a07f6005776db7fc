"""Draw the panels of Figs 4 and 10 of the HCSS paper.

::

    python docs/figures/fractal_panels.py FOLDER

writes ``fig4.png`` (gamma, H, L and kmax varied one at a time) and ``fig10.png`` (four cloud types). The paper does not
say what it held fixed in Fig 4, nor the coverage of Fig 10; what is used here stands in the pictures.
"""

from __future__ import annotations

import sys
from pathlib import Path

from hcss_paper import figure_04_fractal_fields as fig4
from hcss_paper import figure_10_cloud_types as fig10

SEED = 1
DPI = 180


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit("usage: python docs/figures/fractal_panels.py FOLDER")
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    panels = [[(title, fig4.field(change, SEED)) for title, change in row] for row in fig4.ROWS]
    fig4.drawn(panels, most=400).savefig(folder / "fig4.png", dpi=DPI)
    clouds = {kind: fig10.thickness(kind, SEED) for kind in fig10.TYPES}
    fig10.drawn(clouds, most=800).savefig(folder / "fig10.png", dpi=DPI)


if __name__ == "__main__":
    main()
