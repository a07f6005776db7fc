"""The scenario of a followed sky: place, view and bands of the images, sea and vapour of their clear sky."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hcss_follow.analysis import Image
from hcss_follow.clear_sky import ClearSky, clear_pixels, fit_clear_sky
from hcss_follow.images import zenith_and_azimuth_deg
from hcss_follow.state import State
from hcss_twin.providers import CatalogError

LAYER = {
    "type": "deep-convection", "base": 500.0, "top": 1500.0, "water_content": 0.6, "thickness_min": 0.01,
    "generator": "followed",
}  # fmt: skip
"""Ice so dense that 1000 m are opaque: the depth of clouds, which hang from tops at any altitude."""

_WARMEST = 99.9
"""Percentile of the image that is the scene's clear sky: colder clear sky is very thin cloud."""


@dataclass(frozen=True)
class Made:
    """A scenario, and what was found on the way.

    Attributes
    ----------
    scenario : dict
    clear_sky : ClearSky or None
        None without clear pixels.
    lines, notes : tuple of str
        What was done, and what to be aware of.
    """

    scenario: dict[str, Any]
    clear_sky: ClearSky | None
    lines: tuple[str, ...]
    notes: tuple[str, ...]


def scenario_of(
    state: State, image: Image, *, state_name: str, lead_s: float = 0.0, satellite_longitude: float | None = None,
    margin: int = 0, responses: Sequence[Path] = (), member: int | None = None,
) -> Made:  # fmt: skip
    """Return the scenario of a state.

    Parameters
    ----------
    image : Image
        The latest one.
    state_name : str
        State file, beside the scenario.
    lead_s : float
        Start of the scenario after the latest image.
    satellite_longitude : float, optional
        Default: the satellite is overhead.
    margin : int
        Pixels of the image around the scene.
    responses : sequence of Path
        Of the images' bands and of others.
    """
    rows, columns = (side - 2 * margin for side in state.shape)
    if min(rows, columns) < 1:
        raise CatalogError(f"--margin: {margin}; allowed: less than half of {min(state.shape)} pixels")
    notes = []
    zenith, azimuth = 0.0, 0.0
    if satellite_longitude is None:
        notes.append("The satellite is taken to be overhead; --satellite LON says where it is.")
    else:
        zenith, azimuth = zenith_and_azimuth_deg(state.latitude, state.longitude, satellite_longitude)
    parameters: dict[str, Any] = {"state": state_name, "lead": lead_s}
    bands: list[Any] = ["lwir-10.8", "lwir-12.0"]
    if responses:
        bands = [{"name": path.stem.lower(), "response": str(path)} for path in responses]
        parameters["limits_um"] = list(half_power_um(responses[0]))
    if member is not None:
        parameters["member"] = member
    scenario: dict[str, Any] = {
        "title": f"The sky of {state.time.isoformat()}, followed",
        "time": state.time.isoformat(),
        "bands": bands,
        "accuracy": 0.002,
        "place": {"latitude": round(state.latitude, 4), "longitude": round(state.longitude, 4)},
        "view": {"zenith": round(zenith, 2), "azimuth": round(azimuth, 2)},
        "image": {"rows": rows, "columns": columns, "pixel_size": state.pixel_size_m},
        "frames": {"count": 3, "interval": 900.0},
        "motion": {"platform_speed": 0.0, "wind_speed": 0.0},
        "slant": {"parallax": "off", "shadows": "off"},  # images have clouds where they are seen
        "clouds": {**LAYER, "parameters": parameters},
        "output": {"variables": ["brightness_temperature", "cloud_thickness"]},
    }
    clear = clear_pixels(state.kelvin, state.clear_K)
    measured = [float(state.kelvin[clear].mean())] if clear.any() else []
    if clear.any() and image.second_K is not None and len(bands) > 1:
        measured.append(float(np.nanmean(image.second_K[clear])))
    lines: tuple[str, ...] = ()
    fitted = None
    if measured:
        fitted = fit_clear_sky(scenario, measured, int(clear.sum()))
        sea, vapour = np.median(fitted.draws, axis=0)
        spread, correlation = fitted.draws.std(axis=0), float(np.asarray(np.corrcoef(fitted.draws.T))[0, 1])
        warmest = max(float(np.percentile(state.kelvin, _WARMEST)), measured[0])
        scenario["sea"] = {"temperature": round(fitted.warm_sea_K(warmest), 3)}
        scenario["atmosphere"] = {"water_vapour_scale": round(float(vapour), 4)}
        lines = (
            f"sea {sea:.2f} +- {spread[0]:.2f} K, vapour {vapour:.2f} +- {spread[1]:.2f} of the climatology's, "
            f"correlation {correlation:.2f}, from {fitted.pixels} clear pixels in {len(measured)} channels; the "
            f"scene's sea is {scenario['sea']['temperature']:.2f} K, the warmest of the image.",
        )
        notes += fitted.notes
    else:
        notes.append("no clear pixels: sea and vapour are those of the climatology")
    return Made(scenario, fitted, lines, tuple(notes))


def half_power_um(path: Path) -> tuple[float, float]:
    """Return where a response (CSV of wavelength in um and response) falls to half of its peak."""
    try:
        with path.open(encoding="utf-8") as file:
            rows = [(float(row[0]), float(row[1])) for row in csv.reader(file) if row and _is_number(row[0])]
    except (OSError, ValueError, IndexError) as error:
        raise CatalogError(f"{path}: no response of wavelength (um) and response: {error}") from error
    if not rows:
        raise CatalogError(f"{path}: no numbers; allowed: wavelength in um and response")
    wavelength, response = np.array(rows).T
    inside = wavelength[response >= 0.5 * response.max()]
    return float(inside.min()), float(inside.max())


def toml_of(scenario: Mapping[str, Any]) -> str:
    """Return a scenario as TOML: plain values, then tables."""
    plain = [f"{key} = {_value(value)}" for key, value in scenario.items() if not isinstance(value, dict)]
    tables = [
        "\n".join([f"[{key}]", *(f"{name} = {_value(each)}" for name, each in value.items())])
        for key, value in scenario.items()
        if isinstance(value, dict)
    ]
    return (
        "\n".join(["# Made by `hcss follow`; rights: those of the images.", *plain])
        + "\n\n"
        + "\n\n".join(tables)
        + "\n"
    )


def _value(value: Any) -> str:
    """Return a value as TOML, in which texts and lists of numbers are as in JSON."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {_value(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    return json.dumps(value)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
