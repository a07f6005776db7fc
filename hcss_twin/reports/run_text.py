"""What ``hcss run`` says: what was written, whether it is right, its total error, what is left out, what to do next."""

from __future__ import annotations

import shutil
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

from hcss_twin.plan.error_budget import ErrorBudget
from hcss_twin.plan.few_columns import CROSSED, OMISSION_SHARE, SWITCHED_OFF, Omission
from hcss_twin.plan.plan import Plan
from hcss_twin.reports.tables import Table, class_text

if TYPE_CHECKING:
    from hcss_twin.engine.certificate.certificate import Certificate

MOST_BANDS, MOST_CLASSES = 4, 2
"""Columns and rows of the table of errors; where there are more, the last one is the largest of the rest."""

UNKNOWN_WIDTH = 100
"""Characters of a line where no terminal says how many it has."""

_LEAST_CAUSE = 30
"""Characters beside the figures below which their causes get lines of their own."""

_NAMED_SHARE = 0.1
"""Omissions that are named beside the largest are more than this share of it."""

_TITLE = "total error (rms, K)"
_CAUSE = "largest cause (inputs taken as true)"


def run_text(plan: Plan, certificate: Certificate | None, output: Path, written: Sequence[str]) -> Iterator[str]:
    """Yield what a run says, about eight lines.

    Parameters
    ----------
    certificate : Certificate or None
        None if no pixel was checked.
    output : Path
        The cube.
    written : sequence of str
        A line for each file.
    """
    yield from written
    if certificate is not None:
        yield certificate.verdict
        if certificate.budget is not None:
            yield from error_table(certificate.budget, shutil.get_terminal_size((UNKNOWN_WIDTH, 0)).columns)
    elif plan.needs_radiance:
        yield "computed, NOT CHECKED: output.certificate is 0"
    left_out = [*_left_out(plan, certificate, _kelvin_of_one(certificate))]
    if left_out:
        yield "; ".join(left_out)
    if filled := plan.filled_in:
        yield "assumed: " + "; ".join(f"{item.field} = {item.value}" for item in filled)
    yield f"next: hcss preview {output}; hcss report {output}"


def _kelvin_of_one(certificate: Certificate | None) -> tuple[float, float]:
    """Return the range over bands of a change of brightness temperature over the relative change of radiance."""
    budget = certificate.budget if certificate is not None else None
    cells = budget.contributions.values() if budget is not None else ()
    found = [(cell[0].kelvin or 0.0) / cell[0].relative for cell in cells if cell[0].relative]
    return min(found, default=0.0), max(found, default=0.0)


def _left_out(plan: Plan, certificate: Certificate | None, kelvin_of_one: tuple[float, float]) -> Iterator[str]:
    """Yield what is left out beyond its share of the accuracy: no model has it, the user's choice, the plan's."""
    if certificate is not None and certificate.beyond:
        yield f"NOT WITHIN the accuracy: {_first(certificate.beyond)}"
    limit = OMISSION_SHARE * plan.accuracy.relative
    large = [omission for omission in plan.omissions if omission.decision and omission.exceeds(limit)]
    large.sort(key=lambda omission: -(omission.size or 0.0))
    for heading, by_user in (("switched off by you", True), ("left out to save time", False)):
        chosen = [omission for omission in large if (omission.decision == SWITCHED_OFF) == by_user]
        if chosen:
            first, *others = [_with_share(each, certificate) for each in chosen]
            named = [each for each in others if (each.size or 0.0) > _NAMED_SHARE * (first.size or 0.0)]
            texts = [
                _omitted(first, kelvin_of_one),
                *(f"{each.what}, {_size(replace(each, sense=''), kelvin_of_one)}" for each in named),
            ]
            if rest := others[len(named) :]:
                texts.append(f"{len(rest)} smaller, at most {_size(replace(rest[0], sense=''), kelvin_of_one)}")
            yield f"{heading}, not in these figures: {'; '.join(texts)}"


