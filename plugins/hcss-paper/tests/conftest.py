"""Computed results are kept apart from the user's cache, and no test uses what another one kept in its place."""

import os

import pytest


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        if "HCSS_CACHE_DIR" not in os.environ:
            patch.setenv("HCSS_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(autouse=True)
def _no_kept_plans(monkeypatch):
    """Plans are kept by scenario: what a test replaces in the code is in no name of them."""
    monkeypatch.setattr("hcss_twin.plan.make_plan.kept_findings", lambda *_: None)
