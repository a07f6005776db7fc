"""The ``hcss`` command: each command a few lines over the public API."""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import click

from hcss_twin import __version__
from hcss_twin.errors import HcssError, ScenarioError

EXIT_FAILED = 1
EXIT_BAD_SCENARIO = 2
EXIT_INTERRUPTED = 130


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="hcss")
def cli() -> None:
    """Infrared image sequences of clouds over sea as seen from space.

    SCENARIO is the name of a shipped scenario (`hcss scenarios`) or a TOML file.
    """


def _scenario_options(command: Any) -> Any:
    command = click.option(
        "--set",
        "assignments",
        multiple=True,
        metavar="KEY=VALUE",
        help="Replace one key, for example view.zenith=40.",
    )(command)
    return click.argument("scenario")(command)


def _load(scenario: str, assignments: Iterable[str]) -> Any:
    from hcss_twin.scenario.overrides import parse_assignment
    from hcss_twin.scenario.scenario import Scenario

    try:
        overrides = dict(parse_assignment(text) for text in assignments)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--set") from error
    return Scenario.load(scenario, overrides)


@cli.command()
@_scenario_options
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Cube to write; default: NAME.nc here.")
@click.option("--force", is_flag=True, help="Replace an existing cube.")
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def run(scenario: str, assignments: tuple[str, ...], output: Path | None, force: bool, as_json: bool) -> None:
    """Simulate SCENARIO and write its cube."""
    loaded = _load(scenario, assignments)
    output = output or Path(f"{Path(scenario).stem}.nc")
    if output.exists() and not force:
        raise click.ClickException(f"{output} exists; give another name with -o, or --force")
    from hcss_twin.scene.plan import make_plan
    from hcss_twin.scene.simulate import run as run_plan

    plan = make_plan(loaded)
    run_plan(plan, output, _progress)
    if as_json:
        click.echo(json.dumps({"cube": str(output), "bytes": output.stat().st_size, **plan.as_dict()}))
    else:
        click.echo(f"{output}  {output.stat().st_size / 1e6:.1f} MB")
        for item in plan.filled_in:
            click.echo(f"  filled in: {item.field} = {item.value} ({item.why})")


@cli.command()
@_scenario_options
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def plan(scenario: str, assignments: tuple[str, ...], as_json: bool) -> None:
    """Say what SCENARIO needs, and what it does not, without computing it."""
    from hcss_twin.reporting.plan_text import plan_text
    from hcss_twin.scene.plan import make_plan

    made = make_plan(_load(scenario, assignments))
    click.echo(json.dumps(made.as_dict()) if as_json else plan_text(made))


@cli.command()
@_scenario_options
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def validate(scenario: str, assignments: tuple[str, ...], as_json: bool) -> None:
    """Check SCENARIO; every problem is named at once."""
    from hcss_twin.scene.plan import make_plan

    try:
        loaded = _load(scenario, assignments)
        make_plan(loaded)
    except ScenarioError as error:
        if not as_json:
            raise
        click.echo(json.dumps({"valid": False, "problems": [vars(problem) for problem in error.problems]}))
        sys.exit(EXIT_BAD_SCENARIO)
    click.echo(json.dumps({"valid": True, "scenario": json.loads(loaded.to_json())}) if as_json else "valid")


@cli.command()
@click.argument("cube", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "-o", "--output", type=click.Path(file_okay=False, path_type=Path), help="Folder; default: beside CUBE."
)
@click.option("--kelvin", is_flag=True, help="Show brightness temperature instead of radiance.")
@click.option(
    "--frames", default=8, show_default=True, type=click.IntRange(1, 64), help="Frames per contact sheet."
)
@click.option(
    "--animation/--no-animation", default=True, show_default=True, help="Also write a GIF per band."
)
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def preview(
    cube: Path, output: Path | None, kelvin: bool, frames: int, animation: bool, as_json: bool
) -> None:
    """Draw CUBE: a contact sheet per band with a colour bar, and an animation."""
    from hcss_twin.reporting.preview import draw_preview

    paths = draw_preview(cube, output or cube.parent, kelvin=kelvin, frames=frames, animation=animation)
    click.echo(json.dumps([str(path) for path in paths]) if as_json else "\n".join(map(str, paths)))


@cli.command()
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def plugins(as_json: bool) -> None:
    """List the providers that can be selected, and plugins that are broken."""
    from hcss_twin.registry.registry import Registry

    registry = Registry.discover()
    if as_json:
        entries = [
            {
                "kind": str(entry.kind),
                "name": entry.name,
                "distribution": entry.distribution,
                "version": entry.version,
                "summary": entry.summary,
                "references": list(entry.references),
            }
            for entry in registry.entries()
        ]
        broken = [
            {
                "entry_point": b.entry_point,
                "distribution": b.distribution,
                "version": b.version,
                "error": b.error,
            }
            for b in registry.broken
        ]
        click.echo(json.dumps({"providers": entries, "broken": broken}))
        return
    kind = None
    for entry in registry.entries():
        if entry.kind != kind:
            kind = entry.kind
            click.echo(click.style(f"{kind.human}s", bold=True))
        click.echo(f"  {entry.name:<14}{entry.summary}  [{entry.origin}]")
    for plugin in registry.broken:
        click.echo(click.style(f"broken: {plugin}", fg="red"))


@cli.command()
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def scenarios(as_json: bool) -> None:
    """List the shipped scenarios."""
    from hcss_twin.catalog import Catalog

    catalog = Catalog()
    titles = {
        name: catalog.toml(catalog.find(name, "scenarios", ".toml")).get("title", "")
        for name in catalog.names("scenarios", ".toml")
    }
    if as_json:
        click.echo(json.dumps(titles))
        return
    for name, title in titles.items():
        click.echo(f"{name:<14}{title}")


