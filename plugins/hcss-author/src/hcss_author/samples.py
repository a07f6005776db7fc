"""Sample inputs of providers of all kinds; those of the laws that ``hcss run`` asks are of ``hcss_twin``."""

from __future__ import annotations

import dataclasses
import logging
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

import numpy as np

from hcss_twin import providers
from hcss_twin.laws.samples import StillScene, sample_radiance_inputs
from hcss_twin.providers import (
    Array,
    AtmosphereInputs,
    Catalog,
    CloudInputs,
    CloudLayer,
    Declaration,
    ElementInputs,
    Grid,
    Microphysics,
    Motion,
    OpticsInputs,
    Profile,
    SceneInfo,
    SeaInputs,
    SensorBand,
    SensorInputs,
    Sun,
    SurfaceInputs,
    View,
    planck,
)

__all__ = [
    "frozen",
    "sample_atmosphere_inputs",
    "sample_cloud_inputs",
    "sample_element_inputs",
    "sample_grid",
    "sample_high_layer",
    "sample_layer",
    "sample_microphysics",
    "sample_motion",
    "sample_optics_inputs",
    "sample_profile",
    "sample_radiance_inputs",
    "sample_scene",
    "sample_sea_inputs",
    "sample_sensor_inputs",
    "sample_surface_inputs",
    "sample_wavenumbers",
]

_USUAL_RANGE_CM1 = (500.0, 4000.0)


def frozen(values: Any) -> Array:
    """Return values as a float64 array that cannot be written to, as providers must not."""
    array: Array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


def sample_profile(temperature_K: float | None = None) -> Profile:
    """Return an atmosphere of scale height 8 km up to 80 km with all gases of ``GASES``.

    Water vapour falls off over 2 km from 1 % at the surface, ozone has its most at 34 km, the others are well mixed.

    Parameters
    ----------
    temperature_K : float, optional
        Of an isothermal atmosphere; by default 288 K at the surface, falling by 6.5 K per km to 216.5 K.
    """
    profile = sample_radiance_inputs().setting.profile
    if temperature_K is None:
        return profile
    kelvin = frozen(np.full_like(profile.altitude_m, temperature_K))
    return dataclasses.replace(profile, name=f"isothermal {temperature_K:g} K", temperature_K=kelvin)


def sample_microphysics(material: str = "water") -> Microphysics:
    """Return particles: water droplets or other particles with a mode radius of 4 um, or ice particles of 20 um.

    n(r) = a r^6 exp(-6 r / r_mode): the modified gamma distribution with its mode at r_mode.
    """
    water = sample_layer().microphysics
    if material == "ice":
        radii, density_m3 = (20.0 / 50.0, 20.0 * 10.0), 1e5
        return dataclasses.replace(water, material="ice", b=0.3, number_density_m3=density_m3, radius_range_um=radii)
    density = None if material == "water" else 2500.0
    return dataclasses.replace(water, material=material, density_kg_m3=density)


def sample_layer(coverage: float = 0.5) -> CloudLayer:
    """Return a low water cloud between 1000 m and 1800 m with a minimum thickness of 50 m."""
    return dataclasses.replace(sample_radiance_inputs().setting.layers[0], coverage=coverage)


def sample_high_layer(coverage: float = 0.5) -> CloudLayer:
    """Return a high ice cloud between 8000 m and 10 000 m, above that of :func:`sample_layer`."""
    return dataclasses.replace(
        sample_layer(coverage),
        name="sample high",
        base_m=8000.0,
        top_m=10_000.0,
        thickness_min_m=100.0,
        microphysics=sample_microphysics("ice"),
    )


def sample_grid() -> Grid:
    """Return an image of 48 x 64 pixels of 200 m: not square, so that exchanged axes show."""
    return Grid(rows=48, columns=64, pixel_size_m=200.0)


def sample_motion() -> Motion:
    """Return a moving platform, a wind and evolving shapes."""
    return Motion(
        platform_speed_m_s=100.0, cloud_velocity_m_s=(6.0, -3.0), evolution_time_s=1800.0, frame_interval_s=2.0
    )


def sample_cloud_inputs(coverage: float = 0.5, seed: int = 1, **changes: Any) -> CloudInputs:
    """Return inputs of a cloud generator; ``changes`` replace fields of ``CloudInputs``."""
    inputs = CloudInputs(
        layer=sample_layer(coverage), grid=sample_grid(), motion=sample_motion(), seed=seed, catalog=Catalog()
    )
    return dataclasses.replace(inputs, **changes)


