"""Response files: the same response is read from each form in which agencies publish theirs, and nothing is guessed."""

import numpy as np
import pytest
import response_corpus
from response_corpus import bad, good

from hcss_twin import CatalogError, Scenario, make_plan
from hcss_twin.core.catalog import Catalog
from hcss_twin.scenario.response_file import read_response

UM = np.array([3.5, 3.7, 3.9, 4.1, 4.3])
VALUES = np.array([0.0, 0.6, 1.0, 0.45, 0.0])
PAIRS = list(zip(UM, VALUES, strict=True))


def rows(*columns, between=","):
    return "".join(between.join(f"{value:.8g}" for value in row) + "\n" for row in zip(*columns, strict=True))


def read(tmp_path, content, name="", column=None, unit=None):
    path = tmp_path / "response.txt"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_response("response.txt", Catalog(base=tmp_path), name, column, unit)


@pytest.mark.parametrize("file", good(), ids=lambda file: file.name)
def test_a_response_is_the_same_in_every_everyday_form_and_what_is_unusual_is_told(file, tmp_path):
    found = read(tmp_path, file.content, "x", **file.keys)
    np.testing.assert_allclose(found.wavelength_um, response_corpus.UM, rtol=2e-6)
    np.testing.assert_allclose(found.response, response_corpus.VALUES, atol=2e-6)
    assert file.told in found.read_as


@pytest.mark.parametrize("file", bad(), ids=lambda file: file.name)
def test_a_fault_is_named_with_its_line_its_value_and_what_is_allowed(file, tmp_path):
    with pytest.raises(CatalogError, match=rf"response\.txt.*{file.message}"):
        read(tmp_path, file.content, "x", **file.keys)


FORMS = {
    "ours": ("wavelength_um,response\n" + rows(UM, VALUES), ""),
    "several columns": (
        "Channel 7\nWavelength (um)   Wavenumber (cm-1)   SRF\n" + rows(UM, 1e4 / UM, VALUES, between="      "),
        "um by its label from column 'Wavelength (um)', response from column 'SRF'",
    ),
    "the same without labels": (rows(UM, 1e4 / UM, VALUES, between=" "), "um by magnitude from column '1'"),
    "unit in a comment": ("! wavenumbers in cm-1, by channel\n" + rows(1e4 / UM, VALUES, between=" "), "above it"),
    "units on a line below": ("Wave length;SRF\n[nm];[-]\n" + rows(1e3 * UM, VALUES, between=";"), "nm by the text"),
    "percent by magnitude": (rows(UM, 100.0 * VALUES, between="\t"), "in percent by magnitude"),
    "decimal commas": (rows(UM, VALUES, between=";").replace(".", ","), "; decimal commas"),
    "two detectors": (
        "det wavelength_um rsr\n" + "".join(f"{d} {x} {y * f}\n" for d, f in ((1, 0.5), (2, 1.5)) for x, y in PAIRS),
        "mean of 2 detectors",
    ),
    "zeros far beyond the band": (
        "wavelength_um,response\n0.4,0\n1,0\n2,0\n" + rows(UM, VALUES) + "9,0\n14,0\n", "",
    ),
}  # fmt: skip


@pytest.mark.parametrize("form", FORMS)
def test_how_a_form_was_read_is_told(form, tmp_path):
    content, words = FORMS[form]
    found = read(tmp_path, content)
    np.testing.assert_allclose(found.wavelength_um, UM, rtol=1e-6)
    np.testing.assert_allclose(found.response, VALUES, atol=1e-6)
    assert words in found.read_as
    assert bool(words) == bool(found.read_as)


TABLE = "Wavelength (um),B10,B11,note_sd\n" + rows(UM, VALUES, VALUES[::-1], 0.0 * VALUES)


@pytest.mark.parametrize(("name", "column"), [("B11", None), ("b11", None), ("x", "B11"), ("x", "3"), ("B10", "b11")])
def test_of_several_responses_the_one_that_is_named_is_read(name, column, tmp_path):
    np.testing.assert_allclose(read(tmp_path, TABLE, name, column).response, VALUES[::-1])


def test_fields_of_other_bands_may_be_empty(tmp_path):
    content = "Wavelength (um),B10,B11\n" + "".join(f"{um},{value},\n" for um, value in PAIRS) + "10,,0.5\n11,,1.0\n"
    np.testing.assert_allclose(read(tmp_path, content, "B10").wavelength_um, UM)
    np.testing.assert_allclose(read(tmp_path, content, "B11").wavelength_um, [10.0, 11.0])


