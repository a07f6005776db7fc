"""Are good orbits and geometries accepted with the right positions, and bad ones refused or noted by name?

    python tests/campaign/trajectories/run.py --write      # all inputs: some minutes; writes results.json
    python tests/campaign/trajectories/run.py --part orbits

Expected positions come from SGP4 and ERFA; each input is determined by its number.
"""

import argparse
import json
import os
import tempfile
from pathlib import Path

import geometry_inputs
import orbit_inputs
from judge import judged

RESULTS = Path(__file__).with_name("results.json")
PARTS = {"orbits": orbit_inputs, "geometries": geometry_inputs}


def summary(part, rows):
    """Lines that count what happened."""
    good, bad = rows["good"], rows["bad"]
    wrong = [each for each in good if each["error_m"] is not None and each["error_m"] > each["within_m"]]
    return [
        f"{part}: {len(good)} good: {sum(each['refused'] is not None for each in good)} refused, "
        f"{sum(bool(each['questions']) for each in good)} questioned, {len(wrong)} wrong by more than allowed",
        f"{part}: {len(bad)} bad: {sum(each['named'] for each in bad)} refused or noted by name, "
        f"{sum(each['refused'] is None and not each['questions'] for each in bad)} accepted without a word",
    ]


def one_row_a_line(known):
    """Text of results."""
    parts = []
    for name, part in known.items():
        lists = (
            f'  "{kind}": [\n' + ",\n".join(f"   {json.dumps(row)}" for row in rows) + "\n  ]"
            for kind, rows in part.items()
            if isinstance(rows, list)
        )
        text = "{\n" + ",\n".join(lists) + "\n }" if name in PARTS else json.dumps(part)
        parts.append(f' "{name}": {text}')
    return "{\n" + ",\n".join(parts) + "\n}\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--part", choices=PARTS, help="one of them only")
    parser.add_argument("--write", action="store_true", help="write the results")
    parser.add_argument("--results", type=Path, default=RESULTS, help="another file")
    parser.add_argument("--failures", action="store_true", help="print those that fail")
    given = parser.parse_args()
    parts = [given.part] if given.part else list(PARTS)
    known = json.loads(given.results.read_text()) if given.results.exists() else {}
    with tempfile.TemporaryDirectory() as cache:
        os.environ["HCSS_CACHE_DIR"] = cache
        for part in parts:
            kinds = {"good": PARTS[part].good(), "bad": PARTS[part].bad()}
            known[part] = {kind: [judged(each) for each in inputs] for kind, inputs in kinds.items()}
    for part in parts:
        print("\n".join(summary(part, known[part])))
        if given.failures:
            for row in known[part]["good"]:
                if row["refused"] or row["questions"] or (row["error_m"] or 0.0) > row.get("within_m", 0.0):
                    print("good:", json.dumps(row))
            for row in known[part]["bad"]:
                if not row["named"]:
                    print("bad:", json.dumps(row))
    if given.write:
        given.results.write_text(one_row_a_line(known))


if __name__ == "__main__":
    main()
