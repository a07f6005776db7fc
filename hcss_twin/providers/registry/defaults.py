"""Default providers of this package, registered through the same hooks as plugins."""

from __future__ import annotations

from collections.abc import Sequence

from hcss_twin.providers.registry.specs import API_VERSION, ProviderSpec, hookimpl

HCSS = "W. Sun et al., Complex Cloud-Sea Background Simulation for Space-Based Infrared Payload Digital Twin"


def _own(name: str, target: str, parameters: str, summary: str, *references: str) -> ProviderSpec:
    """Return the spec of a provider in :mod:`hcss_twin.models`."""
    models = "hcss_twin.models"
    return ProviderSpec(name, f"{models}.{target}", f"{models}.{parameters}", API_VERSION, summary, references)


@hookimpl
def hcss_register_cloud_generators() -> Sequence[ProviderSpec]:
    """Return the cloud generators of this package."""
    return [
        _own("fractal", "clouds.fractal.generator:FractalClouds", "clouds.fractal.parameters:FractalParameters",
             "fractal noise fields with drift, evolution and a chosen coverage", HCSS),
        _own("imagery", "clouds.imagery.generator:ImageryClouds", "clouds.imagery.parameters:ImageryParameters",
             "cloud fields taken from an image"),
    ]  # fmt: skip


@hookimpl
def hcss_register_sea_models() -> Sequence[ProviderSpec]:
    """Return the sea models of this package."""
    return [
        _own("cox-munk", "sea.cox_munk:CoxMunkSea", "parameters:CoxMunkParameters",
             "wind-roughened sea of Fresnel facets with Cox-Munk slopes",
             "C. Cox and W. Munk, Measurement of the Roughness of the Sea Surface from Photographs of the Sun's "
             "Glitter, J. Opt. Soc. Am. 44, 838 (1954)"),
        _own("rough-sea", "sea.rough_sea:RoughSea", "parameters:RoughSeaParameters",
             "shadowed facets with a second reflection, sea water of any temperature and salinity, foam",
             "C. Cox and W. Munk, J. Opt. Soc. Am. 44, 838 (1954)",
             "B. G. Smith, Geometrical Shadowing of a Random Rough Surface, IEEE Trans. Antennas Propag. 15, 668 "
             "(1967)",
             "X. Wu and W. L. Smith, Emissivity of Rough Sea Surface for 8-13 um: Modeling and Verification, Appl. "
             "Opt. 36, 2609 (1997)"),
    ]  # fmt: skip


@hookimpl
def hcss_register_optics() -> Sequence[ProviderSpec]:
    """Return the optics providers of this package."""
    return [
        _own("mie", "optics.mie:MieOptics", "parameters:MieParameters",
             "Mie scattering of water or ice spheres with a modified gamma size distribution", HCSS),
        _own("bulk", "optics.mie:BulkOptics", "parameters:BulkParameters",
             "Mie scattering of cold water droplets, bulk optics of rough crystals for ice",
             "P. Yang et al., Spectrally Consistent Scattering, Absorption, and Polarization Properties of "
             "Atmospheric Ice Crystals at Wavelengths from 0.2 to 100 um, J. Atmos. Sci. 70, 330 (2013)",
             "T. C. Grenfell and S. G. Warren, Representation of a nonspherical ice particle by a collection of "
             "independent spheres for scattering and absorption of radiation, J. Geophys. Res. 104, 31697 (1999)",
             "P. M. Rowe, M. Fergoda and S. Neshyba, Temperature-Dependent Optical Properties of Liquid Water From "
             "240 to 298 K, J. Geophys. Res. Atmos. 125, e2020JD032624 (2020)"),
    ]  # fmt: skip


@hookimpl
def hcss_register_transmittance_providers() -> Sequence[ProviderSpec]:
    """Return the transmittance providers of this package."""
    return [
        _own("table", "atmosphere.table:TableTransmittance", "parameters:TableParameters",
             "tabulated spectral transmittance of a standard atmosphere"),
        _own("band-model", "atmosphere.band_model.provider:BandModelTransmittance", "parameters:BandModelParameters",
             "LOWTRAN7's molecular band model, continua and aerosol for any profile",
             "F. X. Kneizys et al., Users Guide to LOWTRAN 7, AFGL-TR-88-0177 (1988)",
             "J. H. Pierluissi and C. E. Maragoudakis, Molecular Transmission Band Models for LOWTRAN, "
             "AFGL-TR-86-0272 (1986)"),
    ]  # fmt: skip


@hookimpl
def hcss_register_radiance_models() -> Sequence[ProviderSpec]:
    """Return the radiance models of this package."""
    return [
        _own("physical", "radiance.physical.model:Physical", "parameters:PhysicalParameters",
             "multiple scattering in clouds over a rough sea, whole composite paths, closed energy balance"),
        _own("physical-two-stream", "radiance.physical.model:PhysicalTwoStream", "parameters:PhysicalParameters",
             "as physical, clouds in closed form: faster; emissivity to 0.03, reflectance to 15 percent"),
        _own("as-printed", "radiance.as_printed:AsPrinted", "parameters:AsPrintedParameters",
             "thermal and solar terms of sea, cloud and air as in eqs 15-20 of the HCSS paper", HCSS),
    ]  # fmt: skip


@hookimpl
def hcss_register_elements() -> Sequence[ProviderSpec]:
    """Return the element providers of this package."""
    return [
        _own("point-sources", "elements.point_sources:PointSources", "elements.parameters:PointSourceParameters",
             "moving sources smaller than a pixel, on tracks from the scenario or a CSV file"),
    ]  # fmt: skip


@hookimpl
def hcss_register_surfaces() -> Sequence[ProviderSpec]:
    """Return the surface providers of this package."""
    return [
        _own("coast", "surfaces.coastline:Coast", "surfaces.parameters:CoastParameters",
             "land and sea from the coastlines of Natural Earth (1:10 million)",
             "Natural Earth, Land, 1:10m physical vectors (public domain), naturalearthdata.com"),
        _own("raster", "surfaces.raster:Raster", "surfaces.parameters:RasterParameters",
             "classes and temperature from a GeoTIFF or NetCDF file"),
    ]  # fmt: skip


@hookimpl
def hcss_register_sensors() -> Sequence[ProviderSpec]:
    """Return the sensor models of this package."""
    return [
        _own("radiometer", "sensor.radiometer:Radiometer", "sensor.parameters:RadiometerParameters",
             "blur, smear, noise of photons or of a given size, fixed pattern, saturation, quantisation",
             "J. W. Goodman, Introduction to Fourier Optics (1968)",
             "R. D. Fiete, Modeling the Imaging Chain of Digital Cameras (2010)"),
    ]  # fmt: skip
