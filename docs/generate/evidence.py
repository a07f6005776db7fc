"""Page of all comparisons, from ``catalogs/evidence.toml``."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from hcss_twin.reports.evidence import KINDS, Comparison, EvidenceCatalog
from hcss_twin.reports.evidence_page import failed_figure

PAGE = "reference/evidence.md"

_INTRODUCTION = """# Evidence

{generated}

Comparisons of the models with references; `hcss report --evidence CUBE` selects [those of a
scene](../how-to/trust.md#evidence), with their conditions. *Blind*: no constant, limit or input was chosen with the
data of the reference. *Failed*: the model missed the goal of the comparison, which supports nothing. Consistency of own
codes is no test of accuracy. Quantities without a heading *Measurement* were not compared with one.
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
        if not rows:
            yield "No comparison."
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
    """Yield comparisons of one kind and source together."""
    for _, group in itertools.groupby(rows, lambda row: (row.kind, row.blind, row.source)):
        yield list(group)


class _Shared(NamedTuple):
    """What the references of a group have in common: their beginning, up to a comma, number, and scenes."""

    begin: str
    number: str
    when: tuple[str, ...]


def _shared(group: Sequence[Comparison]) -> _Shared:
    begin, count = group[0].reference.split(", "), group[0].count
    for row in group:
        pairs = zip(begin, row.reference.split(", ")[:-1], strict=False)
        begin = [mine for mine, _ in itertools.takewhile(lambda pair: pair[0] == pair[1], pairs)]
        count = count if row.count == count else ""
    same = all(row.when == group[0].when for row in group)
    alone = len(group) == 1
    return _Shared("" if alone else ", ".join(begin), "" if alone else count, tuple(group[0].when) if same else ())


def _title(row: Comparison, shared: _Shared) -> str:
    kind = {"measurement": "Measurement", "own code": "Own codes"}.get(row.kind, KINDS[row.kind].capitalize())
    needs = f"; for {', '.join(shared.when)}" if shared.when else ""
    common = "".join(f", {each}" for each in (shared.begin, shared.number) if each)
    return f"{kind}{', blind' if row.blind else ''} (`{row.source}`{needs}){common}:\n"


def _line(row: Comparison, shared: _Shared) -> str:
    scenes = f"{', '.join(row.when)}: " if row.when and not shared.when else ""
    reference = row.reference.removeprefix(f"{shared.begin}, ")
    um = "" if row.um is None else f" ({row.um[0]:g}-{row.um[1]:g} um)"
    count = "" if shared.number else f", {row.count}"
    return f"* {scenes}{reference}{um}{count}: {failed_figure(row)}"
