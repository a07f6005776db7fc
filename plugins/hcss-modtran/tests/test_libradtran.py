import numpy as np
import pytest
from hcss_modtran.combine import combine
from hcss_modtran.importing import ReadOptions, import_files, read_paths
from hcss_modtran.libradtran import read_libradtran, read_settings

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.atmosphere.table_file import AtmosphereTable
from hcss_twin.physics.planck import planck

WAVENUMBER = np.arange(800.0, 1000.5, 10.0)
NM = 1e7 / WAVENUMBER
SEA_K, AIR_K = 285.0, 250.0
SOLAR = ["source solar", "output_quantity transmittance", "sza 60", "output_user lambda edir eglo"]
THERMAL = [
    "source thermal",
    "albedo 0",
    f"sur_temperature {SEA_K}",
    "zout toa",
    "umu -0.5 0.5 1.0  # down, slant, vertical",
    "output_process per_cm-1",
    "output_user lambda uu",
]
TAU = np.linspace(0.3, 0.9, WAVENUMBER.size)


def write(path, *columns):
    rows = [" ".join(f"{value:.9e}" for value in row) for row in zip(*columns, strict=True)]
    # uvspec writes ascending wavelengths.
    path.write_text("\n".join(rows[::-1]) + "\n")
    return path


def without(lines, name):
    return [line for line in lines if line.split()[0] != name]


def test_direct_beam_over_the_suns_cosine_is_the_transmittance(tmp_path):
    file = write(tmp_path / "a.out", NM, 0.5 * TAU, TAU)
    (path,) = read_libradtran(file, read_settings(SOLAR))
    np.testing.assert_allclose(path.wavenumber_cm1, WAVENUMBER)
    np.testing.assert_allclose(path.transmittance, TAU)
    assert (path.geometry.kind, path.geometry.angle_deg, path.geometry.observer_m) == ("up", 60.0, 0.0)
    reflectivity = [line.replace("transmittance", "reflectivity") for line in SOLAR]
    (path,) = read_libradtran(file, read_settings(reflectivity))
    np.testing.assert_allclose(path.transmittance, 0.5 * TAU)


def test_each_upward_cosine_of_a_thermal_run_is_a_path(tmp_path):
    file = write(tmp_path / "a.out", NM, *(planck(WAVENUMBER, kelvin) for kelvin in (200.0, 250.0, 280.0)))
    slant, vertical = read_libradtran(file, read_settings([*THERMAL, "altitude 2"]))
    np.testing.assert_allclose(slant.total_radiance, planck(WAVENUMBER, 250.0), rtol=1e-8)
    np.testing.assert_allclose(vertical.total_radiance, planck(WAVENUMBER, 280.0), rtol=1e-8)
    assert slant.geometry.angle_deg == pytest.approx(120.0)
    assert slant.geometry.end_m == 2000.0
    assert slant.surface_temperature_K == SEA_K


@pytest.mark.parametrize(
    ("keys", "states"), [([], True), (["mol_modify H2O 30 MM"], False), (["mixing_ratio CO2 500"], False)]
)
def test_a_table_states_the_gases_of_its_profile_unless_the_runs_changed_them(keys, states, tmp_path):
    sun = write(tmp_path / "sun.out", NM, 0.5 * TAU, TAU)
    air = write(tmp_path / "air.out", NM, TAU * planck(WAVENUMBER, SEA_K) + (1 - TAU) * planck(WAVENUMBER, AIR_K))
    (tmp_path / "sun.inp").write_text("\n".join([*SOLAR, *keys]))
    (tmp_path / "air.inp").write_text("\n".join([*without(THERMAL, "umu"), "umu 0.5", *keys]))
    told = import_files([sun, air], tmp_path / "a.nc", ReadOptions(), profile="tropical", resolution_cm1=1.0)
    known, of_runs = AtmosphereTable.read(tmp_path / "a.nc").profile, load_profile("tropical", Catalog())
    assert known.mixing_ratio.keys() == (of_runs.mixing_ratio.keys() if states else set())
    assert any("change amounts of gases" in line for line in told) == (not states)
    if states:
        np.testing.assert_allclose(known.mixing_ratio["h2o"], of_runs.mixing_ratio["h2o"])


