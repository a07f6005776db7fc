"""Mark the tests that measure long; a plugin of pytest for packages whose tests ``tests/conftest.py`` does not see.

``-p long_tests`` with this folder on the path puts it to use; ``tests/choose_long.py`` chooses the tests.
"""

import json
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
