"""Mark the tests that measure long; a plugin of pytest for packages whose tests ``tests/conftest.py`` does not see.

``-p long_tests`` with this folder on the path puts it to use; ``tests/choose_long.py`` chooses the tests, from times
that are written to the file that the environment variable HCSS_TEST_TIMES names.
"""

import json
import os
from pathlib import Path

import pytest

LONG = Path(__file__).with_name("long.json")
"""Tests that only the whole check runs, by file and name."""


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
