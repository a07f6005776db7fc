"""``hcss fit``: how uncertain cloud parameters are, given images."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hcss_twin.cli.match import image_options, worded_for_options
from hcss_twin.cli.options import Stop, require_writable

if TYPE_CHECKING:
    from hcss_twin.analysis.uncertainty.posterior_file import Posterior


# Of the bar: a sampler tells only about how far it is.
_PARTS = 1000

# What has no meaning where only a dimension is given.
_OF_AN_IMAGE = ("variable", "method", "window_pixels", "cloud_is", "missing", "row_origin", "column_origin", "coverage")


def _pairs(context: click.Context, parameter: click.Parameter, given: tuple[str, ...]) -> dict[str, str]:
    """Read NAME=VALUE as often as it is given."""
    found: dict[str, str] = {}
    for each in given:
        name, equals, value = each.partition("=")
        if not equals or not name or not value:
            raise click.BadParameter(f"'{each}' given, allowed: NAME=VALUE")
        if name in found:
            raise click.BadParameter(f"{name} is given twice")
        found[name] = value
    return found


@click.command("fit")
@click.argument("images", nargs=-1, type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "--fd",
    type=float,
    help="Instead of IMAGES: a fractal dimension of grey levels, by the variogram, with --fd-error; --rows, "
    "--columns and --pixel-size are those of the image (800, 800, 20 m).",
)
@click.option("--fd-error", type=float, help="Standard deviation of --fd.")
@click.option(
    "--fix",
    "fixed",
    multiple=True,
    metavar="NAME=VALUE",
    callback=_pairs,
    help="Fix H, gamma, Lx, Ly (cells per 16 km) or coverage; coverage=image takes the image's.",
)
@click.option(
    "--prior",
    "priors",
    multiple=True,
    metavar="NAME=KIND:A:B",
    callback=_pairs,
    help="Prior of a parameter, or spread_NAME of several images': uniform:LOW:HIGH, loguniform:LOW:HIGH, "
    "normal:MEAN:SD or lognormal:MEDIAN:SD.",
)
@click.option(
    "--octaves",
    type=(click.IntRange(0, 16), click.IntRange(0, 16)),
    default=(0, 8),
    show_default=True,
    metavar="FIRST LAST",
    help="Octaves k of the fractal sum.",
)
@click.option(
    "--smallest-lag",
    type=click.IntRange(1),
    default=1,
    show_default=True,
    help="Pixels; shorter ones are not looked at (blur, noise).",
)
@click.option(
    "--misfit",
    type=click.FloatRange(0, 2),
    default=0.0,
    show_default=True,
    help="Relative error that every semivariance may have because real clouds are no fractal field.",
)
@click.option(
    "--samples",
    type=click.FloatRange(100, 1e6),
    default=1000.0,
    show_default=True,
    help="Effective sample size that every parameter must have.",
)
@click.option(
    "--max-steps",
    type=click.IntRange(500, 10**7),
    default=50_000,
    show_default=True,
    help="Steps per walker after which chains that have not converged are refused.",
)
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0), help="Of simulations and chains.")
@image_options
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Posterior to write, NetCDF; default: NAME-posterior.nc here.",
)
@click.option("--force", is_flag=True, help="Replace an existing posterior.")
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
@click.pass_obj
def fit_command(
    stop: Stop | None,
    /,
    images: tuple[Path, ...],
    fd: float | None,
    fd_error: float | None,
    fixed: dict[str, str],
    priors: dict[str, str],
    octaves: tuple[int, int],
    smallest_lag: int,
    misfit: float,
    samples: float,
    max_steps: int,
    seed: int,
    output: Path | None,
    force: bool,
    as_json: bool,
    **options: Any,
) -> None:
    """Sample the posterior of fractal cloud parameters given IMAGES, and write it.

    Several IMAGES have a population, whose mean and spread are sampled with the parameters of each. Chains that
    have not converged are refused; an interrupted fit goes on where it was when the command is given again.
    """
    if (fd is None) is (len(images) == 0):
        raise click.UsageError("give IMAGES, or --fd with --fd-error, and not both")
    if (fd is None) is not (fd_error is None):
        raise click.UsageError("--fd and --fd-error go together")
    output = output or Path(f"{images[0].stem if images else 'fd'}-posterior.nc")
    require_writable([output], force, "give another name with -o")
    chosen: dict[str, Any] = {
        "fixed": {name: _fixed(name, value) for name, value in fixed.items()},
        "priors": priors,
        "octaves": octaves,
        "smallest_lag": smallest_lag,
        "misfit": misfit,
        "samples": samples,
        "most_steps": max_steps,
        "seed": seed,
    }
    from hcss_twin.core.environment import announce_compilation

    with announce_compilation(lambda line: click.echo(line, err=True)), _bar(stop or Stop()) as told:
        if fd is not None and fd_error is not None:
            found = _fit_dimension(fd, fd_error, output, options, chosen, told)
        else:
            from hcss_twin.analysis.matching.target import ImageChoice
            from hcss_twin.analysis.uncertainty.fit import fit

            with worded_for_options():
                found = fit(images, output, choice=ImageChoice(**options), progress=told, **chosen)
    if as_json:
        click.echo(json.dumps(_answer(found, output)))
        return
    click.echo("\n".join([*_lines(found), f"{output}"]))


def _fit_dimension(
    fd: float,
    fd_error: float,
    output: Path,
    options: dict[str, Any],
    chosen: dict[str, Any],
    told: Callable[[str, float], None],
) -> Posterior:
    refused = [name for name in _OF_AN_IMAGE if options[name] not in (None, "auto", "error")]
    if refused:
        raise click.UsageError(f"{', '.join(refused)}: has no meaning without IMAGES; leave it out")
    from hcss_twin.analysis.uncertainty.fit import fit_dimension

    names = ("rows", "columns", "pixel_size_m")
    frame = {name: options[name] for name in names if options[name] is not None}
    return fit_dimension(fd, fd_error, output, progress=told, **frame, **chosen)


def _fixed(name: str, value: str) -> float | str:
    try:
        return float(value)
    except ValueError:
        if value == "image":
            return value
        raise click.BadParameter(f"--fix {name}: '{value}' given, allowed: a number") from None


@contextmanager
def _bar(stop: Stop) -> Iterator[Callable[[str, float], None]]:
    """Show a bar on a terminal that begins anew with each thing that is done; quiet in a pipe."""
    shown: dict[str, Any] = {}

    def close() -> None:
        for bar in shown.values():
            bar.__exit__(None, None, None)
        shown.clear()

    def told(what: str, part: float) -> None:
        stop.check()
        if not sys.stderr.isatty():
            return
        if what not in shown:
            close()
            shown[what] = click.progressbar(length=_PARTS, label=what, file=sys.stderr).__enter__()
        bar = shown[what]
        # A better estimate of the autocorrelation time may take some of it back; a bar does not go back.
        bar.update(max(0, int(part * _PARTS) - bar.pos))

    try:
        yield told
    finally:
        close()


def _summary(found: Posterior) -> dict[str, dict[str, Any]]:
    import numpy as np

    summary: dict[str, dict[str, Any]] = {}
    for name, drawn in found.samples.items():
        low, middle, high = np.quantile(drawn, [0.05, 0.5, 0.95], axis=0).tolist()
        summary[name] = {
            "mean": drawn.mean(axis=0).tolist(),
            "standard_deviation": drawn.std(axis=0).tolist(),
            "quantiles": {"0.05": low, "0.5": middle, "0.95": high},
            **found.diagnostics[name],
        }
    return summary


def _answer(found: Posterior, output: Path) -> dict[str, Any]:
    return {
        "posterior": str(output),
        "parameters": _summary(found),
        "fixed": found.fixed,
        "notes": str(found.attributes["notes"]).splitlines(),
    }


def _lines(found: Posterior) -> list[str]:
    """Tell a posterior in lines of text."""
    lines = str(found.attributes["notes"]).splitlines()
    lines.append(f"{'':<18} {'mean':>9} {'sd':>9} {'5 %':>9} {'50 %':>9} {'95 %':>9} {'ESS':>7} {'R-hat':>6}")
    for name, told in _summary(found).items():
        several = isinstance(told["mean"], list)
        for image in range(len(told["mean"]) if several else 1):
            numbers = [told["mean"], told["standard_deviation"], *told["quantiles"].values()]
            values = [each[image] for each in numbers] if several else numbers
            label = f"{name}, image {image + 1}" if several else name
            size, r_hat = told["effective_sample_size"], told["split_r_hat"]
            row = " ".join(f"{value:>9.4g}" for value in values)
            lines.append(f"{label:<18} {row} {size:>7.0f} {r_hat:>6.3f}")
    lines += [f"{name} fixed at {value:g}" for name, value in found.fixed.items()]
    return lines
