"""The Cox-Munk provider with a stand-in table of optical constants: shapes, ranges, messages."""

from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.parameters import CoxMunkParameters
from hcss_twin.models.sea import pierson_moskowitz
from hcss_twin.models.sea.cox_munk import CoxMunkSea
from hcss_twin.physics.fresnel import unpolarised_reflectance
from hcss_twin.providers import SeaInputs

TABLE = "# title: stand-in\nwavelength_um,n,k\n2.0,1.3,0.001\n5.0,1.36,0.01\n20.0,1.1,0.2\n"
WAVENUMBER = np.array([600.0, 1000.0, 2500.0])


def build(folder: Path, wind: float = 5.0, table: str = TABLE, name: str = "water") -> CoxMunkSea:
    (folder / "optical_constants").mkdir(exist_ok=True)
    (folder / "optical_constants" / "water.csv").write_text(table, encoding="utf-8")
    inputs = SeaInputs(wind, 0.0, 290.0, Catalog(root=folder))
    return CoxMunkSea(inputs, CoxMunkParameters(water_index=name))


def test_index_is_interpolated_in_the_logarithm_of_the_wavelength(tmp_path: Path) -> None:
    # 8 um lies between 5 and 20 um; the specular geometry at nadir isolates the index.
    sea = build(tmp_path)
    found = sea.brdf(np.array([1250.0]), np.ones(1), np.ones(1), np.zeros(1)).item()
    part = np.log(8 / 5) / np.log(20 / 5)
    index = complex(1.36 - part * 0.26, 0.01 * 20.0**part)
    density = 1.0 / (np.pi * (0.003 + 0.00512 * 5.0))
    assert found == pytest.approx(float(unpolarised_reflectance(index, 1.0)) * density / 4.0, rel=1e-12)


@pytest.mark.parametrize("wavenumber", [499.9, 5000.1, np.nan])
def test_wavenumber_outside_the_table_is_refused_with_the_range(tmp_path: Path, wavenumber: float) -> None:
    sea = build(tmp_path)
    with pytest.raises(ValueError, match=r"'water' covers 500 to 5000 cm-1 \(2 to 20 um\)"):
        sea.emissivity(np.array([wavenumber]), np.ones(1))


def test_the_ends_of_the_declared_range_are_inside(tmp_path: Path) -> None:
    sea = build(tmp_path)
    assert np.all(np.isfinite(sea.emissivity(np.array(sea.declares.valid["wavenumber_cm1"]), np.ones(1))))


@pytest.mark.parametrize("mu", [0.0, -0.5, 1.1, np.nan])
def test_cosine_outside_its_range_is_refused_by_name(tmp_path: Path, mu: float) -> None:
    sea = build(tmp_path)
    bad, good, zero = np.array([mu]), np.ones(1), np.zeros(1)
    with pytest.raises(ValueError, match="mu between"):
        sea.emissivity(WAVENUMBER, bad)
    with pytest.raises(ValueError, match="mu_out between"):
        sea.brdf(WAVENUMBER, bad, good, zero)
    with pytest.raises(ValueError, match="mu_in between"):
        sea.brdf(WAVENUMBER, good, bad, zero)


@pytest.mark.parametrize("azimuth", [-0.1, 3.2, np.nan])
def test_relative_azimuth_outside_zero_to_pi_is_refused(tmp_path: Path, azimuth: float) -> None:
    sea = build(tmp_path)
    with pytest.raises(ValueError, match="relative_azimuth"):
        sea.brdf(WAVENUMBER, np.ones(1), np.ones(1), np.array([azimuth]))


def test_directions_need_one_axis(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="one axis"):
        build(tmp_path).emissivity(WAVENUMBER, np.array(1.0))


def test_wind_beyond_the_measurements_is_noted_and_within_them_is_not(tmp_path: Path) -> None:
    for wind in (1.0, 14.0):
        assert not any("Cox and Munk" in note for note in build(tmp_path, wind).declares.notes)
    for wind in (0.0, 14.1, 60.0):
        assert any("Cox and Munk" in note for note in build(tmp_path, wind).declares.notes)
    with pytest.raises(ValueError, match="wind_speed_m_s"):
        build(tmp_path, 61.0)


def test_wave_height_is_that_of_the_height_spectrum(tmp_path: Path) -> None:
    assert build(tmp_path, 10.0).significant_wave_height_m == pierson_moskowitz.significant_wave_height_m(10.0)
    assert build(tmp_path, 0.0).significant_wave_height_m == 0.0


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("wavelength_um,n\n1,1.3\n2,1.3\n", "column k missing"),
        ("wavelength_um,n,k\n2,1.3,0.1\n1,1.3,0.1\n", "must increase"),
        ("wavelength_um,n,k\n1,1.3,0.1\n2,1.3,-0.1\n", "must be above 0"),
    ],
)
def test_malformed_optical_constants_are_refused(tmp_path: Path, table: str, message: str) -> None:
    with pytest.raises(CatalogError, match=message):
        build(tmp_path, table=table)


def test_unknown_water_gets_the_closest_name(tmp_path: Path) -> None:
    with pytest.raises(CatalogError, match="closest is 'water'"):
        build(tmp_path, name="watr")


def test_misspelt_parameter_is_refused() -> None:
    with pytest.raises(ValidationError):
        CoxMunkParameters.model_validate({"water_indx": "water"})
