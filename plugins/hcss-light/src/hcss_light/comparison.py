"""Pixels of a scenario as the engine computes them, beside Monte Carlo."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hcss_light.reference import levels_of, radiance_of_layers
from hcss_light.slices import Field, Slices
from hcss_light.stage import shares_of
from hcss_light.voxels import LightError
from hcss_twin import Scenario, make_plan
from hcss_twin.engine.clouds import FrameClouds
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stages.light import LightStage
from hcss_twin.engine.stream import PartMaker
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, NetcdfFile, Sun
from hcss_twin.providers.light import LightInputs

CHECKED_PIXELS, CHECKED_PHOTONS = 8, 1000
"""Pixels of a certificate, and photons of each and each band."""


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
        If the scene has no cloud, several points for each pixel, or no radiance.
    """
    scenario = _with(scenario, "sea", "temperature_texture", scenario.sea.temperature_texture or 0.0)
    vapour = scenario.atmosphere.water_vapour_texture or 0.0
    scenario = _with(scenario, "atmosphere", "water_vapour_texture", vapour)
    plan = make_plan(scenario)
    if reason := _not_comparable(plan):
        raise LightError(reason)
    if not 0 <= frame < plan.frame_times_s.size:
        raise LightError(f"--frame: {frame}; allowed: 0 to {plan.frame_times_s.size - 1}")
    tables = tables_of(plan)
    light = plan.light.name
    makers = {"cube": PartMaker(plan, tables)}
    for name in tiers:
        makers[name] = PartMaker(
            plan if name == light else make_plan(_with(scenario, "radiance", "light", name)), tables
        )
    count = plan.pixels[0] * plan.pixels[1]
    cells = np.random.default_rng([seed, 22]).choice(count, size=min(pixels, count), replace=False)
    places = [
        (row + plan.extent[0].start, column + plan.extent[1].start)
        for row, column in (divmod(cell, plan.pixels[1]) for cell in cells.tolist())
    ]
    return _compared(plan, tables, makers, places, photons, frame, seed) | {"light": light}


