"""The contract between providers and the engine, version 1.

Four kinds can be swapped by any installed package (cloud generators, sea models, optics,
transmittance providers), a fifth, the radiance model, assembles what they return, and a sixth,
the sensor, turns that into what is measured. A provider is a class that is called as
``Class(inputs, parameters)``: ``inputs`` is the dataclass of its kind, ``parameters`` an instance
of the parameter model its spec names, or None where it names none.

Each kind has a file: its inputs, a Protocol of what every provider must have (``SeaModel``),
and, where there is something, a Protocol of what one *may* have (``SeaModelOptions``). The
engine looks for the names of the latter one by one and does without those that are missing;
nobody inherits either. What is promised for version 1 is written in ``docs/provider-api.md``.

Principles:

* Providers return dimensionless or geometric properties; only the engine multiplies by
  Planck's function or the sun (a file that brings its own path radiance is the exception).
* A transmittance is asked for a *whole composite path*. Legs are summed, never multiplied,
  because band-model and k-distributed transmittances do not multiply.
* Providers declare what they depend on, so that the plan can skip. The engine of today uses the
  ranges, the native grid, ``tileable``, ``legs`` and ``notes``; the rest is for engines to come,
  and the conformance kit checks it already.
* Outside a declared range is an error, never a clamp.
* A result depends on the arguments of the call alone: not on what else is asked in it, on earlier
  calls, or on threads (several call one provider at once). Arrays given to a provider are read
  only; arrays it returns belong to the caller and are not written to again.

Axes: ``wavenumber_cm1`` (V,) ascending and last; altitudes above the sea in metres; angles
as cosines ``mu`` or radians. Azimuths are bearings from the surface point toward sensor or
sun, clockwise from north; ``relative_azimuth`` in [0, pi] is 0 with the sensor on the sun's
side and pi toward the glint. View zenith angles are those at the surface point.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hcss_twin.core.arrays import Array
    from hcss_twin.providers.atmosphere import AtmosphereInputs, TransmittanceOptions, TransmittanceProvider
    from hcss_twin.providers.clouds import (
        CloudGenerator,
        CloudGeneratorOptions,
        CloudInputs,
        CloudLayer,
        Grid,
        Microphysics,
        Motion,
    )
    from hcss_twin.providers.common import Declares
    from hcss_twin.providers.optics import Optics, OpticsInputs, SingleScattering
    from hcss_twin.providers.radiance import (
        RadianceInputs,
        RadianceModel,
        RadianceModelOptions,
        SolarIrradiance,
        Sun,
        View,
    )
    from hcss_twin.providers.sea import SeaInputs, SeaModel, SeaModelOptions, WaveShapes
    from hcss_twin.providers.sensor import Measured, Sensor, SensorBand, SensorInputs, SensorOptions

API_VERSION = 1
"""Version of the contract; what a spec states as its ``api_version``."""

__all__ = [
    "API_VERSION",
    "Array",
    "AtmosphereInputs",
    "CloudGenerator",
    "CloudGeneratorOptions",
    "CloudInputs",
    "CloudLayer",
    "Declares",
    "Grid",
    "Measured",
    "Microphysics",
    "Motion",
    "Optics",
    "OpticsInputs",
    "RadianceInputs",
    "RadianceModel",
    "RadianceModelOptions",
    "SeaInputs",
    "SeaModel",
    "SeaModelOptions",
    "Sensor",
    "SensorBand",
    "SensorInputs",
    "SensorOptions",
    "SingleScattering",
    "SolarIrradiance",
    "Sun",
    "TransmittanceOptions",
    "TransmittanceProvider",
    "View",
    "WaveShapes",
]

_PARTS = ("atmosphere", "clouds", "common", "optics", "radiance", "sea", "sensor")


def __getattr__(name: str) -> Any:
    """Import the contract at its first use: ``hcss plugins`` reads the registry below without numpy."""
    if name not in __all__:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    parts = ("core.arrays", *(f"providers.{kind}" for kind in _PARTS))
    for module in (import_module(f"hcss_twin.{part}") for part in parts):
        globals().update({each: getattr(module, each) for each in __all__ if hasattr(module, each)})
    return globals()[name]
