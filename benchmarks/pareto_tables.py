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
    "fewer wavenumbers": ("wavenumbers", "#7f7f7f", "every pixel by itself, at all and at fewer wavenumbers"),
    "classes": ("classes", "#bcbd22", "as-printed, 2 to 128 classes of pixels"),
}


def draw(found: dict[str, Any], path: Path) -> None:
    """Draw a panel for each band with all scenes, models and peers."""
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    bands = next(iter(found.values()))["reference"]["bands"]
    figure = Figure(figsize=(14.0, 6.8), layout="constrained")
    panels = figure.subplots(1, len(bands), sharex=True, sharey=True)
    for axes, band in zip(panels, bands, strict=True):
        for scene, result in found.items():
            style = {"marker": MARKERS[scene], "ms": 6, "mew": 0.6}
            for way, runs in result["ways"].items():
                cost, error = [each["new"] for each in runs.values()], [each["by_band"][band] for each in runs.values()]
                axes.plot(cost, error, "-", color=COLOURS[way], lw=0.9, mec="white", **style)
            for key, (_, colour, _) in PEERS.items():
                points = result.get(key, [])
                cost, error = [each["seconds"] for each in points], [each["by_band"][band] for each in points]
                axes.plot(cost, error, ":", color=colour, lw=0.7, mec="white", **style)
            change = _largest(result["reference"], bands.index(band))
            axes.plot(0.5, change, color="none", mec="#555555", ls="", **style)
        axes.set(xscale="log", yscale="log", title=band, xlabel="processor time of the whole run, s")
        axes.grid(True, which="major", alpha=0.3)
    panels[0].set_ylabel("largest error of 24 random pixels, relative to the scene's reference")
    used = {way for result in found.values() for way in result["ways"]}
    handles = [Line2D([], [], color=colour, lw=4, label=way) for way, colour in COLOURS.items() if way in used]
    handles += [Line2D([], [], color=colour, lw=4, label=text) for _, colour, text in PEERS.values()]
    handles += [Line2D([], [], color="k", marker=MARKERS[scene], ls="", label=scene) for scene in found]
    handles.append(
        Line2D([], [], color="none", mec="#555555", marker="o", ls="", label="reference, against the level before")
    )
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=9, frameon=False)
    figure.savefig(path, dpi=110)


def _largest(reference: dict[str, Any], band: int) -> float:
    return float(np.max(np.abs(reference["level_change"]), axis=0)[band])


def fronts(found: dict[str, Any]) -> str:
    """Return the error in each band, and the cost, of all scenes and ways."""
    bands = next(iter(found.values()))["reference"]["bands"]
    heads = ["scene", "way", "asked", *bands, "clear sky", "s, new tables", "s, kept tables"]
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for scene, result in found.items():
        changes = [f"{_largest(result['reference'], index):.1e}" for index in range(len(bands))]
        lines.append(f"| {scene} | *reference, against the level before* | | {' | '.join(changes)} | | | |")
        for way, runs in result["ways"].items():
            for accuracy, one in runs.items():
                cells = [way, accuracy, *(f"{error:.1e}" for error in one["by_band"].values())]
                cells += [f"{max(one['clear'].values()):.1e}", _short(one["new"]), _short(one["kept"])]
                lines.append(f"| {scene} | {' | '.join(cells)} |")
        for key, (count, _, _) in PEERS.items():
            for each in result.get(key, []):
                errors = " | ".join(f"{error:.1e}" for error in each["by_band"].values())
                lines.append(f"| {scene} | {each[count]} {count} | | {errors} | | {each['seconds']:.2g} | |")
    return "\n".join(lines)


def _short(value: float) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}" if value >= 1 else f"{value:.2g}"
