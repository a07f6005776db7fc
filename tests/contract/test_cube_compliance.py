"""The IOOS compliance checker on CF-1.11 and ACDD-1.3; in a process of its own, because it warns."""

import json
import subprocess
import sys

import pytest
from cheap import CHEAP

pytest.importorskip("compliance_checker")

from example_cube import example_frame, example_header

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.cube.sensor_cube import is_replaced
from hcss_twin.cube.writer import CubeWriter
from hcss_twin.plan.plan import Plan

CONVENTIONS = ("cf:1.11", "acdd:1.3")
RUN = f"""
from compliance_checker.runner import CheckSuite, ComplianceChecker

CheckSuite.load_all_available_checkers()
ComplianceChecker.run_checker(
    "cube.nc", {CONVENTIONS!r}, 0, "strict", output_filename="report.json", output_format="json"
)
"""


@pytest.fixture(scope="module", params=["plain", "date line, one frame", "simulated", "rounded", "measured"])
def header(request):
    if request.param in ("simulated", "rounded", "measured"):
        small = {
            "image.rows": 16,
            "image.columns": 20,
            "frames.count": 2,
            "output.variables": ["all"],
            "output.compression": 1,
            "output.quantization": 1e-4 if request.param == "rounded" else 0.0,
        } | CHEAP
        if request.param == "measured":
            small |= {"sensor.name": "generic-mwir", "sensor.variables": ["all"]}
        if request.param == "rounded":
            small |= {"platform.altitude": "800 km", "output.variables": ["all", "geometry"]}
        return make_plan(Scenario.load("stratus", small))
    if request.param == "plain":
        return example_header(platform_speed_m_s=7000.0)
    return example_header(
        longitude=179.999, frame_times_s=(0.25,), solar_zenith_deg=(100.0,), solar_azimuth_deg=(10.0,)
    )


@pytest.fixture(scope="module")
def findings(header, tmp_path_factory):
    """Messages of the checker by convention and priority."""
    folder = tmp_path_factory.mktemp("cube")
    if isinstance(header, Plan):
        simulate(header.scenario, folder / "cube.nc").close()
        if header.sensor is not None:
            (folder / "cube.sensor.nc").replace(folder / "cube.nc")
    else:
        with CubeWriter(folder / "cube.nc", header) as writer:
            for index in range(header.frames):
                writer.write_frame(index, example_frame(header, index))
    command = [sys.executable, "-c", RUN]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=120)
    assert (folder / "report.json").is_file(), done.stderr
    report = json.loads((folder / "report.json").read_text())
    assert set(report) == set(CONVENTIONS)
    return {
        name: {
            level: [
                f"{result['name']} {text}" for result in report[name][f"{level}_priorities"] for text in result["msgs"]
            ]
            for level in ("high", "medium")
        }
        for name in CONVENTIONS
    }


def written(header):
    """Variables of the cube that was checked."""
    if not isinstance(header, Plan) or header.sensor is None:
        return header.variables
    return (*(spec for spec in header.variables if not is_replaced(spec.name)), *header.sensor.variables)


def test_cf_finds_no_error(findings):
    assert findings["cf:1.11"]["high"] == []


def test_cf_recommends_only_to_put_band_and_layer_before_time(findings, header):
    """Time comes first so that a frame is one stretch of the file; CF only recommends the opposite."""
    left = findings["cf:1.11"]["medium"]
    assert all(text.startswith("§2.4") and ("band (" in text or "layer (" in text) for text in left)
    assert len(left) == sum(bool({"band", "layer"} & set(spec.dims)) for spec in written(header))


def test_acdd_misses_only_standard_names_that_cf_does_not_have(findings, header):
    # The checker asks no standard names of flags and coordinates.
    nameless = {
        spec.name
        for spec in written(header)
        if spec.standard_name is None and "flag_values" not in spec.attributes and spec.kind != "geometry"
    }
    assert {text.split('"')[1] for text in findings["acdd:1.3"]["high"]} == nameless
    assert all(text.endswith("standard_name") for text in findings["acdd:1.3"]["high"])


def test_acdd_finds_every_recommended_attribute(findings):
    assert findings["acdd:1.3"]["medium"] == []
