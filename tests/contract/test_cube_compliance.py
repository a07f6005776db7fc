"""The IOOS compliance checker on CF-1.11 and ACDD-1.3; in a process of its own, because it warns."""

import json
import subprocess
import sys

import netCDF4
import pytest
from cheap import CHEAP

pytest.importorskip("compliance_checker")

from example_cube import example_frame, example_header

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.cube.requested_variables import expand
from hcss_twin.cube.sensor_cube import is_replaced
from hcss_twin.cube.writer import CubeWriter
from hcss_twin.plan.plan import Plan

CONVENTIONS = ("cf:1.11", "acdd:1.3")
CUBES = ("plain", "date line, one frame", "simulated", "rounded", "measured")
RUN = f"""
import pathlib

from compliance_checker.runner import CheckSuite, ComplianceChecker

CheckSuite.load_all_available_checkers()
for folder in pathlib.Path().iterdir():
    report = f"{{folder}}/report.json"
    ComplianceChecker.run_checker(
        f"{{folder}}/cube.nc", {CONVENTIONS!r}, 0, "strict", output_filename=report, output_format="json"
    )
"""


def header_of(cube):
    if cube in ("simulated", "rounded", "measured"):
        small = {
            "image.rows": 16,
            "image.columns": 20,
            "frames.count": 2,
            "bands": ["mwir-3.7", "lwir-10.8"],
            "accuracy": 1e-2,
            "output.variables": ["radiance", "cloud_mask", "cloud_thickness"],
            "output.compression": 1,
            "output.quantization": 1e-4 if cube == "rounded" else 0.0,
        } | CHEAP
        if cube == "measured":
            small |= {"sensor.name": "generic-mwir", "sensor.variables": ["all"]}
        if cube == "rounded":
            small |= {"platform.altitude": "800 km", "output.variables": ["all", "geometry"]}
        return make_plan(Scenario.load("stratus", small))
    if cube == "plain":
        return example_header(platform_speed_m_s=7000.0)
    one_frame = {"frame_times_s": (0.25,), "solar_zenith_deg": (100.0,), "solar_azimuth_deg": (10.0,)}
    return example_header(longitude=179.999, variables=tuple(expand(["radiance", "cloud_mask"], {})), **one_frame)


def write(folder, header):
    if isinstance(header, Plan):
        simulate(header.scenario, folder / "cube.nc").close()
        if header.sensor.stages:
            (folder / "cube.sensor.nc").replace(folder / "cube.nc")
    else:
        with CubeWriter(folder / "cube.nc", header) as writer:
            for index in range(header.frames):
                writer.write_frame(index, example_frame(header, index))


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    """Header and report of every cube, all checked by one process: starting the checker takes most of the time."""
    base, headers = tmp_path_factory.mktemp("cubes"), {cube: header_of(cube) for cube in CUBES}
    for cube, header in headers.items():
        (base / cube).mkdir()
        write(base / cube, header)
    command = [sys.executable, "-c", RUN]
    done = subprocess.run(command, cwd=base, capture_output=True, text=True, check=False, timeout=120)
    reports = [base / cube / "report.json" for cube in CUBES]
    assert all(report.is_file() for report in reports), done.stderr
    return {cube: (headers[cube], json.loads(report.read_text())) for cube, report in zip(CUBES, reports, strict=True)}


@pytest.fixture(params=CUBES)
def cube(request):
    return request.param


@pytest.fixture
def header(checked, cube):
    return checked[cube][0]


@pytest.fixture
def findings(checked, cube):
    """Messages of the checker by convention and priority."""
    report = checked[cube][1]
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
    if not isinstance(header, Plan) or not header.sensor.stages:
        return header.variables
    return (*(spec for spec in header.variables if not is_replaced(spec.name)), *header.sensor.variables)


def test_cf_finds_no_error(findings):
    assert findings["cf:1.11"]["high"] == []


def test_cf_recommends_only_to_put_band_and_layer_before_time(findings, header, cube):
    """Time comes first so that a frame is one stretch of the file; CF only recommends the opposite.

    Rounded values have attributes of CF-1.12, which the checker does not know yet.
    """
    left = findings["cf:1.11"]["medium"]
    label = [text for text in left if "Conventions global attribute" in text]
    assert len(label) == (cube == "rounded")
    left = [text for text in left if text not in label]
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


def test_the_image_centre_is_no_coordinate_of_pixels(tmp_path):
    """CDO skips variables whose coordinates are a latitude and longitude of one place."""
    write(tmp_path, header_of("plain"))
    with netCDF4.Dataset(tmp_path / "cube.nc") as cube:
        of_pixels = [variable for variable in cube.variables.values() if {"time", "y", "x"} <= set(variable.dimensions)]
        assert of_pixels
        for variable in of_pixels:
            assert not {"latitude", "longitude"} & set(variable.coordinates.split())
