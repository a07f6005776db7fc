"""A hundred good and a hundred bad response files, generated: the forms that laboratories and agencies hand out.

Every good file holds the one response of ``UM`` and ``VALUES``; every bad one has a single fault, with the words that
its message must have.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

UM = np.array([8.0, 8.4, 8.6, 8.9, 9.3, 9.5])
VALUES = np.array([0.0, 0.25, 0.8, 1.0, 0.5, 0.0])


@dataclass(frozen=True)
class Good:
    """A file, and what a user writes beside it."""

    name: str
    content: bytes
    keys: dict[str, str] = field(default_factory=dict)
    told: str = ""


@dataclass(frozen=True)
class Bad:
    """A file with one fault, and a pattern that the message must match."""

    name: str
    content: bytes
    message: str
    keys: dict[str, str] = field(default_factory=dict)


SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t", "blank": " ", "blanks": "    ", "comma and blank": ", "}

HEADERS = {
    "um": ("wavelength_um", "Wavelength [um]", "WAVELENGTH (MICRONS)", "Lambda/\u00b5m", "wl(\u03bcm)", "Microns"),
    "nm": ("wavelength_nm", "Wavelength [nm]", "WAVELENGTH(NM)", "lambda (nanometers)", "wvl nm", "Nanometres"),
    "cm-1": ("wavenumber_cm-1", "Wavenumber [cm^-1]", "WAVENUMBER (1/CM)", "wn_cm-1", "nu (cm\u207b\u00b9)", "cm-1"),
}

RESPONSES = ("response", "RSR", "Relative Response", "SRF", "Transmission", "norm. response")


def spectral(unit: str, um: np.ndarray = UM) -> np.ndarray:
    return {"um": um, "nm": 1e3 * um, "cm-1": 1e4 / um}[unit]


def rows(*columns: np.ndarray, between: str = ",", form: str = ".9g") -> str:
    return "".join(between.join(format(value, form) for value in row) + "\n" for row in zip(*columns, strict=True))


def good() -> list[Good]:
    """Return the hundred good files."""
    files = [*_tables(), *_without_header(), *_details(), *_of_agencies()]
    assert len({each.name for each in files}) == len(files) == 100
    return files


def _tables() -> Iterator[Good]:
    """Separators x units, with labels, order and lines' ends that alternate: 36."""
    for index, (name, between) in enumerate(SEPARATORS.items()):
        for number, (unit, labels) in enumerate(HEADERS.items()):
            for variant in range(2):
                which = (index + 3 * variant + number) % 6
                label, response = labels[which], RESPONSES[(index + number) % 6]
                at, values = spectral(unit), VALUES
                if (index + number) % 2:
                    at, values = at[::-1], values[::-1]
                if not between.strip():  # words within a label would be columns
                    label, response = label.replace(" ", "_"), response.replace(" ", "_")
                text = f"{label}{between}{response}\n" + rows(at, values, between=between)
                text = text.replace("\n", "\r\n") if variant else text
                text = text.upper() if which == 2 else text
                yield Good(f"{name}, {label}, {response}", text.encode("utf-8-sig" if number == 1 else "utf-8"))


def _without_header() -> Iterator[Good]:
    """Numbers alone, with the unit given where they do not say it: 18."""
    for name, between in SEPARATORS.items():
        for unit in ("um", "nm", "cm-1"):
            keys = {} if unit == "um" else {"unit": unit}
            yield Good(f"{name}, no header, {unit}", rows(spectral(unit), VALUES, between=between).encode(), keys)


