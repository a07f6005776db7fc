"""Global attributes of a cube that are not replaceable metadata: what each holds, and when it is there."""

from __future__ import annotations

from dataclasses import dataclass

from hcss_twin.cube.header import FORMAT_ATTRIBUTE, FORMAT_VERSION, SCENARIO_ATTRIBUTE

ALWAYS = "always"
_RADIANCE = "radiance is computed"
_CHECKED = "pixels are checked"


@dataclass(frozen=True)
class AttributeSpec:
    """One global attribute.

    Attributes
    ----------
    name : str
    type : str
        As it is stored: text, JSON (text), number or integer.
    when : str
        Cubes that have it.
    description : str
    """

    name: str
    type: str
    when: str
    description: str


PROVENANCE: tuple[AttributeSpec, ...] = (
    AttributeSpec(
        FORMAT_ATTRIBUTE, "integer", ALWAYS, f"{FORMAT_VERSION}; written last, so that a file that has it is finished."
    ),
    AttributeSpec(
        SCENARIO_ATTRIBUTE, "JSON", ALWAYS, "The scenario with every default filled in; it can be run again."
    ),
    AttributeSpec("hcss_seed", "text", ALWAYS, "The scenario's seed."),
    AttributeSpec("hcss_versions", "JSON", ALWAYS, "Versions of hcss-twin, Python and the libraries, by name."),
    AttributeSpec(
        "hcss_providers",
        "JSON",
        ALWAYS,
        "`name`, `distribution` and `version` of each provider by kind; clouds of several layers are numbered.",
    ),
    AttributeSpec(
        "hcss_files_sha256", "JSON", ALWAYS, "SHA-256 of each file read: by its name in the catalog, or its path."
    ),
    AttributeSpec("hcss_filled_in", "JSON", ALWAYS, "List of `field`, `value` and `why`: what the scenario left open."),
    AttributeSpec(
        "hcss_skipped",
        "JSON",
        ALWAYS,
        "List of `what`, `why` and `bound`: what the run did without, and how much radiance that could have carried, "
        "relative to that of the band ([left out](../how-to/trust.md)).",
    ),
    AttributeSpec(
        "hcss_notes", "JSON", ALWAYS, "List of what users should know about the providers, as they say themselves."
    ),
    AttributeSpec(
        "hcss_particles",
        "JSON",
        ALWAYS,
        "Of each cloud layer `name`, `phase`, `effective_radius_um`, `effective_variance`, `water_content_g_m3`, "
        "`number_density_m3` and `large_particle_extinction_m1`, from the lowest.",
    ),
    AttributeSpec(
        "hcss_significant_wave_height_m", "number", "the sea model knows it", "Significant height of the waves, m."
    ),
    AttributeSpec(
        "hcss_accuracy_requested", "number", _RADIANCE, "The error asked for, relative to the radiance of every band."
    ),
    AttributeSpec(
        "hcss_accuracy_requested_kelvin",
        "number",
        "`accuracy` is in kelvin",
        "The same in kelvin of the brightness temperature.",
    ),
    AttributeSpec(
        "hcss_table_error_estimated",
        "number",
        _RADIANCE,
        "Relative error of a pixel that the tables found while they were placed.",
    ),
    AttributeSpec(
        "hcss_table_errors",
        "JSON",
        _RADIANCE,
        "Share of each approximation, by name ([speed and error](../development/accuracy-and-speed.md)); 0 where "
        "nothing was approximated.",
    ),
    AttributeSpec("hcss_wavenumbers_used", "integer", _RADIANCE, "Weighted wavenumbers that were computed."),
    AttributeSpec("hcss_wavenumbers_known", "integer", _RADIANCE, "Wavenumbers of the whole grid that they stand for."),
    AttributeSpec(
        "hcss_certificate",
        "text",
        _CHECKED,
        "Whether random pixels that were computed again without tables keep the accuracy asked for, in words; begins "
        "with PASSED, FAILED or NOTHING CHECKED ([certificate](../how-to/trust.md)).",
    ),
    AttributeSpec(
        "hcss_accuracy_achieved",
        "JSON",
        _CHECKED,
        "Largest relative error of the checked pixels by band; null where it is no number.",
    ),
    AttributeSpec(
        "hcss_accuracy_achieved_kelvin",
        "JSON",
        "pixels are checked and `accuracy` is in kelvin",
        "The same of the brightness temperature, K.",
    ),
    AttributeSpec("hcss_certificate_pixels", "integer", _CHECKED, "Number of pixels checked."),
    AttributeSpec(
        "hcss_certificate_strata",
        "JSON",
        _CHECKED,
        "List with `name`, `pixels`, `checked`, `exceeding`, `error` (by band) and `left_out` (by reason) for each "
        "kind of pixel that the checked frames have.",
    ),
    AttributeSpec(
        "hcss_certificate_terms",
        "JSON",
        "pixels are checked and terms are requested",
        "Largest error of each term in any band, relative to the total of the band.",
    ),
)
"""What a cube says about how it was made and how far it can be trusted."""

COMPUTED: tuple[AttributeSpec, ...] = (
    AttributeSpec("Conventions", "text", ALWAYS, "CF and ACDD, with their versions."),
    AttributeSpec("date_created", "text", ALWAYS, "When the file was written; `SOURCE_DATE_EPOCH` fixes it."),
    AttributeSpec("time_coverage_start", "text", ALWAYS, "Time of the first frame."),
    AttributeSpec("time_coverage_end", "text", ALWAYS, "Time of the last frame."),
    AttributeSpec("time_coverage_duration", "text", ALWAYS, "From the first frame to the last (ISO 8601)."),
    AttributeSpec("time_coverage_resolution", "text", ALWAYS, "Mean time between frames (ISO 8601)."),
    AttributeSpec("geospatial_bounds", "text", ALWAYS, "Outline of all frames together, as a WKT polygon."),
    AttributeSpec("geospatial_bounds_crs", "text", ALWAYS, "Its coordinates: EPSG:4326, latitude first."),
    AttributeSpec("geospatial_bounds_vertical_crs", "text", ALWAYS, "EPSG:5714, height above the mean sea."),
    AttributeSpec("geospatial_lat_min", "number", ALWAYS, "Southernmost latitude of the outline."),
    AttributeSpec("geospatial_lat_max", "number", ALWAYS, "Northernmost latitude of the outline."),
    AttributeSpec("geospatial_lat_units", "text", ALWAYS, "degrees_north."),
    AttributeSpec("geospatial_lat_resolution", "text", ALWAYS, "Size of a pixel."),
    AttributeSpec("geospatial_lon_min", "number", ALWAYS, "Westernmost longitude of the outline."),
    AttributeSpec("geospatial_lon_max", "number", ALWAYS, "Easternmost longitude of the outline."),
    AttributeSpec("geospatial_lon_units", "text", ALWAYS, "degrees_east."),
    AttributeSpec("geospatial_lon_resolution", "text", ALWAYS, "Size of a pixel."),
    AttributeSpec("geospatial_vertical_min", "number", ALWAYS, "0: the plane of the pixels is the sea."),
    AttributeSpec("geospatial_vertical_max", "number", ALWAYS, "0."),
    AttributeSpec("geospatial_vertical_positive", "text", ALWAYS, "up."),
    AttributeSpec("geospatial_vertical_units", "text", ALWAYS, "m."),
)
"""Discovery metadata that follow from the scene."""
