"""Surface provider of a scenario: its construction, and its classes with boundaries and temperatures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.cube.geometry import pixel_centres_m
from hcss_twin.models.surfaces.materials import material
from hcss_twin.physics.geodesy import to_geographic
from hcss_twin.plan.builder import Builder
from hcss_twin.plan.surroundings import Surroundings
from hcss_twin.providers import Grid, SeaModel, SurfaceInputs, SurfaceProvider
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.models import SurfaceSection
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scenario.section_types import selected

SEA = "sea"


@dataclass(frozen=True)
class SurfaceState:
    """A class of surface at one temperature.

    Attributes
    ----------
    boundary : SeaModel or None
        None for the sea of the scenario.
    """

    name: str
    temperature_K: float
    boundary: SeaModel | None


@dataclass(frozen=True)
class SceneClass:
    """A class of surface in a scene, with a field of temperature if ``low_K`` is below ``high_K``."""

    name: str
    boundary: SeaModel | None
    low_K: float
    high_K: float

    def at(self, temperature_K: float) -> SurfaceState:
        """Return the class at a temperature."""
        return SurfaceState(self.name, temperature_K, self.boundary)


@dataclass(frozen=True)
class SceneSurfaces:
    """Map of the ground of a scene, and its classes."""

    provider: SurfaceProvider
    classes: tuple[SceneClass, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the classes."""
        return tuple(class_.name for class_ in self.classes)


def ground_of(scenario: Scenario, grid: Grid) -> Callable[[float, slice, slice], tuple[Array, Array]]:
    """Return a function of time, rows and columns of a grid over the image for latitude and longitude of its points."""
    place, speed = scenario.place, float(scenario.motion.platform_speed)

    def ground(time_s: float, rows: slice, columns: slice) -> tuple[Array, Array]:
        size = grid.pixel_size_m
        x, y = np.meshgrid(
            pixel_centres_m(columns.start, columns.stop - columns.start, grid.columns, size) + speed * time_s,
            pixel_centres_m(rows.start, rows.stop - rows.start, grid.rows, size),
        )
        return to_geographic(x, y, place.latitude, place.longitude)

    return ground


def build_surfaces(
    builder: Builder, scenario: Scenario, section: SurfaceSection, catalog: Catalog, around: Surroundings, grid: Grid
) -> SceneSurfaces:
    """Build the surface provider of a scenario, and the boundaries of its classes.

    Parameters
    ----------
    grid : Grid
        The image, in pixels.

    Raises
    ------
    CatalogError, ProviderError
        If the provider or a boundary cannot be built.
    """
    samples = scenario.image.samples_per_pixel
    points = Grid(grid.rows * samples, grid.columns * samples, grid.pixel_size_m / samples)
    air_K = float(around.profile.temperature_at(0.0))
    inputs = SurfaceInputs(points, ground_of(scenario, points), around.sea_temperature_K, air_K, catalog)
    provider: SurfaceProvider = builder.build(Kind.SURFACES, selected(section, "provider"), inputs, section.parameters)
    classes = []
    for class_ in provider.classes:
        boundary = class_.boundary
        if class_.name != SEA and boundary is None:
            boundary = material(class_.name, catalog)
        kelvin = class_.temperature_K
        if kelvin is None:
            kelvin = around.sea_temperature_K if class_.name == SEA else air_K
        low_K, high_K = kelvin if isinstance(kelvin, tuple) else (kelvin, kelvin)
        classes.append(SceneClass(class_.name, boundary, low_K, high_K))
    return SceneSurfaces(provider, tuple(classes))
