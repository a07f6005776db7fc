"""Fixtures of pytest that keep what tests compute apart: from the user's cache, and from code that a test replaces.

A ``conftest.py`` imports them, which puts them to use in its folder::

    from hcss_twin.testing.own_cache import fresh_results, own_cache  # noqa: F401
"""

import os
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from hcss_twin.core.cache import recall_or_compute


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep computed results in a temporary folder, unless HCSS_CACHE_DIR names one."""
    with pytest.MonkeyPatch.context() as patch:
        if not os.environ.get("HCSS_CACHE_DIR"):
            patch.setenv("HCSS_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(autouse=True)
def fresh_results(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep scene analyses and references of a test that may replace code apart: their keys do not contain the code."""
    if "monkeypatch" not in request.fixturenames:
        yield
        return
    test = request.getfixturevalue("monkeypatch")

    def recall_unless_code_is_replaced(*each: Any) -> Any:
        compute: Callable[[], Any] = each[3]
        return compute() if test._setattr else recall_or_compute(*each)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hcss_twin.plan.scene_analysis.recall_or_compute", recall_unless_code_is_replaced)
        own = tmp_path_factory.mktemp("references").name
        patch.setattr("hcss_twin.engine.certificate.reference_columns.REFERENCES", (own, ".npz"))
        yield
