"""The realism test as a report page."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from hcss_evaluate.pages.evaluation_figures import REAL, SIMULATED
from hcss_evaluate.realism.coherence import WAVELENGTHS
from hcss_evaluate.realism.score import Curve, Realism
from hcss_twin import __version__
from hcss_twin.reports.figures import Figures
from hcss_twin.reports.page import Markup, Page
from hcss_twin.reports.tables import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FEATURES = 15


def realism_page(realism: Realism) -> Page:
    """Return the page."""
    sections = [
        Page.Section("Can a classifier tell them apart?", _scores(realism)),
        Page.Section("Features that tell most", _features(realism)),
        Page.Section("Spectra and structure functions", _curves(realism)),
    ]
    sections.append(Page.Section("Laws of clouds", _laws(realism)))
    if any(realism.coherence.values()):
        sections.append(Page.Section("Change over time", _coherence(realism)))
    counts = " and ".join(
        f"{patches} {side} patches of {scenes} scenes"
        for side, patches, scenes in zip(("measured", "simulated"), realism.patches, realism.scenes, strict=True)
    )
    return Page("Realism of simulated images", f"{counts} | hcss {__version__}", sections)


def _scores(realism: Realism) -> list[Markup.Block]:
    rows = [
        [score.classifier, score.scale, f"{score.auc:.3f}", f"{score.low:.3f} to {score.high:.3f}"]
        for score in realism.scores
    ]
    content: list[Markup.Block] = [
        Markup.paragraph(
            "AUC is the probability that a simulated patch gets the higher score of the two: 0.5 cannot tell, 1 always "
            "tells. Classifiers are asked about scenes that they have not seen."
        ),
        Table(["classifier", "patches", "AUC", "95 % interval"], rows, "Area under the curve", text_columns=2),
        Markup.paragraph(
            f"{realism.common_scenes} scenes are on both sides. {realism.left_out[0]} measured and "
            f"{realism.left_out[1]} simulated patches without cloud or with missing values are left out."
        ),
    ]
    if realism.copies is not None:
        copies = realism.copies
        content.append(
            Markup.paragraph(
                f"Copies: of {copies.patches} simulated patches, searched in {copies.examples}, moved and mirrored, "
                f"{100.0 * copies.above_90:.1f} % correlate above 0.9 and {100.0 * copies.above_95:.1f} % above 0.95; "
                f"the largest correlation is {copies.largest:.3f}."
            )
        )
    return [*content, *(Markup.note(text, "fair") for text in realism.notes)]


def _features(realism: Realism) -> list[Markup.Block]:
    rows = [
        [feature.name, feature.scale, f"{feature.auc:.3f}", Table.number(feature.real), Table.number(feature.simulated)]
        for feature in realism.features[:_FEATURES]
    ]
    caption = "Share of pairs in which the simulated patch has the larger value (0.5: no difference), and medians"
    return [Table(["feature", "patches", "share", "measured", "simulated"], rows, caption, text_columns=2)]


def _curves(realism: Realism) -> list[Markup.Block]:
    unit = "K² per (cycle per pixel)²"
    spectrum = _drawn(realism.spectrum, "wavenumber (cycles per pixel)", f"power spectral density ({unit})")
    structure = _drawn(realism.structure, "distance (pixels)", "mean squared difference (K²)")
    return [
        Markup.beside(
            Markup.picture(spectrum, "power spectra of both sides", "Mean over patches."),
            Markup.picture(structure, "structure functions of both sides", "Mean over patches."),
        )
    ]


def _laws(realism: Realism) -> list[Markup.Block]:
    sources = [f"{law.name}: {law.published.source}" for law in realism.laws if law.published is not None]
    return [
        Table(
            ["statistic", "measured", "simulated", "published"],
            [law.cells for law in realism.laws],
            "Clouds (2.5 K colder than clear sky) of all images together; ! is beyond the published range",
        ),
        Markup.paragraph(f"Published: {'; '.join(sources)}."),
    ]


def _drawn(curve: Curve, axis: str, value: str) -> Figure:
    figure = Figures.new(5.4, 3.8)
    axes = figure.subplots()
    axes.loglog(curve.axis, curve.real, "o-", color=REAL, label="measured")
    axes.loglog(curve.axis, curve.simulated, "^--", color=SIMULATED, label="simulated")
    axes.set_xlabel(axis, fontsize=8)
    axes.set_ylabel(value, fontsize=8)
    axes.tick_params(labelsize=8)
    axes.legend(fontsize=8)
    return figure


def _coherence(realism: Realism) -> list[Markup.Block]:
    bands = [f"{low:g}-{high:g} px" for low, high in pairwise(WAVELENGTHS)]
    return [
        Table(
            ["time, s", "whole", *bands],
            [
                [Table.number(lag), *(f"{value:.3f}" for value in found)]
                for lag, found in realism.coherence[side].items()
            ],
            f"{title} frames: correlation after a time, moved onto each other, whole and by wavelength",
        )
        for side, title in (("real", "Measured"), ("simulated", "Simulated"))
        if realism.coherence[side]
    ]
