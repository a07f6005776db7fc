import shutil

import pytest

from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.providers import AtmosphereInputs, Catalog


@pytest.fixture(scope="session", autouse=True)
def cache(tmp_path_factory):
    """A cache of the test session's own, so that the source is compiled as on a new machine."""
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("cache")
        patch.setenv("HCSS_LOWTRAN7_CACHE", str(folder))
        yield folder


@pytest.fixture(scope="session")
def compiler():
    if shutil.which("gfortran") is None:
        pytest.skip("no gfortran: LOWTRAN7 cannot be compiled")


@pytest.fixture(scope="session")
def standard():
    """The 1976 US Standard atmosphere, which is LOWTRAN7's own model 6."""
    catalog = Catalog()
    return AtmosphereInputs(load_profile("us-standard-1976", catalog), catalog)


@pytest.fixture(scope="session")
def make(compiler, standard):
    """Make a provider from parameters and, by default, the 1976 US Standard atmosphere."""
    from hcss_lowtran7.parameters import Lowtran7Parameters
    from hcss_lowtran7.provider import Lowtran7

    def provider(inputs=None, **parameters):
        return Lowtran7(inputs or standard, Lowtran7Parameters(**parameters))

    return provider
