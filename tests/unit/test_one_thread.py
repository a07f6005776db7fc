"""Products of matrices of the model `physical` in one thread, whatever the process has."""

import os
import subprocess
import sys

import pytest

# In a process of its own, whose number of threads is known.
START = """
import threading, time
import scipy.linalg
from threadpoolctl import threadpool_info
from hcss_twin.core.one_thread import in_one_thread

def threads():
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}

assert threads() == {2}
"""


def run(code):
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "2", "OMP_NUM_THREADS": "2", "MKL_NUM_THREADS": "2"}
    done = subprocess.run([sys.executable, "-c", START + code], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_one_thread_inside_and_as_many_as_before_behind():
    run("""
@in_one_thread
def inside(error=None):
    assert threads() == {1}
    if error is not None:
        raise error

@in_one_thread
def nested():
    inside()
    assert threads() == {1}

inside()
assert threads() == {2}
nested()
assert threads() == {2}
try:
    inside(KeyError("x"))
except KeyError:
    assert threads() == {2}
""")


def test_functions_that_several_threads_call_each_have_one_and_leave_as_many_as_before():
    run("""
found = []

@in_one_thread
def inside():
    found.append(threads())
    time.sleep(0.02)
    found.append(threads())

many = [threading.Thread(target=inside) for _ in range(6)]
for each in many:
    each.start()
for each in many:
    each.join()
assert found == [{1}] * 12, found
assert threads() == {2}
""")


def test_the_model_runs_in_one():
    run("""
import numpy as np
from hcss_twin.laws.samples import sample_radiance_inputs
from hcss_twin.models.radiance.physical.model import Physical
from hcss_twin.providers import ColumnStates

class Asked(Exception):
    pass

class Model(Physical):
    def __init__(self):
        pass

class States(ColumnStates):
    def empty(self, *_):
        assert threads() == {1}
        raise Asked

try:
    Model().columns(States.product([sample_radiance_inputs().setting], np.ones((1, 1))), np.ones(1))
except Asked:
    assert threads() == {2}
else:
    raise AssertionError("not asked")
""")


def test_the_scene_analysis_does_not_depend_on_the_number_of_threads():
    """Its errors agreed to 12 digits only, while matrix products of plans and tables ran in several threads."""
    numbers = []
    for threads in ("1", "2"):
        code = (
            "from cheap import CHEAP\n"
            "from hcss_twin.engine.compile import compile_tables\n"
            "from hcss_twin.plan.make_plan import make_plan\n"
            "from hcss_twin.scenario.scenario import Scenario\n"
            "plan = make_plan(Scenario.load('stratus', CHEAP), keeps_results=False)\n"
            "print(vars(compile_tables(plan).errors))\n"
        )
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, sys.path))}
        environment |= {"OPENBLAS_NUM_THREADS": threads, "OMP_NUM_THREADS": threads}
        numbers.append(subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True))
    assert all(each.returncode == 0 for each in numbers), numbers[0].stderr
    assert len({each.stdout for each in numbers}) == 1


@pytest.mark.skipif("PYTEST_XDIST_WORKER" not in os.environ, reason="in workers of pytest-xdist")
def test_workers_of_the_tests_have_one_thread_each_whatever_has_imported_numpy_before():
    import scipy.linalg  # noqa: F401  for the BLAS that it brings
    from threadpoolctl import threadpool_info

    threads = {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}
    assert threads == {1} or os.environ["OMP_NUM_THREADS"] != "1"
