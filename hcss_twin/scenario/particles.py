"""Cloud particles: those of the cloud type, with changes by the scenario's layer."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from pydantic import Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.core.units import QuantityParser
from hcss_twin.providers import Microphysics
from hcss_twin.scenario.section_types import (
    LARGEST_UM,
    MAX_WATER_KG_M3,
    MIN_WATER_KG_M3,
    NARROWEST,
    SMALLEST_UM,
    WIDEST,
    ScenarioSection,
)

if TYPE_CHECKING:
    from hcss_twin.scenario.clouds import Layer


_BY_SHAPE = ("alpha", "b", "nu", "number_density", "radius_range_um")
_BY_SIZE = ("effective_radius_um", "effective_variance", "water_content_kg_m3")


class TypeMicrophysics(ScenarioSection):
    """``[microphysics]``: modified gamma distribution n(r) = a r^alpha exp(-b r^nu), r in um.

    Specified by shape parameters and number density, or as a gamma distribution (nu = 1) by effective radius,
    effective variance and mass per volume.
    """

    alpha: QuantityParser.Number | None = Field(None, ge=0, le=20, description="Exponent of the radius.")
    b: QuantityParser.Number | None = Field(None, ge=1e-6, le=1e6, description="Scale, um^-nu.")
    nu: QuantityParser.Number | None = Field(None, ge=0.1, le=10, description="Exponent in the exponential.")
    number_density: QuantityParser.Number | None = Field(None, gt=0, le=1e12, description="Particles per m3.")
    effective_radius_um: QuantityParser.Number | None = Field(
        None,
        ge=SMALLEST_UM,
        le=LARGEST_UM,
        description="Area-weighted mean radius, um; instead of alpha, b, nu, number_density.",
    )
    effective_variance: QuantityParser.Number | None = Field(
        None, ge=NARROWEST, le=WIDEST, description="Width of the area-weighted distribution; with effective_radius_um."
    )
    water_content_kg_m3: QuantityParser.Number | None = Field(
        None,
        ge=MIN_WATER_KG_M3,
        le=MAX_WATER_KG_M3,
        description="Mass of particles per volume, kg m-3; with effective_radius_um.",
    )
    density: QuantityParser.Number | None = Field(
        None, ge=1, le=30_000, description="Density of the material, kg m-3; needed unless it is water or ice."
    )
    radius_range_um: tuple[QuantityParser.Number, QuantityParser.Number] | None = Field(
        None, description="Limits of integration, um; by default, with effective_radius_um, 0.01 to 10 times it."
    )
    source: str = Field(description="Where the numbers come from.")

    @field_validator("radius_range_um")
    @classmethod
    def _ascending(cls, value: tuple[float, float] | None) -> tuple[float, float] | None:
        if value is not None and not 1e-6 <= value[0] < value[1] <= 1e6:
            low, high = value
            raise PydanticCustomError(
                "radius_range_um", f"[{low:g}, {high:g}] is not a range; allowed: 1e-6 <= smallest < largest <= 1e6"
            )
        return value

    @model_validator(mode="after")
    def _one_way(self) -> TypeMicrophysics:
        shape = [name for name in _BY_SHAPE[:4] if getattr(self, name) is not None]
        size = [name for name in _BY_SIZE if getattr(self, name) is not None]
        both = f"allowed: either {', '.join(_BY_SHAPE)}, or {', '.join(_BY_SIZE)}"
        if shape and size:
            raise PydanticCustomError("two_ways", f"{', '.join(shape)} given together with {', '.join(size)}; {both}")
        wanted = _BY_SIZE if size else _BY_SHAPE
        missing = [name for name in wanted if getattr(self, name) is None]
        if missing:
            raise PydanticCustomError("incomplete", f"{', '.join(missing)} missing; {both}")
        return self

    def particles(self, material: str) -> Microphysics:
        """Return the particles that these keys define.

        Raises
        ------
        ValueError
            If a given radius range changes the effective radius or variance noticeably, the density is unknown, or
            the mass per volume is out of range.
        """
        from hcss_twin.models.optics.size_distribution import density_kg_m3, gamma_distribution, water_content_kg_m3

        density_kg_m3(material, self.density)  # refused if unknown
        if self.effective_radius_um is not None:
            assert self.effective_variance is not None
            assert self.water_content_kg_m3 is not None
            return gamma_distribution(
                material,
                self.effective_radius_um,
                self.effective_variance,
                self.water_content_kg_m3,
                self.radius_range_um,
                self.density,
            )
        assert self.alpha is not None
        assert self.b is not None
        assert self.nu is not None
        assert self.number_density is not None
        assert self.radius_range_um is not None
        particles = Microphysics(
            material, self.alpha, self.b, self.nu, self.number_density, self.radius_range_um, self.density
        )
        content = water_content_kg_m3(particles)
        if not MIN_WATER_KG_M3 <= content <= MAX_WATER_KG_M3:
            raise ValueError(
                f"number_density {self.number_density:g} m-3 of these particles is a mass of {content:.3g} kg m-3; "
                f"allowed: {MIN_WATER_KG_M3:g} to {MAX_WATER_KG_M3:g}"
            )
        return particles


MICROPHYSICAL = ("material", "effective_radius", "effective_variance", "water_content")
"""Keys of a layer that change the particles of its type."""


def layer_particles(section: Layer, usual: TypeMicrophysics, material: str, field: str) -> Microphysics:
    """Merge a layer's microphysics with that of its type.

    A given radius or variance selects a gamma distribution,
    :func:`hcss_twin.models.optics.size_distribution.gamma_distribution`, over 0.01 to 10 effective radii; values
    missing in the layer come from the type, computed from its distribution if the type gives shape parameters and
    number density. A water content or a material alone keeps the type's distribution and changes the number
    density; a material alone keeps the mass per volume.

    Parameters
    ----------
    section : Layer
        The layer, with effective radius in um and water content in g m-3.
    usual : TypeMicrophysics
        Microphysics of the cloud type.
    material : str
        Material of the cloud type.
    field : str
        Path of the layer, for problems.

    Raises
    ------
    ScenarioError
        If the values are inconsistent; names the key that the user gave.
    """
    try:
        particles = usual.particles(material)
    except ValueError as error:
        raise ScenarioError([Problem(f"{field}.type", f"'{section.type}', microphysics: {error}")]) from error
    if all(getattr(section, key) is None for key in MICROPHYSICAL):
        return particles
    from hcss_twin.models.optics.size_distribution import (
        density_kg_m3,
        effective_radius_um,
        effective_variance,
        gamma_distribution,
        water_content_kg_m3,
    )

    radius, variance, content = usual.effective_radius_um, usual.effective_variance, usual.water_content_kg_m3
    # Use the stated value if there is one, because computed values are rounded.
    content = water_content_kg_m3(particles) if content is None else content
    content = content if section.water_content is None else section.water_content / 1000.0
    substance = section.material or material
    density = usual.density if substance == material else None
    try:
        density_kg_m3(substance, density)
    except ValueError as error:
        message = f"{error}; or a cloud type (TOML file) of this material, with its density"
        raise ScenarioError([Problem(f"{field}.material", message)]) from error
    if section.effective_radius is None and section.effective_variance is None:
        single = replace(particles, material=substance, density_kg_m3=density, number_density_m3=1.0)
        return replace(single, number_density_m3=content / water_content_kg_m3(single))
    radius = effective_radius_um(particles) if radius is None else radius
    variance = effective_variance(particles) if variance is None else variance
    if section.effective_variance is None and not NARROWEST <= variance <= WIDEST:
        message = (
            f"is missing; that of type '{section.type}', {variance:.3g}, is out of range with effective_radius; "
            f"allowed: >= {NARROWEST:g} and <= {WIDEST:g}; closest valid choice is "
            f"{min(max(variance, NARROWEST), WIDEST):g}"
        )
        raise ScenarioError([Problem(f"{field}.effective_variance", message)])
    return gamma_distribution(
        substance,
        radius if section.effective_radius is None else section.effective_radius,
        variance if section.effective_variance is None else section.effective_variance,
        content,
        density=density,
    )
