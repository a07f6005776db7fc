"""The contract between providers and the engine, version 2.

Any installed package can provide cloud generators, sea models, optics and transmittance providers; radiance models,
which combine their results; elements, which are other things in the scene; surfaces, which are maps of sea and land;
variables, which are derived from radiance, truth and geometry; and sensors, which convert radiance to measurements. A
provider is a class that is called as ``Class(inputs, parameters)``: ``inputs`` is the dataclass of its kind,
``parameters`` an instance of the parameter model in its spec, or None without one.

For each kind there are its inputs, a Protocol of what every provider must have (``SeaModel``) and possibly a Protocol
of optional members (``SeaModelOptions``), which the engine looks up one by one. Providers need not inherit from them.

Principles:

* Providers return dimensionless or geometric properties; only the engine multiplies by Planck's function or the sun.
  Data with their own path radiance, and elements, are exceptions.
* Transmittance is computed for a *whole composite path*. Absorber amounts of its legs are added; transmittances of legs
  are never multiplied, because those of band models and k-distributions do not multiply.
* Providers declare dependencies, so that the plan can skip work. This engine uses the ranges, the native grid,
  ``tileable``, ``legs`` and ``notes``; the conformance kit checks all of them.
* A call outside a declared range is an error; nothing is clamped or extrapolated.
* A result depends on the arguments of its call alone: not on other elements, earlier calls or threads (several call one
  provider at once). Arrays given to a provider are read-only; the caller owns returned arrays.

Axes: ``wavenumber_cm1`` (V,) ascending and last; altitudes above the sea in metres; angles as cosines ``mu`` or
radians. Azimuths are bearings from the surface point toward sensor or sun, clockwise from north; ``relative_azimuth``
in [0, pi] is 0 with the sensor on the sun's side and pi toward the glint. View zenith angles are at the surface point.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hcss_twin.core.arrays import Array
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
        Sun,
        View,
    )
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

API_VERSION = 2
"""Version of the contract, as in the ``api_version`` of a spec."""

__all__ = [
    "API_VERSION",
    "Array",
    "AtmosphereDeclaration",
    "AtmosphereInputs",
    "BrightnessInversion",
    "CloudDeclaration",
    "CloudGenerator",
    "CloudGeneratorOptions",
    "CloudInputs",
    "CloudLayer",
    "Declaration",
    "ElementInputs",
    "ElementPixels",
    "ElementPoint",
    "ElementProvider",
    "ElementScene",
    "Grid",
    "Measured",
    "Microphysics",
    "ModelError",
    "Motion",
    "Optics",
    "OpticsDeclaration",
    "OpticsInputs",
    "OutputVariable",
    "Points",
    "ProviderOptions",
    "RadianceDeclaration",
    "RadianceInputs",
    "RadianceModel",
    "RadianceModelOptions",
    "SeaDeclaration",
    "SeaInputs",
    "SeaModel",
    "SeaModelOptions",
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
]

_PARTS = (
    "atmosphere",
    "clouds",
    "declarations",
    "elements",
    "optics",
    "radiance",
    "sea",
    "sensor",
    "surfaces",
    "variables",
)


def __getattr__(name: str) -> Any:
    """Import the contract on first use, so that ``hcss plugins`` can list providers without numpy."""
    if name == "Declares":  # of version 1
        from hcss_twin.providers.registry.version_1 import Declares

        return Declares
    if name not in __all__:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    parts = ("core.arrays", *(f"providers.{kind}" for kind in _PARTS))
    for module in (import_module(f"hcss_twin.{part}") for part in parts):
        globals().update({each: getattr(module, each) for each in __all__ if hasattr(module, each)})
    return globals()[name]
