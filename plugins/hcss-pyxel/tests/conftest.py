import pytest

SCENE = {
    "image.rows": 96,
    "image.columns": 80,
    "bands": ["mwir", "lwir"],
    "output.variables": ["radiance", "cloud_mask"],
    # these compile in a tenth of a second; nothing here is about the radiance they give
    "radiance.model": "as-printed",
    "sea.model": "cox-munk",
    "optics.provider": "mie",
}


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HCSS_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="session")
def cube(tmp_path_factory):
    """Eight frames of stratus, one a second, each 1 km from the one before."""
    from hcss_twin import Scenario, simulate

    path = tmp_path_factory.mktemp("cube") / "stratus.nc"
    simulate(Scenario.load("stratus", SCENE), path).close()
    return path


@pytest.fixture
def detector():
    """Make a detector at a step of its readout."""
    from pyxel.detectors import CMOS, Characteristics, CMOSGeometry, Environment

    def make(rows=96, columns=80, time=1.0, step=1.0, geometry=None):
        geometry = geometry or CMOSGeometry(row=rows, col=columns, pixel_vert_size=15.0, pixel_horz_size=20.0)
        made = CMOS(geometry=geometry, environment=Environment(), characteristics=Characteristics())
        made.set_readout(times=[time], start_time=0.0)
        made.time, made.time_step = time, step
        return made

    return make