def test_radiance_per_nanometre_is_the_same_radiance(tmp_path):
    per_nm = planck(WAVENUMBER, 280.0) * WAVENUMBER**2 / 1e7
    file = write(tmp_path / "a.out", NM, per_nm, per_nm, per_nm)
    settings = read_settings([*without(THERMAL, "output_process"), "output_process per_nm"])
    found = read_libradtran(file, settings)
    np.testing.assert_allclose(found[0].total_radiance, planck(WAVENUMBER, 280.0), rtol=1e-8)


def test_solar_and_thermal_run_together_give_the_path_radiance(tmp_path):
    total = TAU * planck(WAVENUMBER, SEA_K) + (1 - TAU) * planck(WAVENUMBER, AIR_K)
    sun = write(tmp_path / "sun.out", NM, 0.5 * TAU, TAU)
    air = write(tmp_path / "air.out", NM, total)
    (tmp_path / "sun.inp").write_text("\n".join(SOLAR))
    (tmp_path / "air.inp").write_text("\n".join([*without(THERMAL, "umu"), "umu 0.5"]))
    paths = [path for file in (sun, air) for path in read_paths(file, ReadOptions())]
    table = combine(paths, load_profile("us-standard-1976", Catalog())).table
    np.testing.assert_allclose(table.transmittance[0, 0], TAU, rtol=1e-8)
    np.testing.assert_allclose(table.path_radiance[0, 0], (1 - TAU) * planck(WAVENUMBER, AIR_K), rtol=1e-6)
    assert table.zenith_deg == pytest.approx([60.0])


def test_rows_of_several_levels_are_told_apart_by_zout(tmp_path):
    settings = read_settings([*without(SOLAR, "output_user"), "zout 0 120", "output_user lambda zout edir"])
    rows = [f"{nm} {z} {0.5 * (tau if z == 0 else 1.0)}" for nm, tau in zip(NM, TAU, strict=True) for z in (0, 120)]
    (tmp_path / "a.out").write_text("\n".join(rows))
    (path,) = read_libradtran(tmp_path / "a.out", settings)
    np.testing.assert_allclose(path.transmittance, TAU)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (without(SOLAR, "output_user"), "'output_user' is missing"),
        (without(SOLAR, "source"), "'source' is"),
        (without(SOLAR, "sza"), "'sza' is needed"),
        (without(SOLAR, "output_quantity"), "'output_quantity' is 'radiance'"),
        ([*SOLAR, "zout toa"], "'zout' is 'toa'"),
        ([*SOLAR, "output_user lambda edir edri"], "names 'edri'.*closest is 'edir'"),
        ([*SOLAR, "output_user edir eglo edn"], "lambda or wavenumber"),
        ([*SOLAR, "output_user lambda edir"], r"line 1: 3 numbers; output_user \(lambda edir\) has 2"),
        (without(THERMAL, "sur_temperature"), "'sur_temperature' is needed"),
        (without(THERMAL, "output_process"), "'output_process' is 'missing'"),
        ([*THERMAL, "albedo 0.1"], "needs 'albedo 0'"),
        ([*THERMAL, "umu -1.0 -0.5 -0.2"], "no positive umu"),
        ([*THERMAL, "phi 0 90"], "several phi"),
        ([*SOLAR, "sza 80"], r"line 19: direct transmittance 1\.0"),
    ],
)
def test_unsuitable_settings_are_named(tmp_path, lines, message):
    columns = (TAU,) * 3 if "source thermal" in lines else (0.5 * TAU, TAU)
    file = write(tmp_path / "a.out", NM, *columns)
    with pytest.raises(CatalogError, match=message):
        read_libradtran(file, read_settings(lines))


def test_a_row_that_is_no_number_is_named(tmp_path):
    file = write(tmp_path / "a.out", NM, 0.5 * TAU, TAU)
    file.write_text(file.read_text().replace("\n", "\nERROR in uvspec\n", 1))
    with pytest.raises(CatalogError, match=r"line 2: could not convert"):
        read_libradtran(file, read_settings(SOLAR))
