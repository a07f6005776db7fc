"""The ``hcss`` command: run, plan, validate, preview and list commands; exit codes of all commands."""

from __future__ import annotations

import gc
import io
import itertools
import json
import logging
import os
import signal
import sys
import warnings
from functools import partial
from pathlib import Path
from typing import Any

import click

from hcss_twin.cli.atmosphere import atmosphere
from hcss_twin.cli.cubes import cache, measured_beside, report_command, sense, verify, volume
from hcss_twin.cli.doctor import doctor
from hcss_twin.cli.group import CommandGroup
from hcss_twin.cli.options import Announcement, Existing, Output, Shared, Stop, only_answers, scenario_options
from hcss_twin.core.errors import CacheWarning, HcssError, OptionError, ScenarioError
from hcss_twin.version import __version__

COLLECTIONS = (50_000, 20, 50)
"""Objects between two searches for cycles when one scene is computed, and how rarely older objects are searched: with
Python's 700 and 10 a run spends 4 % of its time on objects of libraries, of which none are garbage. In sweeps, cycles
of objects would stay in memory."""

TRACEBACK = "HCSS_TRACEBACK"
"""Environment variable; set, errors in the code of plugins are shown as Python does."""

EXIT_FAILED = 1
EXIT_BAD_SCENARIO = EXIT_BAD_OPTION = 2
EXIT_INTERRUPTED = 130
EXIT_TERMINATED = 143


@click.group(cls=CommandGroup, context_settings={"help_option_names": ["-h", "--help"], "show_default": True})
@click.version_option(__version__, prog_name="hcss")
def cli() -> None:
    """Simulate infrared image sequences of clouds over sea, seen from space.

    SCENARIO is the name of a shipped scenario (`hcss scenarios`) or a TOML file.
    """


@cli.command()
@scenario_options
@click.option("-o", "--output", type=Output(), help="Cube to write, NetCDF or Zarr (NAME.zarr); default: NAME.nc.")
@Shared.force
@click.option("--workers", default=1, type=click.IntRange(1, 1024), help="Processes; the result is the same.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask cluster instead of --workers, for example tcp://host:8786.")
@click.option("--verbose", is_flag=True, help="Also print the whole certificate, and notes.")
@click.option("--quiet", is_flag=True, help="Print nothing but warnings and errors.")
@Shared.json
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
    quiet: bool,
    as_json: bool,
) -> None:
    """Simulate SCENARIO and write its cube.

    If checked pixels miss the requested accuracy, the command fails and keeps the cube.
    """
    gc.set_threshold(*COLLECTIONS)
    loaded = Shared.load(scenario, assignments)
    output = output or Path(f"{Path(scenario).stem}.nc")
    from hcss_twin.core.environment import announce_compilation
    from hcss_twin.cube.zarr_writer import cube_bytes, is_zarr

    Output.require_writable([output], force, form="Zarr" if is_zarr(output) else "NetCDF")
    measured = measured_beside(output, loaded, force)
    from hcss_twin.cli.progress import shown_progress
    from hcss_twin.core.kernels import compiling_meanwhile
    from hcss_twin.core.stages import StageTimes, watched
    from hcss_twin.engine.first_kernels import kernels_of
    from hcss_twin.engine.predicted_time import expected_planning, learn, predict
    from hcss_twin.engine.simulate import run as run_plan
    from hcss_twin.plan.description import describe
    from hcss_twin.plan.make_plan import make_plan

    found: list[Any] = []
    compiled = Announcement()
    times, stop = StageTimes(), context.ensure_object(Stop)
    with (
        announce_compilation(compiled),
        compiling_meanwhile(partial(kernels_of, loaded)),
        shown_progress(stop.check, quiet, expected_planning(loaded)) as progress,
        watched(times),
    ):
        plan = make_plan(loaded)
        prediction = predict(plan, (), None if compiled.made else stop.comparable(times))
        progress.expect(prediction.seconds)
        run_plan(plan, output, progress.each, found.append, workers, scheduler, force)
    if workers == 1 and scheduler is None and not compiled.made:
        learn(plan, prediction.is_kept, stop.comparable(times))
    if as_json:
        told = {
            "certificate": {name: value for certificate in found for name, value in certificate.as_dict().items()}
            or None,
            **({} if measured is None else {"sensor_cube": str(measured)}),
        }
        took = {"processor_s": times.seconds, "predicted": prediction.as_dict()}
        Shared.write_json({"cube": str(output), "bytes": cube_bytes(output), **told, **took, **describe(plan)})
    elif not quiet:
        from hcss_twin.reports.run_text import run_text

        files = [f"{output}  {cube_bytes(output) / 1e6:.1f} MB"]
        if measured is not None:
            files.append(f"{measured}  {cube_bytes(measured) / 1e6:.1f} MB, as measured")
        certificate = found[0] if found else None
        lines = [*run_text(plan, certificate, output, files), *plan.assembly.cloud_notes]
        if verbose:
            lines += [f"filled in: {item.field} = {item.value} ({item.why})" for item in plan.filled_in]
            lines += [] if certificate is None else ["certificate", *(f"  {line}" for line in certificate.lines)]
        click.echo("\n".join(lines))
    for certificate in found:
        if not certificate.passed:
            click.echo(f"error: {output}: certificate {certificate.lines[0]}", err=True)
            sys.exit(EXIT_FAILED)


