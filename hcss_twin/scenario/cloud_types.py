"""Cloud types: geometry, fractal parameters and particles, from a TOML file."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.models.optics.size_distribution import projected_area_m1
from hcss_twin.providers import CloudLayer
from hcss_twin.scenario.clouds import Layer
from hcss_twin.scenario.particles import TypeMicrophysics, layer_particles
from hcss_twin.scenario.problems import read_model
from hcss_twin.scenario.section_types import THINNEST_M, Material, ScenarioSection


@dataclass(frozen=True)
class PlaceLevels:
    """Altitudes of the air of a place, m: of condensation of air from the sea, melting, inversion, and tropopause."""

    condensation_m: float
    melting_m: float
    inversion_m: float
    tropopause_m: float


Level = Literal["condensation", "inversion", "tropopause"]


class TypeLayer(ScenarioSection):
    """``[layer]``: altitudes and thickness of clouds of this type, the same everywhere or by the air of the place."""

    material: Material = Field(description="What the particles are made of.")
    level: Level | None = Field(
        None,
        description="Level of the place's air that decides altitudes: the base lies at the condensation level, or the "
        "top at the inversion or tropopause; with `depth`, in place of `base` or `top`.",
    )
    offset: Quantity.Length = Field(0.0, ge=-10_000, le=10_000, description="Altitude above that level, m.")
    depth: Quantity.Length | None = Field(
        None,
        ge=THINNEST_M,
        le=20_000,
        description="Depth of the thickest cloud, m; its base is not below the condensation level under an inversion, "
        "and not below the melting level under the tropopause.",
    )
    base: Quantity.Length | None = Field(None, ge=0, le=20_000, description="Altitude of the cloud base, m.")
    top: Quantity.Length | None = Field(
        None, ge=THINNEST_M, le=20_000, description="Altitude of the highest cloud top, m."
    )
    anchor: Literal["base", "top"] = Field("base", description="Side of a thin cloud that stays at its altitude.")
    thickness_min: Quantity.Length = Field(
        ge=THINNEST_M, le=20_000, description="Thickness of the thinnest cloudy pixel, m."
    )

    @model_validator(mode="after")
    def _room(self) -> TypeLayer:
        if self.level is not None:
            if self.depth is None or self.base is not None or self.top is not None:
                raise PydanticCustomError("level", "level given; allowed: with depth, without base and top")
            depth = self.depth
        elif self.base is None or self.top is None or self.depth is not None:
            raise PydanticCustomError(
                "level", "no level given; allowed: base and top without depth, or level with depth"
            )
        else:
            depth = self.top - self.base
        if depth <= 0:
            raise PydanticCustomError("top", f"top {self.top:g} m is not above the base; allowed: above {self.base:g}")
        if self.thickness_min > depth:
            raise PydanticCustomError(
                "thickness_min",
                f"thickness_min {self.thickness_min:g} m exceeds top - base; allowed: up to {depth:g}; "
                f"closest valid choice is {depth:g}",
            )
        return self


_Cells = Annotated[Quantity.Number, Field(ge=1e-3, le=1e6)]
_Octave = Annotated[Quantity.Whole, Field(ge=0, le=16)]


class TypeFractal(ScenarioSection):
    """``[fractal]``: parameters of eqs 2-4 of the HCSS paper."""

    gamma: Quantity.Number = Field(ge=1.01, le=8, description="Gap parameter.")
    H: Quantity.Number = Field(gt=0, lt=1, description="Hurst parameter.")
    L: tuple[_Cells, _Cells] = Field(description="Cells per 16 km along x and y.")
    k: tuple[_Octave, _Octave] = Field(description="First and last octave.")
    brightness_exponent: Quantity.Number | None = Field(
        None, ge=0.05, le=20, description="Above 1 most of the cloud is thin; 1 by default."
    )

    @field_validator("k")
    @classmethod
    def _ascending(cls, value: tuple[int, int]) -> tuple[int, int]:
        first, last = value
        if first > last:
            raise PydanticCustomError(
                "k", f"[{first}, {last}] descends; allowed: first <= last; closest is [{last}, {first}]"
            )
        return value


class TypeSky(ScenarioSection):
    """``[[sky]]``: the generator of a package whose clouds look like measured ones, at some pixel sizes.

    Pixels of several points (`image.samples_per_pixel`) are as large as the distance of their points.
    """

    generator: str = Field(description="Name of the generator.")
    package: str = Field(description="Distribution that has it.")
    parameters: dict[str, Any] = Field(default_factory=dict, description="Its parameters.")
    coverage: Quantity.Fraction | None = Field(
        None, ge=0, le=1, description="Default coverage; without it, that of all types."
    )
    own_coverage: bool = Field(False, description="Its coverage cannot be chosen: layers that state one do not get it.")
    thickness_min: Quantity.Length | None = Field(
        None,
        ge=THINNEST_M,
        le=20_000,
        description="Default thickness of its thinnest cloudy pixel, m; that of `[layer]`.",
    )
    pixel_size_min: Quantity.Length = Field(
        0.0, ge=0, description="Smallest distance of points for which it is meant, m."
    )
    pixel_size_max: Quantity.Length = Field(
        math.inf, gt=0, description="Largest distance of points for which it is meant, m."
    )


_Thickness = Annotated[Quantity.Number, Field(ge=0)]


class PublishedThickness(ScenarioSection):
    """``[optical_thickness]``: what was measured of such clouds, in the visible."""

    published: tuple[_Thickness, _Thickness] = Field(description="Least and greatest of the published values.")
    of: Literal["mean", "median", "thickest"] = Field(description="What they are of.")
    source: str


class CloudType(ScenarioSection):
    """A complete cloud-type file."""

    title: str
    description: str
    source: str
    pixel_size_max: Quantity.Length | None = Field(
        None, gt=0, description="Largest pixel size for which `[fractal]` is meant, m; `hcss plan` warns beyond it."
    )
    layer: TypeLayer
    fractal: TypeFractal
    microphysics: TypeMicrophysics
    optical_thickness: PublishedThickness | None = None
    sky: tuple[TypeSky, ...] = Field(
        (), description="`[[sky]]`: generators that replace `[fractal]` where their packages are installed; the first "
        "that is meant for the pixel size."
    )  # fmt: skip

    def sky_of(self, pixel_size_m: float) -> TypeSky | None:
        """Return the generator that is meant for a pixel size, in place of the fractal one; None if none is."""
        for sky in self.sky:
            if sky.pixel_size_min <= pixel_size_m <= sky.pixel_size_max:
                return sky
        return None

    def visible_optical_thickness(self, of: Literal["mean", "median", "thickest"]) -> float:
        """Return the optical thickness of a cloudy column, in the limit of particles large beside the wavelength.

        Thickness is that of eqs 3 and 7 for a field whose values are evenly distributed, as they are by rank.
        """
        layer, exponent = self.layer, self.fractal.brightness_exponent or 1.0
        most = layer.depth if layer.depth is not None else (layer.top or 0.0) - (layer.base or 0.0)
        share = {"mean": 1.0 / (1.0 + exponent), "median": 0.5**exponent, "thickest": 1.0}[of]
        thickness_m = layer.thickness_min + (most - layer.thickness_min) * share
        return float(2.0 * projected_area_m1(self.microphysics.particles(layer.material)) * thickness_m)


@dataclass(frozen=True)
class ResolvedLayer:
    """A cloud layer with the type parameters that its generator may use."""

    layer: CloudLayer
    type_parameters: dict[str, Any]
    pixel_size_max_m: float | None = None
    level: Level | None = None


@dataclass(frozen=True)
class Extent:
    """Base and top altitude of a layer, m."""

    base: float
    top: float


@dataclass(frozen=True)
class LayerGeometry(Extent):
    """Altitudes and minimum thickness of a layer, m."""

    thickness_min: float


def load_cloud_type(name: str, catalog: Catalog) -> CloudType:
    """Read a cloud type by catalog name or from a user's TOML file.

    Raises
    ------
    CatalogError
        If there is no such file, or it is not TOML.
    ScenarioError
        If a key of the file is wrong; its ``origin`` is the file.
    """
    return read_model(CloudType, catalog, catalog.find(name, "cloud_types", ".toml"))


def extent_of(section: Layer, cloud_type: CloudType | None, levels: PlaceLevels | None) -> Extent | None:
    """Return a layer's altitudes, to the metre where they follow the place; None where they are not known.

    Those that the user gives go before those of the type, which may need the ``levels`` of the place.
    """
    base, top = section.base, section.top
    usual = None if cloud_type is None else cloud_type.layer
    if usual is not None and usual.level is None:
        base, top = usual.base if base is None else base, usual.top if top is None else top
    elif usual is not None and usual.depth is not None and levels is not None:
        level_m = float(round(getattr(levels, f"{usual.level}_m") + usual.offset))
        if usual.level == "condensation":
            base = level_m if base is None else base
            top = base + usual.depth if top is None else top
        top = level_m if top is None else top
        # The base of a deep layer does not lie where its water evaporates or its ice melts, if there is room.
        lowest = float(round(levels.condensation_m if usual.level == "inversion" else levels.melting_m))
        base = max(top - usual.depth, min(lowest, top - usual.thickness_min), 0.0) if base is None else base
    return None if base is None or top is None else Extent(base, top)


def layer_geometry(section: Layer, cloud_type: CloudType, field: str, levels: PlaceLevels) -> LayerGeometry:
    """Merge a layer's altitudes with those of its type at a place.

    Raises
    ------
    ScenarioError
        If no cloud fits between them; names the key that the user gave.
    """
    problems = list(altitude_problems(section, cloud_type, field, levels))
    if problems:
        raise ScenarioError(problems)
    usual = cloud_type.layer
    extent = extent_of(section, cloud_type, levels)
    assert extent is not None
    thinnest = usual.thickness_min if section.thickness_min is None else section.thickness_min
    return LayerGeometry(extent.base, extent.top, thinnest)


def altitude_problems(
    section: Layer, cloud_type: CloudType | None, field: str, levels: PlaceLevels | None = None
) -> Iterator[Problem]:
    """Yield a problem for altitudes between which no cloud fits.

    Without a type, or for a type whose altitudes follow the place without ``levels``, checks the section alone.
    """
    usual = cloud_type.layer if cloud_type is not None else None
    extent = extent_of(section, cloud_type, levels)
    if extent is None:
        return
    base, top = extent.base, extent.top
    depth = top - base
    if depth <= 0:
        of_type = f", that of type '{section.type}'"
        if section.top is None:
            key, message = "base", f"{base:g} m is not below the top; allowed: below {top:g}{of_type}"
        else:
            whose = of_type if section.base is None else ""
            key, message = "top", f"{top:g} m is not above the base; allowed: above {base:g}{whose}"
        yield Problem(f"{field}.{key}", message)
        return
    thinnest = usual.thickness_min if usual is not None and section.thickness_min is None else section.thickness_min
    if thinnest is not None and thinnest > depth:
        whose = f" (that of type '{section.type}')" if section.thickness_min is None else ""
        message = (
            f"{thinnest:g} m{whose} exceeds top - base; allowed: up to {depth:g}; closest valid choice is {depth:g}"
        )
        yield Problem(f"{field}.thickness_min", message)


def overlap_problems(layers: Mapping[str, tuple[Layer, Extent]]) -> Iterator[Problem]:
    """Yield a problem for each pair of overlapping layers.

    The problem is reported at the base of the upper layer, or at the top of the lower one if the user gave that.

    Parameters
    ----------
    layers : mapping of str to (Layer, Extent)
        Section and merged altitudes of each layer by field; layers may touch.
    """
    ascending = sorted(layers.items(), key=lambda layer: (layer[1][1].base, layer[1][1].top))
    for (lower, (low, below)), (upper, (high, above)) in pairwise(ascending):
        if below.top <= above.base:
            continue
        if low.top is not None and high.base is None:
            yield Problem(
                f"{lower}.top",
                f"{below.top:g} m lies above the base of {upper}, {above.base:g} m{_of_type(high)}; layers must not "
                f"overlap; allowed: up to {above.base:g}, or {upper}.base from {below.top:g}",
            )
        else:
            whose = "" if high.base is not None else _of_type(high)
            yield Problem(
                f"{upper}.base",
                f"{above.base:g} m{whose} lies below the top of {lower}, {below.top:g} m"
                f"{'' if low.top is not None else _of_type(low)}; layers must not overlap; "
                f"allowed: from {below.top:g}, or {lower}.top up to {above.base:g}",
            )


def _of_type(section: Layer) -> str:
    return f" (that of type '{section.type}')"


def resolve_layer(section: Layer, catalog: Catalog, field: str, levels: PlaceLevels) -> ResolvedLayer:
    """Merge a scenario's layer with its cloud type at a place; the climatology's temperature is left out.

    Raises
    ------
    CatalogError
        If there is no such type.
    ScenarioError
        If the type's file is malformed, or the particles or merged altitudes are inconsistent.
    """
    cloud_type = load_cloud_type(section.type, catalog)
    geometry = layer_geometry(section, cloud_type, field, levels)
    particles = layer_particles(section, cloud_type.microphysics, cloud_type.layer.material, field)
    layer = CloudLayer(
        name=section.type,
        base_m=geometry.base,
        top_m=geometry.top,
        anchor=section.anchor or cloud_type.layer.anchor,
        thickness_min_m=geometry.thickness_min,
        coverage=section.coverage,
        coverage_mode=section.coverage_mode or "frame",
        edge_taper=section.edge_taper,
        temperature_K=None if section.temperature == "climatology" else section.temperature,
        microphysics=particles,
    )
    return ResolvedLayer(
        layer, cloud_type.fractal.model_dump(exclude_none=True), cloud_type.pixel_size_max, cloud_type.layer.level
    )
