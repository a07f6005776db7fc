"""Cloud layers of a scene and their generators."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.physics.profile import Profile
from hcss_twin.plan.builder import Builder, numbered
from hcss_twin.plan.combinations import Excluded, NotComputed, goes_on_with
from hcss_twin.plan.displaced_clouds import DisplacedClouds
from hcss_twin.plan.errors_of_place import tops_by_place
from hcss_twin.plan.filled_in import FilledIn
from hcss_twin.plan.hanging_levels import levels_of, spanning
from hcss_twin.plan.slant_paths import MAX_POINTS_WITHIN, SlantPaths, enlarged
from hcss_twin.plan.surroundings import Surroundings, with_climatological_top
from hcss_twin.providers import BrightnessInversion, CloudGenerator, CloudInputs, CloudLayer, Grid, Motion
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.cloud_types import (
    LayerGeometry,
    Level,
    PlaceLevels,
    ResolvedLayer,
    overlap_problems,
    resolve_layer,
)
from hcss_twin.scenario.clouds import Layer
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scenario.section_types import own, selected


def _without_slant_paths(paths: SlantPaths, layer: CloudLayer, error: ScenarioError) -> SlantPaths:
    """Return paths that stay in the image, because the clouds of a layer cannot be made beyond it."""
    problem = error.problems[0]
    why = NotComputed(
        f"clouds of '{layer.name}' cannot be made beyond the image", f"{problem.field}: {problem.message}"
    )
    return paths.without("shadows", why).without("parallax", why)


def _excluded_beside_slant_paths(
    generator: CloudGenerator, layer: CloudLayer, field: str, paths: SlantPaths, points: Grid, scenario: Scenario
) -> dict[str, tuple[Excluded, ...]]:
    """Return what of a layer slant paths cannot be computed with, by ``shadows`` and ``parallax``."""
    knows = hasattr(generator, "thickness_around_m") or (generator.declares.tileable and layer.coverage_mode == "field")
    span = spanning(layer, generator)
    others = (
        Excluded(
            f"{field}.generator",
            not knows,
            f"clouds of '{layer.name}' that are known in the image only, which slant paths leave,",
            goes_on_with(generator),
        ),
    )
    point_m, depth_m = points.pixel_size_m, 0.0 if span is layer else paths.farthest_m(span.thickness_max_m)
    size, of_sight = (
        Excluded(
            "image.pixel_size",
            longest_m > MAX_POINTS_WITHIN * point_m,
            f"points of {point_m:g} m, {longest_m / point_m:.0f} of which {what} crosses within '{layer.name}',",
            f"{MAX_POINTS_WITHIN} points; closest valid choice is "
            f"{math.ceil(longest_m / MAX_POINTS_WITHIN * scenario.image.samples_per_pixel * 100.0) / 100.0:g}",
        )
        for what, longest_m in (("the sun's path", paths.longest_m(span)), ("a line of sight", depth_m))
    )
    return {
        "shadows": (*others, size) if paths.sun_zenith_deg.size else (),
        "parallax": (*others, of_sight) if paths.farthest_m(span.top_m) > 0.0 else (),
    }


MAX_POINTS = 2**26
"""Maximum points per frame (8192 x 8192) for generators of whole frames."""

MAX_PIXELS_AT_ONCE = 2**28
"""The same limit (16384 x 16384) with one point per pixel."""


def sums_up(generator: CloudGenerator) -> bool:
    """Whether a generator of whole frames can compute windows from a summary of the frame."""
    return hasattr(generator, "frame_summary") and hasattr(generator, "thickness_in_frame_m")


def _require_few_points(points: Grid, samples: int, layer: CloudLayer, field: str) -> None:
    """Reject frames that are too large for a generator of whole frames."""
    count = points.rows * points.columns
    # With one point per pixel the size is that of the image, which the user may choose up to a memory limit.
    allowed = MAX_POINTS if samples > 1 else MAX_PIXELS_AT_ONCE
    if count <= allowed:
        return
    remedy = f'; or {field}.coverage_mode = "field", which needs no whole frames'
    whole = f"which the cloud generator of '{layer.name}' makes at once"
    if samples > 1:
        key, fitting = "image.samples_per_pixel", max(1, math.floor(samples * math.sqrt(allowed / count)))
        message = (
            f"{samples} makes {points.rows} x {points.columns} points of each frame, {whole}; "
            f"allowed: {allowed} points, so that the closest valid choice is {fitting}"
        )
    else:
        key = "image.rows"
        message = (
            f"{points.rows} rows of {points.columns} columns are {count} points, {whole}; allowed: {allowed}, so that "
            f"the closest valid choice is {max(1, allowed // points.columns)}"
        )
    raise ScenarioError([Problem(key, f"{message}{remedy if layer.coverage_mode == 'frame' else ''}")])


_OF_PARTICLES = ("effective_radius", "effective_variance", "material", "water_content")
"""Keys that may have caused particles that the optics reject, most likely first."""


@dataclass(frozen=True)
class AssembledLayer:
    """A cloud layer of a scenario.

    Attributes
    ----------
    section : Layer
        The layer in the scenario, at the path ``field``.
    particle_field : str
        Field to report if an optics provider rejects the layer's particles.
    type_parameters : mapping
        Parameters of the cloud type's shapes.
    filled_in : tuple of FilledIn
        Values that the climatology gave.
    notes : tuple of str
        Notes on the type.
    """

    layer: CloudLayer
    section: Layer
    field: str
    particle_field: str
    type_parameters: Mapping[str, Any]
    filled_in: tuple[FilledIn, ...] = ()
    notes: tuple[str, ...] = ()


def assemble_layers(
    builder: Builder, scenario: Scenario, catalog: Catalog, around: Surroundings | None
) -> list[AssembledLayer]:
    """Resolve the layers, ordered from the lowest to the highest."""
    layers: list[AssembledLayer] = []
    for index, section in enumerate(scenario.clouds.layers):
        field = scenario.field_as_typed(f"clouds.layers[{index}].type").removesuffix(".type")
        with builder.collect_problems(f"{field}.type"):
            resolved = resolve_layer(section, catalog, field, USUAL_LEVELS if around is None else around.levels)
            layer = resolved.layer
            filled_in = tuple(_by_place(resolved, section, field))
            if around is not None:
                _require_top_inside(layer, around.profile, field)
            if section.temperature == "climatology":
                layer, known = with_climatological_top(layer, scenario, catalog, field)
                filled_in = (*filled_in, known)
            particle_key = next((key for key in _OF_PARTICLES if getattr(section, key) is not None), "type")
            particles = f"{field}.{particle_key}"
            notes = _too_coarse(resolved, section, scenario.image.pixel_size)
            layers.append(AssembledLayer(layer, section, field, particles, resolved.type_parameters, filled_in, notes))
    geometries = {
        assembled.field: (
            assembled.section,
            LayerGeometry(assembled.layer.base_m, assembled.layer.top_m, assembled.layer.thickness_min_m),
        )
        for assembled in layers
    }
    builder.keep(overlap_problems(geometries))
    return sorted(layers, key=lambda assembled: assembled.layer.base_m)


USUAL_LEVELS = PlaceLevels(condensation_m=500.0, melting_m=3000.0, inversion_m=1500.0, tropopause_m=12_000.0)
"""Stand-in for those of air that has problems of its own, because of which the scene is rejected anyway."""

_LEVELS: Mapping[Level, str] = {
    "condensation": "base at the level where air from the sea condenses",
    "inversion": "top at the inversion",
    "tropopause": "top by the tropopause",
}


def _by_place(resolved: ResolvedLayer, section: Layer, field: str) -> Iterator[FilledIn]:
    """Yield the altitudes that follow the air of the place."""
    if resolved.level is None:
        return
    why = f"type '{section.type}': {_LEVELS[resolved.level]} of the air of the scene"
    if section.base is None:
        yield FilledIn(f"{field}.base", f"{resolved.layer.base_m:g} m", why)
    if section.top is None:
        name, measured = resolved.layer.name, resolved.level == "inversion"
        errors, unmeasured = (tops_by_place(name), "") if measured else ((), name)
        yield FilledIn(f"{field}.top", f"{resolved.layer.top_m:g} m", why, errors, unmeasured)


def wind_velocity_m_s(speed_m_s: float, from_deg: float) -> tuple[float, float]:
    """Return the velocity toward east and north of a wind that comes from a bearing."""
    bearing = math.radians(from_deg + 180.0)
    return speed_m_s * math.sin(bearing), speed_m_s * math.cos(bearing)


def _moving(motion: Motion, section: Layer, scenario: Scenario) -> Motion:
    """Return the motion of a layer, which may have its own wind."""
    if section.wind_speed is None and section.wind_from is None:
        return motion
    speed = scenario.motion.wind_speed if section.wind_speed is None else section.wind_speed
    bearing = scenario.motion.wind_from if section.wind_from is None else section.wind_from
    return replace(motion, cloud_velocity_m_s=wind_velocity_m_s(speed, bearing))


def build_generators(
    builder: Builder,
    scenario: Scenario,
    catalog: Catalog,
    layers: Sequence[AssembledLayer],
    motion: Motion,
    slant: SlantPaths,
    inversions: Sequence[BrightnessInversion | None],
) -> tuple[tuple[CloudGenerator, ...], SlantPaths]:
    """Build the generator of each layer, and return the slant paths that all of them allow.

    Generators that have problems are left out.
    """
    image, samples = scenario.image, scenario.image.samples_per_pixel
    points = Grid(image.rows * samples, image.columns * samples, image.pixel_size / samples)
    generators: list[CloudGenerator] = []
    allowed = slant
    for index, (assembled, inversion) in enumerate(zip(layers, inversions, strict=True)):
        layer, section, field = assembled.layer, assembled.section, assembled.field
        margin = slant.margin(layer, points.pixel_size_m)
        # Coverage of the image needs the plane of the image, and so do clouds whose parameters say what is beyond it;
        # others may be made for a larger one.
        ends = section.parameters.get("beyond", "unknown") == "unknown"
        wide = margin if layer.coverage_mode == "field" and ends else (0, 0)
        inputs = CloudInputs(
            layer,
            enlarged(points, wide),
            _moving(motion, section, scenario),
            layer_seed(scenario.seed, index),
            catalog,
            assembled.type_parameters,
            inversion,
        )
        label = numbered(Kind.CLOUDS, index, len(layers))
        with builder.collect_problems(f"{field}.generator", section.parameters), _worded_for(field, samples, wide):
            name = selected(section, "generator")
            try:
                generator = builder.build(Kind.CLOUDS, name, inputs, section.parameters, label)
            except ScenarioError as error:
                if wide == (0, 0) or "on" in (slant.options.shadows, slant.options.parallax):
                    raise
                allowed = _without_slant_paths(allowed, layer, error)
                continue
            span = spanning(layer, generator)
            margin = slant.margin(span, points.pixel_size_m)
            if wide != (0, 0) and any(by > room for by, room in zip(margin, wide, strict=True)):
                wide = margin
                generator = builder.build(
                    Kind.CLOUDS, name, replace(inputs, grid=enlarged(points, wide)), section.parameters, label
                )
            if wide != (0, 0) and not generator.declares.tileable:
                generator = builder.build(Kind.CLOUDS, name, replace(inputs, grid=points), section.parameters, label)
                wide = (0, 0)
            if not (generator.declares.tileable or sums_up(generator)):
                _require_few_points(points, samples, layer, field)
            excluded = _excluded_beside_slant_paths(generator, layer, field, slant, points, scenario)
            for effect, table in excluded.items():
                allowed = allowed.beside(effect, table)
            shift, levels = slant.of_view(layer, points.pixel_size_m), []
            if span is not layer and slant.parallax:
                moved = slant.farthest_m(span.thickness_max_m) / points.pixel_size_m
                levels = [
                    (level, slant.at_height(level.middle_m, points.pixel_size_m)) for level in levels_of(span, moved)
                ]
            # rays that form no grid have shadows even below the clouds
            if wide != (0, 0) or margin != (0, 0) or slant.shadows:
                limits_m = layer.thickness_min_m, layer.thickness_max_m
                generator = DisplacedClouds(generator, wide, shift, wide == (0, 0), levels, limits_m)
            generators.append(generator)
    if allowed is slant:
        return tuple(generators), slant
    return build_generators(builder, scenario, catalog, layers, motion, allowed, inversions)


def _too_coarse(resolved: ResolvedLayer, section: Layer, pixel_size_m: float) -> tuple[str, ...]:
    """Return a note if the fractal clouds of a type are seen with larger pixels than they are meant for."""
    most = resolved.pixel_size_max_m
    is_fractal = section.generator in ("fractal", own("fractal")) and "L" not in section.parameters
    if most is None or pixel_size_m <= most or not is_fractal:
        return ()
    return (
        f"cloud type '{section.type}' is meant for pixels of up to {most:g} m; at {pixel_size_m:g} m neighbouring "
        "pixels are less alike than in measured images of the sea: smaller pixels or fewer cells L give larger clouds",
    )


def layer_seed(seed: int, index: int) -> int:
    """Seed of a cloud layer: the scenario's for the lowest, independent ones for the others."""
    if index == 0:
        return seed
    # Below 2^63, like the seeds of scenarios.
    return int(np.random.SeedSequence(seed, spawn_key=(index,)).generate_state(1, np.uint64)[0] >> 1)


