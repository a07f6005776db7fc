"""Reference of the cube's variables, generated from the tables.

``python -m hcss_twin.cube.document`` writes it to docs/cube.md, or to the path that follows.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path

from hcss_twin.cube.coordinates import COORDINATES, GRID_MAPPING
from hcss_twin.cube.header import FORMAT_ATTRIBUTE, FORMAT_VERSION, SCENARIO_ATTRIBUTE
from hcss_twin.cube.metadata import COMPUTED, DEFAULTS, PROVENANCE, AttributeSpec
from hcss_twin.cube.sensor_cube import MEASURED_RADIANCE, SENSOR_ATTRIBUTE, SENSOR_VARIABLES
from hcss_twin.cube.variables import GEOMETRY, TERM_PREFIX, VARIABLES, VariableSpec, term_variable

_INTRODUCTION = f"""# The cube

*Generated from the tables in `hcss_twin/cube`; do not edit.*

A cube is one NetCDF-4 file that follows CF-1.11 and ACDD-1.3. It holds frames of an image in one or more
bands, and on request the terms of the radiance and the state of the scene (truth).

```python
from hcss_twin.cube.reader import open_cube, scenario_text

with open_cube("cube.nc") as cube:
    frame = cube.radiance.sel(band="mwir").isel(time=0)
print(scenario_text("cube.nc"))
```

* A file with its final name is finished: it is written under a hidden name ending in `.partial`, and renamed
  once all frames are on the disk. The global attribute `{FORMAT_ATTRIBUTE}` = {FORMAT_VERSION} says so, too.
* `{SCENARIO_ATTRIBUTE}` is the text of the scenario the cube was made from.
* Azimuths are bearings from the surface point toward sensor or sun, clockwise from north; zenith angles are
  those at the surface point.
* x points east and y north from the centre of each frame; `{GRID_MAPPING}` describes the plane.
* A cube of a window of a larger image (`image.window`) keeps the coordinates of that image, and its centre in
  `latitude` and `longitude`; `hcss_window` (JSON) says where it lies. Frames of more than 256 MB are
  stored in chunks of a tile ([large scenes](large-scenes.md)).
* A name that ends in `.zarr` makes a Zarr store with the same variables and attributes.
* A pixel is the mean over `image.samples_per_pixel` squared points of its footprint; by default it is the one
  point at its centre. Radiance and its terms are averaged, not the state they are computed from.
* `cloud_layer_thickness`, the dimension `layer` and its coordinates are in a cube only if asked for: by name, or by
  `all` or `truth` where the scene has two layers (with one they would repeat `cloud_thickness`). Layers run from the
  lowest to the highest, whatever their order in the scenario, and can be selected by cloud type like bands:
  `cube.cloud_layer_thickness.sel(layer="cirrus")`.
