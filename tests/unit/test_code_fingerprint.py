"""The hash of a provider's code; ``campaigns/stale_results`` has 102 layouts of plugins."""

import math
import os
import py_compile
import time
from types import SimpleNamespace

import pytest

from hcss_twin.core.code_fingerprint import code_fingerprint
from hcss_twin.core.plugins import Origin
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.specs import Kind, ProviderSpec


@pytest.fixture
def package(tmp_path, monkeypatch):
    folder = tmp_path / "some_package"
    folder.mkdir()
    (folder / "__init__.py").write_text("from . import inner\n")
    (folder / "inner.py").write_text("a = 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    return folder


@pytest.fixture
def started_late(monkeypatch):
    """All files are older than this process."""
    monkeypatch.setattr("hcss_twin.core.code_fingerprint.STARTED_S", math.inf)


def fingerprint():
    return code_fingerprint("hcss-none", ["some_package.inner:Thing"])


@pytest.mark.usefixtures("started_late")
def test_a_link_that_leads_nowhere_does_not_hide_the_rest_of_a_package(package):
    try:
        (package / "gone.py").symlink_to(package / "nowhere.py")
    except OSError:
        pytest.skip("no links here")
    before = fingerprint()
    assert fingerprint() == before
    (package / "new.py").write_text("b = 2\n")
    assert fingerprint() != before


def test_results_of_code_that_changed_since_the_process_started_are_for_no_other_process(package, monkeypatch):
    assert fingerprint() != fingerprint()  # what is loaded may be the earlier code
    monkeypatch.setattr("hcss_twin.core.code_fingerprint.STARTED_S", math.inf)
    assert fingerprint() == fingerprint()


def test_a_link_that_another_environment_makes_to_an_installed_file_is_no_change(package, tmp_path, monkeypatch):
    """As uv installs; the change time of the file is then that of the last installation anywhere."""
    inner, info = package / "inner.py", tmp_path / "some_package-1.0.dist-info"
    os.link(inner, tmp_path / "kept.py")
    info.mkdir()
    (info / "RECORD").write_text("some_package/__init__.py,,20\nsome_package/inner.py,,6\n")
    time.sleep(0.02)
    monkeypatch.setattr("hcss_twin.core.code_fingerprint.STARTED_S", time.time())
    before = fingerprint()
    time.sleep(0.02)
    os.link(inner, tmp_path / "another.py")
    assert fingerprint() == before
    (info / "RECORD").touch()  # installed again: what is loaded may be the earlier code
    assert fingerprint() != fingerprint()


@pytest.mark.usefixtures("started_late")
def test_results_of_compiled_code_that_is_older_than_its_source_are_for_no_other_process(package):
    inner = package / "inner.py"
    py_compile.compile(str(inner))
    assert fingerprint() == fingerprint()
    before = inner.stat()
    inner.write_text("a = 2\n")  # of the same size
    os.utime(inner, ns=(before.st_mtime_ns, before.st_mtime_ns))
    assert fingerprint() != fingerprint()  # Python would run the compiled code of the first
    inner.write_text("a = 1\n")
    os.utime(inner, ns=(before.st_mtime_ns, before.st_mtime_ns))
    assert fingerprint() == fingerprint()


@pytest.mark.usefixtures("started_late", "package")
def test_the_state_of_what_only_the_provider_knows_is_part_of_its_name():
    spec = ProviderSpec("toy", "some_package.inner:Thing", None, 3, "A toy.")
    entry = Entry(Kind.SEA, spec, Origin("a", "hcss-none", "1"))
    codes = [
        entry.code(ResultCache(), SimpleNamespace(**each)) for each in ({}, {"cache_token": "1"}, {"cache_token": "2"})
    ]
    assert len(set(codes)) == 3
    assert entry.code(ResultCache(), SimpleNamespace(cache_token="2")) == codes[2]
