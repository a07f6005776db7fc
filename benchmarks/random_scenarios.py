"""Random valid scenarios: is the error of each cube within the accuracy asked for, and what does accuracy cost?

    python benchmarks/random_scenarios.py                       # 300 scenarios at three accuracies: hours
    python benchmarks/random_scenarios.py --scenarios 20        # the first 20
    python benchmarks/random_scenarios.py --summary             # only what the file of results says

Scenario number i is always the same. Its cubes are made with random pixels of 48 x 48 and a few frames; random pixels
of them are computed again here: the radiance model is asked for their very columns at every wavenumber of the scene's
grid, and the spectra are summed over the bands, with code that shares nothing with the certificate's. Clouds do not
depend on the accuracy (which is checked), so that these columns are computed once for all accuracies.

Rows go to ``benchmarks/results/random-scenarios.json`` as they are found; those that are there are not computed again.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import json
import os
import shutil
import statistics
import tempfile
import time
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin import Scenario, ScenarioError, make_plan, simulate
from hcss_twin.errors import CertificateWarning
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.tables.kept_tables import tables_of

RESULTS = Path(__file__).parent / "results" / "random-scenarios.json"
SCENARIOS = 300
ACCURACIES = (1e-2, 1e-3, 1e-4)
SIDE = 48
PIXELS = {"as-printed": 300, "physical-two-stream": 300, "physical": 60}
"""Pixels computed again, by radiance model: fewer where a column takes long."""

CERTIFICATE = {"as-printed": 300, "physical-two-stream": 100, "physical": 24}
"""Pixels of the cube's own certificate."""

CLOUD_TYPES = ("stratus", "cumulus", "simulated", "stratocumulus", "cirrus")
PROFILES = (
    "tropical",
    "midlatitude-summer",
    "midlatitude-winter",
    "subarctic-summer",
    "subarctic-winter",
    "us-standard-1976",
)
CATALOG_BANDS = (
    "swir-2.7-3.0",
    "mwir",
    "lwir",
    "mwir-3.4-4.1",
    "mwir-3.7",
    "mwir-4.2-4.4",
    "mwir-4.5-4.8",
    "lwir-8.5",
    "lwir-9.7",
    "lwir-10.8",
    "lwir-12.0",
    "window-10.5-12.5",
)


@dataclass(frozen=True)
class Row:
    """What was found for one scenario at one accuracy.

    ``achieved`` is the largest relative error of the checked pixels in any band, ``certificate`` what the cube's
    certificate says of its own; ``exceeding`` pixels err by more than the accuracy and one step of single precision.
    """

    scenario: int
    accuracy: float
    model: str
    layers: int
    bands: int
    day: str
    pixels: int
    achieved: float
    exceeding: int
    worst_band: str
    certificate: float
    certificate_passed: bool
    estimated: float
    wavenumbers: int
    dense: int
    compile_cpu_s: float

    @property
    def agrees(self) -> bool:
        """Whether the certificate has the same verdict, and an error of the same order.

        Both are maxima over random pixels of their own, within a factor of 5; errors about as small as rounding to
        single precision are alike.
        """
        low, high = sorted(max(each, 2e-7) for each in (self.achieved, self.certificate))
        return high <= 5.0 * low and self.certificate_passed == (self.exceeding == 0)


