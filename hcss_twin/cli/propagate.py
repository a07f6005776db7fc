"""``hcss run --draws``: uncertain inputs of a scenario, propagated into radiance."""

from __future__ import annotations

import json
import sys
import warnings
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hcss_twin.cli.options import Stop, progress, require_writable
from hcss_twin.core.errors import CertificateWarning

if TYPE_CHECKING:
    from hcss_twin.sweeps.propagation.propagate import Propagation


EXIT_FAILED = 1

_OPTIONS = (
    click.option(
        "--draws",
        type=int,
        help="Propagate uncertainty: compute so many scenes with inputs drawn at random, each with two seeds, and "
        "write NAME.propagation.nc.",
    ),
    click.option(
        "--posterior",
        type=click.Path(dir_okay=False, path_type=Path),
        help="With --draws: file of `hcss fit` that cloud parameters are drawn from.",
    ),
    click.option(
        "--uncertain",
        multiple=True,
        metavar="KEY=DISTRIBUTION",
        help="With --draws: draw a key, for example sea.temperature=normal:291:0.5; repeat. As in the section "
        "[uncertain].",
    ),
    click.option(
        "--shares",
        type=click.Choice(["regression", "pick-freeze"]),
        default="regression",
        show_default=True,
        help="With --draws: which input matters, from the draws alone, or from more scenes with inputs exchanged.",
    ),
    click.option(
        "--cube-of",
        "cubes_of",
        multiple=True,
        metavar="NUMBERS",
        help="With --draws: also write the cubes of these draws, for example 0,17.",
    ),
    click.option("--layer", type=int, help="With --posterior: the cloud layer that it is of, where there are two."),
)


def propagation_options(command: Any) -> Any:
    """Add the options of a propagation."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def is_asked(given: dict[str, Any]) -> bool:
    """Say whether options ask for a propagation.

    Raises
    ------
    click.UsageError
        If some of them need ``--draws``.
    """
    if given["draws"] is not None:
        return True
    for name, option in (
        ("posterior", "--posterior"),
        ("uncertain", "--uncertain"),
        ("cubes_of", "--cube-of"),
        ("layer", "--layer"),
    ):
        if given[name] not in (None, ()):
            raise click.UsageError(f"{option} needs the number of draws: --draws N, for example 200")
    if given["shares"] != "regression":
        raise click.UsageError("--shares needs the number of draws: --draws N, for example 200")
    return False


def run_propagation(
    context: click.Context,
    scenario: str,
    assignments: tuple[str, ...],
    output: Path | None,
    force: bool,
    as_json: bool,
    given: dict[str, Any],
) -> None:
    """Propagate, and say what came out."""
    from hcss_twin.core.environment import announce_compilation
    from hcss_twin.sweeps.propagation.propagate import cube_path, propagate

    output = output or Path(f"{Path(scenario).stem}.propagation.nc")
    numbers = _numbers(given["cubes_of"])
    files = (output, *(cube_path(output, number) for number in numbers))
    require_writable(files, force, "give another name with -o")
    shown = partial(_progress, context.ensure_object(Stop))
    with announce_compilation(partial(click.echo, err=True)), warnings.catch_warnings():
        warnings.simplefilter("ignore", CertificateWarning)  # told as an error, with the exit code
        found = propagate(
            scenario,
            output,
            draws=given["draws"],
            posterior=given["posterior"],
            uncertain=_assigned(given["uncertain"], "--uncertain"),
            overrides=_assigned(assignments, "--set"),
            layer=given["layer"],
            shares=given["shares"],
            cubes_of=numbers,
            progress=shown,
        )
    _tell(found, as_json)


def _tell(found: Propagation, as_json: bool) -> None:
    from hcss_twin.report.propagation_text import propagation_text, propagation_values

    if as_json:
        click.echo(json.dumps(propagation_values(found)))
    else:
        click.echo(propagation_text(found))
        for path in found.cubes:
            click.echo(f"{path}  {path.stat().st_size / 1e6:.1f} MB")
    failed = [each for each in found.certificates if not each.passed]
    for certificate in failed:
        click.echo(f"error: certificate {certificate.lines[0]}", err=True)
    if failed:
        sys.exit(EXIT_FAILED)


def _numbers(texts: tuple[str, ...]) -> list[int]:
    found: list[int] = []
    for text in texts:
        for part in text.replace(",", " ").split():
            if not part.isdecimal():
                raise click.BadParameter(
                    f"'{part}': allowed: numbers of draws, for example 0,17", param_hint="--cube-of"
                )
            found.append(int(part))
    return list(dict.fromkeys(found))


def _assigned(texts: tuple[str, ...], option: str) -> dict[str, Any]:
    from hcss_twin.scenario.overrides import parse_assignment

    try:
        return dict(parse_assignment(text) for text in texts)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint=option) from error


def _progress(stop: Stop, draws: Any, count: int) -> Any:
    return progress(stop, draws, count, "draws")
