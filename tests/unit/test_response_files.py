"""Response files: the same response is read from each form in which agencies publish theirs, and nothing is guessed."""

import numpy as np
import pytest

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


FORMS = {
    "ours": ("wavelength_um,response\n" + rows(UM, VALUES), ""),
    "descending": ("wavelength_um,response\n" + rows(UM[::-1], VALUES[::-1]), ""),
    "byte-order mark, semicolons, trailing": (
        "\ufeffwavelength_um;response;\n" + rows(UM, VALUES, between=";").replace("\n", ";\n"), "",
    ),
    "separators at the ends of rows alone": ("wavelength_um,response\n" + rows(UM, VALUES).replace("\n", ",\n"), ""),
    "quoted": ('"wavelength_um"\t"response"\n' + rows(UM, VALUES, between="\t"), ""),
    "spreadsheet in Latin-1": (("Wavelength (\u00b5m),RSR\n" + rows(UM, VALUES)).encode("latin-1"), "um by its label"),
    "title lines, wavenumber and response in blanks": (
        "Satellite 4 imager\nchannel 4, version 2.1\n\nwavenumber (cm-1)  response\n"
        + rows(1e4 / UM[::-1], VALUES[::-1], between="   "),
        "cm-1 by its label",
    ),
    "wavelength, wavenumber, response": (
        "Channel 7\nWavelength (um)   Wavenumber (cm-1)   SRF\n" + rows(UM, 1e4 / UM, VALUES, between="      "),
        "um by its label from column 'Wavelength (um)', response from column 'SRF'",
    ),
    "the same without labels": (rows(UM, 1e4 / UM, VALUES, between=" "), "um by magnitude from column '1'"),
    "wavenumber first without labels": (rows(1e4 / UM, UM, VALUES, between=" "), "um by magnitude"),
    "labels in a comment": ("# wavenumber [1/cm], srf\n" + rows(1e4 / UM, VALUES), "cm-1 by its label"),
    "unit in a comment": ("! wavenumbers in cm-1, by channel\n" + rows(1e4 / UM, VALUES, between=" "), "above it"),
    "nanometres": ("Wavelength (nm),BA RSR,StdDev\n" + rows(1e3 * UM, VALUES, 0.01 * VALUES), "nm by its label"),
    "units on a line below": ("Wave length;SRF\n[nm];[-]\n" + rows(1e3 * UM, VALUES, between=";"), "nm by the text"),
    "nanometres by magnitude": ("Wavelength,RSR\n" + rows(1e3 * UM, VALUES), "nm by magnitude"),
    "percent": ("wavelength_um,response_percent\n" + rows(UM, 100.0 * VALUES), "in percent by its label"),
    "percent by magnitude": (rows(UM, 100.0 * VALUES, between="\t"), "in percent by magnitude"),
    "noise below zero": (
        "wavelength_um,response\n" + rows(UM, VALUES - [0.004, 0.0, 0.0, 0.0, 0.002]),
        "2 negative values, down to -0.004",
    ),
    "zeros far beyond the band": (
        "wavelength_um,response\n0.4,0\n1,0\n2,0\n" + rows(UM, VALUES) + "9,0\n14,0\n", "",
    ),
}  # fmt: skip


@pytest.mark.parametrize("form", FORMS)
def test_a_response_is_the_same_in_every_published_form(form, tmp_path):
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


@pytest.mark.parametrize(("unit", "at"), [("cm-1", 1e4 / UM), ("nm", 1e3 * UM)])
def test_a_unit_that_the_file_does_not_say_can_be_given(unit, at, tmp_path):
    """Headers of a few lines without words on units, as of some text files of wavenumbers."""
    found = read(tmp_path, "imager\n4\n5 points, 1.0\n\n" + rows(at, VALUES, between="  "), unit=unit)
    np.testing.assert_allclose(found.wavelength_um, UM, rtol=1e-6)
    assert found.read_as.startswith(f"{unit} as given")


REFUSED = {
    "a wavelength twice": ("wavelength_um,response\n3,0.5\n4,1\n4,0.5\n", "line 4: another response"),
    "out of order": ("wavelength_um,response\n3,0\n5,1\n4,0.5\n", "line 4: neither ascending nor descending"),
    "a word among numbers": ("wavelength_um,response\n3,0\n4,one\n5,0\n", "line 3: 'one' is not a number"),
    "a word in the first row": ("wavelength_um,response\n3,none\n4,1\n5,0\n", "line 2: 'none' is not a number"),
    "a first row too short": ("wavelength_um,response\n3\n4,1\n5,0\n", "line 2: 1 fields, line 3 has 2"),
    "a field too many": ("wavelength_um,response\n3,0\n4,1,1\n5,0\n", "line 3: 3 fields, line 2 has 2"),
    "an empty field": ("wavelength_um,response\n3,0\n4,\n5,0\n", "line 3: a field is empty"),
    "not finite": ("wavelength_um,response\n3,0\n4,nan\n5,0\n", "line 3: a value is not finite"),
    "nm or cm-1": ("2300 0\n2500 1\n2700 0\n", "line 1: 2300 to 2700 in column '1' may be nm or cm-1; allowed"),
    "decimal commas": ("wavelength_um;response\n3,5;0,5\n4,5;1,0\n", "line 2: no rows of numbers; allowed: .* points"),
    "no response": ("wavelength_um,wavenumber_cm-1\n4,2500\n5,2000\n", "no column with a response"),
    "several responses": (TABLE, "responses in several columns; allowed: column = one of B10, B11, note_sd"),
    "above one": ("wavelength_um,response\n3,0\n4,1.3\n5,0\n", "reaches 1.3; allowed: 0..1, or 0..100 in percent"),
    "below zero": ("wavelength_um,response\n3,-0.1\n4,1\n5,0\n", "falls to -0.1; allowed: 0..1"),
    "one row": ("wavelength_um,response\n3,1\n", "one row of numbers; allowed: at least two"),
    "metres": ("wavelength,response\n3e-6,0\n4e-6,1\n5e-6,0\n", "of 3e-06 to 5e-06 um .*by magnitude.*allowed: 0.1 to"),
    "a workbook": (b"PK\x03\x04\x00\x00", "not a text file; allowed: text such as CSV .*export the sheet"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_wrong_or_ambiguous_is_named_with_its_line_and_what_is_allowed(case, tmp_path):
    content, message = REFUSED[case]
    with pytest.raises(CatalogError, match=r"response\.txt.*" + message):
        read(tmp_path, content)


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
