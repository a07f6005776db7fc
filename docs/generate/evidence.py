"""Page of all comparisons, from ``catalogs/evidence.toml``."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator, Sequence

from hcss_twin.reports.evidence import KINDS, Comparison, EvidenceCatalog
from hcss_twin.reports.evidence_page import failed_figure

PAGE = "reference/evidence.md"

_INTRODUCTION = """# Evidence

{generated}

Comparisons of the models with references; `hcss report --evidence CUBE` selects [those of a
scene](../how-to/trust.md#evidence), with their conditions. *Blind*: no constant, limit or input was chosen with the data
of the reference. *Failed*: the model missed the goal of the comparison, which supports nothing. Consistency of own codes
is no test of accuracy.
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
            shared = _shared(group)
            yield _title(group[0], shared)
            yield from (_line(row, shared) for row in group)
            yield ""
    yield "\n## Not measured\n"
    for source, effects in itertools.groupby(catalog.unmeasured, lambda effect: effect.source):
        yield f"`{source}`:\n"
        yield from (f"* {effect.what}" for effect in effects)


def _alike(rows: Sequence[Comparison]) -> Iterator[list[Comparison]]:
    """Yield comparisons of one kind and source, for the same scenes, together."""
    for _, group in itertools.groupby(rows, lambda row: (row.kind, row.blind, row.when, row.source)):
        yield list(group)


def _shared(group: Sequence[Comparison]) -> tuple[str, str]:
    """Return how all references of a group begin, up to a comma, and the number that all compare."""
    if len(group) == 1:
        return "", ""
    begin = os.path.commonprefix([row.reference for row in group]).rpartition(", ")[0]
    counts = {row.count for row in group}
    return begin, counts.pop() if len(counts) == 1 else ""


def _title(row: Comparison, shared: tuple[str, str]) -> str:
    kind = {"measurement": "Measurement", "own code": "Own codes"}.get(row.kind, KINDS[row.kind].capitalize())
    needs = f"; for {', '.join(row.when)}" if row.when else ""
    return f"{kind}{', blind' if row.blind else ''} (`{row.source}`{needs})" + "".join(f", {each}" for each in shared if each) + ":\n"


def _line(row: Comparison, shared: tuple[str, str]) -> str:
    begin, count = shared
    reference = row.reference.removeprefix(f"{begin}, ")
    um = "" if row.um is None else f" ({row.um[0]:g}-{row.um[1]:g} um)"
    return f"* {reference}{um}{'' if count else f', {row.count}'}: {failed_figure(row)}"
