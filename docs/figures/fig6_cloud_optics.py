"""Draw Fig 6 of the HCSS paper, cloud optics at 0.3-14.3 um, with the optics providers.

::

    python docs/figures/fig6_cloud_optics.py FOLDER

writes ``fig6.png``: efficiencies and single-scattering albedo of cumulus, stratus and cirrus, and phase
functions at 3.7 and 10.8 um. Lines are provider ``bulk``, dotted ones ``mie`` (the paper's spheres).
"""

from __future__ import annotations

import sys
from pathlib import Path

from hcss_paper.cloud_optics import cloud_optics_figure

from hcss_twin.core.catalog import Catalog


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit("usage: python docs/figures/fig6_cloud_optics.py FOLDER")
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    cloud_optics_figure(Catalog()).savefig(folder / "fig6.png", dpi=110)


if __name__ == "__main__":
    main()
