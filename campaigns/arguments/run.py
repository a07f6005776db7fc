"""Call every public function with 30 wrong values for each argument.

    python campaigns/arguments/run.py [FUNCTION ...]

Writes ``table.csv`` beside this file, unless functions are named, and prints the errors that are not ours.
"""

import os
import sys
import tempfile
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1]))
sys.path.append(str(Path(__file__).parents[2] / "tests"))

from campaign_table import line, write_table
from wrong_arguments import calls, outcomes


def main():
    lines = []
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        cheap, others = calls(Path(folder))
        for name, call in (cheap | others).items():
            if sys.argv[1:] and name not in sys.argv[1:]:
                continue
            counts, escaped = outcomes({name: call})
            failed = sum(number for (_, outcome), number in counts.items() if outcome == "escaped")
            lines.append(line(name, sum(counts.values()), failed))
            print(name, *escaped, sep="\n  ", flush=True)
    if not sys.argv[1:]:
        write_table(Path(__file__).with_name("table.csv"), lines)


if __name__ == "__main__":
    main()
