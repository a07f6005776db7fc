import os
from pathlib import Path

import numpy as np
import pytest
from hcss_modtran.modtran_tape7 import read_tape7
from tape7_text import RADIANCE_NAMES, air, cards, radiance_rows, radiance_run, transmittance_run, write

from hcss_twin.core.errors import CatalogError
from hcss_twin.physics.planck import planck

WAVENUMBER = np.arange(800.0, 1200.5, 5.0)


def test_transmittance_run_gives_the_combined_column(tmp_path):
    tau = np.linspace(0.1, 0.9, WAVENUMBER.size)
    (path,) = read_tape7(write(tmp_path / "a.tp7", transmittance_run(WAVENUMBER, tau)))
    np.testing.assert_allclose(path.transmittance, tau, atol=5.1e-5)
    assert path.path_radiance is None
    assert path.code == "MODTRAN tape7, IEMSCT 0"


def test_thermal_run_is_converted_to_square_metres_and_blank_fields_are_zero(tmp_path):
    (path,) = read_tape7(write(tmp_path / "a.tp7", radiance_run(WAVENUMBER)))
    tau, radiance, _ = air(WAVENUMBER)
    np.testing.assert_allclose(path.transmittance, tau, atol=1e-8)
    np.testing.assert_allclose(path.path_radiance, (1 - tau) * planck(WAVENUMBER, 250.0), rtol=1e-4)
    np.testing.assert_allclose(path.path_radiance, radiance * 1e4, rtol=1e-4)
    assert path.resolution_cm1 == 5.0
    assert path.model == 6


def test_modtran5_thermal_and_solar_columns_include_their_scattered_part(tmp_path):
    tau, radiance, _ = air(WAVENUMBER)
    sun = 0.2 * radiance
    run = radiance_run(WAVENUMBER, iemsct=2, sun=sun, scattered=0.3 * radiance)
    (path,) = read_tape7(write(tmp_path / "a.tp7", run))
    np.testing.assert_allclose(path.path_radiance, radiance * 1e4, rtol=1e-4)
    np.testing.assert_allclose(path.solar["scattered"], sun * 1e4, rtol=1e-4)
    np.testing.assert_allclose(path.solar["via_end"] / path.solar["at_top"], tau, rtol=6e-3)


def test_columns_that_only_add_up_with_their_scattered_part_are_summed(tmp_path):
    """MODTRAN 6 names (THRML_EM, MULT_SCAT): the total decides that the parts are separate."""
    tau, radiance, surface = air(WAVENUMBER)
    sun = 0.2 * radiance
    lines = radiance_run(WAVENUMBER, iemsct=2, sun=sun, scattered=np.zeros_like(tau))
    header = next(at for at, line in enumerate(lines) if "FREQ" in line)
    lines[header] = lines[header].replace("PTH_THRML", " THRML_EM").replace("SOL_SCAT", "MULT_SCAT"[:9])
    rows = radiance_rows(WAVENUMBER, tau, 0.7 * radiance, surface, sun, 0.3 * radiance)
    full = radiance_rows(WAVENUMBER, tau, radiance, surface, 1.5 * sun, 0.3 * radiance)
    # Total radiance and its brightness temperature of the whole; single scattering is 0.5 of `sun`.
    lines[header + 1 : -1] = [
        row[:96] + whole[96:107] + row[107:151] + whole[151:] for row, whole in zip(rows, full, strict=True)
    ]
    lines[header] = lines[header].replace("   MULT_SCAT", "  MULT_SCAT")
    (path,) = read_tape7(write(tmp_path / "a.tp7", lines))
    np.testing.assert_allclose(path.path_radiance, radiance * 1e4, rtol=2e-4)
    np.testing.assert_allclose(path.solar["scattered"], 1.5 * sun * 1e4, rtol=2e-4)


def test_solar_run_transmits_what_it_says(tmp_path):
    depth = np.linspace(0.1, 4.0, WAVENUMBER.size)
    rows = [
        f"{number:8.2f}{np.exp(-d):8.4f}{9.6e-7 * np.exp(-d):9.2E}{9.6e-7:9.2E}{'':60}{d:11.3E}"
        for number, d in zip(WAVENUMBER, depth, strict=True)
    ]
    head = [*cards(3, h1_km=0.0, h2_km=100.0, angle_deg=30.0, itype=3), "    FREQ   TRANS     SOL TR  SOLAR"]
    (path,) = read_tape7(write(tmp_path / "a.tp7", [*head, *rows, " -9999."]))
    np.testing.assert_allclose(path.transmittance, np.exp(-depth), atol=5.1e-5)
    np.testing.assert_allclose(path.solar["transmitted"] / path.solar["at_top"], np.exp(-depth), rtol=1e-2)
    np.testing.assert_allclose(path.solar["at_top"], 9.6e-3)
    assert path.geometry.kind == "up"


