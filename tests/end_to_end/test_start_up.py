"""What a command imports, and what the first run on a machine says: counted, not timed."""

import json
import os
import re
import shutil
import subprocess
import sys

import pytest
from cheap import CHEAP, CHEAP_OPTIONS

import hcss_twin
from hcss_twin.core.environment import COMPILING

SMALL = ["--set", "image.rows=16", "--set", "image.columns=16", "--set", "frames.count=1", *CHEAP_OPTIONS]
SCENARIO = {"image.rows": 16, "image.columns": 16, "frames.count": 1, **CHEAP}
MODULES = """
import json, sys
sys.argv = ["hcss", *sys.argv[1:]]
from hcss_twin.cli import main
try:
    main()
except SystemExit as left:
    assert not left.code, left.code
print(json.dumps(sorted(sys.modules)))
"""


def python(code, *arguments, cwd, **environment):
    done = subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        cwd=cwd, capture_output=True, text=True, timeout=300, env={**os.environ, **environment},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done


def imported(*arguments, cwd):
    return set(json.loads(python(MODULES, *arguments, cwd=cwd).stdout.splitlines()[-1]))


def test_the_package_alone_imports_nothing_but_the_standard_library(tmp_path):
    code = "import sys; before = set(sys.modules); import hcss_twin; print(*(set(sys.modules) - before))"
    found = {name.partition(".")[0] for name in python(code, cwd=tmp_path).stdout.split()}
    assert found - set(sys.stdlib_module_names) == {"hcss_twin"}


def test_help_imports_little(tmp_path):
    found = imported("--help", cwd=tmp_path)
    # pluggy is there only if an installed plugin adds commands.
    assert not found & {"numpy", "pydantic", "numba", "netCDF4", "scipy"}
    # Each costs up to a millisecond; python itself has 30 to 60.
    assert len(found) < 250


def test_a_run_with_kept_tables_imports_no_reader_no_plotter_and_no_solver(tmp_path):
    hcss_twin.simulate(hcss_twin.Scenario.load("stratus", SCENARIO))
    found = imported("run", "stratus", *SMALL, "-o", "again.nc", cwd=tmp_path)
    heavy = {"pandas", "xarray", "matplotlib", "PIL", "pvlib", "tifffile", "h5py", "requests",
             "scipy.optimize", "scipy.interpolate", "scipy.integrate", "scipy.sparse", "scipy.ndimage",
             "scipy.special", "scipy.linalg"}  # fmt: skip
    assert sorted(found & heavy) == []


def test_a_mask_imports_no_radiance_no_certificate_and_no_picture(tmp_path):
    """With the default models, whose parameters are checked all the same."""
    only_mask = ["--set", "image.rows=16", "--set", "image.columns=16", "--set", 'output.variables=["cloud_mask"]']
    found = imported("run", "stratus", *only_mask, "-o", "mask.nc", cwd=tmp_path)
    assert "hcss_twin.models.radiance.physical.model" in found
    # Of radiance the model's class, which checks its parameters, bands, and which points have tables of their own.
    unneeded = r"physical\.(?!model$|numerics$|terms$)|radiance\.(?!physical|spectral_grid$)|path_radiance"
    unneeded += r"|engine\.(compile|tables\.(?!point_axis$|scene_axes$))|(multiple|thermal)_scattering|certificate"
    unneeded += r"|reports\.(preview|page|figures)|matplotlib"
    assert [name for name in found if re.search(unneeded, name)] == []


@pytest.fixture(scope="module")
def modules_of_a_plain_scene(tmp_path_factory):
    """What a process has imported after it has computed a scene of clouds over open sea, nothing kept."""
    folder = tmp_path_factory.mktemp("plain")
    plain = SCENARIO | {"sea.temperature_texture": 0, "atmosphere.water_vapour_texture": 0}
    code = f"import hcss_twin, json, sys\nhcss_twin.simulate(hcss_twin.Scenario.load('stratus', {plain!r}))\n"
    code += "print(json.dumps(sorted(sys.modules)))"
    return json.loads(python(code, cwd=folder, HCSS_CACHE_DIR=folder / "cache").stdout.splitlines()[-1])


@pytest.mark.parametrize(
    "part",
    [
        r"models\.surface|plan\.surface|over_surfaces",
        r"models\.elements|engine\.element",
        r"engine\.derived",
        "texture",
        r"models\.atmosphere\.inversion",
    ],
)
def test_a_scene_imports_no_code_of_what_it_does_not_have(modules_of_a_plain_scene, part):
    own = [name for name in modules_of_a_plain_scene if name.startswith("hcss_twin.")]
    assert "hcss_twin.engine.stream" in own
    assert [name for name in own if re.search(part, name)] == []


