"""The index and the log of a sweep: what another program has changed there is not used."""

import json

import pytest
from cheap import CHEAP, NARROW
from hcss_sweep import SweepError, sweep

from hcss_twin import Scenario

SMALL = CHEAP | {"image.rows": 4, "image.columns": 4, "frames.count": 1, "bands": NARROW[1:], "output.certificate": 0}


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
