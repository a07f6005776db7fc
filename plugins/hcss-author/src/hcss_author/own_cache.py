"""Fixtures of pytest: tests share results and shipped files, but not with the user, nor with tests that replace code.

A ``conftest.py`` imports them, which puts them to use in its folder::

    from hcss_author.own_cache import fresh_results, own_cache  # noqa: F401
"""

import functools
import inspect
import os
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from hcss_twin.core.cache import recall_or_compute
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.providers import Catalog


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep computed results in a temporary folder, one for all workers, unless HCSS_CACHE_DIR names one."""
    with pytest.MonkeyPatch.context() as patch:
        if not os.environ.get("HCSS_CACHE_DIR"):
            base = tmp_path_factory.getbasetemp()
            folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "results"
            folder.mkdir(exist_ok=True)
            patch.setenv("HCSS_CACHE_DIR", str(folder))
        shipped, of_all, parsed = Catalog().root, ResultCache(), ResultCache.parsed

        @functools.wraps(parsed)
        def shipped_files_once(results: ResultCache, path: Path, *read: Any) -> Any:
            return parsed(of_all if path.is_relative_to(shipped) else results, path, *read)

        patch.setattr(ResultCache, "parsed", shipped_files_once)
        yield


@pytest.fixture(autouse=True)
def fresh_results(request: pytest.FixtureRequest) -> Iterator[None]:
    """Keep files, scene analyses and references of a test that replaces code apart: their keys do not contain it."""
    if "monkeypatch" not in request.fixturenames:
        yield
        return
    test, name = request.getfixturevalue("monkeypatch"), f"references-{uuid.uuid4()}"

    def analysis(*arguments: Any) -> Any:
        compute: Callable[[], Any] = arguments[3]
        return compute() if test._setattr else recall_or_compute(*arguments)

    def references(kind: tuple[str, str], *others: Any) -> Any:
        return recall_or_compute((name, kind[1]) if test._setattr else kind, *others)

    once = ResultCache.parsed
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            ResultCache, "parsed", lambda *arguments: (inspect.unwrap(once) if test._setattr else once)(*arguments)
        )
        patch.setattr("hcss_twin.plan.scene_analysis.recall_or_compute", analysis)
        patch.setattr("hcss_twin.engine.certificate.reference_columns.recall_or_compute", references)
        yield
