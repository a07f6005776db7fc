"""Damaged files of every kind: which exceptions of other libraries escape, which readers hang or crash?

The files are those of ``tests/stability/input_files.py``, the damages and readers those of ``damage.py`` and
``file_readers.py`` beside it. A row has the outcomes of :data:`TOGETHER` seeds, computed in one process of limited
memory, because a damaged file may crash a library.
"""

import json
import os
import resource
import subprocess
import sys
import tempfile
from collections import Counter
from functools import lru_cache
from pathlib import Path

sys.path.append(str(Path(__file__).parents[2] / "tests" / "stability"))

COUNTS = {"fast": 112_000, "slow": 2_000, "pages": 200}
"""Seeds of each group of readers; of some, the library that damages refuses the file."""

TOGETHER = {"fast": 2_000, "slow": 100, "pages": 20}
MEMORY = 6 * 2**30
LONGEST_S = 400
"""Processor time of one process."""


def keys():
    """Return the keys of all rows, a group and its first seed: the groups take turns."""
    every = [
        (first / COUNTS[group], f"{group} {first}")
        for group in COUNTS
        for first in range(0, COUNTS[group], TOGETHER[group])
    ]
    return [key for _, key in sorted(every)]


@lru_cache
def _files():
    """Return the folder of the sound files, which exists as long as this process."""
    from input_files import make_files

    folder = tempfile.TemporaryDirectory()
    make_files(Path(folder.name) / "files")
    return folder


def prepare():
    """Write the sound files."""
    _files()


def compute(key):
    """Return the row of a key; a seed that ends its process or never ends is noted, and the next one follows."""
    group, first = key.split()
    outcomes, escaped = Counter(), {}
    start, end = int(first), min(int(first) + TOGETHER[group], COUNTS[group])
    while start < end:
        with tempfile.TemporaryDirectory() as temporary:
            folder = Path(temporary)
            (folder / "files").symlink_to(Path(_files().name) / "files")
            command = [sys.executable, __file__, folder, group, str(start), str(end)]
            code = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode
            done = json.loads((folder / "done.json").read_text())
        outcomes.update(done["outcomes"])
        escaped |= done["escaped"]
        start = done["seed"] + 1
        if code != 0:
            outcomes["ended the process"] += 1
            escaped[f"the process ended with code {code}"] = done["seed"]
    return {"outcomes": outcomes, "escaped": escaped}


def _compute_here(folder, group, start, end):
    from damage import what_escapes

    for kind, limit in ((resource.RLIMIT_AS, MEMORY), (resource.RLIMIT_CPU, LONGEST_S)):
        resource.setrlimit(kind, (limit, limit))
    files = {path.name: path for path in (folder / "files").iterdir()}
    outcomes, escaped = Counter(), {}
    for seed in range(start, end):
        (folder / "done.json").write_text(json.dumps({"seed": seed, "outcomes": outcomes, "escaped": escaped}))
        found, counts = what_escapes(group, files, folder, [seed])
        outcomes.update(counts)
        escaped |= {what: number for what, number in found.items() if what not in escaped}
    (folder / "done.json").write_text(json.dumps({"seed": end, "outcomes": outcomes, "escaped": escaped}))
    os._exit(0)  # a damaged file may keep HDF5 from ending


def summary(rows):
    """Return lines of text: outcomes by group, and what escaped."""
    for group in COUNTS:
        counts = sum((Counter(row["outcomes"]) for key, row in rows.items() if key.split()[0] == group), Counter())
        mutations = counts.total() - counts["not damaged"]
        yield f"{group}: {mutations} mutations of {COUNTS[group]} seeds, {dict(sorted(counts.items()))}"
    for key, row in rows.items():
        for what, seed in row["escaped"].items():
            yield f"  {key.split()[0]} {seed}: {what}"


if __name__ == "__main__":
    _compute_here(Path(sys.argv[1]), sys.argv[2], *map(int, sys.argv[3:]))
