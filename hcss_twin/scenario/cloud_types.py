"""Cloud types: geometry, fractal parameters and particles, from a TOML file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from pydantic import Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from hcss_twin.catalog import Catalog
from hcss_twin.errors import Problem, ScenarioError
from hcss_twin.providers import CloudLayer, Microphysics
from hcss_twin.scenario.models import Layer, Section
from hcss_twin.scenario.problems import problems_from
from hcss_twin.scenario.units import Length


class TypeLayer(Section):
    """``[layer]``: where clouds of this type are."""

    phase: Literal["water", "ice"] = Field(description="Phase of the particles.")
    base: Length = Field(ge=0, le=20_000, description="Altitude of the cloud base, m.")
    top: Length = Field(gt=0, le=20_000, description="Altitude of the highest cloud top, m.")
    anchor: Literal["base", "top"] = Field(
        "base", description="Side of a thin cloud that stays at its altitude."
    )
    thickness_min: Length = Field(gt=0, le=20_000, description="Thickness of the thinnest cloudy pixel, m.")


class TypeFractal(Section):
    """``[fractal]``: parameters of eqs 2-4 of the HCSS paper."""

    gamma: float = Field(ge=1.01, le=8, description="Gap parameter.")
    H: float = Field(gt=0, lt=1, description="Hurst parameter.")
    L: tuple[float, float] = Field(description="Cells per 16 km along x and y.")
    k: tuple[int, int] = Field(description="First and last octave.")


class TypeMicrophysics(Section):
    """``[microphysics]``: modified gamma distribution n(r) = a r^alpha exp(-b r^nu), r in um."""

    alpha: float = Field(ge=0, le=20, description="Exponent of the radius.")
    b: float = Field(gt=0, description="Scale, um^-nu.")
    nu: float = Field(gt=0, le=10, description="Exponent in the exponential.")
    number_density: float = Field(gt=0, le=1e12, description="Particles per m3.")
    radius_range_um: tuple[float, float] = Field(description="Limits of integration, um.")
    source: str = Field(description="Where the numbers come from.")

    @model_validator(mode="after")
    def _ascending(self) -> TypeMicrophysics:
        low, high = self.radius_range_um
        if not 0 < low < high:
            raise PydanticCustomError(
                "radius_range_um", f"[{low:g}, {high:g}]: allowed 0 < shortest < longest"
            )
        return self


class CloudType(Section):
    """A whole cloud-type file."""

    title: str
    description: str
    source: str
    layer: TypeLayer
    fractal: TypeFractal
    microphysics: TypeMicrophysics


@dataclass(frozen=True)
class ResolvedLayer:
    """A cloud layer with the type parameters its generator may use."""

    layer: CloudLayer
    type_parameters: dict[str, Any]


def resolve_layer(section: Layer, catalog: Catalog, field: str) -> ResolvedLayer:
    """Merge a scenario's layer with its cloud type.

    Raises
    ------
    ScenarioError
        If the type's file is malformed or the merged geometry is impossible.
    """
    path = catalog.find(section.type, "cloud_types", ".toml")
    try:
        cloud_type = CloudType.model_validate(catalog.toml(path))
    except ValidationError as error:
        raise ScenarioError(problems_from(error, CloudType), str(path)) from error
    geometry = cloud_type.layer
    base = geometry.base if section.base is None else section.base
    top = geometry.top if section.top is None else section.top
    depth = top - base
    if depth <= 0:
        raise ScenarioError([Problem(f"{field}.top", f"{top:g} m is not above the base at {base:g} m")])
    thinnest = min(geometry.thickness_min, depth) if section.thickness_min is None else section.thickness_min
    if thinnest > depth:
        raise ScenarioError(
            [
                Problem(
                    f"{field}.thickness_min",
                    f"{thinnest:g} m exceeds top - base; allowed: up to {depth:g}; closest valid choice is {depth:g}",
                )
            ]
        )
    particles = cloud_type.microphysics
    layer = CloudLayer(
        name=section.type,
        base_m=base,
        top_m=top,
        anchor=section.anchor or geometry.anchor,
        thickness_min_m=thinnest,
        coverage=section.coverage,
        temperature_K=section.temperature,
        microphysics=Microphysics(
            phase=geometry.phase,
            alpha=particles.alpha,
            b=particles.b,
            nu=particles.nu,
            number_density_m3=particles.number_density,
            radius_range_um=particles.radius_range_um,
        ),
    )
    return ResolvedLayer(layer, cloud_type.fractal.model_dump())
