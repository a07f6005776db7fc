"""What would fail half-way through a scene is found out while it is planned: one wavenumber, one pixel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import CatalogError, Problem, ProviderError, ScenarioError
from hcss_twin.scene.building.assembly import Assembly
from hcss_twin.scene.sun_track import SunTrack

Array = NDArray[np.float64]


def probe_particles(assembly: Assembly) -> None:
    """Find out now that the optics provider cannot have a layer's particles, or its files; one wavenumber of each."""
    wavenumber = assembly.spectral_grid.wavenumber_cm1[:1]
    problems = []
    for layer, cloudy, field in zip(
        assembly.layers, assembly.cloudy_layers, assembly.particle_fields, strict=True
    ):
        if cloudy:
            try:
                assembly.optics.single_scattering(layer.microphysics, wavenumber)
            except ProviderError as error:
                problems.append(Problem(field, str(error)))
            except CatalogError as error:
                problems.append(Problem("optics.provider", str(error)))
    if problems:
        raise ScenarioError(list(dict.fromkeys(problems)))


def probe_lowest_sun(assembly: Assembly, track: SunTrack, times: Array, zenith_deg: Array) -> None:
    """Find out now, not after the scene is half computed, that a provider cannot follow the sun so low.

    One wavenumber of the columns at the frame with the lowest sun above the horizon.
    """
    up = np.flatnonzero(zenith_deg < 90.0)
    if up.size == 0:
        return
    frame = up[np.argmax(zenith_deg[up])]
    sun = track.at(float(times[frame]))
    wavenumber = assembly.spectral_grid.wavenumber_cm1[:1]
    try:
        assembly.model.clear(wavenumber, sun)
        if assembly.has_cloud:
            assembly.model.cloudy(wavenumber, assembly.extreme_thicknesses_m, sun)
    except ProviderError as error:
        message = (
            f"with the sun at zenith {zenith_deg[frame]:.2f} deg (frame {frame}): {error}; allowed: times with the "
            "sun higher or below the horizon"
        )
        raise ScenarioError([Problem("time", message)]) from error


def probe_last_frame(assembly: Assembly, last_s: float) -> None:
    """Find out now that a generator cannot follow the motion to the end; one pixel, where it gives windows."""
    for generator in assembly.generators:
        if generator.declares.tileable:
            try:
                generator.thickness_m(last_s, slice(0, 1), slice(0, 1))
            except ProviderError as error:
                raise ScenarioError([Problem("frames", str(error))]) from error
