"""The table of output variables: writer, reader, documentation and tests follow it.

Standard names come from the CF standard name table. Radiance integrated over a band has none (the
names for radiance at the top of the atmosphere are per unit wavelength), so it carries only a
``long_name``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import choose_from

Kind = Literal["radiance", "truth", "derived", "coordinate"]

FRAME = ("time", "y", "x")
BAND_FRAME = ("time", "band", "y", "x")
TERM_PREFIX = "radiance_"

_TERM = re.compile(r"[a-z][a-z0-9_]*\Z")
_ON_SCALE = {"units_metadata": "temperature: on_scale"}


@dataclass(frozen=True)
class VariableSpec:
    """One variable of the cube.

    Attributes
    ----------
    name : str
        Name in the file.
    dims : tuple of str
        Dimensions, in order.
    dtype : str
        NumPy name of the type in the file; arrays given to the writer must have it already. Text is ``str``.
    units : str or None
        UDUNITS string; None for text.
    long_name : str
        One line for plots.
    kind : {"radiance", "truth", "derived", "coordinate"}
        ``radiance``: total and its terms; ``truth``: state of the scene; ``derived``: computed from radiance.
    description : str
        Definition, in a sentence or two; written as ``comment``.
    standard_name : str or None
        CF standard name.
    attributes : mapping
        Further attributes of the variable in the file.
    lowest, highest : float or None
        Inclusive limits of the values; None: no limit.
    may_be_missing : bool
        Whether NaN is a value, meaning that the quantity does not exist in the pixel.
    """

    name: str
    dims: tuple[str, ...]
    dtype: str
    units: str | None
    long_name: str
    kind: Kind
    description: str
    standard_name: str | None = None
    attributes: Mapping[str, str | float | NDArray[np.uint8]] = field(default_factory=dict)
    lowest: float | None = None
    highest: float | None = None
    may_be_missing: bool = False


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
        description="1 where the pixel holds cloud of any thickness, 0 where it is clear.",
        standard_name="cloud_binary_mask",
        attributes={"flag_values": np.array([0, 1], dtype=np.uint8), "flag_meanings": "clear cloudy"},
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
        description="Vertical extent of the cloud in the pixel; 0 where clear.",
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
        "of the band; 0 where clear.",
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
        description="Altitude of the cloud top above the sea; missing where clear.",
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
        description="Temperature of the cloud at its top; missing where clear.",
        standard_name="air_temperature_at_cloud_top",
        attributes=_ON_SCALE,
        lowest=0.0,
        may_be_missing=True,
    ),
)


def term_variable(name: str, description: str) -> VariableSpec:
    """Return the variable ``radiance_<name>`` of one term of the radiance model.

    Raises
    ------
    ValueError
        If ``name`` is not made of lower-case letters, digits and underscores.
    """
    if not _TERM.match(name):
        raise ValueError(
            f"radiance term '{name}': a term is named with lower-case letters, digits and underscores"
        )
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


def expand(requested: Iterable[str], terms: Mapping[str, str]) -> list[VariableSpec]:
    """Turn what a scenario asks for into variables, in the order of the table, terms last.

    Parameters
    ----------
    requested : iterable of str
        Names of variables, or ``all``, ``terms`` (every term of the radiance), ``truth`` (every
        variable of that kind).
    terms : mapping of str to str
        Description of each term of the radiance model in use, by its name.

    Raises
    ------
    ValueError
        If a name is unknown, with the allowed names and the closest one, or if nothing is asked for.
    """
    known = {spec.name: spec for spec in VARIABLES}
    known.update((spec.name, spec) for spec in (term_variable(name, text) for name, text in terms.items()))
    groups = {
        "all": set(known),
        "terms": {TERM_PREFIX + name for name in terms},
        "truth": {spec.name for spec in VARIABLES if spec.kind == "truth"},
    }
    wanted: set[str] = set()
    for name in requested:
        if name not in groups and name not in known:
            raise ValueError(f"unknown output variable '{name}'; {choose_from(name, [*groups, *known])}")
        wanted |= groups.get(name, {name})
    if not wanted:
        raise ValueError(f"no output variable is asked for; {choose_from('', [*groups, *known])}")
    return [spec for name, spec in known.items() if name in wanted]
