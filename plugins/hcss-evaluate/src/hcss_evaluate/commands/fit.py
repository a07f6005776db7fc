"""``hcss fit``: uncertainty of cloud parameters given images."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hcss_evaluate.commands.image_options import image_options, refuse_image_options, worded_for_options
from hcss_twin.cli.options import Existing, Number, Output, Shared, Stop

if TYPE_CHECKING:
    from hcss_evaluate.posterior.posterior_file import Posterior


# Steps of the progress bar; a sampler reports only approximate progress.
_PARTS = 1000

_SAMPLING = ("cloud_type", "priors", "octaves", "smallest_lag", "misfit", "samples", "most_steps", "seed")
"""Options that are passed to ``fit`` unchanged."""


def _pairs(context: click.Context, parameter: click.Parameter, given: tuple[str, ...]) -> dict[str, str]:
    """Parse repeated NAME=VALUE options."""
    found: dict[str, str] = {}
    for pair in given:
        name, equals, value = pair.partition("=")
        if not equals or not name or not value:
            raise click.BadParameter(f"'{pair}' given, allowed: NAME=VALUE")
        if name in found:
            raise click.BadParameter(f"{name} is given twice")
        found[name] = value
    return found


@click.command("fit")
@click.argument("images", nargs=-1, type=Existing(dir_okay=False))
@click.option(
    "--fd",
    type=Number(),
    help="Instead of IMAGES: fractal dimension of grey levels by the variogram, with --fd-error. --rows, --columns and "
    "--pixel-size describe the image (800, 800, 20 m).",
)
@click.option("--fd-error", type=Number(), help="Standard deviation of --fd.")
@click.option(
    "--fix",
    "fixed",
    multiple=True,
    metavar="NAME=VALUE",
    callback=_pairs,
    help="Fix H, gamma, Lx, Ly (cells per 16 km) or coverage; coverage=image uses the image's.",
)
@click.option(
    "--prior",
    "priors",
    multiple=True,
    metavar="NAME=KIND:A:B",
    callback=_pairs,
    help="Prior of a parameter (or spread_NAME of several images): uniform:LOW:HIGH, loguniform:LOW:HIGH, "
    "normal:MEAN:SD or lognormal:MEDIAN:SD.",
)
@click.option(
    "--type",
    "cloud_type",
    help="Cloud type of the image, which sets octaves and gamma, and priors of Lx and Ly about its own.",
)
@click.option(
    "--octaves",
    type=(click.IntRange(0, 16), click.IntRange(0, 16)),
    metavar="FIRST LAST",
    help="Octaves k of the fractal sum; default: those of --type, else 0 and an unknown last one, 3 to 10.",
)
@click.option("--smallest-lag", type=click.IntRange(1), default=1, help="Shortest lag used, pixels.")
@click.option("--misfit", type=Number(0, 2), default=0.0, help="Relative model error of each semivariance.")
@click.option(
    "--samples",
    type=Number(100, 1e6),
    default=1000.0,
    help="Required bulk and tail effective sample size of the stored draws of every parameter.",
)
@click.option(
    "--max-steps",
    "most_steps",
    type=click.IntRange(500, 10**7),
    default=50_000,
    help="Largest number of steps per walker; chains that have not converged by then are rejected.",
)
@click.option("--seed", default=0, type=click.IntRange(0), help="Seed of simulations and chains.")
@image_options
@click.option(
    "-o", "--output", type=Output(dir_okay=False), help="Posterior to write, NetCDF; default: NAME-posterior.nc."
)
@Shared.force
@Shared.json
@click.pass_obj
def fit_command(
    stop: Stop | None,
    /,
    images: tuple[Path, ...],
    fd: float | None,
    fd_error: float | None,
    fixed: dict[str, str],
    output: Path | None,
    force: bool,
    as_json: bool,
    **options: Any,
) -> None:
    """Sample the posterior of fractal cloud parameters given IMAGES.

    With several IMAGES, mean and spread of their population are sampled with the parameters of each. Chains that have
    not converged are rejected. An interrupted fit continues when the command is repeated.
    """
    if (fd is None) is (len(images) == 0):
        raise click.UsageError("give IMAGES, or --fd with --fd-error, and not both")
    if (fd is None) is not (fd_error is None):
        raise click.UsageError("--fd and --fd-error must be given together")
    output = output or Path(f"{images[0].stem if images else 'fd'}-posterior.nc")
    Output.require_writable([output], force, form="NetCDF")
    sampling = {name: options.pop(name) for name in _SAMPLING}
    sampling["fixed"] = {name: _fixed(name, value) for name, value in fixed.items()}
    if fd is not None:
        refuse_image_options(options, "IMAGES", "coverage")
    from hcss_evaluate.matching.target import ImageChoice
    from hcss_evaluate.posterior.fit import fit, fit_dimension
    from hcss_twin.core.environment import announce_compilation

    with announce_compilation(partial(click.echo, err=True)), _bar(stop or Stop()) as report, worded_for_options():
        if fd is not None and fd_error is not None:
            frame = {name: options[name] for name in ("rows", "columns", "pixel_size_m") if options[name] is not None}
            posterior = fit_dimension(fd, fd_error, output, progress=report, **frame, **sampling)
        else:
            posterior = fit(images, output, choice=ImageChoice(**options), progress=report, **sampling)
    summary = _summary(posterior)
    notes = str(posterior.attributes["notes"]).splitlines()
    p_values = posterior.predictive_p_values
    octaves = _last_octaves(posterior)
    if as_json:
        answer = {
            "posterior": str(output),
            "parameters": summary,
            "fixed": posterior.fixed,
            "last_octave": octaves,
            "predictive_p_values": [p for _, p in p_values],
            "doubts": posterior.doubts,
            "notes": notes,
        }
        Shared.write_json(answer)
    else:
        fixed_lines = [f"{name} fixed at {value:g}" for name, value in posterior.fixed.items()]
        p_lines = [f"{name}: posterior predictive p = {p:.2g}" for name, p in p_values]
        octave_lines = [f"last octave, draws: {', '.join(f'{last} {part:.0%}' for last, part in octaves.items())}"]
        doubt_lines = [f"doubt: {doubt['image']}: {doubt['reason']}" for doubt in posterior.doubts]
        click.echo(
            "\n".join([*notes, *_table(summary), *fixed_lines, *octave_lines, *p_lines, *doubt_lines, str(output)])
        )


def _fixed(name: str, value: str) -> float | str:
    try:
        return float(value)
    except ValueError:
        if value == "image":
            return value
        raise click.BadParameter(f"--fix {name}: '{value}' given, allowed: a number") from None


@contextmanager
def _bar(stop: Stop) -> Iterator[Callable[[str, float], None]]:
    """If stderr is a terminal, show a progress bar that restarts with each task."""
    shown: dict[str, Any] = {}

    def close() -> None:
        for bar in shown.values():
            bar.__exit__(None, None, None)
        shown.clear()

    def report(what: str, part: float) -> None:
        stop.check()
        if not sys.stderr.isatty():
            return
        if what not in shown:
            close()
            shown[what] = click.progressbar(length=_PARTS, label=what, file=sys.stderr).__enter__()
        bar = shown[what]
        # A better estimate of the autocorrelation time may reduce the progress; the bar does not go back.
        bar.update(max(0, int(part * _PARTS) - bar.pos))

    try:
        yield report
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


def _last_octaves(found: Posterior) -> dict[int, float]:
    """Return the fraction of the draws with each last octave."""
    import numpy as np

    drawn = found.attributes["octaves"][1:] if found.last_octave is None else found.last_octave
    values, counts = np.unique(np.asarray(drawn), return_counts=True)
    return {int(value): float(count) / counts.sum() for value, count in zip(values, counts, strict=True)}


def _table(summary: dict[str, dict[str, Any]]) -> list[str]:
    header = [f"{name:>9}" for name in ("mean", "sd", "5 %", "50 %", "95 %", "bulk ESS", "tail ESS", "R-hat")]
    lines = [" ".join([f"{'':<18}", *header])]
    for name, statistics in summary.items():
        several = isinstance(statistics["mean"], list)
        for image in range(len(statistics["mean"]) if several else 1):
            numbers = [statistics["mean"], statistics["standard_deviation"], *statistics["quantiles"].values()]
            values = [number[image] for number in numbers] if several else numbers
            label = f"{name}, image {image + 1}" if several else name
            row = " ".join(f"{value:>9.4g}" for value in values)
            size, tail = statistics["bulk_effective_sample_size"], statistics["tail_effective_sample_size"]
            r_hat = statistics["rank_normalized_split_r_hat"]
            lines.append(f"{label:<18} {row} {size:>9.0f} {tail:>9.0f} {r_hat:>9.3f}")
    return lines
