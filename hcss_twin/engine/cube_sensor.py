"""Sensor input from a finished cube, and metadata of the sensor cube."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.environment import versions
from hcss_twin.core.errors import CubeError
from hcss_twin.cube.header import SCENARIO_ATTRIBUTE, Attribute
from hcss_twin.cube.metadata import creation_time
from hcss_twin.cube.sensor_cube import SENSOR_ATTRIBUTE
from hcss_twin.cube.variables import ELEMENT_PLACE, ELEMENT_POINT_RADIANCE, ELEMENT_RATE
from hcss_twin.engine.provenance import (
    CERTIFICATE,
    CLEAN_CERTIFICATE,
    STORED,
    Recorded,
    recorded_files,
    stored_attribute,
)
from hcss_twin.models.radiance.spectral_grid import SpectralBand
from hcss_twin.plan.builder import numbered, scene_of
from hcss_twin.plan.description import describe_providers
from hcss_twin.plan.lines_of_sight import SunTrack
from hcss_twin.plan.sensor import BuiltSensor
from hcss_twin.providers import Grid, Points, SceneInfo, SensorInputs
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.bands import Bands, sensor_bands, spectral_band
from hcss_twin.scenario.viewing import pixel_size_and_speed

if TYPE_CHECKING:
    import xarray as xr

_NEEDED = (ELEMENT_POINT_RADIANCE, *ELEMENT_PLACE, *ELEMENT_RATE)

Read = Callable[[str], NDArray[Any]]
"""Returns a variable of a frame, without the time."""


def require_points(present: Collection[Any], name: str) -> None:
    """Raise a :class:`CubeError` if a cube with elements lacks what a sensor needs to draw them."""
    missing = [variable for variable in _NEEDED if variable not in present]
    if missing:
        raise CubeError(
            f"{name}: a sensor draws elements at their places within the pixels, and the cube lacks "
            f"{', '.join(missing)}; allowed: a cube with these output.variables, or a run of its scenario with [sensor]"
        )


def points_apart(read: Read, corner: tuple[int, int], name: str) -> tuple[NDArray[np.float32], Points | None]:
    """Return the radiance (B, y, x) of a frame without its small elements, and these; as they add up in each pixel.

    Parameters
    ----------
    corner : (int, int)
        Row and column of the first pixel in the image, from which places count.

    Raises
    ------
    CubeError
        If the places are not in the pixels of the cube.
    """
    radiance, added = np.asarray(read("radiance")), np.asarray(read(ELEMENT_POINT_RADIANCE))
    row, column = (np.asarray(read(variable), dtype=np.float64) for variable in ELEMENT_PLACE)
    y, x = np.nonzero(np.isfinite(row))
    if not y.size:
        return radiance, None
    places = [coordinate[y, x] - first for coordinate, first in zip((row, column), corner, strict=True)]
    # Stored in single precision, a place may lie on the border of its pixel.
    if any(np.any((at < pixel - 0.01) | (at > pixel + 1.01)) for at, pixel in zip(places, (y, x), strict=True)):
        raise CubeError(
            f"{name}: its elements are not in the pixels that it has; allowed: a cube or window with the pixels of its "
            "scenario, none left out and none averaged"
        )
    rates = [np.asarray(read(variable), dtype=np.float64)[y, x] for variable in ELEMENT_RATE]
    light = added[:, y, x].astype(np.float64)
    return radiance - added, Points(places[0], places[1], rates[0], rates[1], light)


_SAME = 1e-6
"""Relative tolerance for agreement between numbers of a cube and of its scenario."""


@dataclass(frozen=True)
class CleanCube:
    """Metadata of a clean cube.

    Attributes
    ----------
    inputs : SensorInputs
        Inputs for the sensor.
    frame_numbers : ndarray (F,) of int
        Frame numbers at the scenario's interval, counted from its start.
    times_s : ndarray (F,)
        Seconds after the start.
    scenario : mapping
        In JSON form.
    scene : SceneInfo
        What a sensor may know of it.
    binned : float
        Pixels of the scenario along the side of one of the cube, which may be subsampled or averaged.
    """

    inputs: SensorInputs
    frame_numbers: NDArray[np.int64]
    times_s: NDArray[np.float64]
    scenario: Mapping[str, Any]
    scene: SceneInfo
    binned: float = 1.0

    @property
    def has_elements(self) -> bool:
        """Whether the scene has elements."""
        return bool(self.scenario.get("elements"))


def read_clean(dataset: xr.Dataset, name: str, base: Path | None) -> CleanCube:
    """Read the sensor inputs from an open cube.

    Parameters
    ----------
    name : str
        Name of the cube, for messages.
    base : Path, optional
        Base folder of relative paths of the scenario and the sensor. By default paths of the scenario are relative to
        its original folder, if its files still exist, and paths of the sensor to the working folder.

    Raises
    ------
    CubeError
        If the cube has no radiance or no scenario, lacks the places of its elements, or is itself a sensor cube.
    CatalogError
        If a band response file is missing.
    """
    if SENSOR_ATTRIBUTE in dataset.attrs:
        raise CubeError(f"{name} is already a sensor cube; a clean cube is needed")
    if "radiance" not in dataset:
        raise CubeError(f"{name} has no radiance, which a sensor needs; request it in the scenario")
    recorded = Recorded.of(dict(dataset.attrs), name)
    bands = bands_of(dataset, name, base)
    try:
        scenario = _with_integration_times(recorded)
        interval_s = float(scenario["frames"]["interval"])
        start = np.datetime64(_utc(scenario["time"]), "ns")
        start_time = datetime.fromisoformat(scenario["time"])
        place = float(scenario["place"]["latitude"]), float(scenario["place"]["longitude"])
        seed = int(scenario["seed"])
        pixel_size_m, speed_m_s = pixel_size_and_speed(scenario)
        image = int(scenario["image"]["rows"]), int(scenario["image"]["columns"])
    except (KeyError, TypeError, ValueError) as error:
        raise _contradicted(name, error) from error
    times_s = (dataset["time"].to_numpy() - start) / np.timedelta64(1, "ns") * 1e-9
    numbers = np.rint(times_s / interval_s).astype(np.int64)
    if np.any(numbers < 0) or np.any(np.abs(numbers * interval_s - times_s) > 1e-3 * interval_s):
        raise CubeError(f"{name}: its times do not match its scenario, every {interval_s:g} s from the start")
    grid = Grid(dataset.sizes["y"], dataset.sizes["x"], pixel_size_of(dataset, pixel_size_m, name))
    inputs = SensorInputs(
        bands=sensor_bands(bands),
        grid=grid,
        platform_speed_m_s=_speed_m_s(dataset, times_s, speed_m_s),
        frame_interval_s=interval_s,
        seed=seed,
        catalog=Catalog(base=base or Path.cwd()),
        corner=corner_in_image(dataset, image, pixel_size_m),
    )
    scene = scene_of(SunTrack(start_time, *place, inputs.platform_speed_m_s))
    cube = CleanCube(inputs, numbers, times_s, scenario, scene, grid.pixel_size_m / pixel_size_m)
    if cube.has_elements:
        require_points(dataset.variables, name)
    return cube


def _with_integration_times(recorded: Recorded) -> dict[str, Any]:
    """Return the scenario of a cube, with the integration times that sections of plugins took from its sensor."""
    scenario, key = dict(recorded.scenario), ".integration_time"
    for item in json.loads(recorded.attributes.get("hcss_filled_in", "[]")):
        if item["field"].endswith(key):
            section = item["field"].removesuffix(key)
            scenario[section] = {**scenario[section], key[1:]: float(item["value"].removesuffix(" s"))}
    return scenario


def bands_of(dataset: xr.Dataset, name: str, base: Path | None = None) -> list[SpectralBand]:
    """Return the bands of an open cube, with their spectral responses, from the scenario that it records.

    Raises
    ------
    CubeError
        If the cube has no scenario, or one with other bands.
    CatalogError
        If a band response file is missing.
    """
    recorded = Recorded.of(dict(dataset.attrs), str(dataset.encoding.get("source", name)), base)
    catalog = Catalog(base=recorded.base)
    try:
        given = TypeAdapter(Bands).validate_python(recorded.scenario["bands"])
        with recorded.stored_files(name) as catalog.shelf.stored:
            known = {band.name: band for band in (spectral_band(section, catalog) for section in given)}
    except (KeyError, TypeError, ValueError) as error:
        raise _contradicted(name, error) from error
    names = [str(label) for label in dataset["band"].to_numpy()]
    others = [label for label in names if label not in known]
    if others:
        raise _contradicted(name, f"band_name: '{others[0]}'; allowed: {', '.join(known)}")
    return [known[label] for label in names]


def _contradicted(name: str, error: object) -> CubeError:
    return CubeError(f"{name}: its scenario ({SCENARIO_ATTRIBUTE}) does not match this cube: {error}")


def _utc(text: str) -> str:
    return datetime.fromisoformat(text).astimezone(UTC).replace(tzinfo=None).isoformat()


def pixel_size_of(dataset: xr.Dataset, expected_m: float, name: str) -> float:
    """Pixel size of the scenario, or of the cube if it was subsampled or averaged."""
    x = dataset["x"].to_numpy().astype(np.float64)
    steps = np.diff(x)
    if not steps.size or _counts_pixels(dataset):
        return expected_m
    if np.ptp(steps) > _SAME * abs(float(steps[0])):
        raise CubeError(f"{name}: x is not evenly spaced; a sensor has pixels of one size")
    step = abs(float(steps[0]))
    return expected_m if abs(step - expected_m) <= _SAME * expected_m else step


def _counts_pixels(dataset: xr.Dataset) -> bool:
    """Whether the axes are rows and columns of a focal plane, not metres on the ground."""
    return bool(dataset["x"].attrs.get("units") == "1")


def corner_in_image(dataset: xr.Dataset, image: tuple[int, int], size_m: float) -> tuple[int, int]:
    """Row and column of the first pixel in the image; (0, 0) if the pixels are not those of the scenario."""
    if _counts_pixels(dataset):
        return 0, 0
    corner = []
    for name, count in zip(("y", "x"), image, strict=True):
        centres_m = dataset[name].to_numpy().astype(np.float64)
        indices = centres_m / size_m + 0.5 * count - 0.5
        first = int(np.rint(indices[0]))
        if first < 0 or np.max(np.abs(indices - first - np.arange(indices.size))) > 0.1:
            return 0, 0
        corner.append(first)
    return corner[0], corner[1]


def _speed_m_s(dataset: xr.Dataset, times_s: NDArray[np.float64], expected_m_s: float) -> float:
    """Speed of the image centre, from its displacement at the last frame."""
    if "centre_displacement" not in dataset or not times_s[-1] > 0.0:
        return expected_m_s
    speed_m_s = float(dataset["centre_displacement"].to_numpy()[-1]) / float(times_s[-1])
    return expected_m_s if abs(speed_m_s - expected_m_s) <= _SAME * abs(expected_m_s) else speed_m_s


def sensor_attributes(
    clean: Mapping[str, Any], sensor: BuiltSensor, catalog: Catalog, clean_name: str
) -> dict[str, Attribute | None]:
    """Return global attributes that differ from those of the clean cube; None: to be removed.

    The certificate refers to clean radiance, so the sensor cube quotes it as that of the clean cube.

    Parameters
    ----------
    clean : mapping
        Global attributes of the clean cube.
    catalog : Catalog
        Knows the files read for the sensor.
    clean_name : str
        File name of the clean cube, without folder; empty if it has no file.
    """
    stamp = creation_time().isoformat(timespec="seconds").replace("+00:00", "Z")
    about = json.dumps(sensor.as_dict())
    scenario = json.loads(str(clean[SCENARIO_ATTRIBUTE]))
    scenario["sensor"] = sensor.section.model_dump(mode="json")
    entries = [stage.entry for stage in sensor.stages]
    kinds = [numbered(Kind.SENSORS, index, len(entries)) for index in range(len(entries))]
    models = ", ".join(f"'{entry.name}'" for entry in entries)
    providers = json.loads(str(clean["hcss_providers"]))
    files = {**json.loads(str(clean["hcss_files_sha256"])), **recorded_files(catalog, scenario)}
    providers |= describe_providers(dict(zip(kinds, entries, strict=True)))
    identifier = hashlib.sha256(f"{clean.get('id', '')}\n{about}".encode()).hexdigest()[:16]
    title = str(clean.get("title", ""))
    attributes: dict[str, Attribute | None] = {
        "title": f"{title} - as measured by {sensor.title}" if title else f"As measured by {sensor.title}",
        "summary": f"Measured by the simulated sensor '{sensor.title}' (model {models}), not the radiance that "
        f"reaches it: {clean.get('summary', '')}",
        "processing_level": "simulated radiance as measured, with the effects of optics, detector and converter",
        "instrument": sensor.title,
        "id": f"hcss-{identifier}",
        "history": f"{stamp} measured by hcss_twin from {clean_name or 'a clean cube'}\n{clean.get('history', '')}",
        "date_created": stamp,
        "clean_cube": clean_name,
        "clean_cube_id": str(clean.get("id", "")),
        SCENARIO_ATTRIBUTE: json.dumps(scenario, indent=1),
        SENSOR_ATTRIBUTE: about,
        "hcss_providers": json.dumps(providers),
        "hcss_versions": json.dumps({**json.loads(str(clean["hcss_versions"])), **versions()}),
        "hcss_files_sha256": json.dumps(dict(sorted(files.items()))),
    }
    attributes |= stored_attribute(catalog, scenario["output"].get("store_inputs", True), clean.get(STORED))
    if "hcss_certificate" in clean:
        attributes[CLEAN_CERTIFICATE] = str(clean["hcss_certificate"])
    return {**attributes, **{name: None for name in CERTIFICATE if name in clean}}
