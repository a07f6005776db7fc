"""What the tests of all packages share: one look at the installation, no wait for disks, long tests, measured times.

``tests/conftest.py`` imports it for the tests that it sees; ``-p all_packages`` with this folder on the path puts it to
use for others. ``tests/choose_long.py`` chooses the long tests, from times that are written to the file that the
environment variable HCSS_TEST_TIMES names.
"""

import gc
import json
import os
import sys
from pathlib import Path

import pytest
from hcss_author.own_cache import own_cache  # noqa: F401

from hcss_twin.core import result_cache
from hcss_twin.core.plugins import OWN_DISTRIBUTION, installed
from hcss_twin.core.result_cache import ResultCache

LONG = Path(__file__).with_name("long.json")
"""Tests that only the whole check runs, by file and name."""


@pytest.fixture(scope="session", autouse=True)
def one_installation():
    """Find plugins and the package's files once, not in each scene: a tenth of the time of a scene with kept tables.

    Not while a test has another path for imports, or replaces the function that looks at the files.
    """
    path, plugins, files = list(sys.path), {}, ResultCache()
    of_package, of_files = ResultCache.fingerprint, result_cache.code_fingerprint

    def installed_once(group):
        if sys.path != path:
            return installed(group)
        if group not in plugins:
            plugins[group] = tuple(installed(group))
        return plugins[group]

    def fingerprint(own, distribution=OWN_DISTRIBUTION, targets=()):
        is_shared = distribution == OWN_DISTRIBUTION and result_cache.code_fingerprint is of_files
        return of_package(files if is_shared else own, distribution, targets)

    with pytest.MonkeyPatch.context() as patch:
        for module in ("hcss_twin.core.sections", "hcss_twin.providers.registry.registry"):
            patch.setattr(f"{module}.installed", installed_once)
        patch.setattr(ResultCache, "fingerprint", fingerprint)
        gc.freeze()  # what was imported is no garbage: no search goes through it again
        yield


@pytest.fixture(scope="session", autouse=True)
def disks_are_not_waited_for():
    """Files of tests need not survive a loss of power, and each wait for the disk leaves a processor idle for 5 ms."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "fsync", lambda handle: None)
        yield


def mark_long(items):
    """Mark the chosen tests before tests are selected by their marks."""
    chosen = set(json.loads(LONG.read_text(encoding="utf-8")))
    for item in items:
        if item.nodeid in chosen:
            item.add_marker(pytest.mark.long)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    mark_long(items)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item, nextitem):
    """Add a line with the processor time of the test, its fixtures and its child processes."""
    began = sum(os.times()[:4])
    result = yield
    if os.environ.get("HCSS_TEST_TIMES"):
        with open(os.environ["HCSS_TEST_TIMES"], "a", encoding="utf-8") as file:
            file.write(f"{sum(os.times()[:4]) - began:.2f} {item.nodeid}\n")
    return result
