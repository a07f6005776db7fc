"""Report page of the evidence of a cube: for a reader who must judge its numbers, and knows neither code nor models."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hcss_twin.cube.zarr_writer import cube_bytes
from hcss_twin.reports.cube_page import achieved_table
from hcss_twin.reports.evidence import KINDS, Comparison, Evidence, Support
from hcss_twin.reports.page import Markup, Page
from hcss_twin.reports.provenance import Provenance
from hcss_twin.reports.tables import Table
from hcss_twin.version import __version__


def evidence_page(path: Path) -> Page:
    """Return the page of a cube.

    Raises
    ------
    CubeError
        If it is not a complete cube.
    """
    evidence = Evidence.of(path)
    attributes = evidence.attributes
    file = f"{path.name}, {cube_bytes(path) / 1e6:.1f} MB"
    sections = [
        Page.Section("In short", list(_summary(evidence))),
        Page.Section("Scene", [_scene(evidence)]),
        Page.Section("Numerical accuracy", list(_certificate(evidence))),
        Page.Section("Error of each model", list(_budget(evidence))),
        Page.Section("Comparisons behind the models", list(_comparisons(evidence))),
        Page.Section("What no measurement supports", list(_unsupported(evidence))),
        Page.Section("What nobody has measured", list(_unmeasured(evidence))),
        Page.Section("Provenance", list(
            Provenance.blocks(
                attributes, file, {"id": "identifier", "date_created": "written"}, shown=lambda name: True
            )
        )),
    ]  # fmt: skip
    title = f"Evidence: {attributes.get('title', path.name)}"
    return Page(title, f"What stands behind the numbers of {path.name} | hcss {__version__}", sections)


def _summary(evidence: Evidence) -> Iterator[Markup.Block]:
    words = str(evidence.attributes.get("hcss_certificate", ""))
    badge = Provenance.badge(words) or Markup.badge("no certificate", "fair")
    yield Markup.element("p", badge)
    kinds = Counter(row.kind for row in evidence.comparisons)
    measured = [row for row in evidence.comparisons if row.kind == "measurement"]
    totals = [row for row in evidence.budget if row["model"] == "total"]
    largest = max(totals, key=lambda row: row["relative"], default=None)
    title = {quantity.name: quantity.title for quantity in evidence.quantities}
    items = []
    if largest is not None:
        least = "at least " if largest["statistic"] == "at least" else ""
        items.append(
            f"Largest total error that the models state for themselves: {least}{_percent(largest['relative'])} or "
            f"{least}{largest['kelvin']:.2g} K ({largest['class']}, {largest['band']})."
        )
    listed = ", ".join(f"{name}: {kinds[kind]}" for kind, name in KINDS.items() if kinds[kind])
    items.append(f"Comparisons that concern this scene: {len(evidence.comparisons)}{f' ({listed})' if listed else ''}.")
    items.append(
        f"Comparisons with measurements: {len(measured)}, of which {sum(row.blind for row in measured)} blind."
    )
    failed = [row for row in evidence.comparisons if row.failed]
    if failed:
        listed = "; ".join(dict.fromkeys(f"{title[row.quantity]} ({row.reference})" for row in failed))
        items.append(f"Comparisons that the models failed, which support nothing: {len(failed)}: {listed}.")
    shares = {quantity.title: [row.measured for row in evidence.support if row.quantity is quantity]
              for quantity in evidence.quantities}  # fmt: skip
    never = [title for title, of_bands in shares.items() if not any(of_bands)]
    partly = [title for title, of_bands in shares.items() if any(of_bands) and not all(of_bands)]
    items.append(
        f"Of {len(shares)} quantities of this scene, {len(never)} are supported by no measurement in any band, "
        f"{len(partly)} in some bands only."
    )
    yield Markup.bullets(items)
    sunlit = [quantity.title for quantity in evidence.quantities if "day" in quantity.when and quantity.title in never]
    if sunlit:
        yield Markup.note(f"No measurement supports these sunlit quantities of the scene: {'; '.join(sunlit)}.", "fair")


def _scene(evidence: Evidence) -> Markup:
    attributes = evidence.attributes
    bands = ", ".join(f"{band} ({low:g} to {high:g} um)" for band, (low, high) in evidence.bands_um.items())
    particles = Provenance.value(attributes, "hcss_particles", [])
    clouds = ", ".join(f"{layer.get('name')} ({layer.get('material')})" for layer in particles)
    times = {"day", "night"} & evidence.tags
    sun = ""
    if evidence.sun_zenith_deg is not None:
        low, high = evidence.sun_zenith_deg
        sun = f", sun zenith {low:.4g} deg" if high - low < 0.05 else f", sun zenith {low:.4g} to {high:.4g} deg"
    models = Provenance.value(attributes, "hcss_providers", {})
    return Markup.facts(
        [
            ("bands", bands or "none"),
            ("light", f"{' and '.join(sorted(times)) or 'unknown'}{sun}"),
            ("below", " and ".join(sorted({"sea", "land"} & evidence.tags))),
            ("clouds", clouds or "none"),
            ("models", ", ".join(f"{kind}: {model.get('name')}" for kind, model in models.items())),
        ]
    )


def _certificate(evidence: Evidence) -> Iterator[Markup.Block]:
    attributes = evidence.attributes
    words = attributes.get("hcss_certificate")
    if words is None:
        yield Markup.note("The cube has no certificate: no pixel was recomputed.", "fair")
        return
    yield Markup.paragraph(
        f"{attributes.get('hcss_certificate_pixels', 0)} random pixels were recomputed without tables, at every "
        "wavenumber. This checks the computation, not the models."
    )
    if attributes.get("hcss_accuracy_requested") is not None:
        yield achieved_table(attributes)
    yield Markup.folded("The certificate in words", Markup.bullets(str(words).split("; ")))
    for name, text in (
        ("hcss_beyond_accuracy", "Not within the requested accuracy because of omitted effects:"),
        ("hcss_left_out", "Left out, by choice or for the time it takes:"),
    ):
        effects = Provenance.value(attributes, name, [])
        if effects:
            yield Markup.note(text)
            yield Markup.bullets(str(effect) for effect in effects)


def _budget(evidence: Evidence) -> Iterator[Markup.Block]:
    rows = [_budget_row(row) for row in evidence.budget]
    if not rows:
        yield Markup.note("The cube has no error budget, which is written with the certificate.", "fair")
        return
    yield Markup.paragraph(
        "One standard error of the models where a row says rms, and the largest one found where it says largest. A "
        "model that nobody has compared in a band is unknown there, and the total is then a lower limit."
    )
    yield Table(["class", "band", "model", "of radiance", "temperature", "statistic", "against"], rows, text_columns=7)


def _budget_row(row: dict[str, Any]) -> list[str]:
    kelvin = "unknown" if row["kelvin"] is None else f"{row['kelvin']:.2g} K"
    if row["model"] != "total":
        statistic = row["statistic"] if row["relative"] is not None else ""
        return ["", "", row["model"], _percent(row["relative"]), kelvin, statistic, _references(row)]
    least = "at least " if row["statistic"] == "at least" else ""
    cells = (row["class"], row["band"], "total", f"{least}{_percent(row['relative'])}", f"{least}{kelvin}")
    return [*(Markup.element("strong", cell) for cell in cells), "" if least else row["statistic"], ""]


def _references(row: dict[str, Any]) -> str:
    if row["relative"] is None:
        return "no reference"
    known = "" if row["known"] > 0.95 else f" ({100.0 * row['known']:.0f} % of the band)"
    return f"{'; '.join(row['references'])}{known}{'' if row['recomputed'] else ' (not recomputed by a command)'}"


def _percent(relative: float | None) -> str:
    return "unknown" if relative is None else f"{100.0 * relative:.2g} %"


def _comparisons(evidence: Evidence) -> Iterator[Markup.Block]:
    yield Markup.paragraph(
        "Blind: no constant, limit or input of what was compared was chosen with the data of the reference. Figures "
        "hold for the stated conditions, which may differ from those of this scene. A comparison is not agreement: see "
        "the difference, and the word failed. Sources are files of the hcss_twin repository."
    )
    title = {quantity.name: quantity.title for quantity in evidence.quantities}
    rows, last = [], ""
    for row in evidence.comparisons:
        um = "" if row.um is None else f"{row.um[0]:g}\N{NON-BREAKING HYPHEN}{row.um[1]:g}"
        shown = "" if row.quantity == last else title[row.quantity]
        last = row.quantity
        blind = "yes" if row.blind else "no"
        where = Markup.joined([row.condition, Markup.element("br"), Markup.element("code", row.source)])
        rows.append([shown, row.reference, um, KINDS[row.kind], row.count, blind, failed_figure(row), where])
    header = ["quantity", "reference", "um", "kind", "compared", "blind", "difference", "condition and source"]
    yield Table(header, rows, text_columns=len(header))


def failed_figure(row: Comparison) -> str:
    """Return the figure of a comparison, after the word failed if the model did."""
    return f"failed: {row.figure}" if row.failed else row.figure


def _unsupported(evidence: Evidence) -> Iterator[Markup.Block]:
    yield Markup.paragraph("Share of each band's wavelengths at which the quantity was compared with a measurement:")
    bands = list(evidence.bands_um)
    rows = []
    for quantity in evidence.quantities:
        of_band = {row.band: row for row in evidence.support if row.quantity is quantity}
        cells = [_share(of_band.get(band if quantity.by_band else "")) for band in bands]
        best = [kind for row in of_band.values() for kind in row.kinds if kind != "measurement"]
        others = [KINDS[kind] for kind in KINDS if kind in best]
        failed = {kind for row in of_band.values() for kind in row.failed}
        others += [f"failed: {KINDS[kind]}" for kind in KINDS if kind in failed]
        rows.append([quantity.title, *cells, ", ".join(others) or "nothing"])
    yield Table(["quantity", *bands, "other evidence"], rows, text_columns=len(bands) + 2)


def _share(row: Support | None) -> str:
    if row is None:
        return "not in this band"
    return "none" if row.measured == 0.0 else f"{max(100.0 * row.measured, 1.0):.0f} %" if row.band else "yes"


def _unmeasured(evidence: Evidence) -> Iterator[Markup.Block]:
    yield Markup.paragraph("Effects that the simulation omits or simplifies, and whose size is unknown:")
    rows = [[row.what, row.source] for row in evidence.unmeasured]
    yield Table(["effect", "source"], rows, text_columns=2)
