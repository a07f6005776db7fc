"""Pixels of a scenario as the engine computes them, beside Monte Carlo."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hcss_light.reference import levels_of, reference_radiance
from hcss_light.stage import shares_of
from hcss_light.transport import SourceLight
from hcss_light.voxels import LightError
from hcss_twin import Scenario
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import FrameClouds, PartMaker
from hcss_twin.engine.tables.radiance_tables import TOTAL
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.plan.choose_light import light_inputs
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.providers import Array


def compare(
    scenario: Scenario, pixels: int, photons: int, frame: int, seed: int, tiers: Sequence[str] = ()
) -> dict[str, Any]:
    """Return Monte Carlo radiance of random pixels, that of the cube and that of independent columns, by band.

    Parameters
    ----------
    tiers : sequence of str
        Values of ``radiance.light`` that are computed besides that of the scenario.

    Raises
    ------
    LightError
        If the scene has not one layer of cloud, several points for each pixel, or no radiance.
    """
    plan = make_plan(scenario)
    if len(plan.layers) != 1 or not plan.assembly.has_cloud or not plan.needs_radiance:
        raise LightError("scenario: Monte Carlo needs radiance and one layer of cloud; allowed: clouds.layers with one")
    if not hasattr(plan.assembly.generators[0], "thickness_around_m"):
        raise LightError("clouds.generator: its clouds end with the image; allowed: one that continues them")
    if TOTAL not in {spec.name for spec in plan.variables}:
        raise LightError(f"output.variables: without '{TOTAL}'; allowed: with it")
    if plan.samples_per_pixel != 1:
        raise LightError(f"image.samples_per_pixel: {plan.samples_per_pixel}; allowed: 1")
    if not 0 <= frame < plan.frame_times_s.size:
        raise LightError(f"--frame: {frame}; allowed: 0 to {plan.frame_times_s.size - 1}")
    tables = tables_of(plan)
    inputs = light_inputs(plan, tables.spectrum.nodes)
    transport = SourceLight(inputs)
    time_s = float(plan.frame_times_s[frame])
    sun, clouds = plan.sun_at(time_s), FrameClouds(plan, time_s)
    light = "columns" if plan.light is None else plan.light.name
    names = {"cube": light, **{name: name for name in tiers}}
    makers = {}
    for name, each in names.items():
        own = plan if each == light else make_plan(_with_light(scenario, each))
        makers[name] = PartMaker(own, tables)
    draw = np.random.default_rng([seed, 22])
    cells = draw.choice(
        plan.pixels[0] * plan.pixels[1], size=min(pixels, plan.pixels[0] * plan.pixels[1]), replace=False
    )
    bands = len(plan.bands)
    mean, error = np.empty((2, cells.size, bands))
    values = {name: np.empty((cells.size, bands)) for name in (*names, "columns")}
    places = []
    for number, cell in enumerate(cells.tolist()):
        row, column = (
            int(each) + own.start for each, own in zip(divmod(cell, plan.pixels[1]), plan.extent, strict=True)
        )
        places.append((row, column))
        around = [
            slice(at - before, at + 1 + after)
            for at, (before, after) in zip((row, column), transport.reach, strict=True)
        ]
        (thickness,) = clouds.thickness_m((around[0], around[1]))
        shares = shares_of(plan, time_s, (around[0], around[1]), thickness, levels_of(transport.slices).edges_m)
        inside = np.array([[each[0] for each in transport.reach]])
        found = reference_radiance(
            inputs, transport.slices, thickness, inside, sun, photons, seed + 7919 * number, shares
        )
        mean[number], error[number] = (each[0] for each in found)
        for name, maker in makers.items():
            part, alone = maker.part(frame, (slice(row, row + 1), slice(column, column + 1)))
            values["columns"][number] = alone[0, :, 0, 0]
            values[name][number] = part[TOTAL][:, 0, 0]
    temperature = BrightnessTemperature(plan.spectral_grid, [band.name for band in plan.bands])
    result = []
    for index, band in enumerate(plan.bands):
        noise2 = float(np.mean(error[:, index] ** 2))
        errors = {name: _errors(own, mean, index, noise2, temperature) for name, own in values.items()}
        result.append(
            {
                "name": band.name,
                "monte_carlo": mean[:, index].tolist(),
                "standard_error": error[:, index].tolist(),
                **{name: own[:, index].tolist() for name, own in values.items()},
                "noise": float(np.sqrt(noise2 / cells.size) / np.mean(mean[:, index])),
                "errors": errors,
            }
        )
    return {"pixels": places, "frame": frame, "photons": photons, "light": light, "bands": result}


def write_to_cube(path: Path, scenario: Scenario, result: dict[str, Any]) -> None:
    """Write a comparison next to the certificate of a cube, as its attribute ``hcss_monte_carlo``.

    Bias, rms, and the noise of the mean apart from them, each relative to the mean radiance of the pixels.

    Raises
    ------
    LightError
        If the cube is not one of the scenario.
    """
    from netCDF4 import Dataset

    bands = {
        band["name"]: {**{each: band["errors"]["cube"][each] for each in ("bias", "rms")}, "noise": band["noise"]}
        for band in result["bands"]
    }
    checked = {each: result[each] for each in ("light", "frame", "photons")} | {"pixels": len(result["pixels"])}
    with Dataset(path, "a") as cube:
        own = getattr(cube, "hcss_scenario", None)
        if own is None or json.loads(own) != json.loads(scenario.to_json()):
            raise LightError(f"--cube: {path} has another scenario; allowed: a cube of the scenario that is compared")
        cube.hcss_monte_carlo = json.dumps(checked | {"bands": bands})


def _with_light(scenario: Scenario, light: str) -> Scenario:
    values = json.loads(scenario.to_json())
    values["radiance"]["light"] = light
    return Scenario.from_dict(values, base=scenario.base)


def _errors(
    values: Array, mean: Array, band: int, noise2: float, temperature: BrightnessTemperature
) -> dict[str, float | None]:
    """Return bias and rms relative to the mean radiance, and in kelvin at it."""
    away, level = values[:, band] - mean[:, band], float(np.mean(mean[:, band]))
    bias, rms = float(np.mean(away)), math.sqrt(max(float(np.mean(away**2)) - noise2, 0.0))
    near = np.mean(mean, axis=0) * np.array([[0.99], [1.01]])
    kelvin = np.asarray(temperature.where_known(near.T.astype(np.float32)))[band]
    slope = (float(kelvin[1]) - float(kelvin[0])) / (0.02 * level)
    in_kelvin = (bias * slope, rms * slope) if np.isfinite(slope) else (None, None)
    return {"bias": bias / level, "rms": rms / level, "bias_K": in_kelvin[0], "rms_K": in_kelvin[1]}
