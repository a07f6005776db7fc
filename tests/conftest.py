"""What every test shares: computed cloud optics are kept apart from the user's; drawn examples are always the same."""

import os

# Workers of pytest-xdist share the processors: before numpy is loaded.
if "PYTEST_XDIST_WORKER" in os.environ:
    os.environ.setdefault("OMP_NUM_THREADS", "1")

import pytest
from hypothesis import settings

settings.register_profile("fixed", derandomize=True, database=None, deadline=None)
# pytest --hypothesis-profile=search draws others each time, and more of them.
settings.register_profile("search", deadline=None, max_examples=2000)
settings.load_profile("fixed")


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory):
    before = os.environ.get("HCSS_CACHE_DIR")
    os.environ["HCSS_CACHE_DIR"] = before or str(tmp_path_factory.mktemp("cache"))
    yield
    if before is None:
        del os.environ["HCSS_CACHE_DIR"]


@pytest.fixture(autouse=True)
def _found_out_anew(monkeypatch, tmp_path_factory):
    """What a test changes in the code is in no name of what was kept."""
    monkeypatch.setattr("hcss_twin.plan.scene_analysis.recall_or_compute", lambda *each: each[3]())
    own = tmp_path_factory.mktemp("references").name
    monkeypatch.setattr("hcss_twin.engine.certificate.certify.REFERENCES", (own, ".npz"))
