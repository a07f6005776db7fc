"""Fixtures of pytest that keep what tests compute apart: from the user's cache, and from code that a test replaces.

Tests share what they compute and read: workers of pytest-xdist one folder of results, scenes the shipped files.

A ``conftest.py`` imports them, which puts them to use in its folder::

    from hcss_twin.testing.own_cache import fresh_results, own_cache  # noqa: F401
"""

import os
import uuid
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from hcss_twin.core.cache import recall_or_compute
from hcss_twin.core.catalog import catalog_root
from hcss_twin.core.result_cache import ResultCache


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep computed results in a temporary folder, one for all workers, unless HCSS_CACHE_DIR names one."""
    with pytest.MonkeyPatch.context() as patch:
        if not os.environ.get("HCSS_CACHE_DIR"):
            own = tmp_path_factory.getbasetemp()
            folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "results"
            folder.mkdir(exist_ok=True)
            patch.setenv("HCSS_CACHE_DIR", str(folder))
        for name in ("parsed", "sha256"):
            patch.setattr(ResultCache, name, _shipped_files_once(getattr(ResultCache, name)))
        yield


def _shipped_files_once(method: Callable[..., Any]) -> Callable[..., Any]:
    """Return a method of ResultCache that reads a shipped file once in the process, not once in each scene."""
    shipped, of_all = catalog_root(), ResultCache()
    return lambda own, path, *how: method(of_all if path.is_relative_to(shipped) else own, path, *how)


@pytest.fixture(autouse=True)
def fresh_results(request: pytest.FixtureRequest) -> Iterator[None]:
    """Keep scene analyses and references of a test that replaces code apart: their keys do not contain the code."""
    if "monkeypatch" not in request.fixturenames:
        yield
        return
    test, own = request.getfixturevalue("monkeypatch"), f"references-{uuid.uuid4()}"

    def analysis(*each: Any) -> Any:
        compute: Callable[[], Any] = each[3]
        return compute() if test._setattr else recall_or_compute(*each)

    def references(kind: tuple[str, str], *others: Any) -> Any:
        return recall_or_compute((own, kind[1]) if test._setattr else kind, *others)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hcss_twin.plan.scene_analysis.recall_or_compute", analysis)
        patch.setattr("hcss_twin.engine.certificate.reference_columns.recall_or_compute", references)
        yield