def random_raw(number: int, attempt: int, folder: Path) -> dict[str, Any]:
    """Draw a scenario, valid or nearly so; spectral responses are written into ``folder``."""
    random = np.random.default_rng([2026, number, attempt])
    model = random.choice(["as-printed", "physical-two-stream", "physical"], p=[0.5, 0.35, 0.15])
    zone = timezone(timedelta(hours=int(random.integers(-12, 13))))
    moment = datetime(2015, 1, 1, tzinfo=zone) + timedelta(minutes=int(random.integers(0, 20 * 525_600)))
    span_s = float(10.0 ** random.uniform(0.5, 4.3))  # to 5.5 hours
    count = int(random.integers(2, 6))
    view = float(random.uniform(0, 75) if random.random() < 0.9 else random.uniform(75, 85))
    raw: dict[str, Any] = {
        "seed": int(random.integers(0, 2**31)),
        "time": moment,
        "place": {"latitude": float(random.uniform(-70, 70)), "longitude": float(random.uniform(-180, 180))},
        "view": {"zenith": view, "azimuth": float(random.uniform(0, 360))},
        "image": {"rows": SIDE, "columns": SIDE, "pixel_size": float(10 ** random.uniform(1.0, 3.0))},
        "frames": {"count": count, "interval": span_s / count, "first": int(random.integers(0, 5))},
        "motion": {
            "platform_speed": float(random.choice([0.0, 1000.0, 7000.0])),
            "wind_speed": float(random.uniform(0, 40)),
            "wind_from": float(random.uniform(0, 360)),
        },
        "bands": list(_bands(random, number, folder)),
        "atmosphere": _atmosphere(random),
        "clouds": _clouds(random),
        "sea": _sea(random, str(model)),
        "optics": {"provider": str(random.choice(["bulk", "mie"], p=[0.7, 0.3]))},
        "radiance": {"model": str(model)},
        "output": {
            "variables": ["radiance", "cloud_layer_thickness"],
            "certificate": CERTIFICATE[str(model)],
        },
    }
    if not raw["clouds"]:
        raw["output"]["variables"] = ["radiance", "cloud_mask"]
    return raw


def _bands(random: np.random.Generator, number: int, folder: Path) -> Iterator[Any]:
    for index in range(int(random.integers(1, 4))):
        kind = random.random()
        if kind < 0.5:
            # Not twice the same: every third name.
            yield str(random.choice(CATALOG_BANDS[index::3]))
            continue
        low = float(random.uniform(0.71, 13.2))
        width = float(low * 10.0 ** random.uniform(-3.5, -0.5))
        high = min(low + max(width, 1e-3), 14.29)
        if kind < 0.8:
            yield [low, high]
            continue
        name = f"response-{number}-{index}"
        wavelength = np.sort(random.uniform(low, high, int(random.integers(2, 30))))
        with (folder / f"{name}.csv").open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["wavelength_um", "response"])
            writer.writerow([low, 0.0])
            writer.writerows(zip(wavelength.tolist(), random.random(wavelength.size).tolist(), strict=True))
            writer.writerow([high, 0.0])
        yield {"name": name, "response": f"{name}.csv"}


def _atmosphere(random: np.random.Generator) -> dict[str, Any]:
    if random.random() < 0.15:
        return {"provider": "table"}
    chosen: dict[str, Any] = {"profile": str(random.choice(PROFILES))} if random.random() < 0.7 else {}
    if random.random() < 0.3:
        chosen["water_vapour_scale"] = float(random.uniform(0.0, 1.5))
    aerosol = str(random.choice(["none", "maritime", "rural", "urban"]))
    return chosen | {
        "parameters": {
            "aerosol": aerosol,
            "visibility_km": float(10.0 ** random.uniform(np.log10(2.0), 1.69)),
        }
    }


def _clouds(random: np.random.Generator) -> dict[str, Any]:
    count = int(random.choice([0, 1, 2], p=[0.04, 0.66, 0.30]))
    if count == 0:
        return {}
    layers = [_layer(random) for _ in range(count)]
    if count == 2:
        base, depth = random.uniform(50, 2000), 10.0 ** random.uniform(1.5, 3.3)
        above, height = base + depth + random.uniform(0, 4000), 10.0 ** random.uniform(1.5, 3.6)
        layers[0] |= {"base": base, "top": base + depth, "thickness_min": depth * random.uniform(0.005, 0.5)}
        layers[1] |= {
            "base": above,
            "top": above + height,
            "thickness_min": height * random.uniform(0.005, 0.5),
        }
    return {"layers": layers}


def _layer(random: np.random.Generator) -> dict[str, Any]:
    layer: dict[str, Any] = {
        "type": str(random.choice(CLOUD_TYPES)),
        "coverage": float(random.choice([random.uniform(0.02, 0.98), 0.0, 1.0], p=[0.94, 0.03, 0.03])),
        "coverage_mode": str(random.choice(["frame", "field"], p=[0.7, 0.3])),
        "edge_taper": float(random.choice([0.0, random.uniform(0, 1)])),
        "anchor": str(random.choice(["base", "top"])),
    }
    if random.random() < 0.25:
        layer["temperature"] = float(random.uniform(200, 300))
    if random.random() < 0.1:
        layer["water_content"] = float(10.0 ** random.uniform(-3, 0.3))
    return layer


