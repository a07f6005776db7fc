"""Targets against closed forms: 1000 random cases, 50 scenes of 20 frames with one target each.

    python campaigns/targets/run.py            scenes that rows.csv lacks; writes table.csv
    python campaigns/targets/run.py 0 7 12     some scenes, shown only

Each row of rows.csv is one band of one case, with the errors of the clean cube against the closed form and of the
measured cube against the image of a point through the sensor: see LIMITS.
"""

from __future__ import annotations

import csv
import sys
import tempfile
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import closed_forms  # noqa: E402
import target_cases as cases  # noqa: E402
from campaign_table import line, write_table  # noqa: E402

ROWS, SCENES = HERE / "rows.csv", 50

LIMITS = {"radiometry": 2e-3, "flux": 1e-3, "centroid": 0.01, "peak": 0.01}
"""Of the clean cube: difference from the closed form, relative to what is added and replaced (tables of the background
are within 1e-3), with 1e-4 of the background for rounding. Of the measured cube, within 9 pixels: total relative to the
clean one, centroid in pixels; and the highest pixel, relative."""

DRAWN = 5e-3
"""Least contrast, relative to the background, at which single precision shows the image of a target."""


def rows_of(number, folder):
    """Return the rows of a scene."""
    from hcss_twin import Scenario, make_plan, open_cube
    from hcss_twin.engine.simulate import run

    raw, about = cases.scene(number)
    sigma = about.get("sigma")
    if about["sensor"] == "file":
        kernel = closed_forms.image(("gaussian", sigma), (25, 25), 12.5, 12.5, (0.0, 0.0))
        np.savetxt(folder / "spot.txt", kernel, fmt="%.17g")
    plan = make_plan(Scenario.from_dict(raw, cases.CHEAP, base=folder))
    targets = cases.targets(number, plan, about)
    elements = []
    for name, plume in (("plumes", True), ("bodies", False)):
        text = cases.table(plan, about, targets, plume)
        if text:
            (folder / f"{name}.csv").write_text(text)
            elements.append({"parameters": {"file": f"{name}.csv"}})
    seen = {}
    for name, own in (("without", []), ("with", elements)):
        run(make_plan(Scenario.from_dict({**raw, "elements": own}, cases.CHEAP, base=folder)), folder / f"{name}.nc")
        for what, path in (("clean", f"{name}.nc"), ("measured", f"{name}.sensor.nc")):
            with open_cube(folder / path) as cube:
                seen[name, what] = cube["radiance"].to_numpy().astype(float)
    gain = {what: seen["with", what] - seen["without", what] for what in ("clean", "measured")}
    rows = []
    for frame, target in enumerate(targets):
        expected, replaced = closed_forms.added(plan, target, target["time"], about["zenith"])
        speed = plan.assembly.motion.platform_speed_m_s
        east, north = target["velocity"]
        motion = np.array([north, east - speed]) / about["pixel_m"] * about["integration_s"]
        for band, name in enumerate(("mwir", "lwir")):
            spread = ("gaussian", sigma) if sigma else ("airy", _cutoff(plan, raw, band))
            unit = closed_forms.image(spread, (cases.SIDE, cases.SIDE), target["row"], target["column"], motion)
            errors = compared(
                gain["clean"][frame, band],
                gain["measured"][frame, band],
                unit,
                expected[band],
                replaced[band],
                seen["without", "clean"][frame, band].mean(),
            )
            about_case = {key: about[key] for key in ("sensor", "clouds")}
            rows.append({"scene": number, "frame": frame, "band": name, "kind": target["kind"], **about_case, **errors})
    return rows


def _cutoff(plan, raw, band):
    """Cut-off frequency in cycles per pixel at the mean wavelength of a band."""
    response = plan.bands[band]
    low, high = cases.BANDS[band]["limits"]
    assert low < response.central_um < high
    given = raw["sensor"]["parameters"]
    return given["aperture_diameter"] * given["pixel_angle"] / (0.5 * (low + high) * 1e-6)


def compared(clean, measured, unit, expected, replaced, background):
    """Return the errors of one band of a case."""
    total = float(clean.sum())
    found = {
        "added": f"{expected:.6g}",
        "radiometry": abs(total - expected) / (abs(expected) + abs(replaced) + 1e-4 * background),
    }
    if abs(total) > DRAWN * background:
        peak = np.unravel_index(np.argmax(unit), unit.shape)
        # Beyond, the rings of a faint target are lost in the rounding of single precision.
        near = tuple(slice(max(at - 9, 0), at + 10) for at in peak)
        found["flux"] = abs(measured[near].sum() / (total * unit[near].sum()) - 1.0)
        found["centroid"] = float(
            np.hypot(*(a - b for a, b in zip(_centre(measured[near]), _centre(unit[near]), strict=True)))
        )
        highest = measured.flat[np.argmax(np.abs(measured))]
        found["peak"] = abs(highest / (total * unit.max()) - 1.0)
    return {name: value if isinstance(value, str) else f"{value:.3g}" for name, value in found.items()}


def _centre(image):
    y, x = np.indices(image.shape)
    return np.sum(image * y) / image.sum(), np.sum(image * x) / image.sum()


def failures(rows):
    """Return the rows beyond a limit, with the names of the limits."""
    each = (
        (row, [name for name, most in LIMITS.items() if row.get(name) and not float(row[name]) <= most]) for row in rows
    )
    return [(row, names) for row, names in each if names]


def table(rows):
    """Yield the lines of the table: all cases, and the bands of cases by limit."""
    tried = {(row["scene"], row["frame"]) for row in rows}
    yield line("targets", len(tried), len({(row["scene"], row["frame"]) for row, _ in failures(rows)}))
    for name, most in LIMITS.items():
        errors = [float(row[name]) for row in rows if row.get(name)]
        yield line(f"{name} (bands of targets)", len(errors), sum(each > most for each in errors), "error", errors)


def main():
    asked = [int(each) for each in sys.argv[1:]]
    names = ["scene", "frame", "band", "kind", "sensor", "clouds", "added", *LIMITS]
    known = list(csv.DictReader(ROWS.open())) if ROWS.exists() and not asked else []
    done = {int(row["scene"]) for row in known}
    for number in asked or [each for each in range(SCENES) if each not in done]:
        with tempfile.TemporaryDirectory() as folder:
            rows = rows_of(number, Path(folder))
        bad = failures(rows)
        print(f"scene {number}: {len(bad)} of {len(rows)} rows beyond a limit", flush=True)
        if asked:
            for row, over in bad:
                print("  ", row, over)
            continue
        known += rows
        with ROWS.open("w", newline="") as file:
            writer = csv.DictWriter(file, names)
            writer.writeheader()
            writer.writerows(known)
    if not asked:
        write_table(HERE / "table.csv", table(known))


if __name__ == "__main__":
    main()
