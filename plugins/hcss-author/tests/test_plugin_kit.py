"""What the kit has for all kinds: declarations, sample inputs, and no law that cannot be broken."""

from pathlib import Path

import numpy as np
import pytest
from hcss_author import (
    CloudGeneratorContract,
    OpticsContract,
    PlainSea,
    RadianceModelContract,
    SeaModelContract,
    TransmittanceContract,
    sample_microphysics,
    sample_optics_inputs,
    sample_profile,
    sample_radiance_inputs,
    sample_sea_inputs,
    sample_wavenumbers,
)

from hcss_twin.physics.profile import GASES
from hcss_twin.providers import (
    AtmosphereDeclaration,
    CloudDeclaration,
    OpticsDeclaration,
    RadianceDeclaration,
    SeaDeclaration,
    SingleScattering,
)


def test_the_sample_profile_has_all_gases_in_likely_amounts():
    profile = sample_profile()
    assert set(profile.mixing_ratio) == set(GASES)
    for share in profile.mixing_ratio.values():
        assert share.shape == profile.altitude_m.shape
        assert np.all((share > 0.0) & (share < 0.25))
        assert not share.flags.writeable
    # columns per square metre: some 20 mm of water, some 300 Dobson units of ozone (1 DU = 2.687e20 m-2)
    boltzmann, molecules_per_mm = 1.380649e-23, 1e-3 * 1e3 / 0.018015 * 6.02214076e23
    density = profile.pressure_Pa / (boltzmann * profile.temperature_K)
    columns = {gas: np.trapezoid(share * density, profile.altitude_m) for gas, share in profile.mixing_ratio.items()}
    assert 5.0 < columns["h2o"] / molecules_per_mm < 40.0
    assert 200.0 < columns["o3"] / 2.687e20 < 450.0


def saying(**attributes):
    """A provider with other attributes."""
    provider = PlainSea()
    vars(provider).update(attributes)
    return provider


@pytest.mark.parametrize(
    ("kit", "provider", "said"),
    [
        (SeaModelContract(), saying(declares=SeaDeclaration(depends_on=frozenset({"weather"}))), "weather"),
        (SeaModelContract(), saying(significant_wave_height_m="2 m"), "significant_wave_height_m"),
        (SeaModelContract(), saying(anisotropic="yes"), "anisotropic"),
        (SeaModelContract(), saying(declares=SeaDeclaration(valid={"wavenumber": (1, 2)})), "'wavenumber_cm1'"),
        (SeaModelContract(), saying(declares=SeaDeclaration(notes="text")), "tuple of strings"),
        (SeaModelContract(), saying(declares=AtmosphereDeclaration(resolution_cm1=-1.0)), "resolution_cm1"),
        (SeaModelContract(), saying(declares=CloudDeclaration(tileable="no")), "tileable"),
        (
            SeaModelContract(),
            saying(declares=AtmosphereDeclaration(native_grid_cm1=np.array([2.0, 1.0]))),
            "native_grid",
        ),
        (SeaModelContract(), saying(declares=AtmosphereDeclaration(legs="space")), "to_space"),
        (CloudGeneratorContract(), saying(skipped=["waves", "too small"]), "pairs of text"),
        (CloudGeneratorContract(), saying(image_coverage=1.5), "from 0 to 1"),
        (TransmittanceContract(), saying(path_radiance=3.0), "path_radiance"),
        (OpticsContract(), saying(declares=OpticsDeclaration(valid={"wavenumber_cm1": (2, 1)})), "low, high"),
        (OpticsContract(), saying(declares=OpticsDeclaration(materials="ash")), "set of names"),
        (RadianceModelContract(), saying(declares=RadianceDeclaration(depends_on={"time"})), "thickness"),
    ],
)
def test_kit_refuses_an_unsound_declaration(kit, provider, said):
    with pytest.raises(ValueError, match=said):
        kit.test_declaration_is_sound(provider)


def laws(kit):
    return {name for name in dir(kit) if name.startswith("test_")}


def test_every_law_of_the_kit_is_broken_by_a_provider_of_these_files():
    tests = Path(__file__).parent
    files = [
        *tests.glob("test_*kit*.py"),
        tests.parents[2] / "campaigns" / "wrong_providers" / "test_wrong_providers.py",
    ]
    text = "".join(path.read_text(encoding="utf-8") for path in files)
    kits = (CloudGeneratorContract, SeaModelContract, OpticsContract, TransmittanceContract, RadianceModelContract)
    for kit in kits:
        for law in laws(kit):
            refused = f'"{law.removeprefix("test_")}"' in text or f".{law}(" in text
            assert refused, f"{kit.__name__}.{law} has no provider that breaks it"


def test_sample_wavenumbers_respect_native_grid_and_range():
    grid = np.arange(400.0, 4000.0, 7.0)
    picked = sample_wavenumbers(
        AtmosphereDeclaration(native_grid_cm1=grid, valid={"wavenumber_cm1": (400.0, 3000.0)}), 10
    )
    assert np.all(np.isin(picked, grid))
    assert picked.min() >= 500.0
    assert picked.max() <= 3000.0
    assert not picked.flags.writeable


def test_sample_inputs_can_be_made():
    assert sample_sea_inputs().temperature_K == 290.0
    assert sample_optics_inputs().catalog.root.is_dir()
    assert np.all(np.diff(sample_profile(288.0).temperature_K) == 0.0)
    bulk = sample_radiance_inputs().optics.single_scattering(
        sample_microphysics("ice"), sample_wavenumbers(OpticsDeclaration())
    )
    assert isinstance(bulk, SingleScattering)
