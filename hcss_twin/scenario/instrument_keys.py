"""Replacement of the instrument of a scenario by the keys that follow from it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError
from pydantic_core import PydanticCustomError

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import HcssError, Problem, ScenarioError
from hcss_twin.core.units import UNITS, parse_quantity
from hcss_twin.models.sensor.parameters import AT
from hcss_twin.scenario.instrument import InstrumentSection, load_instrument
from hcss_twin.scenario.problems import problems_from
from hcss_twin.scenario.section_types import AGREEMENT

NOMINAL_FOCAL_M = 1.0
"""Focal length of an instrument that states only the angle of a pixel: images depend on its ratio to the pitch."""


def take_instrument(data: dict[str, Any], catalog: Catalog) -> tuple[list[Problem], dict[str, str]]:
    """Replace the instrument of a raw scenario by the camera or image, the bands and the sensor that follow from it.

    Returns
    -------
    problems : list of Problem
        What is wrong or contradicts other keys.
    renamed : dict
        Key of the instrument by the key that follows from it, for messages.
    """
    raw = data.pop("instrument", None)
    if raw is None:
        return [], {}
    raw = {"name": raw} if isinstance(raw, str) else raw
    if not isinstance(raw, Mapping):
        message = f"{Problem.shown(raw)} is not an instrument; allowed: a catalog name or file, or a table of keys"
        return [Problem("instrument", message)], {}
    name, keys = raw.get("name"), dict(raw)
    problems: list[Problem] = []
    try:
        if isinstance(name, str) and name:
            of_file = load_instrument(name, catalog).keys
            if AT in str(raw.get("nedt")):
                of_file.pop("nedt_temperature", None)
            keys = of_file | keys
        return _Followed(data).all(InstrumentSection.model_validate(keys))
    except ValidationError as error:
        problems = problems_from(error, InstrumentSection, prefix="instrument", raw=keys)
    except (HcssError, OSError, RuntimeError, ValueError) as error:
        problems = [Problem("instrument.name", _of_file(error))]
    for section in ("sensor", "camera"):  # which lack what would follow
        data.pop(section, None)
    return problems, {}


def _of_file(error: Exception) -> str:
    return f"{error.origin}: {error}" if isinstance(error, ScenarioError) and error.origin else str(error)


class _Followed:
    """Sections of a raw scenario that follow from an instrument, and contradictions found on the way."""

    def __init__(self, data: dict[str, Any]) -> None:
        self._data = data
        self._problems: list[Problem] = []
        self._renamed: dict[str, str] = {}

    def all(self, given: InstrumentSection) -> tuple[list[Problem], dict[str, str]]:
        """Set everything that follows; return problems and the keys they follow from."""
        moving = any(name in self._data for name in ("orbit", "camera", "attitude"))
        if (bands := given.band_keys()) is not None:
            self._data.setdefault("bands", bands)
        self._place(given, moving)
        self._measure(given, moving)
        return self._problems, self._renamed

    def _set(self, section: str, key: str, value: Any, origin: str) -> None:
        keys = self._data.setdefault(section, {})
        if not isinstance(keys, dict):  # reported with the other keys
            return
        self._renamed[f"{section}.{key}"] = f"instrument.{origin}"
        if key not in keys:
            keys[key] = value
        elif not _agree(keys[key], value):
            self._problems.append(
                Problem(
                    f"{section}.{key}",
                    f"{Problem.shown(keys[key])} with instrument.{origin}, which means {Problem.shown(value)}; "
                    "allowed: one of them",
                )
            )
            del self._renamed[f"{section}.{key}"]

    def _place(self, given: InstrumentSection, moving: bool) -> None:
        """Set the detector and its geometry: of the camera in orbit, or of the grid on the ground."""
        for name in ("rows", "columns"):
            if getattr(given, name) is not None:
                self._set("camera" if moving else "image", name, getattr(given, name), name)
        geometry, platform = given.geometry, self._data.get("platform")
        angle = geometry.get("pixel_angle")
        far = isinstance(platform, dict) and any(platform.get(name) is not None for name in ("altitude", "longitude"))
        if angle is None:
            if moving:
                self._problems.append(Problem("instrument.focal_length", _NO_ANGLE))
                self._data.pop("camera", None)  # which lacks it, too
            return
        if moving or far:
            section = "camera" if moving else "platform"
            focal = geometry.get("focal_length", NOMINAL_FOCAL_M)
            origins = [
                name if getattr(given, name) is not None else "pixel_angle" if "focal_length" not in geometry else name
                for name in ("focal_length", "detector_pitch")
            ]
            self._set(section, "focal_length", focal, origins[0])
            self._set(section, "detector_pitch", geometry.get("detector_pitch", focal * angle), origins[1])
        elif "pixel_size" not in self._data.get("image", {}):
            self._problems.append(
                Problem(
                    "instrument",
                    f"sees {angle:.4g} rad with a pixel, which needs a distance; allowed: with platform.altitude, "
                    "[orbit], or image.pixel_size",
                )
            )

    def _measure(self, given: InstrumentSection, moving: bool) -> None:
        """Set the parameters of the sensor, and the jitter of the camera."""
        sensor = self._data.setdefault("sensor", {})
        stage, path = self._stage(sensor)
        if stage is None:
            return
        stated = [name for name in ("name", "model") if stage.get(name) is not None]
        for name in stated:
            message = f"{Problem.shown(stage[name])} with [instrument]; allowed: one of them"
            self._problems.append(Problem(f"{path}.{name}", message))
        if stated:
            return
        if given.name is not None:
            stage["name"] = given.name
        if "model" in given.model_fields_set:
            stage["model"] = given.model
        parameters = stage.setdefault("parameters", {})
        if not isinstance(parameters, dict):  # reported with the other keys
            return
        for name, value in given.sensor_parameters(jitter=not moving).items():
            field = f"{path}.parameters.{name}"
            exact = 1e-9 if name not in ("pixel_angle", "aperture_diameter") else AGREEMENT
            if name in parameters and not _agree(parameters[name], value, exact):
                message = f"{Problem.shown(parameters[name])} with [instrument], which means {Problem.shown(value)}"
                self._problems.append(Problem(field, f"{message}; allowed: one of them"))
                continue
            parameters[name] = value
            self._renamed[field] = f"instrument.{name}"
        if moving and given.jitter_pixels > 0.0 and "pixel_angle" in given.geometry:
            rms_deg = math.degrees(given.jitter_pixels * given.geometry["pixel_angle"])
            self._set("jitter", "rms", [rms_deg, rms_deg, 0.0], "jitter")

    def _stage(self, sensor: Any) -> tuple[dict[str, Any] | None, str]:
        """Return the stage of a sensor that is the instrument, and its path."""
        if not isinstance(sensor, dict):  # reported with the other keys
            return None, ""
        stages = sensor.get("stages")
        if not isinstance(stages, list) or not stages:
            return sensor, "sensor"
        for index, stage in enumerate(stages):
            if isinstance(stage, dict) and stage.get("name") is None and stage.get("model") is None:
                return stage, f"sensor.stages[{index}]"
        message = "all have a name or a model; allowed with [instrument]: one without both, which is the instrument"
        self._problems.append(Problem("sensor.stages", message))
        return None, ""


_NO_ANGLE = (
    "is missing, and the angle of a pixel with it; allowed: focal_length with detector_pitch, aperture_diameter with "
    "f_number and detector_pitch, or pixel_angle (pixel on the ground / altitude: 30 m from 500 km are '60 urad')"
)


def _agree(stated: Any, value: Any, within: float = AGREEMENT) -> bool:
    """Whether a key of another section says the same as the instrument, within a relative difference."""
    if isinstance(stated, str) and isinstance(value, int | float):
        for units in UNITS:
            try:
                number = parse_quantity(stated, units)
            except PydanticCustomError:
                continue
            if isinstance(number, float) and abs(number - value) <= within * abs(value):
                return True
        return False
    numbers = all(isinstance(each, float | int) and not isinstance(each, bool) for each in (stated, value))
    if numbers and isinstance(value, float):
        return bool(abs(stated - value) <= within * abs(value))
    return bool(stated == value)
