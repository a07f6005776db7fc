"""Global attributes of a cube: CF, the Attribute Convention for Data Discovery 1.3, and provenance.

The tables define the meaning of each attribute and when it is written; the functions compute the values.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from hcss_twin.core.errors import CubeError
from hcss_twin.cube.geometry import Footprint, footprint
from hcss_twin.cube.header import FORMAT_ATTRIBUTE, FORMAT_VERSION, SCENARIO_ATTRIBUTE, Attribute, CubeHeader

AS_SPECIFIED, NOT_AS_SPECIFIED, NOT_CHECKED = "computed as specified", "NOT as specified", "NOT CHECKED"
"""First words of the certificate."""

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
        Type in the file: text, JSON (text), number or integer.
    when : str
        Condition under which a cube has it.
    description : str
    """

    name: str
    type: str
    when: str
    description: str


PROVENANCE: tuple[AttributeSpec, ...] = (
    AttributeSpec(FORMAT_ATTRIBUTE, "integer", ALWAYS,
        f"{FORMAT_VERSION}; written last, as the mark of a finished file."),
    AttributeSpec(SCENARIO_ATTRIBUTE, "JSON", ALWAYS, "The scenario with all defaults; it can be run again."),
    AttributeSpec("hcss_seed", "text", ALWAYS, "The scenario's seed."),
    AttributeSpec("hcss_versions", "JSON", ALWAYS, "Versions of hcss-twin, Python and libraries."),
    AttributeSpec("hcss_providers", "JSON", ALWAYS, "`name`, `distribution` and `version` of each provider, by kind."),
    AttributeSpec("hcss_provider_laws", "JSON", "a provider is of another package",
        "Laws of the conformance kit by outcome: `probes`, tried before the first frame, and the last `hcss check` of "
        "the same version and parameters, or \"not checked\"."),
    AttributeSpec("hcss_files_sha256", "JSON", ALWAYS, "SHA-256 of each file read, by catalog name, path "
        "from the scenario's folder (`./x.csv`) or the package of a plugin (`package:my_plugin/x.nc`), or absolute "
        "path."),
    AttributeSpec("hcss_input_files", "JSON", "files of the user are read, with `output.store_inputs`",
        "Those of at most 256 kB by SHA-256: compressed (zlib), in base64."),
    AttributeSpec("hcss_filled_in", "JSON", ALWAYS,
        "Values that the scenario left open: list of `field`, `value` and `why`."),
    AttributeSpec("hcss_skipped", "JSON", ALWAYS,
        "Omitted physics: list of `what`, `why`, `bound` (largest effect relative to the band radiance), `estimate` "
        "(typical effect, in the `sense` given) and `needs` (keys that would compute it)."),
    AttributeSpec("hcss_notes", "JSON", ALWAYS, "Notes of the providers for users."),
    AttributeSpec("hcss_light", "JSON", "clouds have sides", "`radiance.light`: `name`, `provider`, `expected_rms`."),
    AttributeSpec("hcss_particles", "JSON", ALWAYS,
        "`name`, `material`, `effective_radius_um`, `effective_variance`, `water_content_g_m3`, `number_density_m3` "
        "and `large_particle_extinction_m1` of each cloud layer, from the lowest."),
    AttributeSpec("hcss_significant_wave_height_m", "number", "the sea model knows it",
        "Significant height of the waves, m."),
    AttributeSpec("hcss_accuracy_requested", "number", _RADIANCE,
        "Requested error relative to the radiance of each band."),
    AttributeSpec("hcss_accuracy_requested_kelvin", "number", "`accuracy` is in kelvin",
        "Requested error in kelvin of brightness temperature."),
    AttributeSpec("hcss_table_error_estimated", "number", _RADIANCE,
        "Relative error of a pixel, estimated while the tables were built."),
    AttributeSpec("hcss_table_errors", "JSON", _RADIANCE, "Share of each approximation in that error, by name."),
    AttributeSpec("hcss_wavenumbers_used", "integer", _RADIANCE, "Weighted wavenumbers computed."),
    AttributeSpec("hcss_wavenumbers_known", "integer", _RADIANCE, "Wavenumbers of the full grid that they represent."),
    AttributeSpec("hcss_certificate", "text", _CHECKED,
        "Begins with `computed as specified`, `NOT as specified` or `NOT CHECKED`; then the largest error in per cent "
        "and kelvin."),
    AttributeSpec("hcss_accuracy_achieved", "JSON", _CHECKED,
        "Largest relative error of the checked pixels by band; null: undefined."),
    AttributeSpec("hcss_accuracy_achieved_kelvin", "JSON", "pixels are checked and `accuracy` is in kelvin",
        "The same in kelvin of brightness temperature."),
    AttributeSpec("hcss_certificate_pixels", "integer", _CHECKED, "Number of pixels checked."),
    AttributeSpec("hcss_certificate_strata", "JSON", _CHECKED,
        "List of `name`, `pixels`, `checked`, `exceeding`, `error` (by band) and `left_out` (by reason) of each kind "
        "of pixel."),
    AttributeSpec("hcss_certificate_terms", "JSON", "pixels are checked and terms are requested",
        "Largest error of each term in any band, relative to the band radiance."),
    AttributeSpec("hcss_beyond_accuracy", "JSON", _CHECKED,
        "Physics that the scene needs beyond its share of the accuracy and cannot have: texts with size and the keys "
        "that would compute it."),
    AttributeSpec("hcss_left_out", "JSON", _CHECKED,
        "The same of physics that the user switched off, that takes too long, or that comes on request."),
    AttributeSpec("hcss_error_budget", "JSON", _CHECKED,
        "The total error, models included, by class (`clear`, layers) and band: `total` and `total_K`, or "
        "`at_least` and `at_least_K` if a part is unknown, `unknown` and "
        "`contributions` with `name`, `relative`, `kelvin`, `known` (share of the band with a figure), `statistic`, "
        "`sources`, `recomputed` (false: a figure of notes) and `needs`."),
    AttributeSpec("hcss_monte_carlo", "JSON", "pixels are checked and clouds have sides",
        "Random pixels against Monte Carlo: `pixels`; `bands` with `bias`, `rms` (without noise) and `noise`."),
)  # fmt: skip
"""Provenance of a cube, and its accuracy."""

