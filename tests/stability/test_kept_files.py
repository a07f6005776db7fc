"""Files that a later run reads instead of computing them: what another program has changed is not used."""

import errno
import json
import os
from pathlib import Path

import numpy as np
import pytest
from cheap import CHEAP

from hcss_twin.core.archives import read_arrays, write_arrays
from hcss_twin.core.errors import SweepError
from hcss_twin.core.files import atomic_write
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.sweeps.run import sweep

SMALL = CHEAP | {"image.rows": 4, "image.columns": 4, "frames.count": 1, "bands": ["lwir"], "output.certificate": 0}


def test_an_archive_gives_what_was_written_or_an_error(tmp_path):
    path = tmp_path / "a.npz"
    arrays = {
        "x": np.arange(6.0).reshape(2, 3).T,
        "text": np.array("naïve"),
        "none": np.zeros((0, 3)),
        "one": np.array(3),
    }
    write_arrays(path, arrays)
    read = read_arrays(path)
    assert read.keys() == arrays.keys()
    for name, array in arrays.items():
        assert read[name].dtype == array.dtype
        np.testing.assert_array_equal(read[name], array)
    with np.load(path) as archive:
        changed = dict(archive) | {"x": arrays["x"] + 1e-12}
    np.savez(path, **changed)
    with pytest.raises(ValueError, match="the checksum differs"):
        read_arrays(path)


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep") / "swept"
    sweep(Scenario.load("stratus", SMALL), folder, over={"seed": [1, 2]})
    return folder


def again(folder):
    return sweep(Scenario.load("stratus", SMALL), folder, over={"seed": [1, 2]})


LINES = [
    *(b"\xff\xfe", b"[]", b"{}", b'{"point": "x", "values": {}}', b'{"point": -1, "values": {}}'),
    b'{"point": 0, "values": {}, "state": "done", "file": "../other.nc", "bytes": 1}',
]


@pytest.mark.parametrize("line", LINES)
def test_a_damaged_line_of_the_log_of_a_sweep_is_ignored(swept, line):
    log = swept / "points.jsonl"
    kept = log.read_bytes()
    log.write_bytes(line + b"\n" + kept[:-20])
    try:
        assert [record.file for record in again(swept).points] == ["point-0000.nc", "point-0001.nc"]
    finally:
        log.write_bytes(kept)


@pytest.mark.parametrize("change", [{"points": 3}, {"versions": []}, {"keys": None}, {"sweep": 1}, {"format": "1"}])
def test_a_damaged_index_of_a_sweep_is_refused(swept, change):
    index = swept / "index.json"
    kept = index.read_text()
    index.write_text(json.dumps(json.loads(kept) | change))
    try:
        with pytest.raises(SweepError, match=r"index\.json is not a sweep index"):
            again(swept)
    finally:
        index.write_text(kept)


def test_a_read_only_file_system_is_an_error_although_a_draft_cannot_be_removed_from_it(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(Path, "unlink", refuse)
    with pytest.raises(SweepError, match=r"cannot write .*Read-only"), atomic_write(tmp_path / "a", SweepError):
        refuse()
