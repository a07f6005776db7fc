"""Clear sea and opaque low cloud by default, beside brightness temperatures that SEVIRI measured.

::

    python benchmarks/seviri_boxes.py ../shared/data/seviri            # table of both kinds
    python benchmarks/seviri_boxes.py ../shared/data/seviri --boxes    # and every box

The folder holds ``boxes-dev.json`` (boxes of 2 x 2 degrees with measured temperatures) and ``responses`` (one file for
each channel); neither is part of this repository. Scenes have place, time and view of the box and nothing else: what is
tested is what a user gets who names no more than that. Constants of the air and of the inversion were chosen with these
boxes, so that the table shows how they fit; other days and places show whether they hold.

A second table sets the standard deviation that the error budget of each scene states beside the differences: its mean
over the boxes, its ratio to their root mean square, and the share of boxes whose difference lies within ``WITHIN``
times it, which is 90 % for normal errors. The budget's rows for sea, air and tops were chosen with these boxes too.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin import Scenario, column_spectra, make_plan
from hcss_twin.core.arrays import Array
from hcss_twin.physics.planck import planck
from hcss_twin.plan.error_budget import error_budget

CHANNELS = {"3.9 um": "IR_039", "8.7 um": "IR_087", "10.8 um": "IR_108", "12.0 um": "IR_120", "13.4 um": "IR_134"}
KINDS = {"clear sea": None, "opaque low cloud": "stratocumulus"}
TIME = "2020-09-06T00:45:00Z"

WITHIN = 1.645
"""Standard deviations that hold 90 % of normal errors."""


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
        }
    )


def temperatures_K(scene: Scenario) -> Array:
    """Return the brightness temperature (B,) of the thickest column of a scene in each band."""
    spectra = column_spectra(scene)
    kelvin = np.linspace(180.0, 330.0, 1501)
    radiance = planck(spectra.wavenumber_cm1[None], kelvin[:, None]) @ spectra.weights_cm1.T
    measured = spectra.weights_cm1 @ spectra.radiance[-1]
    return np.array([np.interp(measured[band], radiance[:, band], kelvin) for band in range(measured.size)])


def stated_K(scene: Scenario, of: str) -> Array:
    """Return the total (B,) that the error budget of a scene states for a class in each band."""
    budget = error_budget(make_plan(scene))
    return np.array([budget.total((of, name))[1] for name in CHANNELS])


def differences_K(folder: Path, kind: str) -> tuple[list[dict[str, Any]], Array, Array]:
    """Return the boxes of a kind, simulated less measured temperature (N, B), and what the budget states (N, B)."""
    text = (folder / "boxes-dev.json").read_text(encoding="utf-8")
    boxes = [box for box in json.loads(text)["boxes"] if box["kind"] == kind]
    measured = np.array([[box["measured_K"][name] for name in CHANNELS] for box in boxes])
    scenes = [scenario(box, folder / "responses", KINDS[kind]) for box in boxes]
    simulated = np.array([temperatures_K(scene) for scene in scenes])
    stated = np.array([stated_K(scene, KINDS[kind] or "clear") for scene in scenes])
    return boxes, simulated - measured, stated


def coverage(found: Array, stated: Array) -> list[str]:
    """Return mean stated sigma, its ratio to the rms of what was found, and the share of boxes within; (N, B) each."""
    rms = np.sqrt(np.mean(found**2, axis=0))
    inside = np.mean(np.abs(found) <= WITHIN * stated, axis=0)
    mean = stated.mean(axis=0)
    return [
        f"{sigma:.2f} {ratio:.2f} {100.0 * share:3.0f} %"
        for sigma, ratio, share in zip(mean, mean / rms, inside, strict=True)
    ]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--boxes", action="store_true", help="print every box")
    given = parser.parse_args()
    print("simulated less measured, K: mean and standard deviation")
    print(f"{'':28}" + "".join(f"{name:>16}" for name in (*CHANNELS, "10.8 - 12.0")))
    covered = {}
    for kind in KINDS:
        boxes, of_bands, stated = differences_K(given.folder, kind)
        covered[f"{kind}, {len(boxes)} boxes"] = coverage(of_bands, stated)
        found = np.column_stack((of_bands, of_bands[:, 2] - of_bands[:, 3]))
        if given.boxes:
            for box, row in zip(boxes, found, strict=True):
                where = f"{kind} {box['latitude']:g} {box['longitude']:g}"
                print(f"{where:28}" + "".join(f"{value:16.2f}" for value in row))
        cells = (f"{mean:+.2f} +- {sd:.2f}" for mean, sd in zip(found.mean(0), found.std(0, ddof=1), strict=True))
        print(f"{f'{kind}, {len(boxes)} boxes':28}" + "".join(f"{cell:>16}" for cell in cells))
    print(f"stated standard deviation, K; over the rms difference; share of boxes within {WITHIN} of it")
    for name, row in covered.items():
        print(f"{name:28}" + "".join(f"{cell:>16}" for cell in row))


if __name__ == "__main__":
    main()