def _sea(random: np.random.Generator, model: str) -> dict[str, Any]:
    rough = model != "as-printed" or random.random() < 0.4
    sea: dict[str, Any] = {"model": "rough-sea" if rough else "cox-munk"}
    sea |= {
        "temperature": float(random.uniform(271, 305)),
        "wind_speed": float(random.choice([random.uniform(0, 15), random.uniform(0, 60)])),
        "wind_from": float(random.uniform(0, 360)),
    }
    if rough and random.random() < 0.3:
        sea["parameters"] = {"slopes": "upwind-crosswind"}
    return sea


def scenario(number: int, accuracy: float, folder: Path) -> Scenario:
    """Return scenario ``number``: the first valid one of its draws, whatever the accuracy."""
    for attempt in range(100):
        raw = random_raw(number, attempt, folder)
        try:
            make_plan(Scenario.from_dict({**raw, "accuracy": ACCURACIES[0]}, base=folder))
        except ScenarioError:
            continue
        return Scenario.from_dict({**raw, "accuracy": accuracy}, base=folder)
    raise RuntimeError(f"scenario {number}: no valid draw")


@dataclass(frozen=True)
class Pixels:
    """Random pixels of the frames, and their band radiance without tables.

    ``place`` holds frame, row and column of each, (N, 3); ``radiance`` is (N, B).
    """

    place: np.ndarray
    thickness_m: np.ndarray
    radiance: np.ndarray


def columns_of(cube: Any, layers: int) -> np.ndarray:
    """Thickness of each layer at each pixel, (frames, rows, columns, L)."""
    if layers == 0:
        return np.zeros((*cube.cloud_mask.shape, 0))
    return np.moveaxis(cube.cloud_layer_thickness.transpose("layer", "time", "y", "x").values, 0, -1)


def recompute(plan: Plan, thickness: np.ndarray, wanted: int, seed: int) -> Pixels:
    """Draw pixels and compute each from its own column, at all wavenumbers, with a trapezoidal rule of our own."""
    random = np.random.default_rng([77, seed])
    total = int(np.prod(thickness.shape[:3]))
    flat = random.choice(total, min(wanted, total), replace=False)
    place = np.stack(np.unravel_index(flat, thickness.shape[:3]), axis=1)
    place = place[np.argsort(place[:, 0], kind="stable")]
    metres = thickness[tuple(place.T)].astype(np.float64)
    for own, layer in zip(metres.T, plan.layers, strict=True):
        # The cube is in single precision, which may lie beyond a limit that is not.
        cloudy = own > 0
        own[cloudy] = np.minimum(np.maximum(own[cloudy], layer.thickness_min_m), layer.thickness_max_m)
    radiance = np.empty((len(place), len(plan.bands)))
    for frame in np.unique(place[:, 0]):
        here = np.flatnonzero(place[:, 0] == frame)
        # The real sun, also where its light is too faint for the accuracy to be computed with.
        sun = plan.sun_up_at(float(plan.frame_times_s[frame]))
        clear = here[~np.any(metres[here] > 0, axis=1)]
        cloudy = np.setdiff1d(here, clear)
        if clear.size:
            radiance[clear] = _over_bands(plan, plan.model.clear(plan.spectral_grid.wavenumber_cm1, sun))
        for start in range(0, cloudy.size, 16):
            part = cloudy[start : start + 16]
            terms = plan.model.cloudy(plan.spectral_grid.wavenumber_cm1, metres[part], sun)
            radiance[part] = _over_bands(plan, terms)
    return Pixels(place, metres, radiance)


