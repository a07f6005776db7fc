import json

import numpy as np
import pytest
from hcss_modtran.modtran6 import read_modtran6_csv, read_modtran6_json
from hcss_modtran.spectral_path import PathGeometry
from tape7_text import air, brightness

from hcss_twin.core.errors import CatalogError
from hcss_twin.physics.planck import planck

WAVENUMBER = np.arange(800.0, 1200.5, 10.0)
AIR_K = 250.0


def spectra(**changed):
    tau, path, surface = air(WAVENUMBER, AIR_K)
    arrays = {
        "FREQ": WAVENUMBER,
        "TOT_TRANS": tau,
        "THRML_EM": 0.75 * path,
        "THRML_SCT": 0.25 * path,
        "SURF_EMIS": surface,
        "GRND_RFLT": np.zeros_like(tau),
        "TOTAL_RAD": path + surface,
        "BBODY_TK": brightness(WAVENUMBER, path + surface),
        **changed,
    }
    return {name: np.asarray(values).tolist() for name, values in arrays.items()}


def case(arrays=None, kind="RADIANCE", flag="W", **geometry):
    sight = {"ITYPE": 2, "H1ALT": 100.0, "H2ALT": 3.0, "OBSZEN": 150.0, **geometry}
    return {
        "MODTRANSTATUS": {"NAME": "case"},
        "MODTRANINPUT": {
            "GEOMETRY": sight,
            "SPECTRAL": {"XFLAG": flag, "FWHM": 10.0, "FLAGS": "WT  "},
            "ATMOSPHERE": {"MODEL": "ATM_US_STANDARD_1976"},
        },
        "MODTRANOUTPUT": {"SPECTRA": {kind: spectra() if arrays is None else arrays}},
    }


def write_json(path, *cases, indent=1):
    path.write_text(json.dumps({"MODTRAN": list(cases)}, indent=indent))
    return path


def test_json_case_is_converted_and_knows_its_geometry(tmp_path):
    (path,) = read_modtran6_json(write_json(tmp_path / "a.json", case()))
    tau = air(WAVENUMBER)[0]
    np.testing.assert_allclose(path.transmittance, tau)
    # THRML_EM and THRML_SCT are parts: only together do they close the total.
    np.testing.assert_allclose(path.path_radiance, (1 - tau) * planck(WAVENUMBER, AIR_K), rtol=1e-9)
    assert path.geometry == PathGeometry(100e3, 3e3, 150.0)
    assert (path.model, path.resolution_cm1) == (6, 10.0)


def test_every_json_case_is_a_path(tmp_path):
    found = read_modtran6_json(write_json(tmp_path / "a.json", *(case(H2ALT=h) for h in (0.0, 1.0, 3.0))))
    assert [path.geometry.end_m for path in found] == [0.0, 1e3, 3e3]
    assert [path.source for path in found] == [f"a.json case {n}" for n in (1, 2, 3)]


def test_single_line_of_sight_in_mlos_is_used(tmp_path):
    one = case(MLOS=[{"H1ALT": 100.0, "H2ALT": 0.0, "OBSZEN": 170.0}])
    (path,) = read_modtran6_json(write_json(tmp_path / "a.json", one))
    assert path.geometry == PathGeometry(100e3, 0.0, 170.0)


