"""Tests that take long are left to the whole check: those of ``tests/long.json`` have the marker ``long``."""

import json
from pathlib import Path

import pytest

LONG = Path(__file__).parent / "tests" / "long.json"
"""Tests by file and name, with their parameters, chosen by ``python tests/choose_long.py`` from measured durations."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """Mark them before tests are selected by markers."""
    chosen = set(json.loads(LONG.read_text(encoding="utf-8")))
    for item in items:
        if item.nodeid in chosen:
            item.add_marker(pytest.mark.long)
