"""Page of all comparisons, from ``catalogs/evidence.toml``."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from hcss_twin.reports.evidence import KINDS, Comparison, EvidenceCatalog
from hcss_twin.reports.evidence_page import failed_figure

PAGE = "reference/evidence.md"

_INTRODUCTION = """# Evidence

{generated}

Comparisons of the models with references. `hcss report --evidence CUBE` selects those of a scene
([how](../how-to/trust.md#evidence)). *Blind*: no constant, limit or input of what was compared was chosen with the
data of the reference. Conditions are in the sources, and on the page of a scene. Consistency of own codes is no test
of accuracy. *Failed*: the model missed the goal of the comparison, which supports nothing.
"""


def lines(generated: str) -> Iterator[str]:
    """Yield the lines of the page."""
    catalog = EvidenceCatalog.read()
    yield _INTRODUCTION.format(generated=generated)
    of_kind = [(name, [row for row in catalog.comparisons if row.kind == kind]) for kind, name in KINDS.items()]
    yield "| kind of reference | comparisons | blind | failed |\n|---|---|---|---|"
    for name, rows in of_kind:
        yield f"| {name} | {len(rows)} | {sum(row.blind for row in rows)} | {sum(row.failed for row in rows)} |"
    for quantity in catalog.quantities:
        rows = [row for row in catalog.comparisons if row.quantity == quantity.name]
        yield f"\n## {quantity.title}\n"
        if not any(row.kind == "measurement" for row in rows):
            yield "No measurement.\n" if rows else "No measurement, and no other comparison."
        for group in _alike(rows):
            yield _title(group[0])
            yield from (_line(row) for row in group)
            yield ""
    yield "\n## Not measured\n\n| effect | source |\n|---|---|"
    for effect in catalog.unmeasured:
        yield f"| {effect.what} | `{effect.source}` |"


def _alike(rows: Sequence[Comparison]) -> Iterator[list[Comparison]]:
    """Yield comparisons of one kind and source, for the same scenes, together."""
    for _, group in itertools.groupby(rows, lambda row: (row.kind, row.blind, row.when, row.source)):
        yield list(group)


def _title(row: Comparison) -> str:
    kind = {"measurement": "Measurement", "own code": "Own codes"}.get(row.kind, KINDS[row.kind].capitalize())
    needs = f"; for {', '.join(row.when)}" if row.when else ""
    return f"{kind}{', blind' if row.blind else ''} (`{row.source}`{needs}):\n"


def _line(row: Comparison) -> str:
    um = "" if row.um is None else f" ({row.um[0]:g}-{row.um[1]:g} um)"
    return f"* {row.reference}{um}, {row.count}: {failed_figure(row)}"
