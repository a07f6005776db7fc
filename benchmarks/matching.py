"""How near ``hcss match`` comes to real images: the tables of docs/development/clouds.md.

::

    python benchmarks/matching.py FOLDER                       # about 20 s per image
    python benchmarks/matching.py FOLDER --pictures PICTURES   # also images and simulations side by side

Every NetCDF file and picture of the folder is matched with the defaults of ``hcss match``; files that do not tell
their pixel size get --pixel-size. Cloud-top products are matched a second time, with their high clouds only.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import time
from pathlib import Path

from hcss_evaluate.matching import BUDGET
from hcss_evaluate.matching.match import Match, match
from hcss_evaluate.matching.target import ImageChoice, Target, read_target
from hcss_evaluate.pages.cloud_pictures import draw_match

from hcss_twin.core.errors import HcssError

SUFFIXES = (".nc", ".jpg", ".png", ".tif", ".tiff")


def main() -> None:
    """Match every image and print both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--pictures", type=Path, help="Folder for the pictures, which exists.")
    parser.add_argument("--pixel-size", type=float, default=2000.0, help="Metres, where a file does not tell.")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--budget", type=int, default=BUDGET)
    options = parser.parse_args()
    rows = []
    for number, target in enumerate(targets(options.folder, options.pixel_size), 1):
        begun = time.perf_counter()
        found = match(target, options.seed, options.budget)
        rows.append((number, found, time.perf_counter() - begun))
        if options.pictures is not None:
            draw_match(found, options.pictures / f"match-{number}.png")
    print(f"seed {options.seed}, {options.budget} images; real / mean of simulations\n")
    print("| | image | part | cloud |")
    print("|---|---|---|---|")
    for number, found, _ in rows:
        print(f"| {number} | {found.target.source} | {found.target.notes[0]} | {found.target.notes[1]} |")
    print_quantities(rows)


def print_quantities(rows: list[tuple[int, Match, float]]) -> None:
    """Print a column of real / simulated values for each quantity, and the RMSE."""
    names = [each.name for each in rows[0][1].quantities]
    print("\n| | RMSE (eq 24) | start | " + " | ".join(names) + " | s |")
    print("|---" * (len(names) + 4) + "|")
    for number, found, seconds in rows:
        start = sum(found.start_rmse) / len(found.start_rmse)
        values = [f"{q.image:.4g} / {q.simulated:.4g}{'' if q.is_matched else ' *'}" for q in found.quantities]
        print(
            f"| {number} | {found.mean_rmse:.1%} ({min(found.rmse):.1%} to {max(found.rmse):.1%}) | {start:.1%} | "
            + " | ".join(values)
            + f" | {seconds:.0f} |"
        )
    print("\n\\* not matched\n\n| | gamma | H | Lx | Ly | kmax | s |\n|---|---|---|---|---|---|---|")
    for number, found, _ in rows:
        p = found.parameters
        assert p.L is not None
        assert p.k is not None
        print(f"| {number} | {p.gamma:g} | {p.H:g} | {p.L[0]:g} | {p.L[1]:g} | {p.k[1]} | {p.brightness_exponent:g} |")


def targets(folder: Path, pixel_size_m: float) -> list[Target]:
    """Read the images of a folder; what cannot be read is said and left out."""
    found = []
    for path in sorted(path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES):
        try:
            try:
                target = read_target(path)
            except HcssError as error:
                if "pixel_size" not in str(error):
                    raise
                target = read_target(path, ImageChoice(pixel_size_m=pixel_size_m))
            found.append(target)
            if "every pixel with a value" in target.notes[1]:
                found.append(read_target(path, ImageChoice(method="otsu", missing="clear")))
        except HcssError as error:
            print(f"{path.name}: {error}\n")
    return found


if __name__ == "__main__":
    main()
