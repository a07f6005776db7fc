"""Recorded cases: cubes of scenes. Every function is one case, which writes into a folder and returns what it found."""

from __future__ import annotations

import importlib
import json
from pathlib import Path

import numpy as np
from small_cubes import CHEAP, IR, LAYERS, SCENE, SMALL, Results, cloud_image, cube, hcss, inside

from hcss_twin import Scenario, simulate

# --- shipped scenarios ------------------------------------------------------------------


def shipped_baseline(folder: Path) -> Results:
    return {"cube": cube(folder, "baseline")}


def shipped_cirrus(folder: Path) -> Results:
    return {"cube": cube(folder, "cirrus", **IR)}


def shipped_cirrus_over_cumulus(folder: Path) -> Results:
    return {"cube": cube(folder, "cirrus-over-cumulus", **{"bands": ["lwir-10.8"], "output.certificate": 4})}


def shipped_cumulus(folder: Path) -> Results:
    return {"cube": cube(folder, "cumulus", bands=["mwir"])}


def shipped_degraded_cirrus(folder: Path) -> Results:
    values = {"frames.count": 1, "sensor.variables": ["all"]}
    return {"cube": cube(folder, "degraded-cirrus", **values), "measured": folder / "cube.sensor.nc"}


def shipped_simulated(folder: Path) -> Results:
    return {"cube": cube(folder, "simulated", bands=["lwir"])}


def shipped_stratus(folder: Path) -> Results:
    return {"cube": cube(folder, "stratus", **IR)}


# --- models -----------------------------------------------------------------------------


def as_printed(folder: Path) -> Results:
    return {"cube": cube(folder, "stratus", **CHEAP, bands=["swir-2.7-3.0", "mwir", "lwir"])}


def as_printed_with_rough_sea_and_bulk_optics(folder: Path) -> Results:
    values = {**IR, **CHEAP, "sea.model": "rough-sea", "optics.provider": "bulk", "view.zenith": 50.0}
    return {"cube": cube(folder, "stratus", **values)}


def physical_two_stream(folder: Path) -> Results:
    return {"cube": cube(folder, "stratus", **IR, **{"radiance.model": "physical-two-stream"})}


def accuracy_in_kelvin(folder: Path) -> Results:
    values = {**CHEAP, "bands": ["lwir-10.8"], "accuracy": "0.2 K"}
    return {"cube": cube(folder, "cumulus", **values)}


def climatology(folder: Path) -> Results:
    """Air and sea of place and month, which the scenario does not give."""
    scene = {"time": "2024-01-15T12:00:00Z", "place": {"latitude": -10.0, "longitude": -20.0}}
    clouds = {"clouds": {"type": "cumulus", "generator": "fractal", "coverage": 0.3}}
    return {"cube": cube(folder, scene | clouds, **{**CHEAP, "bands": ["lwir-10.8"]})}


def table_atmosphere(folder: Path) -> Results:
    """A tabulated atmosphere, with its profile, below the physical model of a sea seen at a slant."""
    values = {**IR, "atmosphere": {"provider": "table"}, "view.zenith": 60.0, "clouds.coverage": 0.2}
    return {"cube": cube(folder, "stratus", **values)}


# --- clouds -----------------------------------------------------------------------------


def layers_averaged_pixels(folder: Path) -> Results:
    values = {**CHEAP, "bands": ["lwir-10.8"], "clouds": {"layers": LAYERS}, "image.samples_per_pixel": 2}
    return {"cube": cube(folder, SCENE, **values)}


def surrogate_clouds(folder: Path) -> Results:
    np.save(folder / "image.npy", cloud_image())
    clouds = {"type": "stratus", "coverage": 0.3, "generator": "surrogate"}
    clouds["parameters"] = {"image": "image.npy", "method": "coverage"}
    values = {"image.pixel_size": 200.0, "frames.interval": 60.0, "motion.evolution_time": 600.0}
    with inside(folder):
        return {"cube": cube(folder, SCENE | {"clouds": clouds}, **values, **CHEAP, bands=["lwir-10.8"])}


def imagery_clouds(folder: Path) -> Results:
    """A satellite image (SEVIRI, 10.8 um) as a static scene."""
    sample = importlib.import_module("iris_sample_data")
    image = Path(sample.path) / "toa_brightness_stereographic.nc"
    clouds = {"type": "cumulus", "top": 10_000.0, "generator": "imagery"}
    clouds["parameters"] = {"image": str(image), "missing": "clear"}
    values = {"image.rows": 64, "image.columns": 96, "image.pixel_size": 35_492.0, "frames.count": 1}
    return {"cube": cube(folder, SCENE | {"clouds": clouds}, **{**values, **CHEAP, **IR})}


