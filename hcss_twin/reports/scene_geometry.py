"""Scene geometry of a cube: the angles of sensor and sun, cloud layers, and motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.core.errors import HcssError
from hcss_twin.cube.header import SCENARIO_ATTRIBUTE
from hcss_twin.engine.provenance import recorded_files
from hcss_twin.reports import orientation
from hcss_twin.reports.provenance import Provenance

if TYPE_CHECKING:
    import xarray as xr

Layers = list[tuple[str, float | None, float | None]]


@dataclass(frozen=True)
class SceneGeometry:
    """Angles of a scene, degrees; bearings from the surface point, clockwise from north.

    Attributes
    ----------
    view_zenith, view_azimuth : float
    sun_zenith, sun_azimuth : tuple of float
        In the first and the last frame.
    layers : list of (name, base, top)
        Cloud layers from the lowest; altitudes in m, None where the cube does not state them.
    sensor_altitude_m : float or None
    wind_from : float or None
        Bearing from which the wind that carries the clouds blows.
    footprint_moves_m : float
        Eastward displacement from the first frame to the last, m.
    """

    view_zenith: float
    view_azimuth: float
    sun_zenith: tuple[float, float]
    sun_azimuth: tuple[float, float]
    layers: Layers
    sensor_altitude_m: float | None
    wind_from: float | None
    footprint_moves_m: float


def geometry_of(dataset: xr.Dataset) -> SceneGeometry | None:
    """Return the angles of a cube, of a camera's those in the middle of its image; None if it lacks them."""
    view = orientation.middle_angles(dataset, "sensor_zenith_angle", "sensor_azimuth_angle")
    view = view or orientation.middle_angles(dataset, "pixel_view_zenith", "pixel_view_azimuth")
    names = ("solar_zenith_angle", "solar_azimuth_angle")
    if view is None or any(name not in dataset.coords for name in names):
        return None
    sun_zenith, sun_azimuth = (np.atleast_1d(dataset[name].to_numpy()) for name in names)
    motion = _scenario_section(dataset, "motion")
    displacement = np.atleast_1d(dataset["centre_displacement"]) if "centre_displacement" in dataset.coords else [0]
    return SceneGeometry(
        *view,
        (float(sun_zenith[0]), float(sun_zenith[-1])),
        (float(sun_azimuth[0]), float(sun_azimuth[-1])),
        layers_of(dataset),
        float(dataset["sensor_altitude"]) if "sensor_altitude" in dataset.coords else None,
        float(motion["wind_from"]) if motion.get("wind_speed") and "wind_from" in motion else None,
        float(displacement[-1] - displacement[0]),
    )


def _scenario_section(dataset: xr.Dataset, name: str) -> Mapping[str, Any]:
    section = Provenance.value(dataset.attrs, SCENARIO_ATTRIBUTE, {}).get(name)
    return section if isinstance(section, dict) else {}


def layers_of(dataset: xr.Dataset) -> Layers:
    """Return name, base and top of the cloud layers, from the lowest.

    Altitudes come from the cube, its scenario, or a catalog cloud type whose file still has the recorded hash.
    """
    if "layer_base" in dataset.coords:
        names, bases, tops = (dataset[name].to_numpy() for name in ("layer", "layer_base", "layer_top"))
        return [(str(name), float(base), float(top)) for name, base, top in zip(names, bases, tops, strict=True)]
    hashes = Provenance.value(dataset.attrs, "hcss_files_sha256", {})
    layers: Layers = []
    for section in _scenario_section(dataset, "clouds").get("layers") or []:
        base, top = section.get("base"), section.get("top")
        if base is None or top is None:
            of_type = _type_altitudes(str(section.get("type")), hashes)
            base, top = (of_type[0] if base is None else base, of_type[1] if top is None else top)
        layers.append((str(section.get("type")), base, top))
    return sorted(layers, key=lambda layer: np.inf if layer[1] is None else layer[1])


def _type_altitudes(name: str, hashes: Mapping[str, str]) -> tuple[float | None, float | None]:
    from hcss_twin.core.catalog import Catalog
    from hcss_twin.scenario.cloud_types import load_cloud_type

    catalog = Catalog()
    try:
        usual = load_cloud_type(name, catalog).layer
    except HcssError:
        return None, None
    same = all(hashes.get(file) == sha256 for file, sha256 in recorded_files(catalog, {}).items())
    return (usual.base, usual.top) if same else (None, None)


def bearing_difference(bearing: float, other: float) -> float:
    """Return the difference of two bearings, -180 to 180 degrees."""
    return (bearing - other + 180.0) % 360.0 - 180.0
