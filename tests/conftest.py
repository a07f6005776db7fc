"""What every test shares: computed cloud optics are kept apart from the user's."""

import os

import pytest


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory):
    before = os.environ.get("HCSS_CACHE_DIR")
    os.environ["HCSS_CACHE_DIR"] = before or str(tmp_path_factory.mktemp("cache"))
    yield
    if before is None:
        del os.environ["HCSS_CACHE_DIR"]