@pytest.mark.long
def test_compiling_is_told_once_when_it_is_done_and_not_when_kernels_are_kept(tmp_path):
    kept = {"NUMBA_CACHE_DIR": str(tmp_path / "kernels")}
    code = """
import numpy as np
from hcss_twin.core.environment import announce_compilation
from hcss_twin.plan.windows import pixel_sums
with announce_compilation(print):
    pixel_sums(np.zeros((2, 2)), 2)
    pixel_sums(np.zeros((2, 2), np.float32), 2)
"""
    assert python(code, cwd=tmp_path, **kept).stdout == f"{COMPILING}\n"
    assert python(code, cwd=tmp_path, **kept).stdout == ""
    another = code.replace("np.float32", "np.int16")  # as another scene needs other kernels
    assert python(another, cwd=tmp_path, **kept).stdout == f"{COMPILING}\n"
    shutil.rmtree(kept["NUMBA_CACHE_DIR"])
    again = code.replace("np.float32", "np.float64")  # one of the two
    assert python(again, cwd=tmp_path, **kept).stdout == f"{COMPILING}\n"


ABOUT_KERNELS = """
import gc, json, sys
import hcss_twin
from numba.core import sigutils
from numba.core.dispatcher import Dispatcher
from hcss_twin.engine.first_kernels import kernels_of
scenario = hcss_twin.Scenario.load("stratus", json.loads(sys.argv[1]))
hcss_twin.simulate(scenario)
used = {}
for each in gc.get_objects():
    if isinstance(each, Dispatcher) and each.overloads and not each.targetoptions.get("no_cpython_wrapper"):
        used[each.py_func.__module__, each.py_func.__qualname__] = list(each.overloads)
for each in kernels_of(scenario):
    arguments, _ = sigutils.normalize_signature(f"void({each.types})")
    assert used.pop((each.module, each.function), None) == [arguments], each
print(*(name for module, name in used if module.startswith("hcss_twin.")))
"""


@pytest.mark.long
def test_all_but_small_kernels_of_a_scene_are_listed_with_the_types_that_it_has(tmp_path):
    """So that copies of the process can compile them: what is left to it alone takes less than half a second."""
    done = python(ABOUT_KERNELS, json.dumps({"image.rows": 64, "image.columns": 64, "frames.count": 2}), cwd=tmp_path)
    assert set(done.stdout.split()) <= {"_complementary_error", "exceedance"}


def test_a_process_says_once_that_it_compiles_in_blocks_within_and_after_each_other(tmp_path):
    code = """
import numpy as np
from hcss_twin.core.environment import announce_compilation
from hcss_twin.plan.windows import pixel_sums
with announce_compilation(print), announce_compilation(print):
    pixel_sums(np.zeros((2, 2)), 2)
with announce_compilation(print):
    pixel_sums(np.zeros((2, 2), np.float32), 2)
"""
    assert python(code, cwd=tmp_path, NUMBA_CACHE_DIR=str(tmp_path / "kernels")).stdout == f"{COMPILING}\n"


@pytest.mark.parametrize(
    "way",
    [
        pytest.param("command, clear sky", marks=pytest.mark.long),  # of few kernels
        pytest.param("command", marks=pytest.mark.campaign),
        pytest.param("function", marks=pytest.mark.campaign),
    ],
)
def test_the_first_run_on_a_machine_says_that_it_compiles_and_the_next_does_not(tmp_path, way):
    kept = {"NUMBA_CACHE_DIR": str(tmp_path / "kernels")}
    code = MODULES, "run", "stratus", *SMALL, "--force"
    clear = {"clouds.coverage": 0.0, "image.samples_per_pixel": 2}
    if way == "command, clear sky":
        code = *code, *(word for key, value in clear.items() for word in ("--set", f"{key}={value}"))
    if way == "function":
        code = (f"import hcss_twin as h; h.simulate(h.Scenario.load('stratus', {SCENARIO | clear!r}))",)
    assert python(*code, cwd=tmp_path, **kept).stderr == f"{COMPILING}\n"
    assert python(*code, cwd=tmp_path, **kept).stderr == ""


def test_kernels_of_others_are_not_announced(tmp_path):
    code = """
from numba import njit
from hcss_twin.core.environment import announce_compilation
told = []
with announce_compilation(told.append):
    njit(lambda x: x + 1)(1)
print(told)
"""
    assert python(code, cwd=tmp_path).stdout == "[]\n"


def test_kernels_run_where_no_folder_for_them_may_be_written_and_the_remedy_is_named(tmp_path):
    """As for a service without a home, whose installation belongs to somebody else."""
    code = """
import numpy as np
from hcss_twin.core.environment import announce_compilation
from hcss_twin.plan.windows import pixel_sums
with announce_compilation(print):
    print(pixel_sums(np.ones((2, 2)), 2))
"""
    said = python(code, cwd=tmp_path, NUMBA_CACHE_LOCATOR_CLASSES="IPythonCacheLocator").stdout
    assert "NUMBA_CACHE_DIR" in said
    assert said.endswith("[[4.]]\n")