def test_fields_at_the_ends_of_lines_with_tabs_may_be_empty(tmp_path):
    content = (
        "Wavelength (um)\tB10\tB11\n" + "".join(f"{um}\t{value}\t\n" for um, value in PAIRS) + "10\t\t1\n11\t\t0.5\n"
    )
    np.testing.assert_allclose(read(tmp_path, content, "B10").response, VALUES)
    np.testing.assert_allclose(read(tmp_path, content, "B11").response, [1.0, 0.5])


def test_each_response_has_the_wavelengths_on_its_left(tmp_path):
    content = "wavelength_um,A,wavelength_um,B\n" + rows(UM, VALUES, UM + 1.0, VALUES)
    np.testing.assert_allclose(read(tmp_path, content, "B").wavelength_um, UM + 1.0)


REFUSED = {
    "a first row too short": ("wavelength_um,response\n3\n4,1\n5,0\n", "line 2: 1 fields, line 3 has 2"),
    "an empty field": ("wavelength_um,response\n3,0\n4,\n5,0\n", "line 3: a field is empty"),
    "decimal commas and points": ("wavelength_um;response\n3,5;0.5\n4,5;1,0\n", "line 2: decimal points among"),
    "no response": ("wavelength_um,wavenumber_cm-1\n4,2500\n5,2000\n", "no column with a response"),
    "detectors apart": (
        "det wavelength_um rsr\n1 3 0\n1 4 1\n2 3 0\n2 5 1\n", "line 4: another 'det' with other wavelengths",
    ),
    "several bands": ("M1 3 0\nM1 4 1\nM2 5 0\nM2 6 1\n", "rows of several bands; allowed: .* names M1, M2"),
    "a workbook": (b"PK\x03\x04\x00\x00", "not a text file; allowed: text such as CSV .*export the sheet"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_ambiguous_is_refused(case, tmp_path):
    content, message = REFUSED[case]
    with pytest.raises(CatalogError, match=r"response\.txt.*" + message):
        read(tmp_path, content)


def test_all_faults_of_rows_are_named_at_once(tmp_path):
    content = "wavelength_um,response\n3,0\n3.2,\n3.4,x\n3.6,0.5,1\n3.8,1\n3.7,1\n-4,1\n4.2,inf\n5,0\n"
    with pytest.raises(CatalogError) as told:
        read(tmp_path, content)
    wrong = {
        3: "a field is empty", 4: "'x' is not a number", 5: "3 fields, line 2 has 2", 7: "3.7 after 3.8",
        8: "-4 um; allowed: positive",
    }  # fmt: skip
    places = [str(told.value).index(f"line {line}: {text}") for line, text in wrong.items()]
    assert places == sorted(places)
    assert str(told.value).endswith("; and 1 more")


def test_a_file_whose_rows_all_have_faults_names_them(tmp_path):
    with pytest.raises(CatalogError, match=r"line 1: decimal points among.*; line 2: decimal points among"):
        read(tmp_path, "3,5;0.5\n4,5;0.6\n")


def test_a_response_too_large_and_one_too_negative_are_named_at_once(tmp_path):
    with pytest.raises(CatalogError, match=r"line 2: -20; allowed.*; line 3: 130; allowed"):
        read(tmp_path, "wavelength_um,response\n3,-20\n4,130\n5,0\n")


def test_of_rows_that_begin_with_names_those_of_the_band_are_read(tmp_path):
    content = "Band um RSR\nM1 3 0\nM1 4 1\nM2 5 0\nM2 6 1\n"
    np.testing.assert_allclose(read(tmp_path, content, "m2").wavelength_um, [5.0, 6.0])


def test_a_column_that_is_not_there_is_refused_with_those_that_are(tmp_path):
    with pytest.raises(CatalogError, match="no response in column 'B12'; allowed: B10, B11"):
        read(tmp_path, TABLE, "x", "B12")


def test_a_band_has_the_response_of_its_column_and_the_plan_says_how_it_was_read(tmp_path):
    (tmp_path / "table.csv").write_text(TABLE)
    toml = (
        "time = 2024-04-20T12:30:00+10:00\nplace = {latitude = 35.0, longitude = 150.0}\nclouds.coverage = 0.0\n"
        "image = {rows = 8, columns = 8, pixel_size = 100.0}\nframes.count = 1\n"
        'bands = [{name = "thermal", response = "table.csv", column = "B11"}]\n'
    )
    (tmp_path / "scene.toml").write_text(toml)
    plan = make_plan(Scenario.load(tmp_path / "scene.toml"))
    np.testing.assert_allclose(plan.bands[0].response, VALUES[::-1])
    assert "band thermal: um by its label from column 'Wavelength (um)', response from column 'B11'" in plan.notes
