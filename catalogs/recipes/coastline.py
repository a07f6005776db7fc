"""Coastlines and a coarse land mask from Natural Earth's land polygons (1:10 million).

Source: Natural Earth, "Land", 1:10m physical vectors, version 4.1 (public domain: naturalearthdata.com, Terms of Use),
as TopoJSON in the npm package world-atlas 2.0.2 (ISC licence, Mike Bostock). Its coordinates are whole multiples of
0.0036 degrees of longitude and 0.0017 degrees of latitude, which these files keep.

    npm pack world-atlas@2.0.2
    python catalogs/recipes/coastline.py world-atlas-2.0.2.tgz
"""

from __future__ import annotations

import json
import sys
import tarfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

VERSION = "2.0.2"
FOLDER = Path(__file__).parents[1] / "surfaces"
DEGREE_POINTS = 20
"""Points per degree at which the inside of polygons is looked up for the coarse mask."""


def topology(archive: str) -> dict[str, Any]:
    """Read the polygons from the package, and stop if it is another version."""
    with tarfile.open(archive) as package:
        about = json.load(package.extractfile("package/package.json"))  # type: ignore[arg-type]
        if about["version"] != VERSION:
            sys.exit(f"world-atlas {about['version']}; this recipe needs {VERSION}")
        data: dict[str, Any] = json.load(package.extractfile("package/land-10m.json"))  # type: ignore[arg-type]
    return data


WHOLE_TURN = 99_999
"""Steps of longitude from -180 to 180 degrees."""


def along_the_meridian(ring: NDArray[np.int64], pole: int) -> NDArray[np.int64]:
    """Return a ring that is closed in the plane: where it jumps from 180 to -180 degrees it goes round by the pole.

    The package has rings on the sphere. Two ways to the pole along the same meridian cancel, so that the ring ends at
    the meridian; the single one of Antarctica remains.
    """
    after = np.roll(ring, -1, axis=0)
    pieces, first = [], 0
    for place in np.flatnonzero(np.abs(after[:, 0] - ring[:, 0]) > WHOLE_TURN // 2).tolist():
        (x0, y0), (x1, y1) = ring[place].tolist(), after[place].tolist()
        here, there = (WHOLE_TURN, 0) if x0 > x1 else (0, WHOLE_TURN)
        gap = abs(here - x0) + abs(x1 - there)
        y = round(y0 + (y1 - y0) * abs(here - x0) / gap) if gap else y0
        pieces += [ring[first : place + 1], np.array([(here, y), (here, pole), (there, pole), (there, y)])]
        first = place + 1
    return np.concatenate([*pieces, ring[first:]])


def rings(data: dict[str, Any]) -> list[NDArray[np.int64]]:
    """Return the closed rings (N, 2) in steps of longitude and latitude, without the repeated first vertex."""
    scale, south = data["transform"]["scale"][1], data["transform"]["translate"][1]
    pole = int(np.floor((-90.0 - south) / scale))
    arcs = [np.cumsum(np.array(arc, dtype=np.int64), axis=0) for arc in data["arcs"]]

    def ring(numbers: list[int]) -> NDArray[np.int64]:
        pieces = [arcs[number] if number >= 0 else arcs[~number][::-1] for number in numbers]
        return along_the_meridian(np.concatenate([piece[:-1] for piece in pieces]), pole)

    found = []
    for shape in data["objects"]["land"]["geometries"]:
        polygons = [shape["arcs"]] if shape["type"] == "Polygon" else shape["arcs"]
        found += [ring(each) for polygon in polygons for each in polygon]
    # "Null Island" at 0 N 0 E is a joke of the source.
    middle = np.array([WHOLE_TURN / 2, -south / scale])
    return [each for each in found if np.max(np.abs(each - middle)) > 10.0]


def main(archive: str) -> None:
    """Write both files."""
    data = topology(archive)
    found = rings(data)
    vertices = np.concatenate(found)
    steps = np.diff(vertices, axis=0, prepend=0)
    (scale_x, scale_y), (west, south) = data["transform"]["scale"], data["transform"]["translate"]
    FOLDER.mkdir(exist_ok=True)
    np.savez_compressed(
        FOLDER / "coastline.npz",
        longitude_steps=steps[:, 0].astype(np.int32),
        latitude_steps=steps[:, 1].astype(np.int32),
        vertices=np.array([len(each) for each in found], dtype=np.int32),
        grid=np.array([west, scale_x, south, scale_y]),
    )
    sys.path.insert(0, str(Path(__file__).parents[2]))
    from hcss_twin.models.surfaces.coastline import Coastline

    coastline = Coastline.read(FOLDER / "coastline.npz")
    fine = (np.arange(180 * DEGREE_POINTS) + 0.5) / DEGREE_POINTS - 90.0
    across = (np.arange(360 * DEGREE_POINTS) + 0.5) / DEGREE_POINTS - 180.0
    land = np.zeros((180, 360), dtype=np.bool_)
    for row in range(180):
        latitude, longitude = np.meshgrid(fine[row * DEGREE_POINTS : (row + 1) * DEGREE_POINTS], across, indexing="ij")
        inside = coastline.is_land(latitude, longitude)
        land[row] = inside.reshape(DEGREE_POINTS, 360, DEGREE_POINTS).any(axis=(0, 2))
    # Islands between these points have vertices.
    x, y = west + scale_x * vertices[:, 0], np.maximum(south + scale_y * vertices[:, 1], -90.0)
    cell_y, cell_x = np.clip(np.floor(y + 90.0).astype(int), 0, 179), np.floor(x + 180.0).astype(int) % 360
    land[cell_y, cell_x] = True
    np.save(FOLDER / "land-cells.npy", np.packbits(land))


if __name__ == "__main__":
    main(sys.argv[1])