@cli.command()
@scenario_options
@click.option("--verbose", is_flag=True, help="Print all inputs, assumptions, omissions and errors.")
@Shared.json
@click.pass_context
def plan(context: click.Context, /, scenario: str, assignments: tuple[str, ...], verbose: bool, as_json: bool) -> None:
    """Show what a run of SCENARIO would need, compute and omit."""
    from hcss_twin.cli.progress import shown_progress
    from hcss_twin.core.environment import announce_compilation
    from hcss_twin.core.kernels import compiling_meanwhile
    from hcss_twin.core.stages import StageTimes, watched
    from hcss_twin.engine.first_kernels import kernels_of
    from hcss_twin.engine.predicted_time import expected_planning, learn_planning, predict
    from hcss_twin.plan.description import describe
    from hcss_twin.plan.make_plan import make_plan
    from hcss_twin.plan.provider_cost import provider_costs

    loaded, times = Shared.load(scenario, assignments), StageTimes()
    compiled = Announcement()
    stop = context.ensure_object(Stop)
    with (
        announce_compilation(compiled),
        compiling_meanwhile(partial(kernels_of, loaded)),
        shown_progress(stop.check, False, expected_planning(loaded)),
        watched(times),
    ):
        made = make_plan(loaded)
    comparable = StageTimes() if compiled.made else stop.comparable(times)
    learn_planning(made, comparable)
    if as_json:
        predicted = predict(made, provider_costs(made), comparable).as_dict()
        Shared.write_json({"predicted": predicted, **describe(made)})
    elif verbose:
        from hcss_twin.reports.plan_text import plan_text

        click.echo(plan_text(made))
    else:
        from hcss_twin.reports.plan_brief import plan_brief

        click.echo(plan_brief(made, predict(made, provider_costs(made), comparable), scenario))


@cli.command()
@scenario_options
@Shared.json
@click.pass_context
def validate(context: click.Context, /, scenario: str, assignments: tuple[str, ...], as_json: bool) -> None:
    """Check SCENARIO, or all points of a sweep, and list all problems."""
    from hcss_twin.core.environment import announce_compilation
    from hcss_twin.plan.make_plan import make_plan
    from hcss_twin.scenario.file_checks import check_of

    try:
        with announce_compilation(partial(click.echo, err=True)):
            if (check := check_of(scenario)) is not None:
                shown = partial(context.ensure_object(Stop).progress, label="planning points")
                text, values = check(scenario, Shared.assigned(assignments), shown)
                if as_json:
                    Shared.write_json({"valid": True, **values})
                else:
                    click.echo(f"valid: {text}")
                return
            loaded = Shared.load(scenario, assignments)
            make_plan(loaded)
    except ScenarioError as error:
        if not as_json:
            raise
        Shared.write_json({"valid": False, "problems": [vars(problem) for problem in error.problems]})
        sys.exit(EXIT_BAD_SCENARIO)
    if as_json:
        Shared.write_json({"valid": True, "scenario": json.loads(loaded.to_json())})
    else:
        click.echo("valid")


