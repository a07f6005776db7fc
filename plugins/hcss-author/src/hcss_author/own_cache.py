"""Fixtures of pytest: tests share results and shipped files, but not with the user, nor with tests that replace code.

A ``conftest.py`` imports them, which puts them to use in its folder::

    from hcss_author.own_cache import fresh_results, own_cache  # noqa: F401
"""

import functools
import inspect
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

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
def fresh_results(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep all results of a test apart from its first replacement of code on: keys of results need not contain it."""
    if "monkeypatch" not in request.fixturenames:
        yield
        return
    test, once = request.getfixturevalue("monkeypatch"), ResultCache.parsed
    replace, shared = test.setattr, os.environ.get("HCSS_CACHE_DIR")

    def replace_apart(*arguments: Any, **keywords: Any) -> None:
        if ResultCache.parsed is once:
            replace(ResultCache, "parsed", inspect.unwrap(once))
            if os.environ.get("HCSS_CACHE_DIR") == shared:  # not a folder of the test's own
                test.setenv("HCSS_CACHE_DIR", str(tmp_path_factory.mktemp("results")))
        replace(*arguments, **keywords)

    vars(test)["setattr"] = replace_apart
    yield
