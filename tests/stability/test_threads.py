"""Scenes in several threads, and functions of a cube that is open, in a process that may end by a signal."""

import subprocess
import sys
from pathlib import Path

import pytest

CODE = """
import hashlib, sys, threading
from concurrent.futures import ThreadPoolExecutor
sys.path[:0] = [{folder!r}]
from input_files import small_stratus
import hcss_twin
from hcss_export import export_cube

def job(number):
    only = {{"seed": number, "frames.count": 1, "output.certificate": 0, "output.variables": ["radiance"]}}
    with hcss_twin.simulate(small_stratus(**only), f"{{threading.get_ident()}}-{{number}}.nc") as cube:
        return hashlib.sha256(cube.radiance.values.tobytes()).hexdigest()

alone = [job(number) for number in range(4)]
assert len(set(alone)) == 4
for threads in {threads}:
    with ThreadPoolExecutor(threads) as pool:
        assert list(pool.map(job, 2 * [0, 1, 2, 3], timeout=600)) == 2 * alone
print("same bits", flush=True)

hcss_twin.simulate(small_stratus(), "c.nc").close()
held = hcss_twin.open_cube("c.nc")
for _ in range(2):
    try:
        export_cube("c.nc", "envi", variable="nothing")
    except hcss_twin.CubeError:
        hcss_twin.report("c.nc", replace=True)
    hcss_twin.brightness_temperature("c.nc")
    hcss_twin.Scenario.from_cube("c.nc")
    assert held.band_name.values.tolist() == ["lwir"]
held.close()
print("twice while open", flush=True)

import gc, xarray
with xarray.open_dataset("c.nc") as foreign:
    gc.freeze()  # as a program does before it forks: the collector's list no longer has the open file
    for _ in range(2):
        hcss_twin.report("c.nc", replace=True)
    assert foreign.band_name.values.tolist() == ["lwir"]
hcss_twin.report("c.nc", replace=True)
print("twice while others read it", flush=True)
"""


def run(folder, threads):
    code = CODE.format(folder=str(Path(__file__).parent), threads=threads)
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], cwd=folder, capture_output=True, text=True, timeout=3600
    )
    return done.stdout.splitlines(), f"{done.returncode}\n{done.stderr[-3000:]}"


@pytest.fixture(scope="module")
def said(tmp_path_factory):
    return run(tmp_path_factory.mktemp("threads"), [2, 4])


def test_eight_scenes_in_two_and_four_threads_have_the_bits_that_each_has_alone(said):
    assert "same bits" in said[0], said[1]


def test_functions_of_a_cube_run_twice_while_it_is_open(said):
    assert "twice while open" in said[0], said[1]


def test_functions_of_a_cube_run_twice_while_other_code_has_it_open(said):
    assert "twice while others read it" in said[0], said[1]


@pytest.mark.campaign
def test_scenes_in_threads_again_and_again(tmp_path):
    lines, problem = run(tmp_path, [2, 4] * 10)
    assert "twice while others read it" in lines, problem
