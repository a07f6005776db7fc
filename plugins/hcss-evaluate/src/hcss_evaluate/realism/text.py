"""The realism test as text for a terminal."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

from hcss_evaluate.realism.coherence import WAVELENGTHS
from hcss_evaluate.realism.score import Curve, Realism
from hcss_twin.reports.tables import Table

_FEATURES = 10
_SIDES = ("real", "simulated")


def realism_text(realism: Realism) -> str:
    """Return scores, features, copies, spectra, structure functions and coherence as tables."""
    return "\n".join(_lines(realism))


def _lines(realism: Realism) -> Iterator[str]:
    for index, side in enumerate(_SIDES):
        yield (
            f"{side}: {realism.patches[index]} patches of {realism.scenes[index]} scenes; "
            f"{realism.left_out[index]} patches without cloud or with missing values left out"
        )
    yield f"{realism.common_scenes} scenes are on both sides; folds and intervals keep scenes whole"
    yield ""
    yield "AUC of a classifier (0.5: cannot tell, 1: always tells) and 95 % interval"
    rows = [
        [score.classifier, score.scale, f"{score.auc:.3f}", f"{score.low:.3f} to {score.high:.3f}"]
        for score in realism.scores
    ]
    yield from Table.aligned(rows, 2)
    yield "Features that tell most (share of pairs in which the simulated patch has the larger value; medians)"
    yield from Table.aligned(
        [["feature", "patches", "share", *_SIDES]]
        + [
            [
                feature.name,
                feature.scale,
                f"{feature.auc:.3f}",
                Table.number(feature.real),
                Table.number(feature.simulated),
            ]
            for feature in realism.features[:_FEATURES]
        ],
        2,
    )
    if realism.copies is not None:
        copies = realism.copies
        yield f"Copies: {copies.patches} simulated patches searched in {copies.examples}, moved and mirrored"
        shares = (("above 0.9", copies.above_90), ("above 0.95", copies.above_95))
        yield from Table.aligned(
            [*([name, f"{100.0 * share:.1f} %"] for name, share in shares), ["largest", f"{copies.largest:.3f}"]]
        )
    wavelengths = tuple(1.0 / frequency for frequency in realism.spectrum.axis)
    yield "Power spectral density, K^2 per (cycle per pixel)^2"
    yield from _curve("wavelength, px", replace(realism.spectrum, axis=wavelengths))
    yield "Structure function (mean squared difference), K^2"
    yield from _curve("distance, px", realism.structure)
    yield "Laws of clouds, all images together (!: beyond the published range)"
    yield from Table.aligned([["", *_SIDES, "published"], *(law.cells for law in realism.laws)])
    bands = [f"{low:g}-{high:g} px" for low, high in pairwise(WAVELENGTHS)]
    for side in _SIDES:
        if realism.coherence[side]:
            yield f"Correlation of {side} frames after a time, moved onto each other, whole and by wavelength"
            yield from Table.aligned(
                [["s", "whole", *bands]]
                + [
                    [Table.number(lag), *(f"{value:.3f}" for value in found)]
                    for lag, found in realism.coherence[side].items()
                ]
            )
    yield from (f"note: {note}" for note in realism.notes)


def _curve(axis: str, curve: Curve) -> Iterator[str]:
    """Yield a table of both sides and their ratio in dB."""
    rows = [
        [f"{at:.3g}", Table.number(real, 3), Table.number(simulated, 3), f"{10.0 * math.log10(simulated / real):+.1f}"]
        for at, real, simulated in zip(curve.axis, curve.real, curve.simulated, strict=True)
    ]
    return Table.aligned([[axis, *_SIDES, "ratio, dB"], *rows], 0)