def sample_scene() -> SceneInfo:
    """Return noon of an April day at 35 N 150 E, for providers that take the scene."""
    noon = datetime(2024, 4, 20, 2, tzinfo=UTC)
    return SceneInfo(noon, 35.0, 150.0, lambda time_s: Sun(24.0, 180.0, 1.005), logging.getLogger(providers.__name__))


def sample_sea_inputs(wind_speed_m_s: float = 8.0) -> SeaInputs:
    """Return a sea of 290 K under a westerly wind."""
    return SeaInputs(wind_speed_m_s=wind_speed_m_s, wind_from_deg=270.0, temperature_K=290.0, catalog=Catalog())


def sample_optics_inputs() -> OpticsInputs:
    """Return inputs of an optics provider."""
    return OpticsInputs(catalog=Catalog())


def sample_atmosphere_inputs(profile: Profile | None = None) -> AtmosphereInputs:
    """Return inputs of a transmittance provider, by default with :func:`sample_profile`."""
    return AtmosphereInputs(profile=profile or sample_profile(), catalog=Catalog())


def sample_element_inputs(bands: int = 2) -> ElementInputs:
    """Return inputs of an element provider over :func:`sample_grid`; bodies radiate at the bands' peaks, 1 um wide."""
    sensor = sample_sensor_inputs().bands[:bands]
    peaks = frozen([1e4 / band.wavelength_um[np.argmax(band.response)] for band in sensor])
    return ElementInputs(
        bands=sensor,
        grid=sample_grid(),
        view=View(zenith_deg=30.0, azimuth_deg=90.0),
        black_body=lambda temperature_K: planck(peaks, temperature_K) * peaks**2 / 1e4,
        catalog=Catalog(),
    )


def sample_surface_inputs(points_per_s: int = 0) -> SurfaceInputs:
    """Return inputs of a surface provider over :func:`sample_grid` around 35 N 150 E, moving so many points east."""
    grid = sample_grid()

    def ground(time_s: float, rows: slice, columns: slice) -> tuple[Array, Array]:
        x = (
            np.arange(columns.start, columns.stop) + 0.5 - 0.5 * grid.columns + points_per_s * time_s
        ) * grid.pixel_size_m
        y = (np.arange(rows.start, rows.stop) + 0.5 - 0.5 * grid.rows) * grid.pixel_size_m
        east, north = np.meshgrid(x, y)
        return 35.0 + north / 111e3, 150.0 + east / 91e3

    return SurfaceInputs(grid, ground, sea_temperature_K=290.0, air_temperature_K=288.0, catalog=Catalog())


def sample_sensor_inputs(seed: int = 1, **changes: Any) -> SensorInputs:
    """Return inputs of a sensor: two bands over :func:`sample_grid`; ``changes`` replace fields of ``SensorInputs``."""
    motion = sample_motion()
    inputs = SensorInputs(
        bands=(
            SensorBand("mid", frozen([3.5, 4.0, 4.5]), frozen([0.0, 1.0, 0.0])),
            SensorBand("long", frozen([8.0, 12.0]), frozen([1.0, 1.0])),
        ),
        grid=sample_grid(),
        platform_speed_m_s=motion.platform_speed_m_s,
        frame_interval_s=motion.frame_interval_s,
        seed=seed,
        catalog=Catalog(),
        scene_at=StillScene(),
    )
    return dataclasses.replace(inputs, **changes)


def sample_wavenumbers(declares: Declaration, count: int = 12) -> Array:
    """Return up to ``count`` wavenumbers in the range of a provider, within 500 to 4000 cm-1 if it can.

    Nodes of its native grid if it has one, otherwise evenly spaced wavenumbers within its declared range.
    """
    low, high, grid = _spectrum(declares, _USUAL_RANGE_CM1)
    inner = max(low, _USUAL_RANGE_CM1[0]), min(high, _USUAL_RANGE_CM1[1])
    low, high = inner if inner[0] < inner[1] else (low, high)
    if grid is None:
        return frozen(np.linspace(low, high, count))
    inside = grid[(grid >= low) & (grid <= high)]
    return frozen(inside[np.unique(np.linspace(0, inside.size - 1, count).astype(int))])


def _spectrum(declares: Declaration, otherwise: tuple[float, float]) -> tuple[float, float, Array | None]:
    """Return the range of wavenumbers, and the native grid, of a kind that can declare them."""
    valid: Mapping[str, tuple[float, float]] = getattr(declares, "valid", {})
    return *valid.get("wavenumber_cm1", otherwise), getattr(declares, "native_grid_cm1", None)
