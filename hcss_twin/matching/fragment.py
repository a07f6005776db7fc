"""A match as the part of a scenario file that describes its clouds."""

from __future__ import annotations

import json
import textwrap
from pathlib import Path

from hcss_twin.clouds.fractal.parameters import FractalParameters
from hcss_twin.drafts import draft_of
from hcss_twin.errors import CatalogError
from hcss_twin.matching.cloud_image import CloudImage
from hcss_twin.matching.dimension_range import DimensionMatch
from hcss_twin.matching.match import Match

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


def clouds_fragment(
    parameters: FractalParameters, coverage: float, cloud_type: str, comments: list[str]
) -> str:
    """Return the section ``[clouds]`` of a scenario with complete parameters, under comments."""
    lines: list[str] = []
    comments = [
        *comments,
        f"The type {cloud_type} gives height and particles, which grey levels do not tell.",
    ]
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
    with draft_of(path, CatalogError) as draft:
        draft.write_text(text, encoding="utf-8")