@cli.command()
@click.argument("cube", type=Existing())
@click.option("-o", "--output", type=click.Path(file_okay=False, path_type=Path), help="Folder; default: that of CUBE.")
@click.option(
    "--kelvin", is_flag=True, help="Insist on brightness temperature; without it, radiance where the cube has none."
)
@click.option("--variable", help="Variable to show, for example cloud_thickness; default: brightness temperature.")
@click.option(
    "--linear",
    is_flag=True,
    help="Linear scale, for example of --variable radiance; default: more contrast where values are frequent.",
)
@click.option("--frames", default=4, type=click.IntRange(1, 64), help="Frames per contact sheet.")
@click.option("--animation/--no-animation", default=True, help="Also write a GIF per band.")
@Shared.force
@Shared.json
def preview(
    cube: Path,
    output: Path | None,
    kelvin: bool,
    variable: str | None,
    linear: bool,
    frames: int,
    animation: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Draw a contact sheet and an animation for each band of CUBE, the band with most to see first."""
    from hcss_twin.reports.preview import draw_preview

    paths = draw_preview(
        cube,
        output or cube.parent,
        kelvin=kelvin,
        frames=frames,
        animation=animation,
        variable=variable,
        linear=linear,
        replace=force,
    )
    if as_json:
        Shared.write_json([str(path) for path in paths])
    else:
        click.echo("\n".join(map(str, paths)))


@cli.command()
@click.argument("name", required=False)
@Shared.json
def plugins(name: str | None, as_json: bool) -> None:
    """List providers, commands of plugins, and broken plugins; with NAME describe one provider and its parameters."""
    from hcss_twin.providers.registry.registry import Registry

    registry = Registry.discover()
    if name is not None:
        from hcss_twin.reports.provider_text import described, provider_text

        providers = described(registry, name)
        if as_json:
            Shared.write_json(providers)
        else:
            click.echo("\n\n".join(map(provider_text, providers)))
        return
    commands, broken, remarks = cli.plugin_commands()
    entries, broken, remarks = registry.entries(), [*registry.broken, *broken], [*registry.remarks, *remarks]
    if as_json:
        facts = ("name", "distribution", "version", "summary", "references")
        answer = {
            "providers": [
                {"kind": str(entry.kind), **{key: getattr(entry, key) for key in facts}} for entry in entries
            ],
            "commands": [
                {
                    "name": command.spec.name,
                    "summary": command.spec.summary,
                    "distribution": command.origin.distribution,
                }
                for command in commands.values()
            ],
            "broken": [
                {key: getattr(plugin, key) for key in ("entry_point", "distribution", "version", "error")}
                for plugin in broken
            ],
            "remarks": [{**vars(remark.origin), "topic": remark.topic, "remark": remark.text} for remark in remarks],
        }
        Shared.write_json(answer)
        return
    rows = [(f"{entry.kind.human}s", entry.name, entry.summary, entry.origin) for entry in entries]
    rows += [
        ("commands", command.spec.name, command.spec.summary, command.origin) for _, command in sorted(commands.items())
    ]
    width = max(len(row[1]) for row in rows) + 2
    for heading, group in itertools.groupby(rows, key=lambda row: row[0]):
        click.echo(click.style(heading, bold=True))
        for _, title, summary, origin in group:
            click.echo(f"  {title:<{width}}{summary}  [{origin}]")
    for remark in remarks:
        click.echo(click.style(f"remark: {remark}", fg="yellow"))
    for plugin in broken:
        click.echo(click.style(f"broken: {plugin}", fg="red"))


@cli.command()
@Shared.json
def scenarios(as_json: bool) -> None:
    """List the shipped scenarios."""
    from hcss_twin.core.catalog import Catalog

    catalog = Catalog()
    titles = {
        name: catalog.toml(catalog.find(name, "scenarios", ".toml")).get("title", "")
        for name in catalog.names("scenarios", ".toml")
    }
    if as_json:
        Shared.write_json(titles)
        return
    width = max(map(len, titles), default=0) + 2
    for name, title in titles.items():
        click.echo(f"{name:<{width}}{title}")


@cli.command()
def schema() -> None:
    """Print the JSON schema of scenario files for editors."""
    from hcss_twin.scenario.plugin_sections import owned_schemas
    from hcss_twin.scenario.reference import json_schema

    with only_answers():
        Shared.write_json(json_schema(owned_schemas()), indent=1)


for _command in (atmosphere, cache, doctor, report_command, sense, verify, volume):
    cli.add_command(_command)


def main() -> None:
    """Run the command line; report errors of the package as a message and an exit code.

    Exit codes: 0 success; 1 failure; 2 wrong scenario or command line; 130 interrupted; 143 terminated.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # some file names are not text, and some terminals lack letters
            stream.reconfigure(errors="backslashreplace")
    warnings.showwarning = _show_warning
    logging.getLogger("hcss_twin.providers").addHandler(_Shown(logging.WARNING))
    stop = Stop(is_process=True)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)
    try:
        _run(stop)
    except BaseException:
        # A library may have turned the interrupt into another exception, for example an ImportError.
        if not stop.signal:
            raise
        click.echo("interrupted", err=True)
        # If the interrupt hit exec(), as in a library that creates classes, Python exits by SIGINT unless exec() runs
        # again.
        exec("")
        sys.exit(EXIT_TERMINATED if stop.signal == signal.SIGTERM else EXIT_INTERRUPTED)
    finally:
        gc.freeze()  # Python would search everything for cycles before it ends, .15 s


class _Shown(logging.Handler):
    """Prints what providers log, as a message."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print one record: level, provider, and text."""
        whose = record.name.removeprefix("hcss_twin.providers.")
        click.echo(f"{record.levelname.lower()}: {whose}: {record.getMessage()}", err=True)


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: Any = None,
    line: str | None = None,
) -> None:
    """Print a warning of this package as a message, and others as Python does."""
    if issubclass(category, CacheWarning):
        click.echo(f"warning: {message}", err=True)
    else:
        click.echo(warnings.formatwarning(message, category, filename, lineno, line), err=True, nl=False)


def _run(stop: Stop) -> None:
    try:
        cli.main(prog_name="hcss", standalone_mode=False, obj=stop)
    except click.exceptions.Abort:  # at a prompt
        sys.exit(EXIT_INTERRUPTED)
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
    except MemoryError as error:
        from hcss_twin.core.memory import out_of_memory

        click.echo(f"error: {out_of_memory(error)}", err=True)
        sys.exit(EXIT_FAILED)
    except Exception as error:
        from hcss_twin.core.plugins import plugin_at_fault

        culprit = "" if TRACEBACK in os.environ else plugin_at_fault(error)
        if not culprit:
            raise
        click.echo(f"error: {culprit}; {TRACEBACK}=1 shows the traceback", err=True)
        sys.exit(EXIT_FAILED)


if __name__ == "__main__":
    main()