def check(plan: Plan, tables: RadianceTables, frame: int) -> dict[str, Any]:
    """Return bias, rms and noise by band of random pixels of one square of a plan's light, for its certificate.

    Empty if Monte Carlo cannot compute the scene.
    """
    if _not_comparable(plan):
        return {}
    draw, squares = np.random.default_rng([plan.scenario.seed, 23]), []
    for side in plan.extent:
        longest = LightStage.largest_square
        first = side.start + longest * int(draw.integers(-(-(side.stop - side.start) // longest)))
        squares.append((first, min(first + longest, side.stop)))
    pixels = min(CHECKED_PIXELS, plan.scenario.output.certificate)
    places = [(int(draw.integers(*squares[0])), int(draw.integers(*squares[1]))) for _ in range(pixels)]
    makers = {"cube": PartMaker(plan, tables)}
    found = _compared(plan, tables, makers, places, CHECKED_PHOTONS, frame, plan.scenario.seed % 2**31)
    errors = ", ".join(
        f"{band['name']} bias {100.0 * band['errors']['cube']['bias']:+.2f} +- {100.0 * band['noise']:.2f} %, "
        f"rms {100.0 * band['errors']['cube']['rms']:.2g} %"
        for band in found["bands"]
    )
    text = f"clouds with sides against Monte Carlo of {pixels} random pixels: {errors}"
    if (model := plan.scenario.radiance.model) != "physical":
        text += f" (with what columns of radiance.model = '{model}' differ by from light that is scattered many times)"
    return summary(found) | {"light": plan.light.name, "text": text}


def summary(result: dict[str, Any]) -> dict[str, Any]:
    """Return numbers of pixels and photons, and bias, rms and noise of the mean by band, relative to the mean."""
    bands = {
        band["name"]: {
            **{statistic: band["errors"]["cube"][statistic] for statistic in ("bias", "rms")},
            "noise": band["noise"],
        }
        for band in result["bands"]
    }
    return {key: result[key] for key in ("frame", "photons")} | {"pixels": len(result["pixels"]), "bands": bands}


def _not_comparable(plan: Plan) -> str:
    """Return why Monte Carlo cannot compute a plan; empty if it can."""
    if not plan.assembly.has_cloud or not plan.needs_radiance:
        return "scenario: Monte Carlo needs radiance and cloud; allowed: 'radiance' in output.variables, and clouds"
    if not all(hasattr(plan.assembly.generators[layer], "thickness_around_m") for layer in plan.cloudy_layers):
        return "clouds.generator: its clouds end with the image; allowed: one that continues them"
    if "radiance" not in {spec.name for spec in plan.variables}:
        return "output.variables: 'radiance' is not among them; allowed: a list with 'radiance'"
    only = "Monte Carlo has the mean sea below clouds and nothing else; allowed:"
    if plan.assembly.elements:
        return f"elements: {only} a scene without [[elements]]"
    if plan.surfaces:
        return f"surfaces: {only} a scene without [surfaces]"
    if plan.point_effects:
        return f"{plan.point_effects[0].effect.name}: {only} to leave it out"
    if plan.waves.varies:
        return f"sea.waves: {only} 'off'"
    if plan.samples_per_pixel != 1:
        return f"image.samples_per_pixel: {plan.samples_per_pixel}; allowed: 1"
    return ""


def _compared(
    plan: Plan, tables: RadianceTables, makers: dict[str, PartMaker], places: list[tuple[int, int]], photons: int,
    frame: int, seed: int,
) -> dict[str, Any]:  # fmt: skip
    """Return the result of :func:`compare` for pixels at some rows and columns."""
    inputs, time_s = LightStage.inputs(plan, tables.spectrum.nodes), float(plan.frame_times_s[frame])
    sampled = SampledClouds(plan, inputs)
    sun, clouds = plan.sun_at(time_s), FrameClouds(plan, time_s)
    mean, error = np.empty((2, len(places), len(plan.bands)))
    values = {name: np.empty((len(places), len(plan.bands))) for name in (*makers, "columns")}
    for number, (row, column) in enumerate(places):
        if plan.views.varies:
            toward = plan.toward(plan.rays.views_of_pixels([row], [column], time_s)[0])
            inputs, sun = LightStage.inputs(toward, tables.spectrum.nodes), toward.sun_at(time_s)
            sampled = SampledClouds(plan, inputs)
        found = sampled.radiance((row, column), time_s, clouds, sun, photons, seed + 7919 * number)
        mean[number], error[number] = (of_point[0] for of_point in found)
        for name, maker in makers.items():
            part, alone = maker.part(frame, (slice(row, row + 1), slice(column, column + 1)))
            values["columns"][number] = alone[0, :, 0, 0]
            values[name][number] = part["radiance"][:, 0, 0]
    temperature = BrightnessTemperature(plan.spectral_grid, [band.name for band in plan.bands])
    result = []
    for index, band in enumerate(plan.bands):
        noise2 = float(np.mean(error[:, index] ** 2))
        errors = {name: _errors(radiance, mean, index, noise2, temperature) for name, radiance in values.items()}
        result.append(
            {
                "name": band.name,
                "monte_carlo": mean[:, index].tolist(),
                "standard_error": error[:, index].tolist(),
                **{name: radiance[:, index].tolist() for name, radiance in values.items()},
                "noise": float(np.sqrt(noise2 / len(places)) / np.mean(mean[:, index])),
                "errors": errors,
            }
        )
    return {"pixels": places, "frame": frame, "photons": photons, "bands": result}


def write_to_cube(path: Path, scenario: Scenario, result: dict[str, Any]) -> None:
    """Write a comparison next to the certificate of a cube, as its attribute ``hcss_monte_carlo``.

    Bias, rms, and the noise of the mean apart from them, each relative to the mean radiance of the pixels.

    Raises
    ------
    LightError
        If the cube is not one of the scenario.
    """
    checked = summary(result) | {"light": result["light"]}
    with NetcdfFile(path, "a") as cube:
        cube_scenario = getattr(cube, "hcss_scenario", None)
        if cube_scenario is None or json.loads(cube_scenario) != json.loads(scenario.to_json()):
            raise LightError(f"--cube: {path} has another scenario; allowed: a cube of the scenario that is compared")
        cube.hcss_monte_carlo = json.dumps(checked)


def _with(scenario: Scenario, section: str, key: str, value: str | float) -> Scenario:
    values = json.loads(scenario.to_json())
    values[section][key] = value
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


class SampledClouds:
    """Clouds of a plan on levels at least as thin as the slices of the tier ``source``."""

    def __init__(self, plan: Plan, inputs: LightInputs) -> None:
        self._plan, self._inputs = plan, inputs
        self._slices, self._reach = slices_and_reach(inputs)

    def radiance(
        self, pixel: tuple[int, int], time_s: float, clouds: FrameClouds, sun: Sun | None, photons: int, seed: int
    ) -> tuple[Array, Array]:
        """Return the radiance (1, B) of a pixel by Monte Carlo, and its standard error."""
        below = pixel if self._plan.is_grid else self._nearest(pixel, time_s)
        rows, columns = (
            slice(at - before, at + 1 + after) for at, (before, after) in zip(below, self._reach, strict=True)
        )
        thickness = (clouds.thickness_m if self._plan.is_grid else clouds.of_scene_m)((rows, columns))
        layers = []
        for layer_inputs, slices in zip(self._inputs.stack, self._slices, strict=True):
            number, window = layer_inputs.number, (rows, columns)
            shares: Field | None
            if layer_inputs.tops_vary:
                cloud, shares = clouds.standing(number, window, slices.edges_m)
            else:
                cloud = thickness[number]
                shares = shares_of(self._plan, number, time_s, window, cloud, slices.edges_m)
            layers.append((slices, slices.density(cloud, layer_inputs.shape, shares)))
        inside = np.array([[margin[0] for margin in self._reach]])
        return radiance_of_layers(self._inputs, layers, inside, sun, photons, seed)

    def _nearest(self, pixel: tuple[int, int], time_s: float) -> tuple[int, int]:
        """Return the point of the scene nearest to where the ray of a pixel meets the columns of the lowest layer."""
        row, column = pixel
        window = slice(row, row + 1), slice(column, column + 1)
        place = self._plan.scene.in_points(*self._plan.rays.points_m(window, time_s, self._inputs.reference_m))
        y, x = (int(np.rint(points[0, 0])) for points in place)
        return y, x


def slices_and_reach(inputs: LightInputs) -> tuple[list[Slices], Any]:
    """Return the levels of each layer, and rows and columns of points around others whose clouds matter to them."""
    if inputs.above is None:
        from hcss_light.transport import SourceLight

        light = SourceLight(inputs)
        return [levels_of(light.slices)], light.sea_reach
    from hcss_light.stacked_light import StackedSource  # not for one layer

    stacked = StackedSource(inputs)
    return [levels_of(layer) for layer in stacked.stack.layers], stacked.reach
