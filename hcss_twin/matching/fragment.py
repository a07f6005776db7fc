"""A match as the part of a scenario file that describes its clouds."""

from __future__ import annotations

import json
import textwrap
from pathlib import Path

from hcss_twin.clouds.fractal.parameters import FractalParameters
from hcss_twin.drafts import draft_of
from hcss_twin.errors import CatalogError
from hcss_twin.matching.match import Match

_WIDTH = 110


def match_fragment(match: Match, cloud_type: str) -> str:
    """Return TOML: the section ``[clouds]``, and as comments what it was made from and how good it is.

    It may end any scenario file; the image's size and pixels, for which it was judged, are a comment.
    """
    rows, columns = match.target.image.level.shape
    best, worst = min(match.rmse), max(match.rmse)
    comments = [
        f"Clouds like those of {match.target.source}, found by hcss match.",
        *match.target.notes,
        f"RMSE of eq 24 of the HCSS paper over {len(match.rmse)} seeds that the search had not seen: "
        f"{match.mean_rmse:.1%} ({best:.1%} to {worst:.1%}).",
        *(f"Not matched: {line}" for line in match.unmatched),
        f"Judged at: image = {{rows = {rows}, columns = {columns}, "
        f"pixel_size = {match.target.image.pixel_size_m:g}}}",
    ]
    return clouds_fragment(match.parameters, round(match.coverage, 6), cloud_type, comments)


def clouds_fragment(
    parameters: FractalParameters, coverage: float, cloud_type: str, comments: list[str]
) -> str:
    """Return the section ``[clouds]`` of a scenario with complete parameters, under comments."""
    lines: list[str] = []
    for comment in comments:
        # A comment in TOML holds no control characters, a file name may.
        plain = "".join(letter if letter.isprintable() else "?" for letter in comment)
        lines += textwrap.wrap(plain, _WIDTH, initial_indent="# ", subsequent_indent="#   ")
    lines += [
        "",
        "[clouds]",
        f"type = {json.dumps(cloud_type)}",
        f"coverage = {coverage!r}",
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