@cli.command()
def schema() -> None:
    """Print the JSON schema of scenario files, for editors."""
    from hcss_twin.scenario.reference import json_schema

    click.echo(json.dumps(json_schema(), indent=1))


@cli.group()
def atmosphere() -> None:
    """Bring results of other radiative-transfer codes, and look at atmospheres."""


@atmosphere.command("import")
@click.argument(
    "files", nargs=-1, required=True, type=click.Path(exists=True, dir_okay=False, path_type=Path)
)
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="Table to write (.nc).")
@click.option(
    "--format",
    "file_format",
    default="auto",
    show_default=True,
    type=click.Choice(["auto", "modtran-tape7", "modtran6-json", "modtran6-csv", "libradtran"]),
    help="What the files are.",
)
@click.option("--profile", help="Atmosphere of the runs: catalog name or CSV file.")
@click.option("--resolution", type=click.FloatRange(min=0), help="Spectral resolution in cm-1.")
@click.option(
    "--geometry",
    multiple=True,
    metavar="[FILE=]H1,H2,ANGLE",
    help="Line of sight in km, km, deg where a file does not tell; above 90 deg the observer looks down.",
)
@click.option("--output-user", help="uvspec: the output_user line, for example 'lambda edir uu'.")
@click.option(
    "--setting", multiple=True, metavar="LINE", help="uvspec: a line of its input, for example 'sza 20'."
)
@click.option("--title", help="Title of the table.")
@click.option("--force", is_flag=True, help="Replace an existing table.")
def atmosphere_import(
    files: tuple[Path, ...],
    output: Path,
    file_format: str,
    profile: str | None,
    resolution: float | None,
    geometry: tuple[str, ...],
    output_user: str | None,
    setting: tuple[str, ...],
    title: str | None,
    force: bool,
) -> None:
    """Combine FILES of MODTRAN or libRadtran into one atmosphere table."""
    from hcss_twin.atmosphere.imports.reader import ReadOptions, parse_geometry
    from hcss_twin.atmosphere.imports.run import import_files

    if output.exists() and not force:
        raise click.ClickException(f"{output} exists; give another name with -o, or --force")
    try:
        sights = dict(parse_geometry(text) for text in geometry)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--geometry") from error
    settings = (*setting, f"output_user {output_user}") if output_user else setting
    options = ReadOptions(file_format, sights, settings)
    checks = import_files(files, output, options, profile=profile, resolution_cm1=resolution, title=title)
    click.echo(
        "\n".join([*(f"  {line}" for line in checks), f"{output}  {output.stat().st_size / 1e6:.1f} MB"])
    )


@atmosphere.command("plot")
@click.argument("sources", nargs=-1, required=True, metavar="PROVIDER_OR_TABLE...")
@click.option(
    "-o", "--output", required=True, type=click.Path(path_type=Path), help="Picture to write (.png)."
)
@click.option("--profile", default="us-standard-1976", show_default=True, help="Atmosphere of the providers.")
@click.option(
    "--zenith", multiple=True, type=click.FloatRange(0, 90, max_open=True), help="Angle in deg; repeat."
)
@click.option("--height", multiple=True, type=click.FloatRange(min=0), help="Target height in m; repeat.")
@click.option("--range-um", nargs=2, type=float, default=(2.5, 14.3), show_default=True, help="Wavelengths.")
def atmosphere_plot(
    sources: tuple[str, ...],
    output: Path,
    profile: str,
    zenith: tuple[float, ...],
    height: tuple[float, ...],
    range_um: tuple[float, float],
) -> None:
    """Draw transmittance and path radiance of a provider or table, or compare two."""
    from hcss_twin.reporting import atmosphere_plot as plot

    if len(sources) > 2:
        raise click.UsageError(f"{len(sources)} sources; one is drawn, or two are compared")
    spectra = plot.sample(
        [plot.open_source(name, profile) for name in sources],
        zenith or plot.ZENITHS_DEG,
        height or plot.HEIGHTS_M,
        range_um,
    )
    plot.draw(spectra, output)
    lines = plot.compare(spectra[0], spectra[1]) if len(spectra) == 2 else []
    click.echo("\n".join([*lines, str(output)]))


def _progress(frames: Iterable[Any], count: int) -> Iterator[Any]:
    """Show a bar on a terminal; stay quiet in a pipe."""
    if not sys.stderr.isatty():
        yield from frames
        return
    with click.progressbar(frames, length=count, label="frames", file=sys.stderr, show_pos=True) as bar:
        yield from bar


def _terminate(number: int, _frame: object) -> None:
    # An exception unwinds the writer, which removes its partial file.
    raise SystemExit(128 + number)


def main() -> None:
    """Run the command line; every error on purpose becomes one message and an exit code.

    Exit codes: 0 done; 1 failed; 2 the scenario or the command line is wrong; 130 interrupted.
    """
    signal.signal(signal.SIGTERM, _terminate)
    try:
        cli.main(prog_name="hcss", standalone_mode=False)
    except click.exceptions.Abort:
        click.echo("interrupted", err=True)
        sys.exit(EXIT_INTERRUPTED)
    except click.ClickException as error:
        error.show()
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        click.echo("interrupted", err=True)
        sys.exit(EXIT_INTERRUPTED)
    except ScenarioError as error:
        click.echo(str(error), err=True)
        sys.exit(EXIT_BAD_SCENARIO)
    except HcssError as error:
        click.echo(f"error: {error}", err=True)
        sys.exit(EXIT_FAILED)


if __name__ == "__main__":
    main()
