"""Judge how ``hcss import`` takes 109 good and 116 bad images, and write the verdicts to ``NAME.csv``.

python tests/campaign/image_files/run.py [--as NAME]
"""

import csv
import sys
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from bad_images import bad_cases
from good_images import good_cases
from image_verdicts import judge_bad, judge_good, verdict


def main():
    """Judge all images and write ``NAME.csv``."""
    name = sys.argv[sys.argv.index("--as") + 1] if "--as" in sys.argv else "results"
    with (Path(__file__).parent / f"{name}.csv").open("w", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["kind", "case", "verdict", "text"])
        for kind, cases, judge in (("good", good_cases(), judge_good), ("bad", bad_cases(), judge_bad)):
            count = Counter()
            for case, build in cases:
                found, text = verdict(case, build, judge)
                rows.writerow([kind, case, found, " ".join(text.split())])
                count[found.partition(" ")[0]] += 1
            print(kind, len(cases), dict(count))


if __name__ == "__main__":
    main()
