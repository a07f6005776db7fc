"""Random valid scenarios, each the same whenever it is drawn."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin import Scenario, ScenarioError, make_plan

ACCURACIES = (1e-2, 1e-3, 1e-4)
"""Accuracies at which scenarios are run."""

MODELS = ("as-printed", "physical-two-stream", "physical")
CERTIFICATE = {"as-printed": 300, "physical-two-stream": 100, "physical": 24}
"""Pixels of the cube's own certificate, by radiance model."""

SIDE = 48
CLOUD_TYPES = ("paper-stratus", "paper-cumulus", "paper-simulated", "stratocumulus", "paper-cirrus")
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


def random_raw(number: int, attempt: int, folder: Path, model: str | None = None) -> dict[str, Any]:
    """Draw a scenario, valid or nearly so; spectral responses are written into ``folder``."""
    random = np.random.default_rng([2026, number, attempt])
    drawn = random.choice(MODELS, p=[0.5, 0.35, 0.15])
    model = str(drawn) if model is None else model
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
        # Its reference knows columns alone.
        "sea": _sea(random, str(model)) | {"waves": "off"},
        "slant": {"shadows": "off", "parallax": "off"},
        "optics": {"provider": str(random.choice(["bulk", "mie"], p=[0.7, 0.3]))},
        "radiance": {"model": str(model)},
        "output": {"variables": ["radiance", "cloud_layer_thickness"], "certificate": CERTIFICATE[str(model)]},
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
        "parameters": {"aerosol": aerosol, "visibility_km": float(10.0 ** random.uniform(np.log10(2.0), 1.69))}
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
        layers[1] |= {"base": above, "top": above + height, "thickness_min": height * random.uniform(0.005, 0.5)}
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
        "temperature_texture": 0.0,  # the reference solves columns over one sea
    }
    if rough and random.random() < 0.3:
        sea["parameters"] = {"slopes": "upwind-crosswind"}
    return sea


def scenario(
    number: int, accuracy: float, folder: Path, model: str | None = None, certificate: int | None = None
) -> Scenario:
    """Return scenario ``number``, of any model or one: the first valid one of its draws, whatever the accuracy."""
    for attempt in range(100):
        raw = random_raw(number, attempt, folder, model)
        if certificate is not None:
            raw["output"]["certificate"] = certificate
        try:
            make_plan(Scenario.from_dict({**raw, "accuracy": ACCURACIES[0]}, base=folder))
        except ScenarioError:
            continue
        return Scenario.from_dict({**raw, "accuracy": accuracy}, base=folder)
    raise RuntimeError(f"scenario {number}: no valid draw")
