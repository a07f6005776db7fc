"""The plan as plain values, for ``hcss plan --json`` and cube attributes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hcss_twin.cube.writer import largest_error
from hcss_twin.models.optics.size_distribution import (
    effective_radius_um,
    effective_variance,
    projected_area_m1,
    water_content_kg_m3,
)
from hcss_twin.physics.viewing import LinesOfSight
from hcss_twin.plan.error_budget import beyond_accuracy, error_budget, left_out
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.provider_cost import provider_costs
from hcss_twin.providers import CloudLayer
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.scenario.scenario import Scenario


def describe(plan: Plan) -> dict[str, Any]:
    """Return the decisions of a plan as JSON values."""
    return {
        "frames": int(plan.frame_times_s.size),
        "rows": plan.pixels[0],
        "columns": plan.pixels[1],
        "window_of": [plan.grid.rows, plan.grid.columns] if plan.is_window else None,
        "samples_per_pixel": plan.samples_per_pixel,
        "view": {"zenith_deg": plan.view.zenith_deg, "azimuth_deg": plan.view.azimuth_deg},
        "platform": _platform(plan.scenario, plan.assembly.lines_of_sight),
        "cloud_tops": {tops.name: tops.nodes for tops in plan.tops} or None,
        "views": None,
        "layers": [
            {
                "name": layer.name,
                "base_m": layer.base_m,
                "top_m": layer.top_m,
                "anchor": layer.anchor,
                "coverage": layer.coverage,
                "coverage_mode": layer.coverage_mode,
                "particles": describe_particles(layer),
            }
            for layer in plan.layers
        ],
        "bands": [{"name": band.name, "lower_um": band.lower_um, "upper_um": band.upper_um} for band in plan.bands],
        "providers": describe_providers(plan.assembly.entries),
        "sun": {
            "zenith_deg": [float(plan.sun_zenith_deg[0]), float(plan.sun_zenith_deg[-1])],
            "azimuth_deg": [float(plan.sun_azimuth_deg[0]), float(plan.sun_azimuth_deg[-1])],
        },
        "wavenumbers": int(plan.spectral_grid.wavenumber_cm1.size),
        "numerics": {**vars(plan.numerics), "spectral_grid": vars(plan.grid_refinement)},
        "accuracy": {**vars(plan.accuracy), "budget": vars(plan.budget)},
        "variables": [spec.name for spec in plan.variables],
        "uncompressed_bytes": plan.uncompressed_bytes,
        "quantization": {
            spec.name: {"bits": spec.significant_bits, "relative_error": largest_error(spec.significant_bits)}
            for spec in plan.variables
            if spec.significant_bits is not None
        },
        "packing": {spec.name: vars(spec.packing) for spec in plan.variables if spec.packing is not None},
        "filled_in": [item.as_dict() for item in plan.filled_in],
        "notes": list(plan.notes),
        "provider_costs": [vars(cost) for cost in provider_costs(plan)],
        "skipped": [vars(item) for item in plan.omissions],
        **_against_the_world(plan),
        **{name: value for effect in plan.effects for name, value in effect.described().items()},
    }


def _against_the_world(plan: Plan) -> dict[str, Any]:
    if not plan.needs_radiance:
        return {}
    budget = error_budget(plan)
    return {
        "beyond_accuracy": list(beyond_accuracy(plan)),
        "left_out": list(left_out(plan, budget)),
        "error_budget": budget.as_dict(),
    }


def describe_providers(entries: Mapping[str, Entry]) -> dict[str, dict[str, str]]:
    """Return name, distribution and version of providers by kind."""
    return {
        kind: {"name": entry.name, "distribution": entry.distribution, "version": entry.version}
        for kind, entry in entries.items()
    }


def describe_particles(layer: CloudLayer) -> dict[str, str | float]:
    """Return material and bulk properties of a layer's particles.

    ``large_particle_extinction_m1`` is twice the projected area, 3/2 of the water content over density and
    effective radius: the extinction where particles are much larger than the wavelength, as in visible light.
    """
    cloud = layer.microphysics
    return {
        "name": layer.name,
        "material": cloud.material,
        "effective_radius_um": effective_radius_um(cloud),
        "effective_variance": effective_variance(cloud),
        "water_content_g_m3": 1000.0 * water_content_kg_m3(cloud),
        "number_density_m3": cloud.number_density_m3,
        "large_particle_extinction_m1": 2.0 * projected_area_m1(cloud),
    }


def _platform(scenario: Scenario, lines: LinesOfSight | None) -> dict[str, float] | None:
    if lines is None:
        return None
    return {
        "altitude_m": lines.altitude_m,
        "slant_range_m": lines.centre_range_m,
        "pixel_size_m": scenario.image.pixel_size,
        "ground_speed_m_s": float(scenario.motion.platform_speed),
    }
