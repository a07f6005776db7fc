"""Default providers of this package, registered through the same hooks as plugins."""

from __future__ import annotations

from collections.abc import Sequence

from hcss_twin.providers.registry.specs import ProviderSpec, hookimpl

HCSS = "W. Sun et al., Complex Cloud-Sea Background Simulation for Space-Based Infrared Payload Digital Twin"


@hookimpl
def hcss_register_cloud_generators() -> Sequence[ProviderSpec]:
    """Return the cloud generators of this package."""
    return [
        ProviderSpec(
            name="fractal",
            target="hcss_twin.models.clouds.fractal.generator:FractalClouds",
            parameters="hcss_twin.models.clouds.fractal.parameters:FractalParameters",
            api_version=2,
            summary="fractal noise fields with drift, evolution and a chosen coverage",
            references=(HCSS,),
        ),
        ProviderSpec(
            name="imagery",
            target="hcss_twin.models.clouds.imagery.generator:ImageryClouds",
            parameters="hcss_twin.models.clouds.imagery.parameters:ImageryParameters",
            api_version=2,
            summary="cloud fields taken from an image",
        ),
        ProviderSpec(
            name="surrogate",
            target="hcss_twin.models.clouds.surrogate.generator:SurrogateClouds",
            parameters="hcss_twin.models.clouds.surrogate.parameters:SurrogateParameters",
            api_version=2,
            summary="evolving cloud fields with the amplitudes and the spectrum of an image",
            references=(
                "T. Schreiber and A. Schmitz, Improved Surrogate Data for Nonlinearity Tests, "
                "Phys. Rev. Lett. 77, 635 (1996)",
            ),
        ),
    ]


@hookimpl
def hcss_register_sea_models() -> Sequence[ProviderSpec]:
    """Return the sea models of this package."""
    return [
        ProviderSpec(
            name="cox-munk",
            target="hcss_twin.models.sea.cox_munk:CoxMunkSea",
            parameters="hcss_twin.models.parameters:CoxMunkParameters",
            api_version=2,
            summary="wind-roughened sea of Fresnel facets with Cox-Munk slopes",
            references=(
                "C. Cox and W. Munk, Measurement of the Roughness of the Sea Surface from Photographs of the "
                "Sun's Glitter, J. Opt. Soc. Am. 44, 838 (1954)",
            ),
        ),
        ProviderSpec(
            name="rough-sea",
            target="hcss_twin.models.sea.rough_sea:RoughSea",
            parameters="hcss_twin.models.parameters:RoughSeaParameters",
            api_version=2,
            summary="shadowed facets with a second reflection, sea water of any temperature and salinity, foam",
            references=(
                "C. Cox and W. Munk, J. Opt. Soc. Am. 44, 838 (1954)",
                "B. G. Smith, Geometrical Shadowing of a Random Rough Surface, IEEE Trans. Antennas Propag. 15, "
                "668 (1967)",
                "X. Wu and W. L. Smith, Emissivity of Rough Sea Surface for 8-13 um: Modeling and Verification, "
                "Appl. Opt. 36, 2609 (1997)",
            ),
        ),
    ]


@hookimpl
def hcss_register_optics() -> Sequence[ProviderSpec]:
    """Return the optics providers of this package."""
    return [
        ProviderSpec(
            name="mie",
            target="hcss_twin.models.optics.mie:MieOptics",
            parameters="hcss_twin.models.parameters:MieParameters",
            api_version=2,
            summary="Mie scattering of water or ice spheres with a modified gamma size distribution",
            references=(HCSS,),
        ),
        ProviderSpec(
            name="bulk",
            target="hcss_twin.models.optics.mie:BulkOptics",
            parameters="hcss_twin.models.parameters:BulkParameters",
            api_version=2,
            summary="Mie scattering of cold water droplets, bulk optics of rough crystals for ice",
            references=(
                "P. Yang et al., Spectrally Consistent Scattering, Absorption, and Polarization Properties of "
                "Atmospheric Ice Crystals at Wavelengths from 0.2 to 100 um, J. Atmos. Sci. 70, 330 (2013)",
                "T. C. Grenfell and S. G. Warren, Representation of a nonspherical ice particle by a collection of "
                "independent spheres for scattering and absorption of radiation, J. Geophys. Res. 104, 31697 (1999)",
                "P. M. Rowe, M. Fergoda and S. Neshyba, Temperature-Dependent Optical Properties of Liquid Water From "
                "240 to 298 K, J. Geophys. Res. Atmos. 125, e2020JD032624 (2020)",
            ),
        ),
    ]


