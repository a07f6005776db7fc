"""Reference of the cube, from the tables of variables and attributes in ``hcss_twin.cube``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from hcss_twin.cube.coordinates import COORDINATES, GRID_MAPPING
from hcss_twin.cube.header import FORMAT_ATTRIBUTE, FORMAT_VERSION, SCENARIO_ATTRIBUTE
from hcss_twin.cube.metadata import ALWAYS, COMPUTED, DEFAULTS, PROVENANCE, AttributeSpec
from hcss_twin.cube.requested_variables import term_variable
from hcss_twin.cube.sensor_cube import MEASURED_RADIANCE, SENSOR_ATTRIBUTE, SENSOR_VARIABLES
from hcss_twin.cube.variables import GEOMETRY, TERM_PREFIX, VARIABLES, VariableSpec

PAGE = "reference/cube.md"

_INTRODUCTION = f"""# The cube

{{GENERATED}}

A cube is one NetCDF-4 file (or Zarr store) that follows CF-1.11 (CF-1.12 where values are rounded) and ACDD-1.3: frames
of an image in one or more bands, and on request the terms of the radiance and the truth layers of the scene.

```python
import hcss_twin

with hcss_twin.open_cube("cube.nc") as cube:
    frame = cube.radiance.sel(band="mwir").isel(time=0)
    print(cube.attrs["{SCENARIO_ATTRIBUTE}"])
```

* A file with its final name is complete: until the last frame it has a hidden name ending in `.partial`. The global
  attribute `{FORMAT_ATTRIBUTE}` = {FORMAT_VERSION} also marks a complete file.
* Angles and axes follow the [conventions](conventions.md); `{GRID_MAPPING}` describes the plane of x and y.
* A cube of a window of a larger image (`image.window`) has the coordinates of that image, and its centre in
  `latitude` and `longitude`; `hcss_window` (JSON) gives the position. Frames of more than 256 MB have one chunk per
  tile ([large scenes](../how-to/large-scenes.md)).
* Variables of plugins (`[[output.derived]]`) name in their attribute `hcss_inputs` what they are derived from; a
  measured cube leaves out those derived from clean radiance.
* Of a pixel of several points (`image.samples_per_pixel`), radiance and its terms are averaged, not the state from
  which they are computed.
* The dimension `layer` is in a cube only if `cloud_layer_thickness` is requested: by name, or by `all` or `truth` if
  the scene has two layers. Select layers by cloud type: `cube.cloud_layer_thickness.sel(layer="cirrus")`.
* NaN (undefined) occurs only in the variables marked below, and negative radiance only in measured cubes.
* Band-integrated radiance has no CF standard name, because those for radiance at the top of the atmosphere
  are per unit wavelength.
"""

_MEASURED = f"""
## Variables of a measured cube

