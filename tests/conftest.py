"""What every test shares: computed cloud optics are kept apart from the user's; drawn examples are always the same."""

import gc
import json
import os
import sys
from collections import Counter
from pathlib import Path

# Otherwise workers and commands in processes of their own compile the package, and rewrite the assertions, each time.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# Workers of pytest-xdist share the processors: for what is loaded later, and for other processes.
if "PYTEST_XDIST_WORKER" in os.environ:
    os.environ.setdefault("OMP_NUM_THREADS", "1")

import pytest  # noqa: E402
from all_packages import disks_are_not_waited_for, mark_long, one_installation, own_cache, pytest_runtest_protocol  # noqa: E402, F401
from hcss_author.own_cache import fresh_results  # noqa: E402, F401
from hypothesis import HealthCheck, settings  # noqa: E402
from threadpoolctl import threadpool_limits  # noqa: E402

# For what is loaded already: zarr's plugin for pytest imports numpy. Two threads in each of two workers wait for each
# other: a reference of discrete ordinates took 28 s in place of 0.6.
if "PYTEST_XDIST_WORKER" in os.environ:
    threadpool_limits(1, user_api="blas")


# A busy machine draws numbers slowly: no test fails for that.
PATIENT = [HealthCheck.too_slow]
settings.register_profile("fixed", derandomize=True, database=None, deadline=None, suppress_health_check=PATIENT)
# pytest --hypothesis-profile=search draws others each time, and more of them.
settings.register_profile("search", deadline=None, max_examples=2000)
settings.load_profile("fixed")


QUICK = Path(__file__).with_name("quick.json")
"""Test files of the quick subset, chosen by ``python tests/choose_quick.py``."""


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Search for garbage neither while thousands of tests are collected nor, later, among them and what they import."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


def pytest_addoption(parser):
    parser.addoption("--quick", action="store_true", help="only the files of tests/quick.json: under a minute")


def pytest_configure(config):
    """Leave out the tests of plugins: pytest asks the function below about files beside this one only."""
    if config.getoption("--quick") and config.args_source is pytest.Config.ArgsSource.TESTPATHS:
        config.args = [str(QUICK.parent)]


def pytest_ignore_collect(collection_path, config):
    """Leave out files that are not quick; returning None leaves the decision to others."""
    if config.getoption("--quick") and collection_path.suffix == ".py":
        quick = json.loads(QUICK.read_text(encoding="utf-8"))
        return None if collection_path.relative_to(QUICK.parent).as_posix() in quick else True
    return None


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_collection_modifyitems(items):
    """Mark the tests that measure long; begin with files that have long tests, then those with many tests.

    So the last files are short: workers of pytest-xdist take files in this order with ``--no-loadscope-reorder``.
    """
    mark_long(items)
    result = yield  # tests are selected by their marks
    many = Counter(item.path for item in items)
    has_long = {item.path for item in items if item.get_closest_marker("long")}
    items.sort(key=lambda item: (item.path not in has_long, -many[item.path]))
    return result
