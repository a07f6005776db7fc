"""Rows of a campaign, kept in a JSON file as they are computed, so that an interrupted campaign goes on."""

import json
import threading
from concurrent.futures import ThreadPoolExecutor


def read_rows(path):
    """Return the rows of a file by key; none if there is no file."""
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def compute_rows(path, keys, compute, jobs=1):
    """Compute the rows of those keys that the file does not have, ``jobs`` at a time, and return all of its rows.

    The file is written after each row, one row a line, in the order of the keys.
    """
    rows, lock = read_rows(path), threading.Lock()
    keys = list(keys)

    def one(key):
        row = compute(key)
        with lock:
            rows[key] = row
            ordered = {each: rows[each] for each in [*keys, *rows] if each in rows}
            lines = ",\n ".join(f"{json.dumps(each)}: {json.dumps(row)}" for each, row in ordered.items())
            draft = path.with_suffix(".partial")
            draft.write_text(f"{{\n {lines}\n}}\n", encoding="utf-8")
            draft.replace(path)

    with ThreadPoolExecutor(jobs) as pool:
        list(pool.map(one, [key for key in keys if key not in rows]))
    return rows
