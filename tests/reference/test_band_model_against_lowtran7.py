"""The band model beside the LOWTRAN7 Fortran, where the plugin ``hcss-lowtran7`` and gfortran are installed.

The same profiles go to both. A table of the Fortran's values that always runs is in
``test_band_model_reference.py``.
"""

import shutil
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("hcss_lowtran7", reason="the plugin hcss-lowtran7 is not installed")
if shutil.which("gfortran") is None:
    pytest.skip("gfortran is not installed", allow_module_level=True)

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.parameters import COEFFICIENTS
from hcss_twin.physics.paths import to_space
from hcss_twin.providers import AtmosphereInputs
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.providers.registry.specs import Kind

PROFILES = [
    "tropical",
    "midlatitude-summer",
    "midlatitude-winter",
    "subarctic-summer",
    "subarctic-winter",
    "us-standard-1976",
]
WAVENUMBER = np.arange(700.0, 4000.1, 5.0)
PATHS = [to_space(height, zenith) for height in (0.0, 1e3, 3e3, 6e3, 1e4) for zenith in (0.0, 30.0, 60.0, 70.0, 80.0)]


# LOWTRAN7's own levels; the catalog's profiles have finer ones above 25 km, which matters more than the code.
LEVELS_M = 1e3 * np.array([*range(26), 30, 35, 40, 45, 50, 70, 100])


def on_lowtran7_levels(profile):
    keep = np.isin(profile.altitude_m, LEVELS_M)
    return replace(
        profile,
        name=f"levels of {profile.name}",  # not the Fortran's own model of that name, whose digits differ
        altitude_m=profile.altitude_m[keep],
        pressure_Pa=profile.pressure_Pa[keep],
        temperature_K=profile.temperature_K[keep],
        mixing_ratio={gas: ratio[keep] for gas, ratio in profile.mixing_ratio.items()},
    )


def provider(name, profile, **parameters):
    registry, catalog = Registry.discover(), Catalog()
    if name == "band-model":
        parameters["file"] = COEFFICIENTS["lowtran7"]
    if parameters["aerosol"] != "none":
        parameters["season"] = "fall-winter" if "winter" in profile else "spring-summer"
    entry = registry.resolve(Kind.ATMOSPHERE, name)
    values = registry.parameters_model(entry).model_validate(parameters)
    return registry.create(entry, AtmosphereInputs(on_lowtran7_levels(load_profile(profile, catalog)), catalog), values)


@pytest.mark.parametrize("aerosol", ["none", "maritime"])
@pytest.mark.parametrize("profile", PROFILES)
def test_transmittance_is_that_of_the_fortran(profile, aerosol):
    ours = provider("band-model", profile, aerosol=aerosol).transmittance(WAVENUMBER, PATHS)
    theirs = provider("lowtran7", profile, aerosol=aerosol, precision="double").transmittance(WAVENUMBER, PATHS)
    assert np.max(np.abs(ours - theirs)) < 2e-4
    assert np.sqrt(np.mean((ours - theirs) ** 2)) < 2e-5


@pytest.mark.parametrize("aerosol", ["none", "maritime"])
@pytest.mark.parametrize("profile", PROFILES)
def test_path_radiance_in_a_band_is_that_of_the_fortran(profile, aerosol):
    paths = [to_space(height, zenith) for height in (0.0, 3e3, 1e4) for zenith in (0.0, 60.0)]
    ours = provider("band-model", profile, aerosol=aerosol).path_radiance(WAVENUMBER, paths)
    theirs = provider("lowtran7", profile, aerosol=aerosol, precision="double").path_radiance(WAVENUMBER, paths)
    for low, high in ((1e4 / 3.0, 1e4 / 2.7), (2000.0, 1e4 / 3.0), (1e4 / 14.0, 1250.0)):
        band = (low <= WAVENUMBER) & (high >= WAVENUMBER)
        np.testing.assert_allclose(ours[:, band].sum(axis=1), theirs[:, band].sum(axis=1), rtol=1e-3)


def test_two_way_solar_transmittance_is_that_of_the_fortran():
    paths = [to_space(0.0, view) + to_space(0.0, sun) for view, sun in ((0.0, 30.0), (20.0, 24.39), (60.0, 70.0))]
    ours = provider("band-model", "us-standard-1976", aerosol="none").transmittance(WAVENUMBER, paths)
    theirs = provider("lowtran7", "us-standard-1976", aerosol="none", precision="double").transmittance(
        WAVENUMBER, paths
    )
    assert np.max(np.abs(ours - theirs)) < 2e-4