@hookimpl
def hcss_register_transmittance_providers() -> Sequence[ProviderSpec]:
    """Return the transmittance providers of this package."""
    return [
        ProviderSpec(
            name="table",
            target="hcss_twin.models.atmosphere.table:TableTransmittance",
            parameters="hcss_twin.models.parameters:TableParameters",
            api_version=2,
            summary="tabulated spectral transmittance of a standard atmosphere",
        ),
        ProviderSpec(
            name="band-model",
            target="hcss_twin.models.atmosphere.band_model.provider:BandModelTransmittance",
            parameters="hcss_twin.models.parameters:BandModelParameters",
            api_version=2,
            summary="LOWTRAN7's molecular band model, continua and aerosol for any profile",
            references=(
                "F. X. Kneizys et al., Users Guide to LOWTRAN 7, AFGL-TR-88-0177 (1988)",
                "J. H. Pierluissi and C. E. Maragoudakis, Molecular Transmission Band Models for LOWTRAN, "
                "AFGL-TR-86-0272 (1986)",
            ),
        ),
    ]


@hookimpl
def hcss_register_radiance_models() -> Sequence[ProviderSpec]:
    """Return the radiance models of this package."""
    return [
        ProviderSpec(
            name="physical",
            target="hcss_twin.models.radiance.physical.model:Physical",
            parameters="hcss_twin.models.parameters:PhysicalParameters",
            api_version=2,
            summary="multiple scattering in clouds over a rough sea, whole composite paths, closed energy balance",
        ),
        ProviderSpec(
            name="physical-two-stream",
            target="hcss_twin.models.radiance.physical.model:PhysicalTwoStream",
            parameters="hcss_twin.models.parameters:PhysicalParameters",
            api_version=2,
            summary="as physical, clouds in closed form: faster; emissivity to 0.03, reflectance to 15 percent",
        ),
        ProviderSpec(
            name="as-printed",
            target="hcss_twin.models.radiance.as_printed:AsPrinted",
            parameters="hcss_twin.models.parameters:AsPrintedParameters",
            api_version=2,
            summary="thermal and solar terms of sea, cloud and air as in eqs 15-20 of the HCSS paper",
            references=(HCSS,),
        ),
    ]


@hookimpl
def hcss_register_elements() -> Sequence[ProviderSpec]:
    """Return the element providers of this package."""
    return [
        ProviderSpec(
            name="point-sources",
            target="hcss_twin.models.elements.point_sources:PointSources",
            parameters="hcss_twin.models.elements.parameters:PointSourceParameters",
            api_version=2,
            summary="moving sources smaller than a pixel, on tracks from the scenario or a CSV file",
        )
    ]


@hookimpl
def hcss_register_surfaces() -> Sequence[ProviderSpec]:
    """Return the surface providers of this package."""
    return [
        ProviderSpec(
            name="coast",
            target="hcss_twin.models.surfaces.coast:Coast",
            parameters="hcss_twin.models.surfaces.parameters:CoastParameters",
            api_version=2,
            summary="land and sea from the coastlines of Natural Earth (1:10 million)",
            references=("Natural Earth, Land, 1:10m physical vectors (public domain), naturalearthdata.com",),
        ),
        ProviderSpec(
            name="raster",
            target="hcss_twin.models.surfaces.raster:Raster",
            parameters="hcss_twin.models.surfaces.parameters:RasterParameters",
            api_version=2,
            summary="classes and temperature from a GeoTIFF or NetCDF file",
        ),
    ]


@hookimpl
def hcss_register_sensors() -> Sequence[ProviderSpec]:
    """Return the sensor models of this package."""
    return [
        ProviderSpec(
            name="radiometer",
            target="hcss_twin.models.sensor.radiometer:Radiometer",
            parameters="hcss_twin.models.sensor.parameters:RadiometerParameters",
            api_version=2,
            summary="blur, smear, noise of photons or of a given size, fixed pattern, saturation, quantisation",
            references=(
                "J. W. Goodman, Introduction to Fourier Optics (1968)",
                "R. D. Fiete, Modeling the Imaging Chain of Digital Cameras (2010)",
            ),
        )
    ]
