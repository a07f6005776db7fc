"""A scenario in a few lines, for the prompt and notebooks."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any

from hcss_twin.scenario.models import ScenarioModel


def summary(scenario: ScenarioModel, sections: Collection[str]) -> tuple[str, list[tuple[str, str]]]:
    """Return the title of a scenario, and labelled lines about it.

    Parameters
    ----------
    scenario : ScenarioModel
    sections : collection of str
        Those of plugins, which may give other rays than the scenario's view and image.
    """
    return f"Scenario: {scenario.title or 'without a title'}", list(_rows(scenario, sections))


def _rows(scenario: ScenarioModel, sections: Collection[str]) -> Iterator[tuple[str, str]]:
    place, image, frames = scenario.place, scenario.image, scenario.frames
    north, east = "N" if place.latitude >= 0 else "S", "E" if place.longitude >= 0 else "W"
    yield "time", scenario.time.isoformat(" ")
    yield "place", f"{abs(place.latitude):g}° {north}, {abs(place.longitude):g}° {east}"
    if sections:
        yield "of plugins", ", ".join(sorted(sections))
    else:
        yield "view", f"{scenario.view.zenith:g}° from the zenith, bearing {scenario.view.azimuth:g}°"
    yield (
        "plane" if sections else "image",
        f"{image.rows} rows x {image.columns} columns, pixels of {image.pixel_size:g} m",
    )
    yield "frames", f"{frames.count}, {frames.interval:g} s apart" if frames.count > 1 else "1"
    yield "bands", ", ".join(map(_band, scenario.bands))
    layers = scenario.clouds.layers
    yield "clouds", "; ".join(f"{layer.type}, coverage {layer.coverage:g}" for layer in reversed(layers)) or "none"
    if scenario.sensor is not None:
        yield "sensor", str(scenario.sensor.name or "described in the scenario")
    yield "output", ", ".join(scenario.output.variables)


def _band(band: Any) -> str:
    """Name of a band, or its limits."""
    if isinstance(band, str):
        return band
    name = getattr(band, "name", None)
    if name:
        return str(name)
    limits = band if isinstance(band, list | tuple) else getattr(band, "limits", band)
    return f"{limits[0]:g}-{limits[1]:g} um" if isinstance(limits, list | tuple) else str(limits)
