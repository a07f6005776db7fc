"""Call every public function with 30 wrong values for each argument and write what came of the calls.

    python tests/campaign/arguments/run.py [FUNCTION ...]

Functions that the results have already are not called again.
"""

import json
import os
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[2]))

from wrong_arguments import calls, outcomes

RESULTS = Path(__file__).parent / "results.json"


def main():
    known = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        cheap, others = calls(Path(folder))
        for name, call in (cheap | others).items():
            if name in known or (sys.argv[1:] and name not in sys.argv[1:]):
                continue
            counts, escaped = outcomes({name: call})
            found = defaultdict(int) | {outcome: number for (_, outcome), number in counts.items()}
            known[name] = {each: found[each] for each in ("refused", "accepted", "escaped")} | {"escapes": escaped}
            RESULTS.write_text(json.dumps(known, indent=1) + "\n")


if __name__ == "__main__":
    main()
