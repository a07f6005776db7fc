"""What authors of plugins import: the contract between providers and the engine, and what they can build on.

A provider is called as ``Class(inputs, parameters)``: ``inputs`` is the dataclass of its kind, ``parameters`` an
instance of the parameter model in its spec, or None without one. A class that has the parameter ``scene`` gets the
:class:`SceneInfo` of its scene in addition. Providers need not inherit from the Protocols.

Principles:

* Providers return dimensionless or geometric properties; only the engine multiplies by Planck's function or the sun.
  Data with their own path radiance, and elements, are exceptions.
* Transmittance is computed for a *whole composite path*. Absorber amounts of its legs are added; transmittances of legs
  are never multiplied, because those of band models and k-distributions do not multiply.
* Providers declare what they depend on and where they are valid, so that the plan can skip work; the conformance kit
  checks it. A call outside a declared range is an error; nothing is clamped or extrapolated.
* A result depends on the arguments of its call alone: not on other elements, earlier calls or threads (several call one
  provider at once). Arrays given to a provider are read-only; the caller owns returned arrays.

Axes: ``wavenumber_cm1`` (V,) ascending and last; altitudes above the sea in metres; angles as cosines ``mu`` or
radians. Azimuths are bearings from the surface point toward sensor or sun, clockwise from north; ``relative_azimuth``
in [0, pi] is 0 with the sensor on the sun's side and pi toward the glint. View zenith angles are at the surface point.
"""

from collections.abc import Mapping
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hcss_twin.core.arrays import Array
    from hcss_twin.core.catalog import Catalog
    from hcss_twin.core.commands import CommandSpec, hookimpl
    from hcss_twin.core.errors import (
        CatalogError,
        CubeError,
        HcssError,
        ImageError,
        Problem,
        ProviderError,
        ScenarioError,
        choose_from,
    )
    from hcss_twin.core.netcdf import NetcdfFile
    from hcss_twin.core.sections import SectionSpec
    from hcss_twin.physics.geometry import relative_azimuth_rad, scattering_cosine, wind_azimuths
    from hcss_twin.physics.paths import SPACE, Leg, Path, to_space
    from hcss_twin.physics.planck import planck, wavenumber_from_um
    from hcss_twin.physics.profile import EARTH_RADIUS_M, GASES, Profile, local_zenith_deg, slant_length_m
    from hcss_twin.providers.atmosphere import (
        AtmosphereDeclaration,
        AtmosphereInputs,
        TransmittanceOptions,
        TransmittanceProvider,
    )
    from hcss_twin.providers.clouds import (
        BrightnessInversion,
        CloudDeclaration,
        CloudGenerator,
        CloudGeneratorOptions,
        CloudInputs,
        CloudLayer,
        Grid,
        Microphysics,
        Motion,
    )
    from hcss_twin.providers.column_states import (
        ColumnGroup,
        ColumnSetting,
        ColumnStates,
        Sun,
        View,
        clear_column,
        cloudy_columns,
    )
    from hcss_twin.providers.common import DEPENDENCIES, MEASURED, RANGES
    from hcss_twin.providers.declarations import Declaration, ModelError, ProviderOptions
    from hcss_twin.providers.elements import (
        ElementInputs,
        ElementPixels,
        ElementPoint,
        ElementProvider,
        ElementScene,
        SightPath,
    )
    from hcss_twin.providers.optics import Optics, OpticsDeclaration, OpticsInputs, SingleScattering
    from hcss_twin.providers.radiance import (
        RadianceDeclaration,
        RadianceInputs,
        RadianceModel,
        RadianceModelOptions,
        SolarIrradiance,
    )
    from hcss_twin.providers.registry.specs import API_VERSION, Kind, ProviderSpec
    from hcss_twin.providers.scene import SceneInfo
    from hcss_twin.providers.sea import SeaDeclaration, SeaInputs, SeaModel, SeaModelOptions, WaveShapes
    from hcss_twin.providers.sensor import (
        Measured,
        Points,
        Sensor,
        SensorBand,
        SensorDeclaration,
        SensorInputs,
        SensorOptions,
    )
    from hcss_twin.providers.surfaces import SurfaceClass, SurfaceInputs, SurfaceMap, SurfaceProvider
    from hcss_twin.providers.variables import OutputVariable, VariableInputs, VariableProvider