def error_table(budget: ErrorBudget, width: int) -> Iterator[str]:
    """Yield a table of the total error by class and band in kelvin, with causes and what is unknown.

    Parameters
    ----------
    width : int
        Characters of a line. Causes that do not fit beside the figures follow below them.
    """
    bands = _grouped([*dict.fromkeys(band for _, band in budget.contributions)], MOST_BANDS, "bands")
    classes = [*dict.fromkeys(of for of, _ in budget.contributions)]
    classes.sort(key=lambda of: -max(budget.total(cell)[1] for cell in budget.contributions if cell[0] == of))
    kinds = _grouped(classes, MOST_CLASSES, "classes")
    worst = {
        (kind, name): max(product(of, some), key=lambda cell: budget.total(cell)[1])
        for kind, of in kinds.items()
        for name, some in bands.items()
    }
    unknown = {
        (kind, name): [each for cell in product(kinds[kind], bands[name]) for each in budget.contributions[cell]
                       if each.unknown]
        for kind, name in worst
    }  # fmt: skip
    figures = [[_TITLE, *bands]]
    figures += [
        [
            f"  {class_text(kind)}",
            *(f"{'> ' * bool(unknown[kind, name])}{budget.total(worst[kind, name])[1]:.2g}" for name in bands),
        ]
        for kind in kinds
    ]
    causes = [_CAUSE]
    for kind in kinds:
        largest = {
            name: max(budget.contributions[worst[kind, name]], key=lambda each: each.relative or 0.0).name
            for name in bands
        }
        # What has no figure at all goes before what has one for part of the band.
        first = [
            min(unknown[kind, name], key=lambda each: each.relative is not None)
            for name in bands
            if unknown[kind, name]
        ]
        named = dict.fromkeys(f"{'part of ' * (each.relative is not None)}{each.name}" for each in first)
        causes.append(_by_band(largest) + f"; unknown: {', '.join(named)}" * bool(named))
    aligned = [f"{line}  " for line in Table.aligned(figures, indent="")]
    start = max(map(len, aligned))
    beside = width - start >= _LEAST_CAUSE
    for line, cause in zip(aligned, causes, strict=True):
        indent = " " * (start if beside else 4)
        wrapped = textwrap.wrap(cause, width - len(indent), break_on_hyphens=False, break_long_words=False)
        yield (f"{line:<{start}}{wrapped.pop(0)}" if beside else line.rstrip())
        yield from (f"{indent}{each}" for each in wrapped)


def _grouped(names: Sequence[str], most: int, plural: str) -> dict[str, Sequence[str]]:
    """Return names by title, at most so many: the last has all the others."""
    if len(names) <= most:
        return {name: (name,) for name in names}
    rest = names[most - 1 :]
    return {**{name: (name,) for name in names[: most - 1]}, f"{len(rest)} other {plural}, worst": rest}


def _by_band(names: Mapping[str, str]) -> str:
    """List names with the bands of each, unless it is the same in all of them."""
    bands_of: dict[str, list[str]] = {}
    for band, name in names.items():
        bands_of.setdefault(name, []).append(band)
    if len(bands_of) == 1:
        return next(iter(bands_of))
    return ", ".join(f"{name} ({', '.join(bands)})" for name, bands in bands_of.items())


def _omitted(omission: Omission, kelvin_of_one: tuple[float, float]) -> str:
    size = _size(omission, kelvin_of_one)
    return f"{omission.what}, {size} ({omission.sense or 'at most, any pixel'}), needs {omission.needs}"


def _with_share(omission: Omission, certificate: Certificate | None) -> Omission:
    """Say of the pixels that cloud edges cross how many of the checked frames there are: those of the edge stratum."""
    strata = () if certificate is None else certificate.strata
    if omission.sense != CROSSED or not strata:
        return omission
    crossed = sum(each.pixels for each in strata if each.name.startswith("edge"))
    share = f"the {100.0 * crossed / sum(each.pixels for each in strata):.2g} % of"
    return replace(omission, sense=CROSSED.replace("the", share, 1))


def _size(omission: Omission, kelvin_of_one: tuple[float, float]) -> str:
    """Write the size of an omission: a share of the radiance in the worst band, and its range in kelvin."""
    size = omission.size or 0.0
    low, high = (f"{size * kelvin:.2g}" for kelvin in kelvin_of_one)
    kelvin = f", about {low if low == high else f'{low} to {high}'} K" if high != "0" else ""
    return f"{100.0 * size:.2g} %{'' if ' K' in omission.sense else kelvin}"


def _first(texts: Sequence[str]) -> str:
    more = f", and {len(texts) - 1} more" if len(texts) > 1 else ""
    return texts[0] + more
