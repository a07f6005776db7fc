"""The ``hcss`` command: each command a few lines over the public API."""

from __future__ import annotations

import json
import signal
import sys
from functools import partial
from pathlib import Path
from typing import Any

import click

from hcss_twin.cli.atmosphere import atmosphere
from hcss_twin.cli.bench import bench
from hcss_twin.cli.clouds import clouds, import_command
from hcss_twin.cli.cubes import cache, export_command, report_command, verify, volume
from hcss_twin.cli.evaluate import evaluate_command
from hcss_twin.cli.fit import fit_command
from hcss_twin.cli.match import match_command
from hcss_twin.cli.options import Stop, load, progress, scenario_options
from hcss_twin.cli.propagate import is_asked, propagation_options, run_propagation
from hcss_twin.cli.sense import measured_beside, sense
from hcss_twin.cli.sweep import sweep_command
from hcss_twin.core.errors import HcssError, OptionError, ScenarioError
from hcss_twin.paper.command import reproduce
from hcss_twin.version import __version__

EXIT_FAILED = 1
EXIT_BAD_SCENARIO = EXIT_BAD_OPTION = 2
EXIT_INTERRUPTED = 130
EXIT_TERMINATED = 143


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="hcss")
def cli() -> None:
    """Infrared image sequences of clouds over sea as seen from space.

    SCENARIO is the name of a shipped scenario (`hcss scenarios`) or a TOML file.
    """


@cli.command()
@scenario_options
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Cube to write, NetCDF or a Zarr store NAME.zarr; default: NAME.nc here.",
)
@click.option("--force", is_flag=True, help="Replace an existing cube.")
@click.option(
    "--workers",
    default=1,
    show_default=True,
    type=click.IntRange(1, 1024),
    help="Processes that make frames, or tiles of large ones; the cube is the same.",
)
@click.option(
    "--scheduler", metavar="ADDRESS", help="Dask cluster that makes them instead, for example tcp://host:8786."
)
@click.option("--verbose", is_flag=True, help="Print the whole certificate.")
@propagation_options
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
@click.pass_context
def run(
    context: click.Context,
    /,
    scenario: str,
    assignments: tuple[str, ...],
    output: Path | None,
    force: bool,
    workers: int,
    scheduler: str | None,
    verbose: bool,
    as_json: bool,
    **propagation: Any,
) -> None:
    """Simulate SCENARIO and write its cube, or with --draws say how uncertain its radiance is.

    Fails, and keeps the cube, where checked pixels miss the accuracy asked for.
    """
    if is_asked(propagation):
        if workers != 1 or scheduler is not None:
            raise click.UsageError("--workers and --scheduler beside --draws, whose scenes are made in one process")
        run_propagation(context, scenario, assignments, output, force, as_json, propagation)
        return
    loaded = load(scenario, assignments)
    output = output or Path(f"{Path(scenario).stem}.nc")
    if output.exists() and not force:
        raise click.ClickException(f"{output} exists; give another name with -o, or --force")
    measured = measured_beside(output, loaded, force)
    from hcss_twin.core.environment import announce_compilation
    from hcss_twin.cube.zarr_writer import cube_bytes
    from hcss_twin.engine.simulate import run as run_plan
    from hcss_twin.plan.description import describe
    from hcss_twin.plan.make_plan import make_plan

    found: list[Any] = []
    with announce_compilation(partial(click.echo, err=True)):
        plan = make_plan(loaded)
        shown = partial(progress, context.ensure_object(Stop))
        run_plan(plan, output, shown, found.append, workers, scheduler)
    if as_json:
        told = {
            "certificate": {name: value for each in found for name, value in each.as_dict().items()} or None,
            **({} if measured is None else {"sensor_cube": str(measured)}),
        }
        click.echo(json.dumps({"cube": str(output), "bytes": cube_bytes(output), **told, **describe(plan)}))
    else:
        click.echo(f"{output}  {cube_bytes(output) / 1e6:.1f} MB")
        if measured is not None:
            click.echo(f"{measured}  {cube_bytes(measured) / 1e6:.1f} MB, as measured")
        for item in plan.filled_in:
            click.echo(f"  filled in: {item.field} = {item.value} ({item.why})")
        for certificate in found:
            click.echo("\n    ".join(("  certificate", *(certificate.lines if verbose else certificate.summary))))
        if plan.needs_radiance and not found:
            click.echo("  certificate\n    NONE: output.certificate is 0, no pixel was checked")
    for certificate in found:
        if not certificate.passed:
            click.echo(f"error: {output}: certificate {certificate.lines[0]}", err=True)
            sys.exit(EXIT_FAILED)


@cli.command()
@scenario_options
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def plan(scenario: str, assignments: tuple[str, ...], as_json: bool) -> None:
    """Say what SCENARIO needs, and what it does not, without computing it."""
    from hcss_twin.core.environment import announce_compilation
    from hcss_twin.plan.description import describe
    from hcss_twin.plan.make_plan import make_plan
    from hcss_twin.report.plan_text import plan_text

    with announce_compilation(partial(click.echo, err=True)):
        made = make_plan(load(scenario, assignments))
    click.echo(json.dumps(describe(made)) if as_json else plan_text(made))