COMPUTED: tuple[AttributeSpec, ...] = (
    AttributeSpec("Conventions", "text", ALWAYS, "CF and ACDD, with their versions."),
    AttributeSpec("date_created", "text", ALWAYS, "Time of writing; `SOURCE_DATE_EPOCH` fixes it."),
    AttributeSpec("time_coverage_start", "text", ALWAYS, "Time of the first frame."),
    AttributeSpec("time_coverage_end", "text", ALWAYS, "Time of the last frame."),
    AttributeSpec("time_coverage_duration", "text", ALWAYS, "First to last frame (ISO 8601)."),
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
"""Discovery metadata derived from the scene."""


UNKNOWN = "unknown"

DEFAULTS: Mapping[str, str] = {
    "title": "Simulated infrared image sequence of clouds over sea, seen from space",
    "summary": "Band-integrated radiance at a space-based infrared sensor, simulated frame by frame for "
    "clouds over sea, without effects of optics or detector, and the state of the scene it was made from.",
    "keywords": "infrared radiance, clouds, sea surface, remote sensing, simulation, scene model",
    "naming_authority": UNKNOWN,
    "source": "hcss_twin: model of radiance from clouds, sea and atmosphere",
    "processing_level": "simulated radiance at the sensor, without instrument effects",
    "comment": "Simulated, not observed. x and y are relative to the centre of each frame.",
    "acknowledgement": "Model after W. Sun et al., Complex Cloud-Sea Background Simulation for Space-Based "
    "Infrared Payload Digital Twin",
    "references": "W. Sun et al., Complex Cloud-Sea Background Simulation for Space-Based Infrared Payload "
    "Digital Twin",
    "license": "Not stated by the creator of this file",
    "standard_name_vocabulary": "CF Standard Name Table v93",
    "institution": UNKNOWN,
    "project": UNKNOWN,
    **{f"{role}_{key}": UNKNOWN for role in ("creator", "publisher") for key in ("name", "email", "url")},
    "platform": "simulated satellite",
    "instrument": "simulated infrared imager",
}
"""Attributes that the caller may replace."""

_COMPUTED_PREFIXES = ("geospatial_", "time_coverage_")
_COMPUTED = frozenset({"Conventions", "date_created", FORMAT_ATTRIBUTE})


def global_attributes(header: CubeHeader) -> dict[str, Attribute]:
    """Return all global attributes except the mark of a finished cube.

    Raises
    ------
    CubeError
        If the caller's attributes contain a computed one, or SOURCE_DATE_EPOCH is not an integer.
    """
    for name in header.attributes:
        if name in _COMPUTED or name.startswith(_COMPUTED_PREFIXES):
            raise CubeError(f"attribute {name}: computed from the cube; it cannot be given")
    created = creation_time()
    stamp = _iso(created)
    # Attributes of quantization are new in 1.12.
    version = "1.12" if any(spec.significant_bits is not None for spec in header.variables) else "1.11"
    return {
        "Conventions": f"CF-{version}, ACDD-1.3",
        **DEFAULTS,
        "id": _identifier(header),
        "history": f"{stamp} created by hcss_twin",
        "date_created": stamp,
        **_coverage_in_time(header),
        **_coverage_in_space(header, footprint(header)),
        **header.attributes,
        **window_attribute(header),
    }


def creation_time() -> datetime:
    """Return the current time, or the time set by the environment variable SOURCE_DATE_EPOCH.

    Raises
    ------
    CubeError
        If that variable is not a whole number of seconds.
    """
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    if epoch is None:
        return datetime.now(UTC)
    try:
        return datetime.fromtimestamp(int(epoch), UTC)
    except (ValueError, OverflowError, OSError) as error:
        raise CubeError(f"SOURCE_DATE_EPOCH: '{epoch}' is not a whole number of seconds since 1970") from error


def window_attribute(header: CubeHeader) -> dict[str, Attribute]:
    """Describe the part of the image that the cube covers, if it is not all of it."""
    image_window = header.window
    if image_window is None:
        return {}
    window = {
        "rows": [image_window.first_row, image_window.first_row + header.rows],
        "columns": [image_window.first_column, image_window.first_column + header.columns],
        "image_rows": image_window.image_rows,
        "image_columns": image_window.image_columns,
    }
    return {"hcss_window": json.dumps(window)}


def _identifier(header: CubeHeader) -> str:
    """Return an identifier of the content: equal for equal scenarios and headers, whenever they are run."""
    scenario = str(header.attributes.get(SCENARIO_ATTRIBUTE, ""))
    described = "\n".join(
        [
            scenario,
            header.start_utc.isoformat(),
            repr(list(map(float, header.frame_times_s))),
            repr(header.bands),
            repr((header.rows, header.columns, header.pixel_size_m, header.latitude, header.longitude)),
            " ".join(spec.name for spec in header.variables),
            *([] if header.window is None else [repr(header.window)]),
        ]
    )
    return "hcss-" + hashlib.sha256(described.encode()).hexdigest()[:16]


def _coverage_in_time(header: CubeHeader) -> dict[str, Attribute]:
    first, last = header.frame_times_s[0], header.frame_times_s[-1]
    step = (last - first) / (header.frames - 1) if header.frames > 1 else 0.0
    return {
        "time_coverage_start": _iso(header.start_utc + timedelta(seconds=first)),
        "time_coverage_end": _iso(header.start_utc + timedelta(seconds=last)),
        "time_coverage_duration": _duration(last - first),
        "time_coverage_resolution": _duration(step),
    }


def _coverage_in_space(header: CubeHeader, extent: Footprint) -> dict[str, Attribute]:
    ring = (*extent.outline, extent.outline[0])
    points = ", ".join(f"{latitude:.8f} {longitude:.8f}" for latitude, longitude in ring)
    return {
        "geospatial_bounds": f"POLYGON (({points}))",
        "geospatial_bounds_crs": "EPSG:4326",
        "geospatial_bounds_vertical_crs": "EPSG:5714",
        "geospatial_lat_min": extent.south,
        "geospatial_lat_max": extent.north,
        "geospatial_lat_units": "degrees_north",
        "geospatial_lat_resolution": f"{header.pixel_size_m:g} m",
        "geospatial_lon_min": extent.west,
        "geospatial_lon_max": extent.east,
        "geospatial_lon_units": "degrees_east",
        "geospatial_lon_resolution": f"{header.pixel_size_m:g} m",
        "geospatial_vertical_min": 0.0,
        "geospatial_vertical_max": 0.0,
        "geospatial_vertical_positive": "up",
        "geospatial_vertical_units": "m",
    }


def _iso(moment: datetime) -> str:
    text = moment.astimezone(UTC).replace(tzinfo=None).isoformat(timespec="microseconds")
    return text.rstrip("0").rstrip(".") + "Z"


def _duration(seconds: float) -> str:
    """Return an ISO 8601 duration rounded to microseconds."""
    return f"PT{f'{seconds:.6f}'.rstrip('0').rstrip('.')}S"
