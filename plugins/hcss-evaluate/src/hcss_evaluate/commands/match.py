"""``hcss match``: parameters of the cloud generator for a measured image or a fractal dimension."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from hcss_evaluate.commands.image_options import image_options, refuse_image_options, worded_for_options
from hcss_evaluate.matching import BUDGET
from hcss_evaluate.numbers import json_number
from hcss_twin.cli.options import Existing, Number, Output, Shared

if TYPE_CHECKING:
    from hcss_evaluate.matching.match import Match
    from hcss_twin.models.clouds.fractal.parameters import FractalParameters


@click.command("match")
@click.argument("image", required=False, type=Existing())
@click.option(
    "--fd",
    "wanted",
    type=(Number(), Number()),
    metavar="LOW HIGH",
    help="Required range of the fractal dimension, within 2 to 3; adjusts the parameters of IMAGE or --type.",
)
@click.option(
    "--dimension",
    default="fractal",
    type=click.Choice(["fractal", "surface"]),
    help="Dimension of --fd: that of the paper's tables, or that of the variogram of grey levels.",
)
@image_options
@click.option("--type", "cloud_type", default="cumulus", help="Cloud type, which sets height and particles.")
@click.option("--seed", default=0, type=click.IntRange(0), help="First seed of the search.")
@click.option(
    "--budget",
    default=BUDGET,
    type=click.IntRange(0, 100_000),
    help="Images to simulate in the search; 0: only the analytic start.",
)
@click.option("-o", "--output", type=Output(dir_okay=False), help="Fragment to write; default: NAME-clouds.toml.")
@click.option("--preview", type=Output(dir_okay=False), help="Also draw IMAGE next to a simulation (.png).")
@Shared.force
@Shared.json
def match_command(
    image: Path | None,
    wanted: tuple[float, float] | None,
    dimension: Literal["fractal", "surface"],
    cloud_type: str,
    seed: int,
    budget: int,
    output: Path | None,
    preview: Path | None,
    force: bool,
    as_json: bool,
    **options: Any,
) -> None:
    """Estimate the parameters of fractal clouds that resemble IMAGE, and write them as a scenario fragment.

    IMAGE is NetCDF (also GOES ABI), GeoTIFF, PNG, JPEG, NumPy or an entry of the cloud database. The fragment is a
    section [clouds]; append it to a scenario without one. Quantities that could not be matched are listed.
    """
    if image is None and wanted is None:
        raise click.UsageError("nothing to match: give an IMAGE, --fd LOW HIGH, or both")
    output = output or Path(f"{image.stem if image else cloud_type}-clouds.toml")
    Output.require_different({"-o": output, "--preview": preview})
    Output.require_writable([output], force, "give another name", form="TOML")
    Output.require_writable([preview], force, "give another name", form="PNG")
    from hcss_evaluate.matching.dimension_range import type_parameters
    from hcss_evaluate.matching.match import write_fragment
    from hcss_twin.providers import Catalog

    # Checked before the search, which is slow.
    usual = type_parameters(cloud_type, Catalog())
    coverage = options["coverage"]
    done = None if image is None else _match_image(image, options, seed, budget, cloud_type)
    if wanted is not None:
        if done is None and coverage is None:
            raise click.UsageError("--fd without IMAGE needs --coverage")
        done = _match_range(wanted, dimension, done, usual, coverage, seed, cloud_type, options)
    assert done is not None
    if preview is not None:
        done.draw(preview)
    write_fragment(done.text, output)
    answer = {**done.answer, "fragment": str(output), "preview": None if preview is None else str(preview)}
    files = str(output) if preview is None else f"{output}  {preview}"
    if as_json:
        Shared.write_json(answer)
    else:
        click.echo("\n".join([*done.lines, files]))


@dataclass(frozen=True)
class _Result:
    """Fitted parameters with their text, fragment and figure."""

    text: str
    answer: dict[str, Any]
    lines: list[str]
    draw: Callable[[Path], None]
    match: Match | None = None


def _match_image(image: Path, options: dict[str, Any], seed: int, budget: int, cloud_type: str) -> _Result:
    from hcss_evaluate.matching.match import match, match_fragment
    from hcss_evaluate.matching.target import ImageChoice, read_target
    from hcss_evaluate.pages.cloud_pictures import draw_match

    with worded_for_options():
        target = read_target(image, ImageChoice(**options))
    if sys.stderr.isatty():
        with click.progressbar(length=max(1, budget), label="simulations", file=sys.stderr) as bar:
            found = match(target, seed, budget, bar.update)
    else:
        found = match(target, seed, budget)
    answer = {
        "source": target.source,
        "notes": target.notes,
        "coverage": found.coverage,
        "parameters": found.parameters.model_dump(mode="json"),
        "rmse": found.rmse,
        "mean_rmse": found.mean_rmse,
        "start_rmse": found.start_rmse,
        "seeds": found.seeds,
        "simulations": found.simulations,
        "quantities": [
            {
                "name": quantity.name,
                "meaning": quantity.meaning,
                **{name: json_number(getattr(quantity, name)) for name in ("image", "simulated", "spread", "error")},
                "matched": quantity.is_matched,
            }
            for quantity in found.quantities
        ],
        "likeness": {**asdict(found.likeness), "ratio": found.likeness.ratio},
        "unmatched": found.unmatched,
    }
    return _Result(match_fragment(found, cloud_type), answer, _match_text(found), partial(draw_match, found), found)


def _match_text(found: Match) -> list[str]:
    """Format fitted parameters as lines of text."""
    lines = [
        *found.target.notes,
        f"{'':<11} {'image':>9} {'simulated':>9} {'spread':>8} {'error':>8}  "
        "(of the simulation: % of the image's value, or the difference)",
    ]
    for quantity in found.quantities:
        error = f"{quantity.error:+.1%}" if quantity.is_ratio else f"{quantity.error:+.3f}"
        mark = "" if quantity.is_matched else "  not matched"
        lines.append(
            f"{quantity.name:<11} {quantity.image:>9.4g} {quantity.simulated:>9.4g} {quantity.spread:>8.2g} "
            f"{error:>8}{mark}"
        )
    start = sum(found.start_rmse) / len(found.start_rmse)
    lines.append(
        f"RMSE (eq 24) {found.mean_rmse:.1%}, {min(found.rmse):.1%} to {max(found.rmse):.1%} over {len(found.rmse)} "
        f"fresh seeds; {start:.1%} before the {found.simulations} simulations of the search"
    )
    lines += [f"not matched: {line}" for line in found.unmatched]
    return [*lines, _parameters_text(found.parameters, found.coverage)]


def _parameters_text(p: FractalParameters, coverage: float) -> str:
    x, y = p.L or (math.nan, math.nan)
    return (
        f"gamma {p.gamma:g}, H {p.H:g}, L [{x:g}, {y:g}], k {list(p.k or ())}, brightness_exponent "
        f"{p.brightness_exponent:g}, coverage {coverage:.4f}"
    )


def _match_range(
    wanted: tuple[float, float],
    dimension: Literal["fractal", "surface"],
    done: _Result | None,
    usual: FractalParameters,
    coverage: float | None,
    seed: int,
    cloud_type: str,
    options: dict[str, Any],
) -> _Result:
    from hcss_evaluate.matching.dimension_range import (
        PIXEL_SIZE_M,
        SIDE,
        dimension_fragment,
        empty_frame,
        match_dimension,
    )
    from hcss_evaluate.matching.structure import simulate_image
    from hcss_evaluate.pages.cloud_pictures import draw_dimension

    if done is not None and done.match is not None:
        match = done.match
        start, like, coverage = match.parameters, match.target.image, match.coverage
        origin = f"the match of {match.target.source}"
        answer, lines = done.answer, [*done.lines, ""]
    else:
        refuse_image_options(options, "IMAGE")
        like = empty_frame(options["rows"] or SIDE, options["columns"] or SIDE, options["pixel_size_m"] or PIXEL_SIZE_M)
        start, origin = usual, f"the type {cloud_type}"
        answer, lines = {}, []
    assert coverage is not None
    found = match_dimension(wanted, start, coverage, like, dimension, seed)
    mean = sum(found.dimensions) / len(found.dimensions)
    p = found.parameters
    lines += [
        f"{dimension} dimension {wanted[0]:g} to {wanted[1]:g} wanted: {mean:.3f}, {min(found.dimensions):.3f} to "
        f"{max(found.dimensions):.3f} over {len(found.seeds)} fresh seeds, {found.inside:.0%} of them inside",
        f"changed of {origin}: {found.changed}",
        _parameters_text(p, coverage),
    ]
    answer = {
        **answer,
        "coverage": coverage,
        "parameters": p.model_dump(mode="json"),
        "dimension": dimension,
        "wanted": wanted,
        "dimensions": found.dimensions,
        "dimension_seeds": found.seeds,
        "inside": found.inside,
        "changed": found.changed,
    }

    def draw(path: Path) -> None:
        middle = sorted(found.dimensions)[(len(found.dimensions) - 1) // 2]
        shown = found.seeds[found.dimensions.index(middle)]
        panels = [(f"simulated, seed {shown}: {middle:.3f}", simulate_image(p, coverage, like, shown))]
        if done is not None and done.match is not None:
            panels.insert(0, (done.match.target.source, like))
        draw_dimension(found, panels, path)

    text = dimension_fragment(found, coverage, like, origin, cloud_type)
    return _Result(text, answer, lines, draw)
