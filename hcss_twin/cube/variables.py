"""The table of output variables: writer, reader, documentation and tests follow it.

Standard names come from the CF standard name table. Radiance integrated over a band has none (the
names for radiance at the top of the atmosphere are per unit wavelength), so it carries only a
``long_name``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

import numpy as np

from hcss_twin.core.errors import choose_from
from hcss_twin.cube.geometry_variables import DIRECTION, GEOMETRY, LOCATION, MOVING_LOCATION
from hcss_twin.cube.spec import BAND_FRAME, FRAME, LAYER_FRAME
from hcss_twin.cube.spec import LAYER as LAYER
from hcss_twin.cube.spec import VariableSpec as VariableSpec

TERM_PREFIX = "radiance_"
SHADOW_MASK = "shadow_mask"

_TERM = re.compile(r"[a-z][a-z0-9_]*\Z")
_ON_SCALE = {"units_metadata": "temperature: on_scale"}

VARIABLES: tuple[VariableSpec, ...] = (
    VariableSpec(
        name="radiance",
        dims=BAND_FRAME,
        dtype="float32",
        units="W m-2 sr-1",
        long_name="band-integrated radiance at the sensor",
        kind="radiance",
        description="Spectral radiance that leaves the top of the atmosphere toward the sensor, integrated "
        "over the band; the sum of all terms.",
        lowest=0.0,
    ),
    VariableSpec(
        name="brightness_temperature",
        dims=BAND_FRAME,
        dtype="float32",
        units="K",
        long_name="brightness temperature in the band",
        kind="derived",
        description="Temperature of the black body whose radiance, integrated over the same band, equals "
        "the radiance. It has no thermal meaning where sunlight dominates.",
        standard_name="toa_brightness_temperature",
        attributes=_ON_SCALE,
        lowest=0.0,
    ),
    VariableSpec(
        name="cloud_mask",
        dims=FRAME,
        dtype="uint8",
        units="1",
        long_name="cloud mask",
        kind="truth",
        description="1 where the pixel holds cloud of any thickness in any layer, on whatever part of its "
        "footprint; 0 where it is clear.",
        standard_name="cloud_binary_mask",
        attributes={"flag_values": np.array([0, 1], dtype=np.uint8), "flag_meanings": "clear cloudy"},
        lowest=0.0,
        highest=1.0,
    ),
    VariableSpec(
        name="cloud_fraction",
        dims=FRAME,
        dtype="float32",
        units="1",
        long_name="cloudy part of the pixel",
        kind="truth",
        description="Part of the pixel's points that hold cloud of any layer; with one point per pixel the cloud mask.",
        standard_name="cloud_area_fraction",
        lowest=0.0,
        highest=1.0,
    ),
    VariableSpec(
        name=SHADOW_MASK,
        dims=FRAME,
        dtype="uint8",
        units="1",
        long_name="mask of clouds' shadows on the sea",
        kind="truth",
        description="1 where the sun's path to the sea crosses cloud of any thickness on some part of the pixel that "
        "is seen clear; 0 elsewhere, where the whole pixel is cloudy, and with the sun below the horizon.",
        attributes={"flag_values": np.array([0, 1], dtype=np.uint8), "flag_meanings": "not_shadowed shadowed"},
        lowest=0.0,
        highest=1.0,
    ),
    VariableSpec(
        name="cloud_thickness",
        dims=FRAME,
        dtype="float32",
        units="m",
        long_name="geometric thickness of the cloud",
        kind="truth",
        description="Vertical extent of the cloud, summed over layers and averaged over the footprint of the pixel "
        "including its clear part; 0 where clear.",
        lowest=0.0,
    ),
    VariableSpec(
        name="cloud_layer_thickness",
        dims=LAYER_FRAME,
        dtype="float32",
        units="m",
        long_name="geometric thickness of the cloud in each layer",
        kind="truth",
        description="Vertical extent of the cloud of one layer, averaged over the footprint of the pixel including "
        "its clear part; 0 where clear. Layers run from the lowest to the highest.",
        lowest=0.0,
    ),
    VariableSpec(
        name="cloud_optical_thickness",
        dims=BAND_FRAME,
        dtype="float32",
        units="1",
        long_name="optical thickness of the cloud",
        kind="truth",
        description="Vertical extinction optical thickness of the cloud particles at the central wavelength "
        "of the band, summed over layers and averaged over the footprint of the pixel including its clear part; "
        "0 where clear.",
        standard_name="atmosphere_optical_thickness_due_to_cloud",
        lowest=0.0,
    ),
    VariableSpec(
        name="cloud_top_altitude",
        dims=FRAME,
        dtype="float32",
        units="m",
        long_name="altitude of the cloud top",
        kind="truth",
        description="Altitude above the sea of the top of the highest cloud, averaged over the cloudy points of the "
        "pixel; missing where clear.",
        standard_name="cloud_top_altitude",
        lowest=0.0,
        may_be_missing=True,
    ),
    VariableSpec(
        name="cloud_top_temperature",
        dims=FRAME,
        dtype="float32",
        units="K",
        long_name="temperature at the cloud top",
        kind="truth",
        description="Temperature of the highest cloud at its top, averaged over the cloudy points of the pixel; "
        "missing where clear.",
        standard_name="air_temperature_at_cloud_top",
        attributes=_ON_SCALE,
        lowest=0.0,
        may_be_missing=True,
    ),
    *(
        VariableSpec(
            name=f"sea_slope_{axis}",
            dims=FRAME,
            dtype="float32",
            units="1",
            long_name=f"slope of the sea toward {bearing}",
            kind="truth",
            description=f"Slope of the waves longer than two points of the image along {axis}, averaged over the "
            "footprint of the pixel, also under clouds; only where waves are drawn (sea.waves).",
        )
        for axis, bearing in (("x", "east"), ("y", "north"))
    ),
)

WAVE_VARIABLES = frozenset({"sea_slope_x", "sea_slope_y"})
"""Those that exist only where waves are drawn."""


def term_variable(name: str, description: str) -> VariableSpec:
    """Return the variable ``radiance_<name>`` of one term of the radiance model.

    Raises
    ------
    ValueError
        If ``name`` is not made of lower-case letters, digits and underscores.
    """
    if not _TERM.match(name):
        raise ValueError(f"radiance term '{name}': a term is named with lower-case letters, digits and underscores")
    return VariableSpec(
        name=TERM_PREFIX + name,
        dims=BAND_FRAME,
        dtype="float32",
        units="W m-2 sr-1",
        long_name=f"part of the radiance: {name.replace('_', ' ')}",
        kind="radiance",
        description=description,
        lowest=0.0,
    )


def expand(
    requested: Iterable[str],
    terms: Mapping[str, str],
    layer_count: int = 1,
    shadows: bool = False,
    waves: bool = True,
    altitude: bool = True,
    moves: bool = False,
) -> list[VariableSpec]:
    """Turn what a scenario asks for into variables, in the order of the table, then terms and viewing geometry.

    Variables by layer belong to the groups where there are several layers; elsewhere they repeat others. Those of
    shadows are there where clouds cast any.

    Parameters
    ----------
    requested : iterable of str
        Names of variables, or ``all`` (but for viewing geometry), ``terms`` (every term of the radiance), ``truth``
        (every variable of that kind), ``geometry`` (every coordinate of the pixels that can be known).
    terms : mapping of str to str
        Description of each term of the radiance model in use, by its name.
    layer_count : int
        Number of cloud layers of the scene.
    shadows : bool
        Whether clouds cast shadows.
    waves : bool
        Whether the scene draws waves; without them their variables belong to no group.
    altitude : bool
        Whether that of the sensor is known; without it there are no directions toward it.
    moves : bool
        Whether the image moves over the ground; latitude and longitude then have a time.

    Raises
    ------
    ValueError
        If a name is unknown, with the allowed names and the closest one, if nothing is asked for, or if a variable
        by layer is asked for without a layer, one of shadows without shadows, one of waves where none are drawn, or a
        direction toward a sensor of unknown altitude.
    """
    known = {spec.name: spec for spec in VARIABLES}
    known.update((spec.name, spec) for spec in (term_variable(name, text) for name, text in terms.items()))
    by_layer = {spec.name for spec in VARIABLES if LAYER in spec.dims}
    absent = by_layer if layer_count < 2 else set[str]()
    if not shadows:
        absent = absent | {SHADOW_MASK}
    if not waves:
        absent = absent | WAVE_VARIABLES
    directions = {spec.name for spec in DIRECTION}
    groups = {
        "all": set(known) - absent,
        "terms": {TERM_PREFIX + name for name in terms},
        "truth": {spec.name for spec in VARIABLES if spec.kind == "truth"} - absent,
        "geometry": {spec.name for spec in (GEOMETRY if altitude else LOCATION)},
    }
    known.update((spec.name, spec) for spec in (*(MOVING_LOCATION if moves else LOCATION), *DIRECTION))
    wanted: set[str] = set()
    for name in requested:
        if name not in groups and name not in known:
            raise ValueError(f"unknown output variable '{name}'; {choose_from(name, [*groups, *known])}")
        if name in by_layer and layer_count == 0:
            raise ValueError(f"'{name}': the scene has no cloud layer; allowed: with one or two layers")
        if name == SHADOW_MASK and not shadows:
            raise ValueError(f"'{name}': clouds cast no shadows; allowed: with slant.shadows = true")
        if name in WAVE_VARIABLES and not waves:
            raise ValueError(f"'{name}': the scene draws no waves; allowed: with sea.waves = \"resolved\"")
        if name in directions and not altitude:
            raise ValueError(f"'{name}': the altitude of the sensor is not known; allowed: with platform.altitude")
        wanted |= groups.get(name, {name})
    if not wanted:
        raise ValueError(f"no output variable is asked for; {choose_from('', [*groups, *known])}")
    return [spec for name, spec in known.items() if name in wanted]
