"""Judge how ``hcss import`` takes 109 good and 116 bad images.

    python campaigns/image_files/run.py

Writes ``table.csv`` beside this file and prints each image that is not read rightly, or whose fault is not named.
"""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1]))

from bad_images import bad_cases
from campaign_table import line, write_table
from good_images import good_cases
from image_verdicts import judge_bad, judge_good, verdict

ASKED = (("good", good_cases, judge_good, ("right", "questioned")), ("bad", bad_cases, judge_bad, ("named",)))
"""Kind, its images and judge, and the verdicts that are no failure."""


def main():
    """Judge all images and write the table."""
    lines = []
    for kind, cases, judge, allowed in ASKED:
        found = [(name, *verdict(name, build, judge)) for name, build in cases()]
        wrong = [each for each in found if each[1].partition(" ")[0] not in allowed]
        lines.append(line(f"{kind} images", len(found), len(wrong)))
        for each in [each for each in found if each in wrong or each[1].startswith("questioned")]:
            print(*each, sep=": ")
    write_table(Path(__file__).with_name("table.csv"), lines)


if __name__ == "__main__":
    main()
