"""What was found for random scenarios: rows, the file they are kept in, and the table that they make."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from campaign_table import line

TABLES = {False: Path(__file__).with_name("table.csv"), True: Path(__file__).with_name("table-finest.csv")}
"""By whether scenarios have multiple scattering and are compared with the finest level and spectral grid."""

ROWS = {False: Path(__file__).with_name("rows.json"), True: Path(__file__).with_name("rows-finest.json")}


ROUNDING = 1.2e-7
"""The step of single precision that a pixel is allowed beside the accuracy."""


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


def table(rows: Sequence[Row]) -> Iterator[dict[str, str]]:
    """Yield lines: runs beyond the accuracy, those that no plan announces, certificates that disagree, and cost."""
    for accuracy in sorted({row.accuracy for row in rows}, reverse=True):
        own = [row for row in rows if row.accuracy == accuracy]
        beyond = [row for row in own if row.achieved > accuracy + ROUNDING]
        errors = [row.achieved / accuracy for row in own]
        yield line(f"accuracy {accuracy:g}", len(own), len(beyond), "error / accuracy", errors)
        yield line(f"{accuracy:g}: plan does not say so", len(own), sum(row.enough for row in beyond))
        reference = [row.reference_error / accuracy for row in own]
        poor = sum(each > 0.1 for each in reference)
        yield line(f"{accuracy:g}: reference", len(own), poor, "its error / accuracy", reference)
        # Of the whole run where that was measured, of the tables elsewhere.
        cost = [row.run_cpu_s or row.compile_cpu_s for row in own]
        yield line(f"{accuracy:g}: cost", len(own), 0, "processor time, s", cost)
    certified = [row for row in rows if row.certificate is not None]
    yield line("certificate disagrees", len(certified), sum(not row.agrees for row in certified))