def test_xflag_gives_the_unit_of_wavelength_and_radiance(tmp_path):
    per_um = WAVENUMBER**2 / 1e4
    radiances = ("THRML_EM", "THRML_SCT", "SURF_EMIS", "GRND_RFLT", "TOTAL_RAD")
    plain = spectra()
    arrays = {
        name: (np.array(values) * (per_um if name in radiances else 1.0)).tolist() for name, values in plain.items()
    }
    arrays["WAVELENGTH"] = (1e4 / np.array(arrays.pop("FREQ"))).tolist()
    (path,) = read_modtran6_json(write_json(tmp_path / "a.json", case(arrays, flag="M")))
    tau = air(WAVENUMBER)[0]
    np.testing.assert_allclose(path.wavenumber_cm1, WAVENUMBER)
    np.testing.assert_allclose(path.path_radiance, (1 - tau) * planck(WAVENUMBER, AIR_K), rtol=1e-6)
    wrong = write_json(tmp_path / "b.json", case(arrays, flag="N"))
    with pytest.raises(CatalogError, match=r"line \d+: .*contradicts the brightness temperature"):
        read_modtran6_json(wrong)


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ('{"MODTRAN": [\n{"MODTRANOUTPUT":\n', r"line 3: not valid JSON"),
        ('{"MODTRAN": []}', r"line 1: no list 'MODTRAN'"),
        ("[]", r"line 1: no list 'MODTRAN'"),
        ({"MODTRAN": [{"MODTRANINPUT": {}}]}, r"line 1: case 1 has no MODTRANOUTPUT.SPECTRA"),
        ({"MODTRAN": [case(spectra(TOT_TRANS=[0.5]))]}, r"line \d+: 'TOT_TRANS' has 1 values.*truncated"),
        ({"MODTRAN": [case(spectra(TOT_TRANS=np.full(WAVENUMBER.size, 1.5)))]}, r"line \d+: TOT_TRANS: allowed 0 to 1"),
        ({"MODTRAN": [case(spectra(TOT_TRANS=["x"] * WAVENUMBER.size))]}, r"line \d+: 'TOT_TRANS' is not an array"),
        ({"MODTRAN": [case(spectra(TOT_TRANS=[[0.5]] * WAVENUMBER.size))]}, r"several lines of sight"),
        ({"MODTRAN": [case({"TOT_TRANS": [0.5]})]}, r"no spectral coordinate"),
        ({"MODTRAN": [case(flag="Q")]}, r"XFLAG is 'Q'; allowed: M, N, W"),
    ],
)  # fmt: skip
def test_damaged_json_is_refused_with_its_line(tmp_path, document, message):
    text = document if isinstance(document, str) else json.dumps(document, indent=1)
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(CatalogError, match=message):
        read_modtran6_json(tmp_path / "a.json")


def test_line_of_a_json_error_is_that_of_the_array(tmp_path):
    path = write_json(tmp_path / "a.json", case(), case(spectra(THRML_EM=["x"])))
    with pytest.raises(CatalogError) as caught:
        read_modtran6_json(path)
    lines = path.read_text().splitlines()
    expected = [number for number, line in enumerate(lines, 1) if '"THRML_EM"' in line][1]
    assert f"line {expected}:" in str(caught.value)


# --- CSV ----------------------------------------------------------------------------------------------------

NAMES = ["freq", "total transmittance", "path emission", "path thermal scat", "surface emission", "ground reflect",
         "total radiance", "brightness temp"]  # fmt: skip


def csv_lines(units=True):
    columns = list(spectra().values())
    rows = [",".join(f"{value:.7E}" for value in row) for row in zip(*columns, strict=True)]
    head = ["MODTRAN6", "case 0", "", "radiance", ",".join(NAMES)]
    return [*head, *(["(cm-1),,(W cm-2 sr-1/cm-1)"] if units else []), *rows, "-9999."]


@pytest.mark.parametrize("units", [True, False])
def test_csv_columns_are_found_by_name_wherever_they_begin(tmp_path, units):
    (tmp_path / "a.csv").write_text("\n".join(csv_lines(units)))
    sight = PathGeometry(100e3, 0.0, 180.0)
    (path,) = read_modtran6_csv(tmp_path / "a.csv", sight)
    tau = air(WAVENUMBER)[0]
    np.testing.assert_allclose(path.transmittance, tau, rtol=1e-6)
    np.testing.assert_allclose(path.path_radiance, (1 - tau) * planck(WAVENUMBER, AIR_K), rtol=1e-5)
    assert path.geometry == sight


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda lines: lines.pop(4), r"line \d+: no row of column names"),
        (lambda lines: lines.__setitem__(10, lines[10].rsplit(",", 1)[0]), r"line 11: 7 fields, the header has 8"),
        (lambda lines: lines.__setitem__(10, lines[10].replace("E", "F", 3)), r"line 11"),
        (lambda lines: lines.__setitem__(4, lines[4].replace("freq", "colour")), r"line 5: the first column"),
        (lambda lines: lines.__delitem__(slice(6, None)), r"line 7: no rows"),
        (lambda lines: lines.insert(20, "interrupted"), r"line 21: 'interrupted' stands between"),
    ],
)
def test_damaged_csv_is_refused_with_its_line(tmp_path, change, message):
    lines = csv_lines()
    if "colour" in message or "first column" in message:
        lines.pop(5)
    change(lines)
    (tmp_path / "a.csv").write_text("\n".join(lines))
    with pytest.raises(CatalogError, match=message):
        read_modtran6_csv(tmp_path / "a.csv")