`NAME.sensor.nc` of a scenario with a [sensor](../how-to/sensors.md) has the coordinates and truth layers of `NAME.nc`,
and the measurement in place of the radiance. The global attribute `{SENSOR_ATTRIBUTE}` (JSON), which only measured
cubes have, describes the sensor, with the [constants](../how-to/instruments.md#numbers-back-to-radiance) that turn
digital numbers into radiance; `clean_cube` names the other file.
"""

_STORAGE = """
## Compression, rounding, packing

Of `stratus` (8 frames of 800 x 800, three bands):

| `[output]` | size | processor, ms a frame | largest relative error |
|---|---|---|---|
| (default) | 1.00 | 8.4 | 0 |
| `compression = 1` (zlib; higher levels gain almost nothing) | 0.31 | 71 | 0 |
| `compression = 1, quantization = 1e-4` | 0.16 | 60 | 6.1e-5 |
| `packing = "int16"` (one band) | 0.60 | as the default | 1.3e-5 |

`quantization` rounds single-precision numbers to the fewest bits that keep the relative error (`bitround` of CF-1.12),
up to three tenths of `accuracy`; `quantization_nsb` and `quantization_maximum_relative_error` of a variable state bits
and error. `packing` stores variables of known range as 16-bit integers with `scale_factor` and `add_offset`, which each
reader unpacks to the same numbers; -32768 means missing. `packing_maximum_error` (units of the variable),
`packing_maximum_relative_error` and `packing_maximum_error_kelvin` (of each band) state the error. The certificate
applies to the rounded numbers.
"""

_VIEWING = """Request them in `output.variables`, by name or as `geometry` ([how](../how-to/viewing-geometry.md)). They
are CF auxiliary coordinates, written once, or with every frame if the platform moves; latitude, longitude and view
angles replace those of the image centre.
"""

_WORDS = {
    "all": "every variable above and every term; variables per layer only if there are two; not the viewing geometry",
    "terms": "every term of the radiance model in use",
    "truth": "every variable of kind truth; variables per layer only if there are two",
    "geometry": "every pixel coordinate below; without `platform.altitude` only latitude and longitude",
}


def lines(generated: str) -> Iterator[str]:
    """Yield the page."""
    term = term_variable("term", "One term of the radiance; the radiance model defines the terms.")
    term_row = _row(term).replace(f"{TERM_PREFIX}term", f"{TERM_PREFIX}<term>")
    words = [f"| `{word}` | {meaning} |" for word, meaning in _WORDS.items()]
    yield from (
        _INTRODUCTION.replace("{GENERATED}", generated),
        "## Output variables\n\n*image*: dimensions time, y, x; *bands*: time, band, y, x; *same*: the name.\n",
        _HEADER,
        *_rows(VARIABLES),
        term_row,
        "\nNames of groups of variables:\n",
        "| group | meaning |\n|---|---|",
        *words,
        _MEASURED,
        _HEADER,
        *(_row(spec) for spec in (MEASURED_RADIANCE, *SENSOR_VARIABLES)),
        _STORAGE,
        "## Coordinates\n",
        _HEADER_OF_ONE,
        *(_row(spec) for spec in COORDINATES),
        "\n## Viewing geometry of every pixel\n",
        _VIEWING,
        _HEADER_OF_ONE,
        *(_row(spec) for spec in GEOMETRY),
        "\n## Global attributes of provenance\n",
        *map(_attribute_row, (spec for spec in PROVENANCE if not spec.when.startswith(_CHECKED))),
        f"\nIf {_CHECKED} (`output.certificate`):\n",
        *map(_attribute_row, (spec for spec in PROVENANCE if spec.when.startswith(_CHECKED))),
        '\nJSON is stored as text: `json.loads(cube.attrs["hcss_table_errors"])`.',
        "\n## Other global attributes\n",
        "ACDD and CF, with defaults (see `ncdump -h`): "
        f"{_names(name for name, text in DEFAULTS.items() if text != _UNKNOWN)}; unknown\n"
        f"by default: {_names(name for name, text in DEFAULTS.items() if text == _UNKNOWN)}.",
        f"\nComputed: `id` (a hash of scenario and coordinates), `history`, {_names(spec.name for spec in COMPUTED)}.",
        "\n`date_created` and `history` contain the time of writing. The environment variable `SOURCE_DATE_EPOCH`\n"
        "(seconds since 1970) fixes it and makes files byte-identical.",
    )


_UNKNOWN = "unknown"
_CHECKED = "pixels are checked"


def _names(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in sorted(names))


_HEADER = "| name | dimensions | units | kind | standard name | meaning |\n|---|---|---|---|---|---|"
_HEADER_OF_ONE = "| name | dimensions | units | standard name | meaning |\n|---|---|---|---|---|"
_ONE_KIND = ("coordinate", "geometry")
"""Kinds whose variables have tables of their own."""

_STILL = " The same in every frame."

_IMAGES = {("time", "y", "x"): "image", ("time", "band", "y", "x"): "bands"}


def _attribute_row(spec: AttributeSpec) -> str:
    when = spec.when.removeprefix(_CHECKED).removeprefix(" and ") if spec.when != ALWAYS else ""
    return f"* `{spec.name}` ({spec.type}{f', if {when}' if when else ''}): {spec.description}"


def _rows(specs: Iterable[VariableSpec]) -> Iterator[str]:
    """Yield a row for each variable, and one for two along the two axes of the image."""
    before = ""
    for row in (*map(_row, specs), ""):
        if before and row:
            names = row.split("`")[1], before.split("`")[1]
            if _along_y_or_columns(row) == before:
                before = before.replace(f"`{names[1]}`", f"`{names[1]}`, `{names[0]}`", 1)
                continue
        if before:
            yield before
        before = row


def _along_y_or_columns(row: str) -> str:
    """Return a row of the table with the other axis of the image in place of y or columns."""
    words = {"slope_y": "slope_x", "along y": "along x", "column": "row", "Column": "Row"}
    return re.sub("|".join(words), lambda match: words[match[0]], row)


def _row(spec: VariableSpec) -> str:
    limits = f"{spec.lowest:g}..{spec.highest:g}" if spec.lowest is not None and spec.highest is not None else ""
    rules = ", ".join(filter(None, (limits, "NaN" if spec.may_be_missing else "")))
    standard = "same" if spec.standard_name == spec.name else f"`{spec.standard_name}`" if spec.standard_name else ""
    cells = [
        f"`{spec.name}`",
        _IMAGES.get(spec.dims, ", ".join(spec.dims) or "scalar"),
        spec.units or "",
        *([spec.kind] if spec.kind not in _ONE_KIND else []),
        standard,
        spec.description.removesuffix(_STILL) + (f" ({rules})" if rules else ""),
    ]
    return "| " + " | ".join(cells) + " |"
