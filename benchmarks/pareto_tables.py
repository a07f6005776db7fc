"""Table and picture of what ``pareto.py`` measured."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

MARKERS = {"stratus": "o", "cumulus": "s", "cirrus": "^", "cirrus-over-cumulus": "D"}
COLOURS = {
    "as-printed": "#8a5fb5",
    "as-printed, LOWTRAN7 itself": "#c77d0a",
    "physical-two-stream": "#d1495b",
    "physical, 8 streams": "#79b4dd",
    "physical, 16 streams": "#2e8b57",
    "physical, 32 streams": "#111111",
    "physical": "#1b4fa8",
}
PEERS = {
    "fewer wavenumbers": ("#7f7f7f", "physical, every pixel, 19 to 229 wavenumbers"),
    "classes": ("#bcbd22", "as-printed, 2 to 128 classes of pixels"),
}
NAMES = {"physical": "physical, asked for 1e-2, 1e-3, 1e-4"}
LEAST = 1e-6
"""Lower end of the axis of errors."""


def draw(found: dict[str, Any], path: Path) -> None:
    """Draw a panel for each band with all scenes, models and peers."""
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    bands = next(iter(found.values()))["reference"]["bands"]
    figure = Figure(figsize=(10.0, 13.0), layout="constrained")
    panels = figure.subplots(len(bands), 1, sharex=True, sharey=True)
    for axes, band in zip(panels, bands, strict=True):
        for scene, result in found.items():
            style = {"marker": MARKERS[scene], "ms": 6, "mew": 0.6}
            for way, runs in result["ways"].items():
                cost, error = [each["new"] for each in runs.values()], [each["by_band"][band] for each in runs.values()]
                axes.plot(cost, error, "-", color=COLOURS[way], lw=0.9, mec="white", **style)
            for key, (colour, _) in PEERS.items():
                points = result.get(key, [])
                cost, error = [each["seconds"] for each in points], [each["by_band"][band] for each in points]
                axes.plot(cost, error, ":", color=colour, lw=0.7, mec="white", **style)
            change = _largest(result["reference"], bands.index(band))
            if change > LEAST:
                axes.plot(0.04, change, color="none", mec="#555555", ls="", **style)
        axes.set(xscale="log", yscale="log", ylim=(LEAST, 3.0))
        axes.set_title(band, loc="left", fontsize=10)
        axes.grid(True, which="major", alpha=0.3)
    figure.supylabel("largest error of 24 random pixels, relative to the scene's reference", fontsize=10)
    panels[-1].set_xlabel("processor time of the whole run with a cold cache, s")
    used = {way for result in found.values() for way in result["ways"]}
    handles = [
        Line2D([], [], color=colour, lw=4, label=NAMES.get(way, way)) for way, colour in COLOURS.items() if way in used
    ]
    handles += [Line2D([], [], color=colour, lw=4, label=text) for colour, text in PEERS.values()]
    handles += [Line2D([], [], color="k", marker=MARKERS[scene], ls="", label=scene) for scene in found]
    handles.append(
        Line2D([], [], color="none", mec="#555555", marker="o", ls="", label="reference, against 48 streams")
    )
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=9, frameon=False)
    figure.savefig(path, dpi=110)


def _largest(reference: dict[str, Any], band: int) -> float:
    return float(np.max(np.abs(reference["level_change"]), axis=0)[band])


def fronts(found: dict[str, Any]) -> str:
    """Return the error in each band, and the cost, of all scenes and models."""
    bands = next(iter(found.values()))["reference"]["bands"]
    heads = ["scene", "way", "asked", *bands, "clear sky", "s, cold cache", "s, warm cache"]
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for scene, result in found.items():
        changes = [f"{_largest(result['reference'], index):.1e}" for index in range(len(bands))]
        lines.append(f"| {scene} | *reference, against 48 streams* | | {' | '.join(changes)} | | | |")
        for way in (each for each in COLOURS if each in result["ways"]):
            for accuracy, one in result["ways"][way].items():
                cells = [way, accuracy, *(f"{error:.1e}" for error in one["by_band"].values())]
                cells += [f"{max(one['clear'].values()):.1e}", _short(one["new"]), _short(one["kept"])]
                lines.append(f"| {scene} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _short(value: float) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}" if value >= 1 else f"{value:.2g}"
