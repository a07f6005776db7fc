"""Fixtures of pytest: tests share results, shipped files and plugins found, but not with the user.

Nor do they share with tests that replace code.

A ``conftest.py`` imports them, which puts them to use in its folder::

    from hcss_author.own_cache import fresh_results, own_cache  # noqa: F401
"""

import functools
import gc
import inspect
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hcss_twin.core import result_cache
from hcss_twin.core.plugins import OWN_DISTRIBUTION, installed
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
        _look_once(patch)
        # Files of tests need not survive a loss of power, and each wait for the disk leaves a processor idle for 5 ms.
        patch.setattr(os, "fsync", lambda handle: None)
        gc.freeze()  # what was imported is no garbage: no search goes through it again
        yield


def _look_once(patch: pytest.MonkeyPatch) -> None:
    """Find plugins and the package's files once, not in each scene: a tenth of the time of a scene with kept tables.

    Not while a test has another path for imports, or replaces the function that looks at the files.
    """
    path, plugins, files = list(sys.path), dict[str, tuple[Any, ...]](), ResultCache()
    of_package, of_files = ResultCache.fingerprint, result_cache.code_fingerprint

    def installed_once(group: str) -> Any:
        if sys.path != path:
            return installed(group)
        if group not in plugins:
            plugins[group] = tuple(installed(group))
        return plugins[group]

    def fingerprint(own: ResultCache, distribution: str = OWN_DISTRIBUTION, targets: tuple[str, ...] = ()) -> str:
        is_shared = distribution == OWN_DISTRIBUTION and result_cache.code_fingerprint is of_files
        return of_package(files if is_shared else own, distribution, targets)

    for module in ("hcss_twin.core.sections", "hcss_twin.providers.registry.registry"):
        patch.setattr(f"{module}.installed", installed_once)
    patch.setattr(ResultCache, "fingerprint", fingerprint)


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