def _over_bands(plan: Plan, terms: Any) -> np.ndarray:
    """Sum of the terms (..., V) times the response, by trapezoids between the grid's wavenumbers within each band."""
    wavenumber = plan.spectral_grid.wavenumber_cm1
    spectrum = sum(np.asarray(term, dtype=np.float64) for term in terms.values())
    sums = []
    for band, own in zip(plan.bands, plan.spectral_grid.nodes, strict=True):
        # Nodes of other bands lie between; from one of its own to the next the integrand is straight, as documented.
        x = wavenumber[own]
        if not np.allclose(1e4 / x[[-1, 0]], band.wavelength_um[[0, -1]], rtol=1e-12, atol=0.0):
            raise RuntimeError(f"{band.name}: the grid does not reach the edges of the band")
        y = spectrum[..., own] * np.interp(1e4 / x, band.wavelength_um, band.response)
        sums.append(np.sum(0.5 * (y[..., 1:] + y[..., :-1]) * np.diff(x), axis=-1))
    return np.stack(sums, axis=-1)


def check(number: int, accuracies: Sequence[float], folder: Path) -> list[Row]:
    """Run a scenario at each accuracy, and compare its pixels with the independent ones."""
    rows, pixels = [], None
    for accuracy in accuracies:
        made = scenario(number, accuracy, folder)
        _forget_tables()
        plan = make_plan(made)
        if pixels is None:
            _warm(plan)
        start = time.process_time()
        tables = tables_of(plan)
        seconds = time.process_time() - start
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", CertificateWarning)  # its verdict is what is compared
            cube = simulate(made)
        thickness = columns_of(cube, len(plan.layers))
        if pixels is None:
            pixels = recompute(make_plan(made), thickness, PIXELS[made.radiance.model], number)
        else:
            here = thickness[tuple(pixels.place.T)]
            same = np.where(
                pixels.thickness_m > 0, np.isclose(here, pixels.thickness_m, rtol=1e-6), here == 0
            )
            if not np.all(same):
                raise RuntimeError(f"scenario {number}: clouds depend on the accuracy")
        frame, row, column = pixels.place.T
        found = (
            cube.radiance.transpose("time", "y", "x", "band").values[frame, row, column].astype(np.float64)
        )
        rows.append(_row(number, made, plan, tables, cube, found, pixels, seconds))
    return rows


def _row(
    number: int,
    made: Scenario,
    plan: Plan,
    tables: Any,
    cube: Any,
    found: Any,
    pixels: Pixels,
    seconds: float,
) -> Row:
    exact = pixels.radiance
    if not (np.all(np.isfinite(found)) and np.all(np.isfinite(exact)) and np.all(exact > 0.0)):
        raise RuntimeError(f"scenario {number}: radiance that is not finite or not positive")
    away = np.abs(found - exact)
    step = np.spacing(exact.astype(np.float32)).astype(np.float64)
    error = away / exact
    attributes = cube.attrs
    achieved = json.loads(attributes["hcss_accuracy_achieved"])
    day = np.unique(plan.sun_zenith_deg < 90.0)
    return Row(
        scenario=number,
        accuracy=made.accuracy,
        model=made.radiance.model,
        layers=len(plan.layers),
        bands=len(plan.bands),
        day="both" if day.size == 2 else "day" if day[0] else "night",
        pixels=len(exact),
        achieved=float(f"{np.max(error):.3g}"),
        exceeding=int(np.sum(np.any(away > made.accuracy * exact + step, axis=1))),
        worst_band=plan.bands[int(np.argmax(np.max(error, axis=0)))].name,
        certificate=max(achieved.values()),
        certificate_passed=str(attributes["hcss_certificate"]).startswith("PASSED"),
        estimated=float(f"{tables.estimated_error:.3g}"),
        wavenumbers=int(tables.spectrum.nodes.wavenumber_cm1.size),
        dense=int(plan.spectral_grid.wavenumber_cm1.size),
        compile_cpu_s=float(f"{seconds:.3g}"),
    )


def _warm(plan: Plan) -> None:
    """Have read and computed what is kept, so that the first accuracy does not pay for the others."""
    wavenumber = plan.spectral_grid.wavenumber_cm1
    sun = plan.sun_at(float(plan.frame_times_s[0]))
    other = make_plan(plan.scenario)
    other.model.clear(wavenumber, sun)
    if plan.assembly.has_cloud:
        other.model.cloudy(wavenumber, plan.extreme_thicknesses_m[:1], sun)


def _forget_tables() -> None:
    shutil.rmtree(Path(os.environ["HCSS_CACHE_DIR"]) / "tables", ignore_errors=True)