* Global attributes that begin with `hcss_` say what the cube was made from, what was left out and how far it can be
  trusted; they are [listed below](#global-attributes-of-provenance).
* Numbers are stored plainly by default, which is fastest. `output.compression` stores them in chunks of one plane with
  shuffled bytes and zlib; `output.quantization` rounds the mantissa of single-precision numbers to the fewest bits that
  keep the relative error given (`bitround` of CF-1.12). Each variable then states its bits and the largest error
  (`quantization_nsb`, `quantization_maximum_relative_error`); the certificate is about the rounded numbers.
* NaN occurs only in the variables marked below, and negative radiance never but in what a sensor measured.
* Band-integrated radiance has no CF standard name, because those for radiance at the top of the atmosphere
  are per unit wavelength.
"""

_MEASURED = f"""
## Variables of a measured cube

Beside `NAME.nc` a scenario with a [sensor](sensor.md) has `NAME.sensor.nc`: the same coordinates and truth layers, and
in place of the variables of radiance what was measured. The global attribute `{SENSOR_ATTRIBUTE}` (JSON) tells the two
apart and says what the sensor is; `clean_cube` names the other.
"""

_STORAGE = """
## What compression and rounding cost

`python benchmarks/writing.py`: `stratus`, 8 frames of 800 x 800 with radiance of three bands and the cloud
mask. Size is relative to plain numbers; processor time is that of writing alone, opening and closing included,
on a machine that others used; the rest does not depend on the machine. Computing a frame takes about 12 ms of
another processor meanwhile.

| `[output]` | size | processor, ms a frame | largest relative error |
|---|---|---|---|
| the same bytes, raw | 1 | 1.6 | 0 |
| (default) | 1.00 | 8.4 | 0 |
| `compression = 1` | 0.31 | 71 | 0 |
| `compression = 4` | 0.30 | 91 | 0 |
| `compression = 9` | 0.29 | 815 | 0 |
| `compression = 1, quantization = 1e-5` | 0.22 | 64 | 7.6e-6 |
| `compression = 1, quantization = 1e-4` | 0.16 | 60 | 6.1e-5 |
| `compression = 1, quantization = 5e-4` (for `accuracy = 2e-3`) | 0.12 | 49 | 4.9e-4 |

Levels above 1 gain next to nothing. zstd takes half the time of zlib for files a fifth larger, and is not offered,
because many readers lack it. Rounding may take three tenths of `accuracy`; the plan says what it does and refuses more.
"""

_VIEWING = """Coordinates that are requested like output variables (`output.variables`), one by one or as `geometry`
([viewing geometry](viewing-geometry.md)). They are CF auxiliary coordinates: each variable of frames names them in its
attribute `coordinates`, where latitude, longitude and view angles take the place of those of the image centre. They are
written once, or with every frame where the platform moves and they do, too.
"""

_WORDS = {
    "all": "every variable above and every term; those by layer where there are two; not the viewing geometry",
    "terms": "every term of the radiance model in use",
    "truth": "every variable of kind truth; those by layer where there are two",
    "geometry": "every coordinate of the pixels below; without `platform.altitude` latitude and longitude",
}


def markdown() -> str:
    """Return the reference as Markdown."""
    term = term_variable("term", "One term of the radiance; the radiance model in use says which there are.")
    term_row = _row(term).replace(f"{TERM_PREFIX}term", f"{TERM_PREFIX}<term>")
    defaults = [f"| `{name}` | {text} |" for name, text in sorted(DEFAULTS.items())]
    words = [f"| `{word}` | {meaning} |" for word, meaning in _WORDS.items()]
    parts = [
        _INTRODUCTION,
        "## Output variables\n",
        _HEADER,
        *(_row(spec) for spec in VARIABLES),
        term_row,
        "\nWords that stand for several:\n",
        "| word | meaning |\n|---|---|",
        *words,
        _MEASURED,
        _HEADER,
        *(_row(spec) for spec in (MEASURED_RADIANCE, *SENSOR_VARIABLES)),
        _STORAGE,
        "## Coordinates\n",
        _HEADER,
        *(_row(spec) for spec in COORDINATES),
        "\n## Viewing geometry of every pixel\n",
        _VIEWING,
        _HEADER,
        *(_row(spec) for spec in GEOMETRY),
        "\n## Global attributes of provenance\n",
        _ATTRIBUTE_HEADER,
        *map(_attribute_row, PROVENANCE),
        '\nJSON is stored as text: `json.loads(cube.attrs["hcss_table_errors"])`.',
        "\n## Global attributes that can be replaced\n",
        "| attribute | default |\n|---|---|",
        *defaults,
        "\n`id` and `history` can be replaced as well; by default `id` is a hash of scenario and coordinates."
        "\n## Global attributes that are computed\n",
        _ATTRIBUTE_HEADER,
        *map(_attribute_row, COMPUTED),
        "\nTwo runs of a scenario differ in `date_created` and `history`, which hold the time of writing. The\n"
        "environment variable `SOURCE_DATE_EPOCH` (seconds since 1970) fixes it, and with it every byte of the file.",
    ]
    return "\n".join(parts) + "\n"


def main(arguments: Iterable[str] = ()) -> None:
    """Write the reference to the path given, or to docs/cube.md of the checkout."""
    parser = argparse.ArgumentParser(description="Write the reference of the cube.")
    parser.add_argument("path", nargs="?", type=Path, default=Path(__file__).parents[2] / "docs" / "cube.md")
    path: Path = parser.parse_args(list(arguments)).path
    path.write_text(markdown(), encoding="utf-8")


_HEADER = "| name | dimensions | type | units | kind | standard name | meaning |\n|---|---|---|---|---|---|---|"

_ATTRIBUTE_HEADER = "| attribute | type | in cubes where | holds |\n|---|---|---|---|"


def _attribute_row(spec: AttributeSpec) -> str:
    return f"| `{spec.name}` | {spec.type} | {spec.when} | {spec.description} |"


def _row(spec: VariableSpec) -> str:
    limits = [
        f"at least {spec.lowest:g}" if spec.lowest is not None else "",
        f"at most {spec.highest:g}" if spec.highest is not None else "",
        "NaN where it does not exist" if spec.may_be_missing else "",
    ]
    rules = ", ".join(limit for limit in limits if limit)
    cells = [
        f"`{spec.name}`",
        ", ".join(spec.dims) or "scalar",
        spec.dtype,
        spec.units or "",
        spec.kind,
        f"`{spec.standard_name}`" if spec.standard_name else "",
        spec.description + (f" ({rules})" if rules else ""),
    ]
    return "| " + " | ".join(cells) + " |"


if __name__ == "__main__":
    main(sys.argv[1:])
