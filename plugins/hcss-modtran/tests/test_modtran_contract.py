"""A table imported from MODTRAN files is that of which they were made, and passes the conformance kit."""

import numpy as np
import pytest
from hcss_author import TransmittanceContract
from hcss_modtran.combine import REFRACTIVITY, combine
from hcss_modtran.modtran_tape7 import read_tape7
from part_of_table import WAVENUMBER, stored, table_provider
from tape7_text import RADIANCE_NAMES, cards, radiance_rows, write

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.physics.paths import to_space
from hcss_twin.physics.profile import EARTH_RADIUS_M
from hcss_twin.providers import AtmosphereInputs

HEIGHTS = [0.0, 250.0, 500.0, 1000.0, 1500.0, 2000.0, 3000.0, 4000.0, 6000.0]
ANGLES = [0.0, 20.0, 40.0, 60.0, 70.0, 80.0]


def seen_from_space(height, angle, profile, top=100e3):
    """Angle at the top of the ray that arrives where the table's does: the layered atmosphere's invariant."""
    density = float(profile.pressure_at(height)) / 101_325.0 * 288.15 / float(profile.temperature_at(height))
    index = 1.0 + REFRACTIVITY * density
    sine = np.sin(np.radians(angle)) * index * EARTH_RADIUS_M / (EARTH_RADIUS_M + top)
    return 180.0 - np.degrees(np.arcsin(sine))


@pytest.fixture(scope="module")
def imported(tmp_path_factory):
    """The shipped table written as tape7, one run per node, and imported again."""
    folder = tmp_path_factory.mktemp("tape7")
    profile = load_profile("us-standard-1976", Catalog())
    runs = []
    for height in HEIGHTS:
        for angle in ANGLES:
            tau, radiance = stored(height, angle)
            rows = radiance_rows(WAVENUMBER, np.maximum(tau, 1e-8), radiance * 1e-4, np.full(tau.shape, 1e-12))
            sight = {"h2_km": height / 1e3, "angle_deg": seen_from_space(height, angle, profile)}
            runs.append([*cards(1, **sight), "    FREQ  " + RADIANCE_NAMES, *rows, " -9999."])
    combined = combine(read_tape7(write(folder / "all.tp7", *runs)), profile)
    np.testing.assert_allclose(combined.table.zenith_deg, ANGLES, atol=1e-3)
    combined.table.write(folder / "modtran.nc", {})
    return folder / "modtran.nc"


def test_imported_file_gives_the_shipped_table_back(imported):
    table, shipped = table_provider(imported), table_provider("us-standard-1976-lowtran7")
    paths = [to_space(height, angle) for height in (0.0, 1000.0, 3000.0) for angle in (0.0, 40.0, 70.0)]
    found, expected = (provider.transmittance(WAVENUMBER, paths) for provider in (table, shipped))
    np.testing.assert_allclose(found, expected, atol=2e-6)
    found, expected = (provider.path_radiance(WAVENUMBER, paths) for provider in (table, shipped))
    np.testing.assert_allclose(found, expected, rtol=2e-4, atol=1e-8)


class TestModtranFile(TransmittanceContract):
    """A table imported from MODTRAN files is held to the kit like any other provider."""

    @pytest.fixture
    def inputs(self):
        catalog = Catalog()
        return AtmosphereInputs(load_profile("us-standard-1976", catalog), catalog)

    @pytest.fixture
    def provider(self, imported, inputs):
        return table_provider(imported)