@pytest.mark.parametrize(
    ("name", "to_axis", "per_cm2"),
    [
        ("WAVLEN MCRN", lambda v: 1e4 / v, lambda v: v**2 / 1e4),
        ("WAVLEN(MCRN)", lambda v: 1e4 / v, lambda v: v**2 / 1e4),
        # uW cm-2 sr-1 / nm
        ("WAVLEN(NM)", lambda v: 1e7 / v, lambda v: v**2 / 1e7 * 1e6),
        ("FREQ(CM-1)", lambda v: v, np.ones_like),
    ],
)
def test_convolved_file_in_any_unit_is_the_same_spectrum(tmp_path, name, to_axis, per_cm2):
    tau, radiance, surface = air(WAVENUMBER)
    rows = radiance_rows(WAVENUMBER, tau, radiance, surface, axis=to_axis(WAVENUMBER), scale=per_cm2(WAVENUMBER))
    if not name.startswith("FREQ"):
        rows = rows[::-1]
    lines = [*cards(1), f"{name:>12}  " + RADIANCE_NAMES, *rows, " -9999."]
    (path,) = read_tape7(write(tmp_path / "a.7sc", lines))
    np.testing.assert_allclose(path.wavenumber_cm1, WAVENUMBER, rtol=1e-6)
    np.testing.assert_allclose(path.path_radiance, (1 - tau) * planck(WAVENUMBER, 250.0), rtol=2e-4)


def test_names_of_modtran4_are_two_words(tmp_path):
    lines = radiance_run(WAVENUMBER)
    at = next(index for index, line in enumerate(lines) if "FREQ" in line)
    lines[at] = lines[at].replace("_", " ")
    (path,) = read_tape7(write(tmp_path / "tape7", lines))
    np.testing.assert_allclose(path.transmittance, air(WAVENUMBER)[0], atol=1e-8)


def test_radiance_in_another_unit_contradicts_the_brightness_temperature(tmp_path):
    tau, radiance, surface = air(WAVENUMBER)
    rows = radiance_rows(WAVENUMBER, tau, radiance, surface, scale=WAVENUMBER**2 / 1e4)
    lines = [*cards(1), "    FREQ  " + RADIANCE_NAMES, *rows, " -9999."]
    with pytest.raises(CatalogError, match=r"line 12: .*fit W cm-2 sr-1 / um"):
        read_tape7(write(tmp_path / "a.tp7", lines))


def test_several_runs_in_one_file_keep_their_geometry(tmp_path):
    runs = [radiance_run(WAVENUMBER, h2_km=height, angle_deg=160.0) for height in (0.0, 1.0, 3.0)]
    paths = read_tape7(write(tmp_path / "a.tp7", *runs))
    assert [path.geometry.end_m for path in paths] == [0.0, 1000.0, 3000.0]
    assert [path.source for path in paths] == ["a.tp7 run 1", "a.tp7 run 2", "a.tp7 run 3"]
    assert all(path.geometry.kind == "down" for path in paths)


def test_touching_fields_and_exponents_without_letter_are_read(tmp_path):
    # "90.936551296.08740": ANGLE and RANGE share no blank.
    (path,) = read_tape7(write(tmp_path / "a.tp7", radiance_run(WAVENUMBER, angle_deg=120.93655)))
    assert path.geometry.angle_deg == 120.93655
    lines = radiance_run(WAVENUMBER)
    lines[11] = lines[11].replace("0.0000E+00", "1.0000-103", 1)
    assert read_tape7(write(tmp_path / "b.tp7", lines))


def damaged(change):
    lines = radiance_run(WAVENUMBER)
    change(lines)
    return lines


def put(at, start, text):
    def change(lines):
        lines[at] = lines[at][:start] + text + lines[at][start + len(text) :]

    return change


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda lines: lines.pop(), r"line 92: .*truncated"),
        (lambda lines: lines.__setitem__(30, lines[30][:60]), r"line 31: .*truncated"),
        (lambda lines: lines.__setitem__(30, lines[30] + "  1.0"), r"line 31: more fields"),
        (put(20, 8, " 1.20000000"), r"line 21: TOT_TRANS: allowed 0 to 1; found 1.2"),
        (put(20, 8, " 0.20x00000"), r"line 21: column 'TOT_TRANS': '0.20x00000' is not a number"),
        (put(20, 8, "        nan"), r"line 21: TOT_TRANS is not a finite number"),
        (put(20, 19, "-1.0000E-07"), r"line 21: PTH_THRML must not be negative"),
        (put(20, 19, " 9.0000E-04"), r"line 21: TOTAL_RAD .*not the sum"),
        (put(20, 0, "  100.00"), r"line 21: the spectral coordinate reverses direction"),
        (lambda lines: lines.pop(10), r"line 1: no line of column names"),
        (put(0, 6, "    2    0"), r"line 1: card 1 says IEMSCT = 0"),
        (lambda lines: lines.__setitem__(slice(11, 92), []), r"line 12: the run has no rows"),
        (lambda lines: lines.extend(["garbage"]), r"line 94: no line of column names"),
        (lambda lines: lines.__setitem__(10, lines[10].replace("FREQ", "WAVELENGTH")), r"line 11: the first column"),
    ],
)  # fmt: skip
def test_damage_is_reported_with_its_line(tmp_path, change, message):
    with pytest.raises(CatalogError, match=message):
        read_tape7(write(tmp_path / "a.tp7", damaged(change)))


