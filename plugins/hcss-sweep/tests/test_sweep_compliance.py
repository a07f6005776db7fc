"""The IOOS compliance checker on the dataset of a sweep: CF-1.11 but for what it recommends about other dimensions."""

import json
import subprocess
import sys

import pytest
from cheap import CHEAP

pytest.importorskip("compliance_checker")

from hcss_sweep import sweep

RUN = """
from compliance_checker.runner import CheckSuite, ComplianceChecker

CheckSuite.load_all_available_checkers()
ComplianceChecker.run_checker("all.nc", ["cf:1.11"], 0, "strict", output_filename="report.json", output_format="json")
"""
ACCEPTED = (
    "not in the recommended order T, Z, Y, X",
    # Where points do not start together no single variable has the instants.
    "Dimension 'time' in variable 'radiance' is expected to be a coordinate axis",
)
SMALL = CHEAP | {"image.rows": 4, "image.columns": 4, "frames.count": 2, "bands": ["lwir-10.8"]}


@pytest.mark.long
@pytest.mark.parametrize(
    "over",
    [
        {"view.zenith": [0, 20], "seed": [1, 2]},
        {"time": ["2024-01-20T02:30:00Z", "2024-07-20T02:30:00Z"], "place.latitude": [10, 20]},
    ],
)
def test_a_dataset_passes_the_checker(tmp_path, over):
    sweep("stratus", tmp_path / "sweep", over=over, overrides=SMALL, dataset=tmp_path / "all.nc")
    done = subprocess.run([sys.executable, "-c", RUN], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert (tmp_path / "report.json").is_file(), done.stderr
    report = json.loads((tmp_path / "report.json").read_text())["cf:1.11"]
    messages = [
        message
        for priority in ("high_priorities", "medium_priorities")
        for check in report[priority]
        for message in check["msgs"]
        if not any(text in message for text in ACCEPTED)
    ]
    assert messages == []
