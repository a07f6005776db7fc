"""What was found for random scenarios: rows, the file they are kept in, and what they say together."""

from __future__ import annotations

import itertools
import json
import statistics
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from random_scenario_draws import ACCURACIES, MODELS

FINEST_RESULTS = Path(__file__).with_name("results-finest.json")
"""Of scenarios with multiple scattering, against the finest level and spectral grid."""

RESULTS = Path(__file__).with_name("results.json")


@dataclass(frozen=True)
class Row:
    """What was found for one scenario at one accuracy.

    ``achieved`` is the largest relative error of the checked pixels in any band, ``certificate`` what the cube's
    certificate says of its own; ``exceeding`` pixels err by more than the accuracy and one step of single precision.
    """

    scenario: int
    accuracy: float
    model: str
    layers: int
    bands: int
    day: str
    pixels: int
    achieved: float
    exceeding: int
    worst_band: str
    certificate: float | None
    certificate_passed: bool | None
    estimated: float
    wavenumbers: int
    dense: int
    compile_cpu_s: float
    level: int = 0
    sun_streams: int = 0
    refinement: int = 0
    enough: bool = True
    reference_error: float = 0.0
    run_cpu_s: float = 0.0

    @property
    def agrees(self) -> bool:
        """Whether the certificate has the same verdict, and an error of the same order.

        Both are maxima over random pixels of their own, within a factor of 5; errors about as small as rounding to
        single precision are alike. A cube without certificate says nothing to disagree with.
        """
        if self.certificate is None:
            return True
        low, high = sorted(max(each, 2e-7) for each in (self.achieved, self.certificate))
        return high <= 5.0 * low and self.certificate_passed == (self.exceeding == 0)


def read_rows(path: Path) -> list[Row]:
    """Rows found so far."""
    return [Row(**each) for each in json.loads(path.read_text())["rows"]] if path.exists() else []


def write_rows(path: Path, rows: Sequence[Row], failed: dict[str, str]) -> None:
    """Write one row a line; the file is there whole or as it was."""
    ordered = sorted(rows, key=lambda row: (row.scenario, -row.accuracy))
    lines = ",\n  ".join(json.dumps(asdict(row)) for row in ordered)
    text = f'{{\n "failed": {json.dumps(failed)},\n "rows": [\n  {lines}\n ]\n}}\n'
    path.parent.mkdir(exist_ok=True)
    draft = path.with_suffix(".json.partial")
    draft.write_text(text)
    draft.replace(path)


def read_failed(path: Path) -> dict[str, str]:
    """Scenarios that ended in an error, with what it said."""
    return dict(json.loads(path.read_text())["failed"]) if path.exists() else {}


def summary(rows: Sequence[Row], failed: dict[str, str]) -> Iterator[str]:
    """Lines of what the rows say together."""
    numbers = {row.scenario for row in rows}
    kept = sum(row.exceeding == 0 for row in rows)
    yield f"{len(numbers)} scenarios, {len(rows)} runs: {kept} within the accuracy asked for, {len(failed)} errors"
    certified = [row for row in rows if row.certificate is not None]
    yield f"certificate agrees in {sum(row.agrees for row in certified)} of {len(certified)}"
    for accuracy in sorted({row.accuracy for row in rows}, reverse=True):
        own = [row for row in rows if row.accuracy == accuracy]
        ratio = [row.achieved / accuracy for row in own]
        uncertain = max(row.reference_error for row in own) / accuracy
        yield (
            f"accuracy {accuracy:g}: {len(own)} runs, {sum(row.exceeding == 0 for row in own)} within, "
            f"{sum(each > 2.0 for each in ratio)} beyond twice, {sum(not row.enough for row in own)} announced as not "
            f"enough by the plan; achieved / asked {statistics.median(ratio):.2f} "
            f"(median), {max(ratio):.2f} (largest), of the reference's own error {uncertain:.2g}; "
            f"CPU s, median {statistics.median(_cost(row) for row in own):.2f}; numerical levels "
            f"{dict(sorted(Counter(row.level for row in own).items()))}, streams for sunlight "
            f"{dict(sorted(Counter(row.sun_streams for row in own).items()))}"
        )
    lit = [row.sun_streams for row in rows if row.accuracy == ACCURACIES[0] and row.sun_streams]
    if lit:
        few = sum(each < 16 for each in lit)
        yield f"{few} of {len(lit)} sunlit scenes use fewer than 16 streams at {ACCURACIES[0]:g}"
    cost = {(row.scenario, row.accuracy): _cost(row) for row in rows}
    for model in [*MODELS, None]:
        chosen = {row.scenario for row in rows if model in (row.model, None)}
        growth = [
            [cost[n, fine] / cost[n, coarse] for n in chosen if (n, fine) in cost and (n, coarse) in cost]
            for coarse, fine in itertools.pairwise(ACCURACIES)
        ]
        if all(len(each) > 1 for each in growth):
            told = ", ".join(
                "{1:.2f} ({0:.2f} to {2:.2f})".format(*statistics.quantiles(each, method="inclusive"))
                for each in growth
            )
            yield f"growth of the cost per decade, median and quartiles, {model or 'all models'}: {told}"
    for row in rows:
        if row.exceeding or not row.agrees:
            yield (
                f"  scenario {row.scenario} at {row.accuracy:g} ({row.model}, {row.layers} layers, {row.day}): "
                f"achieved {row.achieved:g} in {row.worst_band}, {row.exceeding} of {row.pixels} exceed; certificate "
                f"{row.certificate}, {'passed' if row.certificate_passed else 'none or failed'}; level {row.level}, "
                f"{'' if row.enough else 'not '}enough; reference {row.reference_error:g}"
            )
    for number, message in failed.items():
        yield f"  scenario {number}: {message}"


def _cost(row: Row) -> float:
    """Processor time of the whole run where that was measured, of the tables elsewhere."""
    return row.run_cpu_s or row.compile_cpu_s