def read_rows(path: Path) -> list[Row]:
    """Rows found so far."""
    return [Row(**each) for each in json.loads(path.read_text())["rows"]] if path.exists() else []


def write_rows(path: Path, rows: Sequence[Row], failed: dict[str, str]) -> None:
    """Write one row a line; the file is there whole or as it was."""
    ordered = sorted(rows, key=lambda row: (row.scenario, -row.accuracy))
    lines = ",\n  ".join(json.dumps(asdict(row)) for row in ordered)
    text = f'{{\n "failed": {json.dumps(failed)},\n "rows": [\n  {lines}\n ]\n}}\n'
    path.parent.mkdir(exist_ok=True)
    draft = path.with_suffix(".json.partial")
    draft.write_text(text)
    draft.replace(path)


def read_failed(path: Path) -> dict[str, str]:
    """Scenarios that ended in an error, with what it said."""
    return dict(json.loads(path.read_text())["failed"]) if path.exists() else {}


def summary(rows: Sequence[Row], failed: dict[str, str]) -> Iterator[str]:
    """Lines of what the rows say together."""
    numbers = {row.scenario for row in rows}
    kept = sum(row.exceeding == 0 for row in rows)
    yield f"{len(numbers)} scenarios, {len(rows)} runs: {kept} within the accuracy asked for, {len(failed)} errors"
    yield f"certificate agrees in {sum(row.agrees for row in rows)}"
    for accuracy in sorted({row.accuracy for row in rows}, reverse=True):
        own = [row for row in rows if row.accuracy == accuracy]
        ratio = [row.achieved / accuracy for row in own]
        yield (
            f"accuracy {accuracy:g}: achieved / asked median {statistics.median(ratio):.2f}, largest {max(ratio):.2f}; "
            f"compile, CPU s, median {statistics.median(row.compile_cpu_s for row in own):.2f}"
        )
    cost = {(row.scenario, row.accuracy): row.compile_cpu_s for row in rows}
    for model in [*PIXELS, None]:
        chosen = {row.scenario for row in rows if model in (row.model, None)}
        growth = [
            [cost[n, fine] / cost[n, coarse] for n in chosen if (n, fine) in cost and (n, coarse) in cost]
            for coarse, fine in itertools.pairwise(ACCURACIES)
        ]
        if all(growth):
            told = ", ".join(f"{statistics.median(each):.2f}" for each in growth)
            yield f"median growth of the cost per decade, {model or 'all models'}: {told}"
    for row in rows:
        if row.exceeding or not row.agrees:
            yield (
                f"  scenario {row.scenario} at {row.accuracy:g} ({row.model}, {row.layers} layers, {row.day}): "
                f"achieved {row.achieved:g} in {row.worst_band}, {row.exceeding} of {row.pixels} exceed; certificate "
                f"{row.certificate:g}, {'passed' if row.certificate_passed else 'failed'}"
            )
    for number, message in failed.items():
        yield f"  scenario {number}: {message}"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scenarios", type=int, default=SCENARIOS, help="how many, from number 0")
    parser.add_argument("--only", type=int, nargs="*", help="these numbers instead, computed and not kept")
    parser.add_argument("--results", type=Path, default=RESULTS)
    parser.add_argument("--summary", action="store_true", help="compute nothing")
    given = parser.parse_args()
    rows, failed = read_rows(given.results), read_failed(given.results)
    with tempfile.TemporaryDirectory() as folder:
        os.environ["HCSS_CACHE_DIR"] = str(Path(folder) / "cache")
        if given.only is not None:
            rows, failed = [row for n in given.only for row in check(n, ACCURACIES, Path(folder))], {}
        elif not given.summary:
            done = {row.scenario for row in rows} | {int(number) for number in failed}
            for number in sorted(set(range(given.scenarios)) - done):
                try:
                    rows += check(number, ACCURACIES, Path(folder))
                except Exception as error:  # one more finding; the others are still wanted
                    failed[str(number)] = f"{type(error).__name__}: {error}"
                print(number, failed.get(str(number), ""), flush=True)
                write_rows(given.results, rows, failed)
    print("\n".join(summary(rows, failed)))


if __name__ == "__main__":
    main()