def _details() -> Iterator[Good]:
    """What spreadsheets, laboratories and hands do to tables: 28."""
    head, body = "wavelength_um,response\n", rows(UM, VALUES)
    quoted = "".join(",".join(f'"{field}"' for field in line.split(",")) + "\n" for line in (head + body).split())
    texts: dict[str, str | bytes | tuple[str, str]] = {
        "all quoted": quoted,
        "single quotes": quoted.replace('"', "'"),
        "labels quoted": '"Wavelength, um","Response"\n' + body,
        "label with a comma in quotes, tabs": '"Wavelength, um"\t"Response, relative"\n' + body.replace(",", "\t"),
        "separators at the ends of lines": (head + body).replace("\n", ",\n"),
        "separators at the ends of rows": head + body.replace("\n", ",\n"),
        "blanks around": head + body.replace(",", "  ,   ").replace("\n", "  \n"),
        "blank lines between": head + body.replace("\n", "\n\n"),
        "blank lines at the end": head + body + "\n\n\n",
        "lines of separators at the end": head + body + ",\n,\n",
        "no end of the last line": (head + body).rstrip("\n"),
        "old line ends": (head + body).replace("\n", "\r"),
        "UTF-16 of a spreadsheet": ("\ufeff" + (head + body).replace(",", "\t")).encode("utf-16-le"),
        "Latin-1": ("Wavelength (\u00b5m),Response\n" + body).encode("latin-1"),
        "comment lines before": "# made by hand\n# 2024\n" + head + body,
        "comment lines within": head + body.replace("8.6,", "# the middle\n8.6,"),
        "comments at the ends of rows": head + body.replace("\n", " # measured\n"),
        "separator named in the first line": "sep=;\n" + (head + body).replace(",", ";"),
        "response first": "response,wavelength_um\n" + rows(VALUES, UM),
        "response first in percent, nm": "Transmission (%),Wavelength (nm)\n" + rows(1e2 * VALUES, 1e3 * UM),
        "numbers of rows in front": "index,wavelength_um,response\n" + rows(np.arange(6.0), UM, VALUES),
        "decimal commas": ("wavelength_um;response\n" + body.replace(",", ";")).replace(".", ","),
        "Fortran's exponents": head + rows(UM, VALUES, form=".6e").replace("e", "D"),
    }
    for name, text in texts.items():
        yield Good(name, text if isinstance(text, bytes) else str(text).encode())
    yield Good(
        "percent by label", ("wavelength_um,response_percent\n" + rows(UM, 1e2 * VALUES)).encode(), told="percent"
    )
    yield Good("percent by magnitude", (head + rows(UM, 1e2 * VALUES)).encode(), told="percent")
    signs = "".join(f"{x:g},{1e2 * y:g}%\n" for x, y in zip(UM, VALUES, strict=True))
    yield Good("percent signs", (head + signs).encode(),
               told="percent")  # fmt: skip
    twice = head + body.replace("8.6,0.8\n", "8.6,0.8\n8.6,0.8\n")
    yield Good("a row twice", twice.encode(), told="1 row")
    noise = VALUES - np.array([0.003, 0.0, 0.0, 0.0, 0.0, 0.001])
    yield Good("noise below zero", (head + rows(UM, noise)).encode(), told="(lines 2, 7)")


def _of_agencies() -> Iterator[Good]:
    """Columns after lines of comments, several columns, several detectors: 18."""
    wavenumber, nm, count = 1e4 / UM[::-1], 1e3 * UM, len(UM)
    back, noise = VALUES[::-1], 0.01 * VALUES
    three = rows(UM, 1e4 / UM, VALUES, between="   ")
    many = np.repeat(np.arange(1.0, 3.0), count)
    both = (np.tile(UM, 2), np.tile(VALUES, 2))
    files = [
        ("title, channel, count, wavenumbers", f"satellite_1_imager\n 5\n {count}\n wavenumbers\n" + rows(
            wavenumber, back, between="  "), {}),
        ("lines of numbers without words", f"imager\n5\n{count}\n\n" + rows(wavenumber, back, between="  "), {
            "unit": "cm-1"}),
        ("wavelength, wavenumber, response", "Wavelength(um)  Wavenumber(cm-1)  SRF\n" + three, {}),
        ("the same, its labels in a comment", "# Wavelength(um)  Wavenumber(cm-1)  SRF\n" + three, {}),
        ("the same, labels with blanks", "Wavelength (um)   Wavenumber (cm-1)   Rel. Response\n" + three, {}),
        ("the same without labels", three, {}),
        ("exclamation marks, count of points", f"! microns\n! wavelength, response\n{count} = number of points\n"
         + rows(UM, VALUES, between="\t"), {}),
        ("hashes and labels", "# Satellite: X\n# Channel: 5\n# Units: nm\n#\n" + rows(nm, VALUES, between=" "), {}),
        ("hashes, version with numbers", "# Version 1.2\n# 2 columns\n# wavelength[um] response\n" + rows(
            UM, VALUES, between=" "), {}),
        ("percent signs as comments", "% wavelength (nm), RSR\n" + rows(nm, VALUES, between="  "), {}),
        ("band names in the first column", "Band Wavelength_nm RSR\n" + "".join(
            f"M16 {x:.3f} {y:.6f}\n" for x, y in zip(nm, VALUES, strict=True)), {}),
        ("band names, detectors, one average", "% Band  det  wvl_nm  RSR  SNR\n" + "".join(
            f"M16 0 {x:.3f} {y:.6f} 100\n" for x, y in zip(nm, VALUES, strict=True)), {}),
        ("wavelength, response, deviation", "Wavelength (nm),BA RSR,StdDev\n" + rows(nm, VALUES, noise), {}),
        ("several bands", "wavelength_um,B10,B11\n" + rows(UM, 0.5 * VALUES, VALUES), {"column": "B11"}),
        ("several bands in pairs", "wvl_um_4,rsr_4,wvl_um_5,rsr_5\n" + rows(UM - 4.0, 0.5 * VALUES, UM, VALUES), {
            "column": "rsr_5"}),
        ("missing values at the ends", "wavelength_um,response\n7,-99\n7.5,-99\n" + rows(UM, VALUES) + "10,-99\n", {}),
        ("two detectors that agree", "# band det wavelength_um RSR\n" + rows(
            0 * many + 31, many, *both, between=" "), {}),
        ("two detectors with a mean", "# band det wavelength_um RSR\n" + rows(0 * many + 31, many, np.tile(
            UM, 2), np.concatenate((0.9 * VALUES, 1.1 * VALUES)), between=" "), {}),
    ]  # fmt: skip
    for name, text, keys in files:
        yield Good(name, text.encode(), keys)


