"""How far a cube can be trusted: its certificate, its budget of errors, and the ledger of what was left out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from hcss_twin.report.cube_report.scene import json_attribute
from hcss_twin.report.page.page import Markup, Tone, badge, bullets, element, folded, joined, note, paragraph, table

if TYPE_CHECKING:
    import xarray as xr


TONES: Mapping[str, Tone] = {"PASSED": "good", "FAILED": "bad", "NOTHING CHECKED": "fair"}


def verdict(attributes: Mapping[str, Any]) -> Markup:
    """Return the certificate's first word as a badge."""
    text = str(attributes.get("hcss_certificate", ""))
    for word, tone in TONES.items():
        if text.startswith(word):
            return badge(f"certificate {word.lower()}", tone)
    return badge("no certificate", "fair" if "hcss_accuracy_requested" in attributes else "plain")


def certificate(dataset: xr.Dataset) -> Iterator[Markup]:
    """Yield the certificate: what was asked for, estimated and achieved."""
    attributes = dataset.attrs
    yield element("p", verdict(attributes))
    if "hcss_certificate" not in attributes:
        why = "The cube holds no radiance that could be checked."
        if "hcss_accuracy_requested" in attributes:
            why = "No pixel was checked: the scenario's output.certificate is 0."
        yield note(why)
    if "hcss_sensor" in attributes:
        yield note("The certificate is that of the clean cube, whose radiance the sensor measured.")
    achieved = json_attribute(dataset, "hcss_accuracy_achieved", {})
    kelvin = json_attribute(dataset, "hcss_accuracy_achieved_kelvin", {})
    asked = attributes.get("hcss_accuracy_requested")
    if asked is not None:
        asked_kelvin = attributes.get("hcss_accuracy_requested_kelvin")
        header = ["band", "asked for", "estimated", "achieved"]
        estimated = _relative(attributes.get("hcss_table_error_estimated"))
        rows = [[str(band), _relative(asked), estimated, _relative(error)] for band, error in achieved.items()]
        if not achieved:
            rows = [["all", _relative(asked), estimated, "not checked"]]
        if asked_kelvin is not None:
            header += ["asked for, K", "achieved, K"]
            rows = [[*row, f"{float(asked_kelvin):.3g}", _number(kelvin.get(row[0]))] for row in rows]
        yield table(header, rows, "Largest error relative to the radiance of the band; achieved of the checked pixels.")
    yield from _strata(dataset)
    terms = json_attribute(dataset, "hcss_certificate_terms", {})
    if terms:
        yield table(
            ["term", "largest error"],
            [[name.replace("_", " "), _relative(error)] for name, error in terms.items()],
            "Terms of the radiance, relative to the total of the band.",
        )
    if "hcss_certificate" in attributes:
        yield folded("The certificate in words", bullets(str(attributes["hcss_certificate"]).split("; ")))


def _strata(dataset: xr.Dataset) -> Iterator[Markup]:
    strata = json_attribute(dataset, "hcss_certificate_strata", [])
    if not strata:
        return
    bands = list(dict.fromkeys(band for each in strata for band in each.get("error", {})))
    rows = []
    for each in strata:
        left = sum(each.get("left_out", {}).values())
        errors = [_relative(each.get("error", {}).get(band)) for band in bands]
        rows.append(
            [str(each["name"]), str(each["pixels"]), str(each["checked"]), str(each["exceeding"]), str(left), *errors]
        )
    yield table(
        ["kind of pixel", "there are", "checked", "exceed", "left out", *(f"error {band}" for band in bands)],
        rows,
        "Pixels of the checked frames by kind.",
    )


def budget(dataset: xr.Dataset) -> Iterator[Markup]:
    """Yield what each approximation has of the error that the tables found."""
    errors = {name: error for name, error in json_attribute(dataset, "hcss_table_errors", {}).items() if error}
    if errors:
        rows = [
            [name.replace("_", " "), _relative(error)] for name, error in sorted(errors.items(), key=lambda e: -e[1])
        ]
        yield table(["approximation", "error found"], rows, "Relative error while tables were made; others have none.")
    if "hcss_wavenumbers_used" in dataset.attrs:
        used, known = dataset.attrs["hcss_wavenumbers_used"], dataset.attrs.get("hcss_wavenumbers_known")
        yield paragraph(f"{used} weighted wavenumbers stand for {known}.")


def ledger(dataset: xr.Dataset) -> Iterator[Markup]:
    """Yield what was filled in and what was left out, the largest bound first."""
    filled = json_attribute(dataset, "hcss_filled_in", [])
    if filled:
        rows = [[str(each["field"]), str(each["value"]), str(each["why"])] for each in filled]
        yield table(["filled in", "value", "why"], rows, "What the scenario left open.", text_columns=3)
    skipped = json_attribute(dataset, "hcss_skipped", [])
    if skipped:
        rows = [
            [str(each["what"]), _bound(each.get("bound")), str(each["why"])]
            for each in sorted(skipped, key=lambda each: -_rank(each.get("bound")))
        ]
        told = (
            "Left out, and the share of the radiance of any pixel that it can be at most. Unknown: equal in law, not "
            "pixel by pixel, or as the reason says."
        )
        yield element("div", table(["what", "at most", "why"], rows, told, text_columns=3), class_="ledger")
    notes = json_attribute(dataset, "hcss_notes", [])
    if notes:
        yield element("h3", "Notes of the providers")
        yield bullets([str(each) for each in notes])
    if not (filled or skipped or notes):
        yield joined([paragraph("The cube carries no plan.")])


def _rank(bound: float | None) -> float:
    return 1e-300 if bound is None else bound


def _bound(bound: float | None) -> str:
    if bound is None:
        return "unknown"
    if bound == 0.0:
        return "nothing"
    return f"{bound:.2g} x" if bound >= 1.0 else f"{100.0 * bound:.2g} %"


def _relative(value: Any) -> str:
    if value is None or not math.isfinite(float(value)):
        return "none"
    return f"{float(value):.3g}"


def _number(value: Any) -> str:
    return "none" if value is None else f"{float(value):.3g}"
