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
def _fresh_scene_analysis(request):
    """The key of a cached scene analysis does not contain what a test replaces in the code."""
    if "monkeypatch" not in request.fixturenames:
        yield
        return
    test = request.getfixturevalue("monkeypatch")
    from hcss_twin.core.cache import recall_or_compute

    def recall_unless_code_is_replaced(*each):
        return each[3]() if test._setattr else recall_or_compute(*each)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hcss_twin.plan.scene_analysis.recall_or_compute", recall_unless_code_is_replaced)
        yield