@contextmanager
def _worded_for(field: str, samples: int, margin: tuple[int, int]) -> Iterator[None]:
    """Add the layer's name and an explanation of sizes to a generator's errors about its own keys and the image."""
    try:
        yield
    except ScenarioError as error:
        problems = []
        for problem in error.problems:
            where, message = problem.field, problem.message
            if where.startswith("clouds.") and not where.startswith(f"{field}."):
                where = f"{field}.{where.removeprefix('clouds.')}"
            if where.startswith("image.") and samples > 1:
                message += (
                    f" (sizes here are those of points: with image.samples_per_pixel = {samples} rows and columns "
                    f"are {samples} times those of the scenario, and pixel_size is divided by {samples})"
                )
            if where in ("image.rows", "image.columns") and margin != (0, 0):
                message += (
                    f" (with those outside the image that slant paths meet: {margin[0]} rows and {margin[1]} columns "
                    "of points on each side; none with slant.shadows = 'off' and slant.parallax = 'off')"
                )
            problems.append(Problem(where, message))
        raise ScenarioError(problems, error.origin) from error


def _require_top_inside(layer: CloudLayer, profile: Profile, field: str) -> None:
    top = float(profile.altitude_m[-1])
    if layer.top_m > top:
        message = f"{layer.top_m:g} m is above the profile '{profile.name}'; allowed: up to {top:g}"
        raise ScenarioError([Problem(f"{field}.top", message)])
