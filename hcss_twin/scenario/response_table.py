"""Tables of numbers in text files, as laboratories and agencies publish spectral responses.

Lines of text, then rows of numbers: which separator, decimal sign and labels a file has is found from the file itself.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from hcss_twin.core.errors import CatalogError, Problem
from hcss_twin.core.reading import Reading

_COMMENT = ("#", "!", "%", "//", "*")
_SEPARATORS = (";", "\t", ",", None)
WAVENUMBER = re.compile(r"wave[ _-]?num|cm\s*\^?\s*\(?-\s*1|cm\u207b\u00b9|1/cm|(?<![a-z])wn(?![a-z])", re.I)
NM = re.compile(r"(?<![a-z])nm(?![a-z])|nanomet", re.I)
UM = re.compile(r"(?<![a-z])[u\u00b5\u03bc]m(?![a-z])|micro", re.I)
WAVELENGTH = re.compile(
    rf"wave[ _-]?len|lambda|\u03bb|(?<![a-z])(wl|wvl|wave)(?![a-z])|{NM.pattern}|{UM.pattern}", re.I
)
_NAME = re.compile(r"wave|lambda|\u03bb|(?<![a-z])w[ln](?![a-z])|wvl", re.I)
RESPONSE = re.compile(r"resp|rsr|srf|transm|throughput", re.I)
OTHER_UNIT = re.compile(
    r"(?<![a-z])[mgtk]?hz(?![a-z])|(?<![a-z])m?ev(?![a-z])|\u00e5|angstr|(?<![a-z])m(m|et[re]+s?)?[)\]]*$", re.I
)
_SEVERAL_WORDS = re.compile(r"\t|\s{2,}")
_WORD_AND_UNIT = re.compile(r"\S+(?:\s*[(\[][^)\]]*[)\]])?")
_REMARK = re.compile(r"\s+(#|!|//).*$")
_DECIMAL_COMMA = re.compile(r"(?<=\d),(?=\d)|^([+-]?),(?=\d)")
_EXPONENT = re.compile(r"(?<=[\d.])[dD](?=[+-]?\d)")


@dataclass(frozen=True)
class ResponseTable:
    """The numbers of a file, by column.

    Attributes
    ----------
    labels : tuple of str
        Of the columns; empty texts where no line above the numbers labels them.
    rows : tuple of tuple of (float or None)
        None: an empty field.
    lines : tuple of int
        Number of each row's line in the file.
    header : str
        All text above the numbers.
    names : tuple of str
        First words of the rows, where these are no numbers; such a column is not among the others.
    percent : frozenset of int
        Columns whose numbers end with a percent sign.
    notes : tuple of str
        What is unusual about the numbers.
    faults : dict of int to str
        What is wrong in lines that are not among the rows.
    """

    labels: tuple[str, ...]
    rows: tuple[tuple[float | None, ...], ...]
    lines: tuple[int, ...]
    header: str
    names: tuple[str, ...] = ()
    percent: frozenset[int] = frozenset()
    notes: tuple[str, ...] = ()
    faults: Mapping[int, str] = field(default_factory=dict)

    def name(self, column: int) -> str:
        """Return how a column is called in messages, and in the key ``column`` of a band."""
        return self.labels[column] or str(column + 1)

    def is_filled(self, column: int) -> bool:
        """Whether any row has a value."""
        return any(row[column] is not None for row in self.rows)


def read_response_table(path: Path) -> ResponseTable:
    """Read the rows of numbers of a text file, and what is above them.

    Raises
    ------
    CatalogError
        If it is no text or has no rows of numbers.
    """
    with Reading(path, CatalogError, "not a text file; allowed: text such as CSV (of a spreadsheet: export the sheet)"):
        text = _decoded(path.read_bytes())
    lines = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    data = [
        (number, _REMARK.sub("", line) if line.lstrip("\"'+-. ")[:1].isdigit() else line)
        for number, line in lines
        if not line.lstrip().startswith(_COMMENT)
    ]
    form, start = _form(data)
    if start is None:
        raise CatalogError(
            f"{path}{_first_wrong(data)}: no rows of numbers; allowed: at least two columns, wavelength or wavenumber "
            "and response, separated by comma, semicolon, tab or blanks"
        )
    first = data[start]
    count = len(form.fields(first[1]))
    above = [(number, line.strip().lstrip("#!%/* ")) for number, line in lines if number < first[0]]
    labelled, labels = _labels(above, form.separator, count)
    for number, line in data[:start]:
        fields = form.fields(line)
        first_alone = slice(form.words, form.words + 1 if number < labelled else None)
        is_row = any(_number(field) is not None for field in fields[first_alone])
        if is_row and (len(fields) == count or number > labelled):
            wrong = next((field for field in fields[form.words :] if _number(field) is None), None)
            problem = f"{len(fields)} fields, line {first[0]} has {count}" if wrong is None else _no_number(wrong)
            raise CatalogError(f"{path}, line {number}: {problem}")
    texts, numbers, faults = [], [], dict[int, str]()
    for number, line in data[start:]:
        fields = form.fields(line)
        if not any(fields):  # spreadsheets write separators for empty rows
            continue
        wrong = next((text for text in fields[form.words :] if text and _number(text) is None), None)
        if len(fields) != count:
            faults[number] = f"{len(fields)} fields, line {first[0]} has {count}"
        elif form.has_commas and "." in line:
            faults[number] = "decimal points among decimal commas; allowed: one of them"
        elif wrong is not None:
            faults[number] = _no_number(wrong)
        else:
            texts.append(fields)
            numbers.append(number)
    columns = range(form.words, count)
    return ResponseTable(
        labels[form.words :],
        tuple(tuple(_number(row[column]) if row[column] else None for column in columns) for row in texts),
        tuple(numbers),
        "\n".join(line for _, line in above),
        tuple(row[0] for row in texts) if form.words else (),
        frozenset(column - form.words for column in columns if any(row[column].endswith("%") for row in texts)),
        ("decimal commas",) if form.has_commas else (),
        faults,
    )


@dataclass(frozen=True)
class _Form:
    """How rows of numbers are written: what separates their fields, decimal commas, and words before the numbers."""

    separator: str | None
    has_commas: bool
    words: int

    def fields(self, line: str) -> list[str]:
        """Return the fields of a line, without quotes."""
        fields = [field.strip().strip("\"'").strip() for field in line.split(self.separator)]
        return [_DECIMAL_COMMA.sub(r"\1.", field) for field in fields] if self.has_commas else fields

    def numbers_in(self, line: str) -> int:
        """Return the number of fields of a row of numbers, of which single ones may be empty; 0 for other lines."""
        fields = self.fields(line)
        values = [_number(field) for field in fields[self.words :] if field]
        has_words = all(field and _number(field) is None for field in fields[: self.words])
        return len(fields) if len(values) > 1 and None not in values and has_words else 0


_FORMS = [
    _Form(separator, has_commas, words)
    for words in (0, 1)
    for separator in _SEPARATORS
    for has_commas in (False, True)
    if not (has_commas and separator == ",")
]


def _form(data: Sequence[tuple[int, str]]) -> tuple[_Form, int | None]:
    """Return the form of the table and the index of its first row, whose number of fields occurs most.

    It is the form with the most rows, and of those without words before the numbers, if there are any.
    """
    best: tuple[int, _Form, int | None] = (0, _FORMS[0], None)
    for form in _FORMS:
        counts = [form.numbers_in(line) for _, line in data]
        usual = Counter(filter(None, counts)).most_common(1)
        is_second_choice = best[2] is not None and form.words > best[1].words
        if usual and usual[0][1] > best[0] and not is_second_choice:
            best = usual[0][1], form, counts.index(usual[0][0])
    return best[1:]


def _decoded(content: bytes) -> str:
    """Return the text; older files have the micro sign in Latin-1."""
    try:
        wide = content.startswith((b"\xff\xfe", b"\xfe\xff"))
        text = content.decode("utf-16" if wide else "utf-8-sig")  # spreadsheets write byte-order marks
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    if re.search(r"[\x00-\x08\x0e-\x1f\x7f-\x9f]", text):
        raise ValueError("it has bytes that are no characters")
    return text


def _number(field: str) -> float | None:
    try:
        return float(_EXPONENT.sub("e", field.removesuffix("%")))
    except ValueError:
        return None


def _no_number(field: str) -> str:
    return f"{Problem.shown(field)} is not a number"


def _first_wrong(data: Sequence[tuple[int, str]]) -> str:
    """Name the first line that begins with a digit, which was meant as a row."""
    number = next((number for number, line in data if line.lstrip("\"'+-.")[:1].isdigit()), None)
    return "" if number is None else f", line {number}"


def _labels(above: Sequence[tuple[int, str]], separator: str | None, count: int) -> tuple[float, tuple[str, ...]]:
    """Return the labels of columns, and the number of their line.

    They are in the last line above the numbers that has as many, one of them spectral. Without such a line they are
    empty, and the number is infinite.
    """
    found = []
    for number, line in reversed(above):
        fields = _Form(separator, has_commas=False, words=0).fields(line)
        if any(field.endswith((":", "=")) for field in fields):  # a remark such as "Unit: nm"
            continue
        ways = [fields, [*fields, ""]]  # rows may end with a separator where labels do not
        if separator is None:
            ways += [_SEVERAL_WORDS.split(line), _WORD_AND_UNIT.findall(line)]
        found += [(number, tuple(way)) for way in ways if len(way) == count and any(map(_is_of_spectrum, way))]
    names = [each for each in found if any(map(_NAME.search, each[1]))]  # a line below them may have units alone
    if names or found:
        return (names or found)[0]
    return math.inf, ("",) * count


def _is_of_spectrum(label: str) -> bool:
    return is_spectral(label) or bool(OTHER_UNIT.search(label))


def is_spectral(label: str) -> bool:
    """Whether a label names a wavelength or wavenumber."""
    return bool(WAVENUMBER.search(label) or WAVELENGTH.search(label)) and not RESPONSE.search(label)