_SEPARATED = {"comma": ",", "semicolon": ";", "tab": "\t", "blanks": "  "}


def bad() -> list[Bad]:
    """Return the hundred bad files: 25 faults in four separators."""
    files = [
        Bad(f"{fault}, {name}", made[0].replace(",", between).encode("latin-1"), *made[1:])
        for fault, made in _faults().items()
        for name, between in _SEPARATED.items()
    ]
    assert len(files) == 100
    return files


def _faults() -> dict[str, tuple[str, str] | tuple[str, str, dict[str, str]]]:
    """Return files with commas, and what their messages name: the line, the value, what is allowed."""
    head, body = "wavelength_um,response\n", rows(UM, VALUES)

    def row(old: str, new: str) -> str:
        assert old in body
        return head + body.replace(old, new)

    return {
        "a word": (row("8.6,0.8", "8.6,high"), "line 4: 'high' is not a number"),
        "a word as wavelength": (row("8.6,0.8", "x8.6,0.8"), "line 4: 'x8.6' is not a number"),
        "a field too many": (row("8.6,0.8", "8.6,0.8,1"), "line 4: 3 fields, line 2 has 2"),
        "a field too few": (row("8.6,0.8", "8.6"), "line 4: 1 fields, line 2 has 2"),
        "not a number": (row("8.6,0.8", "8.6,nan"), "line 4: nan"),
        "infinite": (row("8.6,0.8", "inf,0.8"), "line 4: inf"),
        "zero": (row("8,0\n", "0,0\n"), "line 2: 0 um.*positive"),
        "negative wavelength": (row("8,0\n", "-8,0\n"), "line 2: -8 um.*positive"),
        "out of order": (row("8.6,0.8", "8.2,0.8"), "line 4: 8.2 after 8.4.*ascend"),
        "two responses": (row("8.6,0.8", "8.4,0.8"), "line 4: 0.8 for 8.4.*0.25"),
        "above one": (row("8.6,0.8", "8.6,1.3"), "line 4: 1.3; allowed: 0..1"),
        "far below zero": (row("8.6,0.8", "8.6,-0.8"), "line 4: -0.8; allowed: 0..1"),
        "above a hundred percent": (row("8.6,0.8", "8.6,250"), "line 4: 250; allowed: .*percent"),
        "percent that is a fraction": ("wavelength_um,response_percent\n" + body, "line 5: 1 .*percent"),
        "zeros": (head + rows(UM, 0.0 * VALUES), "positive somewhere"),
        "one row": (head + "8.6,0.8\n", "one row.*at least two"),
        "labels alone": (head, "no rows of numbers"),
        "nm or cm-1": (rows(1e3 * UM, VALUES), "line 1: 8000 to 9500.*may be nm or cm-1; allowed: unit"),
        "metres": ("wavelength_m,response\n" + rows(1e-6 * UM, VALUES), "'wavelength_m'.*allowed: .*um, nm, cm-1"),
        "terahertz": ("frequency_THz,response\n" + rows(299.792458 / UM, VALUES), "'frequency_THz'.*um, nm, cm-1"),
        "electron volts": ("energy_eV,response\n" + rows(1.23984 / UM, VALUES), "'energy_eV'.*um, nm, cm-1"),
        "unit against its label": (head + body, "unit nm.*'wavelength_um'", {"unit": "nm"}),
        "nm that are um": ("wavelength_nm,response\n" + body, "0.008 to 0.0095 um .*nm by its label.*allowed"),
        "several responses": ("wavelength_um,A,B\n" + rows(UM, VALUES, VALUES), "allowed: column = one of A, B"),
        "another column": (head + body, "no response in column 'B12'; allowed: response", {"column": "B12"}),
    }