@cli.command()
@scenario_options
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def validate(scenario: str, assignments: tuple[str, ...], as_json: bool) -> None:
    """Check SCENARIO; every problem is named at once."""
    from hcss_twin.core.environment import announce_compilation
    from hcss_twin.plan.make_plan import make_plan

    try:
        loaded = load(scenario, assignments)
        with announce_compilation(partial(click.echo, err=True)):
            make_plan(loaded)
    except ScenarioError as error:
        if not as_json:
            raise
        click.echo(json.dumps({"valid": False, "problems": [vars(problem) for problem in error.problems]}))
        sys.exit(EXIT_BAD_SCENARIO)
    click.echo(json.dumps({"valid": True, "scenario": json.loads(loaded.to_json())}) if as_json else "valid")


@cli.command()
@click.argument("cube", type=click.Path(exists=True, path_type=Path))
@click.option("-o", "--output", type=click.Path(file_okay=False, path_type=Path), help="Folder; default: beside CUBE.")
@click.option("--kelvin", is_flag=True, help="Show brightness temperature instead of radiance.")
@click.option("--variable", help="Show any variable of CUBE, for example radiance_sea_emission or cloud_thickness.")
@click.option("--frames", default=8, show_default=True, type=click.IntRange(1, 64), help="Frames per contact sheet.")
@click.option("--animation/--no-animation", default=True, show_default=True, help="Also write a GIF per band.")
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def preview(
    cube: Path, output: Path | None, kelvin: bool, variable: str | None, frames: int, animation: bool, as_json: bool
) -> None:
    """Draw CUBE: a contact sheet per band with a colour bar, and an animation."""
    from hcss_twin.report.preview import draw_preview

    paths = draw_preview(
        cube, output or cube.parent, kelvin=kelvin, frames=frames, animation=animation, variable=variable
    )
    click.echo(json.dumps([str(path) for path in paths]) if as_json else "\n".join(map(str, paths)))


@cli.command()
@click.argument("name", required=False)
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def plugins(name: str | None, as_json: bool) -> None:
    """List the providers that can be selected, and plugins that are broken; of provider NAME its parameters."""
    from hcss_twin.providers.registry.registry import Registry

    registry = Registry.discover()
    if name is not None:
        from hcss_twin.report.provider_text import described, provider_text

        found = described(registry, name)
        click.echo(json.dumps(found) if as_json else "\n\n".join(map(provider_text, found)))
        return
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
            {"entry_point": b.entry_point, "distribution": b.distribution, "version": b.version, "error": b.error}
            for b in registry.broken
        ]
        click.echo(json.dumps({"providers": entries, "broken": broken}))
        return
    kind = None
    width = max((len(entry.name) for entry in registry.entries()), default=0) + 2
    for entry in registry.entries():
        if entry.kind != kind:
            kind = entry.kind
            click.echo(click.style(f"{kind.human}s", bold=True))
        click.echo(f"  {entry.name:<{width}}{entry.summary}  [{entry.origin}]")
    for plugin in registry.broken:
        click.echo(click.style(f"broken: {plugin}", fg="red"))


@cli.command()
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def scenarios(as_json: bool) -> None:
    """List the shipped scenarios."""
    from hcss_twin.core.catalog import Catalog

    catalog = Catalog()
    titles = {
        name: catalog.toml(catalog.find(name, "scenarios", ".toml")).get("title", "")
        for name in catalog.names("scenarios", ".toml")
    }
    if as_json:
        click.echo(json.dumps(titles))
        return
    width = max(map(len, titles), default=0) + 2
    for name, title in titles.items():
        click.echo(f"{name:<{width}}{title}")


@cli.command()
def schema() -> None:
    """Print the JSON schema of scenario files, for editors."""
    from hcss_twin.scenario.reference import json_schema

    click.echo(json.dumps(json_schema(), indent=1))


cli.add_command(cache)
cli.add_command(atmosphere)
cli.add_command(import_command)
cli.add_command(clouds)
cli.add_command(match_command)
cli.add_command(fit_command)
cli.add_command(volume)
cli.add_command(verify)
cli.add_command(bench)
cli.add_command(sense)
cli.add_command(export_command)
cli.add_command(sweep_command)
cli.add_command(evaluate_command)
cli.add_command(reproduce)
cli.add_command(report_command)


def main() -> None:
    """Run the command line; every error on purpose becomes one message and an exit code.

    Exit codes: 0 done; 1 failed; 2 the scenario or the command line is wrong; 130 interrupted; 143 terminated.
    """
    stop = Stop()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)
    try:
        cli.main(prog_name="hcss", standalone_mode=False, obj=stop)
    except click.exceptions.Abort:
        click.echo("interrupted", err=True)
        sys.exit(EXIT_TERMINATED if stop.signal == signal.SIGTERM else EXIT_INTERRUPTED)
    except click.ClickException as error:
        error.show()
        sys.exit(error.exit_code)
    except ScenarioError as error:
        click.echo(str(error), err=True)
        sys.exit(EXIT_BAD_SCENARIO)
    except OptionError as error:
        click.echo(f"error: {error}", err=True)
        sys.exit(EXIT_BAD_OPTION)
    except HcssError as error:
        click.echo(f"error: {error}", err=True)
        sys.exit(EXIT_FAILED)
    except RuntimeError as error:
        if "no locator available" not in str(error):  # numba's words
            raise
        click.echo(
            "error: compiled kernels can be kept neither beside the package nor in the user's cache folder; set the "
            "environment variable NUMBA_CACHE_DIR to a folder that can be written",
            err=True,
        )
        sys.exit(EXIT_FAILED)


if __name__ == "__main__":
    main()