__all__ = [
    "API_VERSION",
    "DEPENDENCIES",
    "EARTH_RADIUS_M",
    "GASES",
    "MEASURED",
    "RANGES",
    "SPACE",
    "Array",
    "AtmosphereDeclaration",
    "AtmosphereInputs",
    "BrightnessInversion",
    "Catalog",
    "CatalogError",
    "CloudDeclaration",
    "CloudGenerator",
    "CloudGeneratorOptions",
    "CloudInputs",
    "CloudLayer",
    "ColumnGroup",
    "ColumnSetting",
    "ColumnStates",
    "CommandSpec",
    "CubeError",
    "Declaration",
    "ElementInputs",
    "ElementPixels",
    "ElementPoint",
    "ElementProvider",
    "ElementScene",
    "Grid",
    "HcssError",
    "ImageError",
    "Kind",
    "Leg",
    "Measured",
    "Microphysics",
    "ModelError",
    "Motion",
    "NetcdfFile",
    "Optics",
    "OpticsDeclaration",
    "OpticsInputs",
    "OutputVariable",
    "Path",
    "PointEffect",
    "Points",
    "Problem",
    "Profile",
    "ProviderError",
    "ProviderOptions",
    "ProviderSpec",
    "RadianceDeclaration",
    "RadianceInputs",
    "RadianceModel",
    "RadianceModelOptions",
    "ScenarioError",
    "SceneInfo",
    "SeaDeclaration",
    "SeaInputs",
    "SeaModel",
    "SeaModelOptions",
    "SectionSpec",
    "Sensor",
    "SensorBand",
    "SensorDeclaration",
    "SensorInputs",
    "SensorOptions",
    "SightPath",
    "SingleScattering",
    "SolarIrradiance",
    "Sun",
    "SurfaceClass",
    "SurfaceInputs",
    "SurfaceMap",
    "SurfaceProvider",
    "TransmittanceOptions",
    "TransmittanceProvider",
    "VariableInputs",
    "VariableProvider",
    "View",
    "WaveShapes",
    "choose_from",
    "clear_column",
    "cloudy_columns",
    "hookimpl",
    "local_zenith_deg",
    "planck",
    "relative_azimuth_rad",
    "scattering_cosine",
    "slant_length_m",
    "to_space",
    "wavenumber_from_um",
    "wind_azimuths",
]

HOMES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "providers.declarations": ("Declaration", "ModelError", "ProviderOptions"),
        "providers.clouds": (
            "BrightnessInversion",
            "CloudDeclaration",
            "CloudGenerator",
            "CloudGeneratorOptions",
            "CloudInputs",
            "CloudLayer",
            "Grid",
            "Microphysics",
            "Motion",
        ),
        "providers.sea": ("SeaDeclaration", "SeaInputs", "SeaModel", "SeaModelOptions", "WaveShapes"),
        "providers.optics": ("Optics", "OpticsDeclaration", "OpticsInputs", "SingleScattering"),
        "providers.atmosphere": (
            "AtmosphereDeclaration",
            "AtmosphereInputs",
            "TransmittanceOptions",
            "TransmittanceProvider",
        ),
        "providers.radiance": (
            "RadianceDeclaration",
            "RadianceInputs",
            "RadianceModel",
            "RadianceModelOptions",
            "SolarIrradiance",
        ),
        "providers.column_states": (
            "ColumnGroup",
            "ColumnSetting",
            "ColumnStates",
            "Sun",
            "View",
            "clear_column",
            "cloudy_columns",
        ),
        "providers.elements": (
            "ElementInputs",
            "ElementPixels",
            "ElementPoint",
            "ElementProvider",
            "ElementScene",
            "SightPath",
        ),
        "providers.surfaces": ("SurfaceClass", "SurfaceInputs", "SurfaceMap", "SurfaceProvider"),
        "providers.effects": ("PointEffect",),
        "providers.scene": ("SceneInfo",),
        "providers.variables": ("OutputVariable", "VariableInputs", "VariableProvider"),
        "providers.sensor": (
            "Measured",
            "Points",
            "Sensor",
            "SensorBand",
            "SensorDeclaration",
            "SensorInputs",
            "SensorOptions",
        ),
        "providers.common": ("DEPENDENCIES", "MEASURED", "RANGES"),
        "providers.registry.specs": ("API_VERSION", "Kind", "ProviderSpec"),
        "core.arrays": ("Array",),
        "core.catalog": ("Catalog",),
        "core.commands": ("CommandSpec", "hookimpl"),
        "core.sections": ("SectionSpec",),
        "core.errors": (
            "CatalogError",
            "CubeError",
            "HcssError",
            "ImageError",
            "Problem",
            "ProviderError",
            "ScenarioError",
            "choose_from",
        ),
        "core.netcdf": ("NetcdfFile",),
        "physics.geometry": ("relative_azimuth_rad", "scattering_cosine", "wind_azimuths"),
        "physics.paths": ("SPACE", "Leg", "Path", "to_space"),
        "physics.planck": ("planck", "wavenumber_from_um"),
        "physics.profile": ("EARTH_RADIUS_M", "GASES", "Profile", "local_zenith_deg", "slant_length_m"),
    }
)
"""Modules of ``hcss_twin`` that define the names, in the order of the provider reference."""


def __getattr__(name: str) -> Any:
    """Import a name on first use, so that ``hcss plugins`` can list providers without numpy."""
    for module, names in HOMES.items():
        if name in names:
            globals()[name] = getattr(import_module(f"hcss_twin.{module}"), name)
            return globals()[name]
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
