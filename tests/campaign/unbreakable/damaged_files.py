"""Damaged files of every kind: which exceptions of other libraries escape, which readers hang or crash?

The files are those of ``tests/stability/input_files.py``, the damages and readers those of ``damage.py`` and
``file_readers.py`` beside it. A row has the outcomes of :data:`TOGETHER` seeds, computed in one process of limited
memory, because a damaged file may crash a library.
"""

import json
import resource
import subprocess
import sys
import tempfile
from collections import Counter
from functools import lru_cache
from pathlib import Path

HERE = Path(__file__).parent
sys.path.append(str(HERE.parents[1] / "stability"))

RESULTS = HERE / "results-files.json"
COUNTS = {"fast": 112_000, "slow": 2_000, "pages": 200}
"""Seeds of each group of readers; of some, the library that damages refuses the file."""

TOGETHER = {"fast": 2_000, "slow": 100, "pages": 20}
MEMORY = 6 * 2**30
LONGEST_S = 7_200


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
    """Return the row of a key."""
    sound = str(Path(_files().name) / "files")
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "files").symlink_to(sound)
        command = [sys.executable, __file__, folder, *key.split()]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST_S)
        except subprocess.TimeoutExpired:
            done = subprocess.CompletedProcess(command, -1, "", "timeout")
        if done.returncode == 0:
            return json.loads(done.stdout.splitlines()[-1])
        seed = Path(folder, "seed").read_text()
        return {"outcomes": {"crashed": 1}, "escaped": {f"code {done.returncode}: {done.stderr[-300:]}": int(seed)}}


def _compute_here(folder, group, first):
    from damage import what_escapes

    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    files = {path.name: path for path in (folder / "files").iterdir()}
    count = min(TOGETHER[group], COUNTS[group] - first)

    def seeds():
        for seed in range(first, first + count):
            (folder / "seed").write_text(str(seed))
            yield seed

    escaped, outcomes = what_escapes(group, files, folder, seeds())
    print(json.dumps({"outcomes": outcomes, "escaped": escaped}))


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
    _compute_here(Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]))
