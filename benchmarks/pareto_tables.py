"""Tables and picture of what ``pareto.py`` measured."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hcss_twin.reports.benchmark_stages import CERTIFICATE, KEPT_RUN, NEW_RUN, RAW, STAGES
from hcss_twin.reports.benchmark_text import Curve, Reference, fill_axes, power

DRAWN = ("physical", "physical-two-stream", "as-printed")


def tables(found: dict[str, Any]) -> dict[str, str]:
    """Return the tables in Markdown, by name."""
    return {
        "fronts": fronts(found, tuple(found["ways"])),
        "stages": "\n".join(_stages(found)),
        "brute force": "\n".join(_brute_force(found)),
        "peers": "\n".join(_peers(found)),
    }


def draw(found: dict[str, Any], path: Path) -> None:
    """Draw the fronts above, peers of single stages below."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 11.0), layout="constrained")
    top, bottom = figure.subfigures(2, 1, height_ratios=(2.4, 1.0))
    axes = top.add_subplot()
    curves, references = _curves(found)
    fill_axes(axes, curves, references)
    axes.set_title(
        "stratus, 8 frames of 800 x 800 pixels, 3 bands: beside points the accuracy asked for, or how many "
        "wavenumbers or classes",
        fontsize=9,
    )
    top.legend(loc="outside lower center", ncols=2, fontsize=8, frameon=False)
    left, right = bottom.subplots(1, 2)
    rows = found["peers"]["clouds"]
    _bars(left, [row["name"] for row in rows], [row["ns"] for row in rows], "clouds: ns per pixel and frame", "log")
    rows = found["peers"]["writing"]
    _bars(right, [row["name"] for row in rows], [row["ms"] for row in rows], "writing the cube, 67 MB: ms", "linear")
    figure.savefig(path, dpi=130)


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


def _curves(found: dict[str, Any]) -> tuple[list[Curve], list[Reference]]:
    curves, references = [], []
    for family, name in enumerate(way for way in DRAWN if way in found["ways"]):
        results = [each for each in found["ways"][name]["accuracies"] if each["achieved"]]
        error, notes = [each["achieved"] for each in results], [power(each["accuracy"]) for each in results]
        for run, style, words in ((KEPT_RUN, "--", "tables kept"), (NEW_RUN, "-", "new tables")):
            cost = [each["over_raw"][run] for each in results]
            told = notes if style == "-" else ()
            curves.append(Curve(f"{name}, {words}", cost, error, family, style, told, family == 1))
    peers, paper = found["peers"], found["ways"]["as-printed"]
    raw = paper["accuracies"][0]["seconds"][RAW]
    for key, family, where in (("classes", 3, "band model"), ("classes, LOWTRAN7", 4, "LOWTRAN7 called for each")):
        if key in peers:
            # Clouds and writing come on top, as in any other way.
            shared = sum(paper["accuracies"][0]["seconds"][stage] for stage in ("plan", "clouds", "write"))
            cost = [(each["seconds"] + shared) / raw for each in peers[key]]
            counts = [str(each["classes"]) for each in peers[key]]
            errors, left = [each["error"] for each in peers[key]], key == "classes"
            curves.append(Curve(f"classes of pixels, {where}", cost, errors, family, "", counts, left))
    brute = [each for each in paper["brute_force"] if each["error"] > 0]
    fine = peers["1000 wavelengths"]
    cost = [each["over_raw"] for each in brute] + [fine["seconds_per_point"] * paper["points"] / raw]
    errors = [each["error"] for each in brute] + [fine["error"]]
    counts = [str(each["wavenumbers"]) for each in brute] + ["3 x 1000 wavelengths"]
    curves.append(Curve("every pixel integrated, as-printed", cost, errors, 5, "", counts, True))
    for name, style in (("as-printed", ":"), ("physical", "--")):
        if name in found["ways"]:
            once = next(each for each in found["ways"][name]["brute_force"] if each["together"] > 1)
            references.append(
                Reference(f"the same at all {once['wavenumbers']}, {name}: the reference", once["over_raw"], style)
            )
    return curves, references


def fronts(found: dict[str, Any], ways: tuple[str, ...]) -> str:
    """Return error and cost of some of the ways at each accuracy."""
    first = next(iter(found["ways"].values()))
    heads = [power(each["accuracy"]) for each in first["accuracies"]]
    lines = ["| way | " + " | ".join(heads) + " |", "|---|" + "---|" * len(heads)]
    for name in ways:
        cells = [
            f"{each['achieved']:.0e}, {_short(each['over_raw'][NEW_RUN])}, {_short(each['over_raw'][KEPT_RUN])}"
            for each in found["ways"][name]["accuracies"]
        ]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _stages(found: dict[str, Any], accuracy: float = 1e-3) -> list[str]:
    names = [*STAGES, CERTIFICATE, KEPT_RUN]
    lines = ["| way | " + " | ".join(names) + " |", "|---|" + "---|" * len(names)]
    for way, result in found["ways"].items():
        one = next(each for each in result["accuracies"] if each["accuracy"] == accuracy)["seconds"]
        lines.append(f"| {way} | " + " | ".join(_short(one[name] / one[RAW]) for name in names) + " |")
    return lines


def _brute_force(found: dict[str, Any]) -> list[str]:
    lines = ["| way | wavenumbers, pixels at once | ms per point | over raw | error |", "|---|---|---|---|---|"]
    for way in (name for name in DRAWN if name in found["ways"]):
        for each in found["ways"][way]["brute_force"]:
            error = "reference" if each["every"] == 1 else f"{each['error']:.0e}"
            lines.append(
                f"| {way} | {each['wavenumbers']}, {each['together']} | {_short(1e3 * each['seconds_per_point'])} | "
                f"{each['over_raw']:.1e} | {error} |"
            )
    return lines


def _peers(found: dict[str, Any]) -> list[str]:
    peers = found["peers"]
    lines = ["| peer | time | error or ratio |", "|---|---|---|"]
    fine = peers["1000 wavelengths"]
    cells = f"{_short(1e3 * fine['seconds_per_point'])} ms per point | {fine['error']:.0e}"
    lines.append(f"| every pixel at 1000 wavelengths a band, as-printed | {cells} |")
    for key in ("classes", "classes, LOWTRAN7"):
        for each in peers.get(key, []):
            lines.append(f"| {key}: {each['classes']} | {_short(each['seconds'])} s | {each['error']:.0e} |")
    base = peers["clouds"][0]["ns"]
    lines += [
        f"| clouds: {each['name']} | {_short(each['ns'])} ns | {_short(each['ns'] / base)} times ours |"
        for each in peers["clouds"]
    ]
    base = peers["writing"][0]["ms"]
    lines += [
        f"| writing: {each['name']} | {_short(each['ms'])} ms | {_short(each['ms'] / base)} times raw |"
        for each in peers["writing"]
    ]
    return [*lines, *(f"\nmissing: {line}" for line in peers["missing"])]


def _short(value: float) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}" if value >= 1 else f"{value:.2g}"
