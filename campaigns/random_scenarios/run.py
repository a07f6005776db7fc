"""Random valid scenarios: is the error of each cube within the accuracy asked for, and what does accuracy cost?

    python campaigns/random_scenarios/run.py                       # 300 scenarios at three accuracies: hours
    python campaigns/random_scenarios/run.py --scenarios 20        # the first 20
    python campaigns/random_scenarios/run.py --summary             # only the table of the rows

With ``--finest`` every scenario has the model of multiple scattering, and some unlike pixels of one frame are computed
with 64 streams, on a spectral grid twice as fine as that of any accuracy, and without tables of any kind
(``random_scenario_reference.py``); the cubes then have no certificate.

Scenario number i is always the same. Its cubes are made with random pixels of 48 x 48 and a few frames; random pixels
of them are computed again here: the radiance model is asked for their very columns at every wavenumber of the scene's
grid, and the spectra are summed over the bands, with code that shares nothing with the certificate's. Clouds do not
depend on the accuracy (which is checked), so that these columns are computed once for all accuracies.

Rows go to ``rows.json`` beside this file as they are found, and those that are there are not computed again;
``table.csv``, or ``table-finest.csv``, says what they say together.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

sys.path.append(str(Path(__file__).parents[1]))

from campaign_table import write_table
from random_scenario_checks import check
from random_scenario_draws import ACCURACIES
from random_scenario_rows import ROWS, TABLES, read_failed, read_rows, table, write_rows

SCENARIOS = 300


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenarios", type=int, default=SCENARIOS, help="how many, from number 0")
    parser.add_argument("--only", type=int, nargs="*", help="these numbers instead, computed and not kept")
    parser.add_argument("--finest", action="store_true", help="multiple scattering, against the finest level and grid")
    parser.add_argument("--summary", action="store_true", help="compute nothing")
    parser.add_argument("--limit", type=float, default=np.inf, help="seconds of processor time for one accuracy")
    given = parser.parse_args()
    options: dict[str, Any] = {"model": "physical", "finest": True} if given.finest else {}
    options["limit_s"] = given.limit
    path = ROWS[given.finest]
    rows, failed = read_rows(path), read_failed(path)
    with tempfile.TemporaryDirectory() as folder:
        os.environ["HCSS_CACHE_DIR"] = str(Path(folder) / "cache")
        if given.only is not None:
            found = [check(n, ACCURACIES, Path(folder), **options) for n in given.only]
            rows = [row for some, _ in found for row in some]
            failed = {key: message for _, others in found for key, message in others.items()}
        elif not given.summary:
            done = {row.scenario for row in rows} | {int(key.split()[0]) for key in failed}
            for number in sorted(set(range(given.scenarios)) - done):
                try:
                    some, unfinished = check(number, ACCURACIES, Path(folder), **options)
                    rows += some
                    failed |= unfinished
                except Exception as error:  # one more finding; the others are still wanted
                    failed[str(number)] = f"{type(error).__name__}: {error}"
                print(number, failed.get(str(number), ""), flush=True)
                write_rows(path, rows, failed)
    for row in rows:
        if row.exceeding or not row.agrees:
            print(row)
    for number, message in failed.items():
        print(f"scenario {number}: {message}")
    if given.only is None:
        write_table(TABLES[given.finest], table(rows))


if __name__ == "__main__":
    main()