def test_empty_file_is_refused(tmp_path):
    (tmp_path / "a.tp7").write_text("\n\n")
    with pytest.raises(CatalogError, match="empty"):
        read_tape7(tmp_path / "a.tp7")


# --- files MODTRAN wrote ------------------------------------------------------------------------------------


def real_output(name):
    """Return a file of the folder modtran of HCSS_SAMPLE_DATA, or skip the test."""
    path = Path(os.environ.get("HCSS_SAMPLE_DATA", "")) / "modtran" / name
    if not path.is_file():
        pytest.skip(f"HCSS_SAMPLE_DATA names no folder with modtran/{name}")
    return path


def sample(name):
    (path,) = read_tape7(real_output(name))
    return path


@pytest.mark.parametrize(
    ("name", "iemsct", "kind"),
    [
        ("ModTrantape7file", 0, "horizontal"),
        ("tape7-01", 0, "horizontal"),
        ("tape7-01b", 0, "horizontal"),
        ("tape7-02c", 2, "up"),
        ("tape7-04", 3, "limb"),
        ("tape7-05", 2, "up"),
        ("tape7-05b", 2, "up"),
        ("NIRscat.fl7", 2, "up"),
    ],
)
def test_real_files_are_read_as_what_they_are(name, iemsct, kind):
    path = sample(name)
    assert path.code == f"MODTRAN tape7, IEMSCT {iemsct}"
    assert path.geometry.kind == kind
    assert np.all((path.transmittance >= 0) & (path.transmittance <= 1))
    assert np.ptp(path.transmittance) > 0 or name == "tape7-02c"
    assert (path.path_radiance is None) == (iemsct in (0, 3))


@pytest.mark.parametrize("name", ["ModTrantape7file", "tape7-01", "tape7-01b"])
def test_real_combined_transmittance_is_below_each_of_its_parts_and_agrees_with_its_logarithm(name):
    rows = [line.split() for line in real_output(name).read_text().splitlines()[12:-1]]
    table = np.array(rows, dtype=float)
    path = sample(name)
    np.testing.assert_array_equal(path.transmittance, table[:, 1])
    # Columns 2 to 10 are water, uniform gases, ozone, ...; band transmittances do not multiply exactly.
    assert np.all(path.transmittance <= table[:, 2:11].min(axis=1) + 1e-4)
    thick = path.transmittance < 5e-3
    np.testing.assert_allclose(path.transmittance[~thick], np.exp(-table[~thick, 12]), atol=6e-4)


@pytest.mark.parametrize("name", ["tape7-02c", "tape7-05", "tape7-05b"])
def test_real_path_radiance_is_that_of_air_between_the_coldest_and_the_warmest_level(name):
    path = sample(name)
    absorbed = 1 - path.transmittance
    assert np.all(path.path_radiance <= absorbed * planck(path.wavenumber_cm1, 300.0))
    assert np.all(path.path_radiance >= absorbed * planck(path.wavenumber_cm1, 180.0))


def test_real_opaque_air_radiates_like_a_black_body_of_the_air_at_the_observer():
    # Tropical model: 299.7 K at the surface; the 15 um band is opaque within metres.
    path = sample("tape7-02c")
    np.testing.assert_allclose(path.path_radiance, planck(path.wavenumber_cm1, 299.67), rtol=2e-3)


def test_real_sunlight_obeys_the_transmittance():
    path = sample("tape7-05")
    # The path ends in space: the sun's light reaches its end unweakened.
    np.testing.assert_allclose(path.solar["via_end"] / path.solar["at_top"], path.transmittance, rtol=6e-3, atol=1e-5)
    # Sun in the zenith, path at 20 deg: the vertical is 0.94 of the slant optical depth (less where lines saturate).
    clear = path.transmittance > 0.4
    vertical = -np.log(path.solar["at_observer"] / path.solar["at_top"])[clear]
    ratio = vertical / -np.log(path.transmittance[clear])
    assert np.median(ratio) == pytest.approx(np.cos(np.radians(20.0)), abs=0.03)


def test_real_solar_run_transmits_exp_of_minus_its_depth():
    path = sample("tape7-04")
    lines = real_output("tape7-04").read_text().splitlines()[11:-1]
    depth = np.array([float(line.split()[-1]) for line in lines])
    found = path.solar["transmitted"] / path.solar["at_top"]
    np.testing.assert_allclose(found, np.exp(-depth), rtol=0.02, atol=1e-40)


def test_real_near_infrared_air_scatters_sunlight_and_glows_not():
    path = sample("NIRscat.fl7")
    assert path.path_radiance.max() < 1e-18
    assert np.all(path.solar["single_scattered"] <= path.solar["scattered"])
    np.testing.assert_allclose(path.total_radiance, path.solar["scattered"], rtol=1e-4)
    # The sun at 1 au gives about 0.72 W m-2 nm-1 at 1 um, 0.072 W m-2 (cm-1)-1.
    assert path.solar["at_top"][0] == pytest.approx(0.075, rel=0.05)
