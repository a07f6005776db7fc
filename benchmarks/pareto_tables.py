"""Tables and picture of what ``pareto.py`` measured."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hcss_twin.reports.benchmark_stages import KEPT_RUN, NEW_RUN, RAW, STAGES

MARKERS = {"stratus": "o", "cumulus": "s", "cirrus": "^"}
COLOURS = {
    "as-printed": "#8a5fb5",
    "as-printed, LOWTRAN7 itself": "#c77d0a",
    "physical-two-stream": "#d1495b",
    "physical, 8 streams": "#1b6ca8",
    "physical, 16 streams": "#2e8b57",
    "physical, 32 streams": "#111111",
}
COARSE, CLASSES = "physical, 8 streams, every pixel at few wavenumbers", "as-printed, classes of pixels"


def tables(found: dict[str, Any]) -> dict[str, str]:
    """Return the tables in Markdown, by name."""
    return {"fronts": fronts(found), "stages": "\n".join(_stages(found)), "peers": "\n".join(_peers(found))}


def draw(found: dict[str, Any], path: Path) -> None:
    """Draw all scenes and models above, peers of single stages below."""
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    figure = Figure(figsize=(10.0, 11.0), layout="constrained")
    top, bottom = figure.subfigures(2, 1, height_ratios=(2.4, 1.0))
    axes = top.add_subplot()
    for scene, result in found["scenes"].items():
        marker = MARKERS[scene]
        for way, runs in result["ways"].items():
            error = [max(each["by_band"].values()) for each in runs]
            for run, face, line in ((KEPT_RUN, "none", ":"), (NEW_RUN, COLOURS[way], "-")):
                cost = [each["over_raw"][run] for each in runs]
                axes.plot(cost, error, line, marker=marker, color=COLOURS[way], mfc=face, ms=6, lw=0.8)
        for points, colour in ((result["fewer wavenumbers"], "#7f7f7f"), (result["classes"], "#bcbd22")):
            cost = [each["seconds"] / _raw(result) for each in points]
            axes.plot(cost, [each["error"] for each in points], marker=marker, color=colour, ls="", ms=6)
    axes.set(xscale="log", yscale="log")
    axes.set_xlabel("time of the whole run over the time of writing the same bytes raw")
    axes.set_ylabel("largest error of any band and pixel, relative to the one reference of the scene")
    axes.grid(True, which="major", alpha=0.3)
    axes.set_title(
        "8 frames of 800 x 800 pixels, 3 bands, asked for 1e-2, 1e-3 and 1e-4 (16 and 32 streams: 1e-3). "
        "Filled: new tables; open: kept tables",
        fontsize=9,
    )
    used = {way for result in found["scenes"].values() for way in result["ways"]}
    colours = {way: colour for way, colour in COLOURS.items() if way in used} | {COARSE: "#7f7f7f", CLASSES: "#bcbd22"}
    handles = [Line2D([], [], color=colour, lw=4, label=way) for way, colour in colours.items()]
    handles += [Line2D([], [], color="k", marker=MARKERS[scene], ls="", label=scene) for scene in found["scenes"]]
    top.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8, frameon=False)
    left, right = bottom.subplots(1, 2)
    rows = found["peers"]["clouds"]
    _bars(left, [row["name"] for row in rows], [row["ns"] for row in rows], "clouds: ns per pixel and frame", "log")
    rows = found["peers"]["writing"]
    _bars(right, [row["name"] for row in rows], [row["ms"] for row in rows], "writing the cube, 67 MB: ms", "linear")
    figure.savefig(path, dpi=130)


def _raw(result: dict[str, Any]) -> float:
    """Seconds of a raw write of the scene's bytes."""
    return float(next(iter(result["ways"].values()))[0]["seconds"][RAW])


def _bars(axes: Any, names: list[str], values: list[float], title: str, scale: str) -> None:
    places = range(len(names))
    colours = ["#1b6ca8" if name.startswith(("our", "fractal")) else "#999999" for name in names]
    axes.barh(places, values, color=colours)
    axes.set_xscale(scale)
    if scale == "log":
        axes.set_xlim(min(values) / 3, max(values) * 8)
    else:
        axes.set_xlim(0, max(values) * 1.2)
    axes.set_yticks(places, names, fontsize=8)
    axes.invert_yaxis()
    axes.set_title(title, fontsize=9)
    for place, value in zip(places, values, strict=True):
        axes.annotate(_short(value), (value, place), (4, 0), textcoords="offset points", va="center", fontsize=8)


def fronts(found: dict[str, Any], accuracy: float = 1e-3) -> str:
    """Return the error in each band, and the cost, of all scenes and ways at an accuracy."""
    bands = next(iter(found["scenes"].values()))["reference"]["bands"]
    lines = [f"| scene | model | {' | '.join(bands)} | new tables | kept tables |", "|---" * (len(bands) + 4) + "|"]
    for scene, result in found["scenes"].items():
        for way, runs in result["ways"].items():
            one = next(each for each in runs if each["accuracy"] == accuracy)
            cells = [f"{error:.1e}" for error in one["by_band"].values()]
            cells += [_short(one["over_raw"][run]) for run in (NEW_RUN, KEPT_RUN)]
            lines.append(f"| {scene} | {way} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _stages(found: dict[str, Any], accuracy: float = 1e-3) -> list[str]:
    names = [*STAGES, KEPT_RUN]
    lines = ["| scene, model | " + " | ".join(names) + " |", "|---|" + "---|" * len(names)]
    for scene, result in found["scenes"].items():
        for way, runs in result["ways"].items():
            one = next(each for each in runs if each["accuracy"] == accuracy)["seconds"]
            lines.append(f"| {scene}, {way} | " + " | ".join(_short(one[name] / one[RAW]) for name in names) + " |")
    return lines


def _peers(found: dict[str, Any]) -> list[str]:
    lines = ["| peer | time | error or ratio |", "|---|---|---|"]
    for scene, result in found["scenes"].items():
        for title, key, count in ((COARSE, "fewer wavenumbers", "wavenumbers"), (CLASSES, "classes", "classes")):
            for each in result[key]:
                lines.append(f"| {scene}: {title}: {each[count]} | {_short(each['seconds'])} s | {each['error']:.0e} |")
    for title, unit, words in (("clouds", "ns", "ours"), ("writing", "ms", "raw")):
        rows = found["peers"][title]
        lines += [
            f"| {title}: {each['name']} | {_short(each[unit])} {unit} | {_short(each[unit] / rows[0][unit])} "
            f"times {words} |"
            for each in rows
        ]
    return [*lines, *(f"\nmissing: {line}" for line in found["peers"]["missing"])]


def _short(value: float) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}" if value >= 1 else f"{value:.2g}"