def imagery_single_clouds(folder: Path) -> Results:
    """An image made into an entry of the cloud database, whose clouds are scattered over a push-broom scene."""
    np.save(folder / "sea.npy", cloud_image())
    with inside(folder):
        cleaning = ("--close", "3", "--fill-holes", "--min-area", "9")
        imported = json.loads(hcss("import", "sea.npy", "--pixel-size", "500", "--json", *cleaning))
        clouds = {"type": "cumulus", "coverage": 0.4, "coverage_mode": "field", "generator": "imagery"}
        clouds["parameters"] = {"entry": "sea", "placement": "single-clouds"}
        values = {"image.pixel_size": 500.0, "motion": {"platform_speed": 2000.0, "wind_speed": 0.0}}
        scene = SCENE | {"clouds": clouds, "frames": {"interval": 1.0}}
        made = cube(folder, scene, **{**values, **CHEAP, "bands": ["lwir-10.8"]})
    return {"entry": folder / "clouds" / "sea.nc", "import": imported, "cube": made}


# --- geometry, light and time -----------------------------------------------------------


def shadows(folder: Path) -> Results:
    clouds = {
        "type": "cumulus",
        "generator": "fractal",
        "base": 1000.0,
        "top": 1900.0,
        "coverage": 0.4,
        "coverage_mode": "field",
    }
    values = {**IR, "slant.shadows": "on", "image.pixel_size": 100.0, "output.certificate": 4}
    return {"cube": cube(folder, SCENE | {"clouds": clouds}, **values)}


def shadows_and_parallax(folder: Path) -> Results:
    values = {**CHEAP, **IR, "clouds": {"layers": LAYERS}, "image.pixel_size": 200.0, "view.zenith": 30.0}
    return {"cube": cube(folder, SCENE, **values, **{"slant.shadows": "on", "slant.parallax": "on"})}


def resolved_waves(folder: Path) -> Results:
    sea = {"sea.model": "rough-sea", "sea.waves": "on"}
    values = {**CHEAP, **IR, "image.pixel_size": 2.0, "view.zenith": 40.0, "accuracy": 3e-3}
    clouds = {"type": "cumulus", "generator": "fractal", "coverage": 0.4}
    return {"cube": cube(folder, SCENE | {"clouds": clouds}, **{**values, **sea})}


WIDE = {
    **CHEAP,
    "bands": ["lwir-10.8"],
    "image.pixel_size": 3000.0,
    "platform.altitude": "800 km",
    "platform.mode": "push-broom",
}


def wide_field(folder: Path) -> Results:
    """Several views; the second cube is a window of the first."""
    values = WIDE | {"output.variables": ["all", "geometry"]}
    window = {"image.window": {"rows": [17, 30], "columns": [3, 36]}, "output.certificate": 0}
    return {
        "cube": cube(folder, "stratus", **values),
        "window": cube(folder, "stratus", "window.nc", **values, **window),
    }


def wide_field_physical(folder: Path) -> Results:
    values = {**WIDE, "radiance.model": "physical", "sea.model": "rough-sea", "optics.provider": "bulk"}
    values |= {"clouds.type": "cirrus", "clouds.generator": "fractal", "output.certificate": 4}
    return {"cube": cube(folder, "cirrus", **values)}


def moving_sun(folder: Path) -> Results:
    """From the afternoon into the night."""
    values = {**CHEAP, **IR, "frames.count": 6, "frames.interval": 1200.0, "image.rows": 24, "image.columns": 24}
    scene = SCENE | {
        "clouds": {"type": "stratus", "generator": "fractal", "coverage": 0.5},
        "time": "2024-04-20T16:45:00+10:00",
    }
    return {"cube": cube(folder, scene, **values)}


def moving_sun_physical(folder: Path) -> Results:
    values = {"bands": ["mwir-3.7"], "frames.count": 4, "frames.interval": 600.0, "image.rows": 24}
    return {"cube": cube(folder, "cirrus", **values)}


def night(folder: Path) -> Results:
    values = {**CHEAP, **IR, "time": "2024-04-20T00:30:00+10:00"}
    return {"cube": cube(folder, "stratus", **values)}


def clear_sky(folder: Path) -> Results:
    return {"cube": cube(folder, SCENE, **CHEAP, **IR)}


def clear_sky_physical(folder: Path) -> Results:
    """Without a file: the dataset in memory."""
    scenario = Scenario.from_dict(SCENE, {**SMALL, "bands": ["swir-2.7-3.0", "lwir"]})
    return {"dataset": simulate(scenario)}
