"""Commands for authors of plugins: ``hcss new-plugin`` and ``hcss check``."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hcss_twin.cli.options import Number, Shared

if TYPE_CHECKING:
    from hcss_author.check import Check

_SHOWN_LINES, _SHOWN_COLUMNS = 8, 200
_WHOLE_ARRAYS = ("ACTUAL: ", "DESIRED: ", "x: ", "y: ")
_BYWORK = ("+ where <function", "assert np.False_", "First 5 mismatches", "[")
"""How lines of a message begin from which whole arrays follow, and lines that tell nothing about the numbers."""

_WIDTH = len("expected failure")


@click.command("new-plugin")
@click.argument("kind")
@click.argument("name")
@click.option(
    "--folder", type=click.Path(file_okay=False, path_type=Path), help="New folder of the package; default: hcss-NAME."
)
@Shared.json
def new_plugin(kind: str, name: str, folder: Path | None, as_json: bool) -> None:
    """Write a package with a provider or an extension of your own.

    KIND of a provider: clouds, sea, optics, atmosphere, radiance, elements, surfaces, variables or sensors; of an
    extension: rays, effect, section, light or command.

    NAME selects it in scenarios, or is the name of the command. The package is complete: it can be installed, and its
    tests pass.
    """
    from hcss_author.new_plugin.write import check_new, write_package
    from hcss_twin.providers.registry.registry import Registry

    folder = folder or Path(f"hcss-{name}")
    files = write_package(check_new(kind, name, folder, Registry.discover()), name, folder)
    if as_json:
        Shared.write_json({"folder": str(folder), "files": [str(file) for file in files]})
        return
    click.echo("\n".join(map(str, files)))
    click.echo(f"\nNext: pip install -e '{folder}[test]' && hcss check {name}")


@click.command()
@click.argument("name")
@click.option("--kind", help="Kind of the provider, where several kinds have the name.")
@click.option("--set", "assignments", multiple=True, metavar="KEY=VALUE", help="Parameter of the provider; repeat.")
@click.option(
    "--limit",
    default=120.0,
    type=Number(min=0, min_open=True),
    help="Seconds that one call may take, the compilation of its kernels included.",
)
@Shared.json
def check(name: str, kind: str | None, assignments: tuple[str, ...], limit: float, as_json: bool) -> None:
    """Hold the installed provider NAME to the conformance kit, and measure the cost of its calls.

    Every law is listed: passed, failed, expected failure (declared by the provider), not applicable, or not run. The
    command fails if a law does. Cubes quote the result.
    """
    if find_spec("pytest") is None:
        raise click.ClickException("the conformance kit needs pytest: pip install pytest")
    from hcss_author.check import check_provider, find
    from hcss_twin.providers.registry.discovery import Entry
    from hcss_twin.providers.registry.registry import Registry

    registry, parameters = Registry.discover(), Shared.assigned(assignments)
    entry = find(registry, name, kind)
    result = check_provider(entry, parameters, limit)
    if isinstance(entry, Entry):  # cubes quote the checks of providers
        model = registry.parameters_model(entry)
        registry.keep_check(entry, None if model is None else model(**parameters), result.count)
    if as_json:
        Shared.write_json(result.as_dict(), indent=1)
    else:
        click.echo(check_text(result))
    if not result.passed:
        sys.exit(1)


def check_text(check: Check) -> str:
    """Write the laws, the cost per call, and how many laws have each outcome."""
    lines = [check.title]
    before = ""
    for law in check.laws:
        lines.append(
            f"  {law.outcome:<{_WIDTH}}  {law.name}"
            + (f": {law.why}" if law.outcome not in ("passed", "failed") else "")
        )
        if law.outcome == "failed":
            shown = ["as above"] if law.why == before else [f"law: {law.meaning}", *_cut(law.why)]
            lines += [f"      {line}" for line in shown]
            before = law.why
    if check.costs:
        lines.append("  cost per call (median, and the slowest)")
        width = max(len(cost.member) for cost in check.costs)
        for cost in check.costs:
            times = f"{cost.median_s * 1e3:10.3f} ms  {cost.most_s * 1e3:10.3f} ms"
            lines.append(f"      {cost.member:<{width}}  {times}  of {cost.calls}")
    lines.append(", ".join(f"{number} {outcome}" for outcome, number in check.count.items()))
    return "\n".join(lines)


def _cut(text: str) -> list[str]:
    """Return the lines of a failure that hold its numbers, each with its beginning and its end."""
    lines = [" ".join(line.replace("\\n", " ").split()) for line in text.splitlines()]
    lines = [line for line in takewhile(lambda line: not line.startswith(_WHOLE_ARRAYS), lines) if line]
    lines = [line for line in lines if not line.startswith(_BYWORK)]
    half = _SHOWN_COLUMNS // 2
    shown = [line if len(line) <= 2 * half else f"{line[:half]} ... {line[-half:]}" for line in lines[:_SHOWN_LINES]]
    more = len(lines) - _SHOWN_LINES
    return [*shown, f"... {more} more lines in --json"] if more > 0 else shown
