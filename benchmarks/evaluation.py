"""How like real images simulated cubes are: the table of docs/how-to/evaluate.md.

::

    python benchmarks/evaluation.py FOLDER                     # a minute or two on a quiet core
    python benchmarks/evaluation.py FOLDER --reports REPORTS   # also the pages

For each image clouds are matched (``hcss match``), a cube of them is run in the image's band, and the cube is
evaluated against the image: with one threshold for both sides, and with the cube's own mask. The images are the
SEVIRI scene of iris-sample-data and, where FOLDER has it, the GOES-16 radiance at 6.2 um. Radiance is ``as-printed``,
which compiles quickly.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import tempfile
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from hcss_evaluate import EvaluationChoice, evaluate
from hcss_evaluate.comparison.result import Evaluation
from hcss_evaluate.matching.match import match
from hcss_evaluate.matching.target import ImageChoice, read_target
from hcss_evaluate.pages.evaluation_page import evaluation_page

from hcss_twin import Scenario, make_plan
from hcss_twin.engine.simulate import run
from hcss_twin.reports.page import write_page

BUDGET = 120
SHOWN = ("EV", "Den", "DP", "FD", "coverage", "tops", "outline", "spectrum", "degree", "mean", "deviation")

GOES = "OR_ABI-L1b-RadC-M3C08_G16_s20171921817189_e20171921819562_c20171921820002.nc"
LWIR: Any = "lwir-10.8"
VAPOUR: Any = {"name": "wv-6.2", "limits": [5.77, 6.60]}


def main() -> None:
    """Match, run and evaluate every image, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--reports", type=Path, help="Folder for the pages, which exists.")
    options = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, image, choice, scene in images(options.folder):
            cube = simulated(image, choice, scene, Path(folder) / f"{len(rows)}.nc")
            real = EvaluationChoice(variable=choice.variable)
            for mask, sim in (("threshold", EvaluationChoice()), ("mask", EvaluationChoice(method="truth"))):
                found = evaluate(image, cube, real, replace(sim, band=band_name(scene)))
                rows.append((f"{name}, {mask}", found))
                if options.reports is not None:
                    write_page(options.reports / f"{name}-{mask}.html", evaluation_page(found))
    print_table(rows)


def images(folder: Path) -> Iterator[tuple[str, Path, ImageChoice, dict[str, Any]]]:
    """Yield each image with how it is read and where and when its scene is."""
    import iris_sample_data

    yield (
        "SEVIRI 10.8 um",
        Path(iris_sample_data.path) / "toa_brightness_stereographic.nc",
        ImageChoice(missing="clear"),
        scene("2007-12-05T12:00:00Z", (50.0, -20.0), (160, 256), 35_491.9, LWIR, 3600.0),
    )
    if (folder / GOES).is_file():
        yield (
            "GOES-16 6.2 um",
            folder / GOES,
            ImageChoice(variable="Rad", rows=400, columns=400),
            scene("2017-07-11T18:17:18Z", (30.0, -87.0), (400, 400), 2004.0, VAPOUR, 300.0),
        )


def scene(
    time: str, place: tuple[float, float], shape: tuple[int, int], size_m: float, band: Any, interval_s: float
) -> dict[str, Any]:
    """Return a scenario without its clouds."""
    return {
        "time": time,
        "place": {"latitude": place[0], "longitude": place[1]},
        "image": {"rows": shape[0], "columns": shape[1], "pixel_size": size_m},
        "frames": {"count": 6, "interval": interval_s},
        "motion": {"wind_speed": 20.0, "platform_speed": 0.0},
        "bands": [band],
        "radiance": {"model": "as-printed"},
        "sea": {"model": "cox-munk"},
        "optics": {"provider": "mie"},
        "output": {"variables": ["radiance", "brightness_temperature", "cloud_mask"], "certificate": 0},
    }


def band_name(scenario: dict[str, Any]) -> str:
    """Return the name of a scenario's only band."""
    band = scenario["bands"][0]
    return str(band if isinstance(band, str) else band["name"])


def simulated(image: Path, choice: ImageChoice, scenario: dict[str, Any], path: Path) -> Path:
    """Write a cube of clouds that were matched to an image."""
    found = match(read_target(image, choice), 0, BUDGET)
    clouds = {
        "type": "cirrus",
        "coverage": found.coverage,
        "generator": "fractal",
        "parameters": found.parameters.model_dump(mode="json"),
    }
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return run(make_plan(Scenario.from_dict({**scenario, "clouds": clouds})), path)


def print_table(rows: list[tuple[str, Evaluation]]) -> None:
    """Print a row per comparison: RMSE in both definitions, real / simulated values, distances."""
    print("| | RMSE as printed | corrected | " + " | ".join(SHOWN) + " | W1 | W1 centred | spectra |")
    print("|---" * (len(SHOWN) + 6) + "|")
    for name, found in rows:
        values = [f"{found.metric(each).real:.4g} / {found.metric(each).sim:.4g}" for each in SHOWN]
        print(
            f"| {name} | {100 * found.rmse('as-printed'):.1f} % | {100 * found.rmse('corrected'):.1f} % | "
            + " | ".join(values)
            + f" | {found.distance('wasserstein'):.2f} K | {found.distance('wasserstein_centred'):.2f} K | "
            f"{found.spectral_distance_db:.1f} dB |"
        )


if __name__ == "__main__":
    main()
