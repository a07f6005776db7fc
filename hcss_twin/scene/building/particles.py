"""What the particles of a layer are, in the terms people know."""

from __future__ import annotations

from collections.abc import Mapping

from hcss_twin.optics.size_distribution import (
    effective_radius_um,
    effective_variance,
    projected_area_m1,
    water_content_kg_m3,
)
from hcss_twin.providers import CloudLayer


def told(layer: CloudLayer) -> Mapping[str, str | float]:
    """Phase and bulk numbers of a layer's particles, for plan and cube.

    ``large_particle_extinction_m1`` is twice the projected area, 3/2 of the water content over density and
    effective radius: the extinction where particles are much larger than the wavelength, as in visible light.
    """
    cloud = layer.microphysics
    return {
        "name": layer.name,
        "phase": cloud.phase,
        "effective_radius_um": effective_radius_um(cloud),
        "effective_variance": effective_variance(cloud),
        "water_content_g_m3": 1000.0 * water_content_kg_m3(cloud),
        "number_density_m3": cloud.number_density_m3,
        "large_particle_extinction_m1": 2.0 * projected_area_m1(cloud),
    }
