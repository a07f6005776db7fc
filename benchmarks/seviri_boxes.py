"""Clear sea and opaque low cloud by default, beside brightness temperatures that SEVIRI measured.

::

    python benchmarks/seviri_boxes.py ../shared/data/seviri            # table of both kinds
    python benchmarks/seviri_boxes.py ../shared/data/seviri --boxes    # and every box

The folder holds ``boxes-dev.json`` (boxes of 2 x 2 degrees with measured temperatures) and ``responses`` (one file for
each channel); neither is part of this repository. Scenes have place, time and view of the box and nothing else: what is
tested is what a user gets who names no more than that. Constants of the air and of the inversion were chosen with these
boxes, so that the table shows how they fit; other days and places show whether they hold.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin import Scenario, column_spectra
from hcss_twin.core.arrays import Array
from hcss_twin.physics.planck import planck

CHANNELS = {"3.9 um": "IR_039", "8.7 um": "IR_087", "10.8 um": "IR_108", "12.0 um": "IR_120", "13.4 um": "IR_134"}
KINDS = {"clear sea": None, "opaque low cloud": "stratocumulus"}
TIME = "2020-09-06T00:45:00Z"


def scenario(box: dict[str, Any], responses: Path, cloud_type: str | None) -> Scenario:
    """Return a scene with the place, time and view of a box, under clear or overcast sky."""
    clouds = [] if cloud_type is None else [{"type": cloud_type, "coverage": 1.0}]
    bands = [{"name": name, "response": str(responses / f"{file}.csv")} for name, file in CHANNELS.items()]
    return Scenario.from_dict(
        {
            "time": TIME,
            "place": {"latitude": float(box["latitude"]), "longitude": float(box["longitude"])},
            "view": {"zenith": box["view_zenith_deg"], "azimuth": 0.0},
            "image": {"rows": 8, "columns": 8, "pixel_size": 3000.0},
            "frames": {"count": 1},
            "bands": bands,
            "clouds": {"layers": clouds},
            "accuracy": 1e-2,
        }
    )


def temperatures_K(scene: Scenario) -> Array:
    """Return the brightness temperature (B,) of the thickest column of a scene in each band."""
    spectra = column_spectra(scene)
    kelvin = np.linspace(180.0, 330.0, 1501)
    radiance = planck(spectra.wavenumber_cm1[None], kelvin[:, None]) @ spectra.weights_cm1.T
    measured = spectra.weights_cm1 @ spectra.radiance[-1]
    return np.array([np.interp(measured[band], radiance[:, band], kelvin) for band in range(measured.size)])


def differences_K(folder: Path, kind: str) -> tuple[list[dict[str, Any]], Array]:
    """Return the boxes of a kind, and simulated less measured temperature (N, B)."""
    text = (folder / "boxes-dev.json").read_text(encoding="utf-8")
    boxes = [box for box in json.loads(text)["boxes"] if box["kind"] == kind]
    measured = np.array([[box["measured_K"][name] for name in CHANNELS] for box in boxes])
    simulated = np.array([temperatures_K(scenario(box, folder / "responses", KINDS[kind])) for box in boxes])
    return boxes, simulated - measured


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--boxes", action="store_true", help="print every box")
    given = parser.parse_args()
    print("simulated less measured, K: mean and standard deviation")
    print(f"{'':28}" + "".join(f"{name:>14}" for name in CHANNELS) + f"{'10.8 - 12.0':>16}")
    for kind in KINDS:
        boxes, found = differences_K(given.folder, kind)
        found = np.column_stack((found, found[:, 2] - found[:, 3]))
        if given.boxes:
            for box, row in zip(boxes, found, strict=True):
                where = f"{kind} {box['latitude']:g} {box['longitude']:g}"
                print(f"{where:28}" + "".join(f"{value:14.2f}" for value in row))
        cells = (f"{mean:+.2f} +- {sd:.2f}" for mean, sd in zip(found.mean(0), found.std(0, ddof=1), strict=True))
        print(f"{f'{kind}, {len(boxes)} boxes':28}" + "".join(f"{cell:>14}" for cell in cells))


if __name__ == "__main__":
    main()
