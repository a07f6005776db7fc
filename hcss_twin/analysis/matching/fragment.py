"""The shape of a cloud type as a start.

A match as the part of a scenario file that describes its clouds.
"""

from __future__ import annotations

import json
import textwrap
from pathlib import Path

import numpy as np

from hcss_twin.analysis.matching.dimension_range import DimensionMatch
from hcss_twin.analysis.matching.match import Match
from hcss_twin.analysis.matching.structure import CloudImage
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.core.files import atomic_write
from hcss_twin.models.clouds.fractal.parameters import FractalParameters

# The frame of the paper's tables.
SIDE = 800
PIXEL_SIZE_M = 20.0


def type_parameters(cloud_type: str, catalog: Catalog) -> FractalParameters:
    """Return the complete parameters of a cloud type of the catalog.

    Raises
    ------
    CatalogError
        If there is no such type.
    """
    shape = catalog.toml(catalog.find(cloud_type, "cloud_types", ".toml"))["fractal"]
    x, y = shape["L"]
    first, last = shape["k"]
    return FractalParameters(gamma=float(shape["gamma"]), H=float(shape["H"]), L=(float(x), float(y)), k=(first, last))


def empty_frame(rows: int = SIDE, columns: int = SIDE, pixel_size_m: float = PIXEL_SIZE_M) -> CloudImage:
    """Return a frame that only has a size; that of the paper by default."""
    return CloudImage(np.zeros((rows, columns), dtype=np.float32), pixel_size_m)


_WIDTH = 110


def match_fragment(match: Match, cloud_type: str) -> str:
    """Return TOML: the section ``[clouds]``, and as comments what it was made from and how good it is.

    It may end any scenario file without clouds; the image's size and pixels, for which it was judged, are
    a comment.
    """
    best, worst = min(match.rmse), max(match.rmse)
    comments = [
        f"Clouds like those of {match.target.source}, found by hcss match.",
        *match.target.notes,
        f"RMSE of eq 24 of the HCSS paper over {len(match.rmse)} seeds that the search had not seen: "
        f"{match.mean_rmse:.1%} ({best:.1%} to {worst:.1%}).",
        *(f"Not matched: {line}." for line in match.unmatched),
        _judged_at(match.target.image),
    ]
    return clouds_fragment(match.parameters, match.coverage, cloud_type, comments)


def dimension_fragment(
    found: DimensionMatch, coverage: float, like: CloudImage, started_from: str, cloud_type: str
) -> str:
    """Return TOML as :func:`match_fragment`, for a range of the fractal dimension.

    ``started_from`` says whose parameters were changed.
    """
    low, high = found.wanted
    mean = sum(found.dimensions) / len(found.dimensions)
    comments = [
        f"Clouds with a {found.dimension} dimension of {low:g} to {high:g}, found by hcss match from the "
        f"parameters of {started_from}; changed: {found.changed}.",
        f"Over {len(found.seeds)} seeds that the search had not seen it is {mean:.3f} ({min(found.dimensions):.3f} "
        f"to {max(found.dimensions):.3f}); {found.inside:.0%} of them lie in the range.",
        _judged_at(like),
    ]
    return clouds_fragment(found.parameters, coverage, cloud_type, comments)


def _judged_at(image: CloudImage) -> str:
    rows, columns = image.level.shape
    return f"Judged at: image = {{rows = {rows}, columns = {columns}, pixel_size = {image.pixel_size_m:g}}}"


def clouds_fragment(parameters: FractalParameters, coverage: float, cloud_type: str, comments: list[str]) -> str:
    """Return the section ``[clouds]`` of a scenario with complete parameters, under comments."""
    lines: list[str] = []
    comments = [*comments, f"The type {cloud_type} gives height and particles, which grey levels do not tell."]
    for comment in comments:
        # A comment in TOML holds no control characters, a file name may.
        plain = "".join(letter if letter.isprintable() else "?" for letter in comment)
        lines += textwrap.wrap(plain, _WIDTH, initial_indent="# ", subsequent_indent="#   ")
    lines += [
        "",
        "[clouds]",
        f"type = {json.dumps(cloud_type)}",
        f"coverage = {round(coverage, 9)!r}",
        'generator = "fractal"',
        "",
    ]
    lines.append("[clouds.parameters]")
    for name, value in parameters.model_dump().items():
        lines.append(f"{name} = {list(value) if isinstance(value, tuple) else value!r}")
    return "\n".join(lines) + "\n"


def write_fragment(text: str, path: Path) -> None:
    """Write a fragment, whole or not at all.

    Raises
    ------
    CatalogError
        If the file cannot be written.
    """
    with atomic_write(path, CatalogError) as draft:
        draft.write_text(text, encoding="utf-8")
