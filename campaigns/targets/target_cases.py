"""Random scenes with one target a frame: hot and cold bodies, plumes, moving, at cloud edges, by day and by night."""

from __future__ import annotations

import math

import numpy as np

FRAMES, SIDE = 20, 48
EMISSIVITY = True
"""Whether the file has that column; without it (the code before) bodies are black."""
SENSORS = ("gaussian", "airy", "file")
KINDS = ("hot", "cold", "ambient", "plume")
BANDS = [{"name": "mwir", "limits": [3.6, 3.8]}, {"name": "lwir", "limits": [10.5, 11.0]}]
CHEAP = {"radiance.model": "as-printed", "sea.model": "cox-munk", "optics.provider": "mie"}
CLOUDS = {
    "clear": {},
    "thick": {"type": "stratus", "coverage": 0.5, "coverage_mode": "field", "base": 900.0, "top": 1300.0,
              "thickness_min": 60.0},
    "thin": {"type": "stratus", "coverage": 0.5, "coverage_mode": "field", "base": 900.0, "top": 915.0,
             "thickness_min": 2.0},
}  # fmt: skip


def scene(number, seed=40):
    """Return the scenario, without elements, of a scene, and what its targets need to know."""
    random = np.random.default_rng([seed, number])
    sensor, clouds = SENSORS[number % 3], list(CLOUDS)[number // 3 % 3]
    pixel_m, zenith = float(random.choice([10.0, 20.0, 60.0])), float(random.choice([0.0, random.uniform(0.0, 60.0)]))
    integration_s = float(random.choice([0.0, 0.02, 0.05]))
    parameters = {} if integration_s == 0.0 else {"integration_time": integration_s}
    if sensor == "airy":
        cutoff = random.uniform(0.4, 1.6)
        # diameter x angle / wavelength of the longer band; the other band has its own cut-off
        parameters |= {"psf": "airy", "aperture_diameter": 0.5, "pixel_angle": cutoff * 10.74e-6 / 0.5}
    else:
        sigma = float(random.uniform(0.4, 1.5) if sensor == "gaussian" else random.uniform(0.9, 1.5))
        parameters |= (
            {"psf": "gaussian", "psf_sigma": sigma} if sensor == "gaussian" else {"psf": "file", "psf_file": "spot.txt"}
        )
    raw = {
        "time": "2024-04-20T12:30:00+10:00" if random.random() < 0.5 else "2024-04-20T23:30:00+10:00",
        "place": {"latitude": 35.0, "longitude": 150.0},
        "seed": int(random.integers(2**31)),
        "image": {"rows": SIDE, "columns": SIDE, "pixel_size": pixel_m,
                  "samples_per_pixel": int(random.choice([1, 2, 4]))},
        "frames": {"count": FRAMES, "interval": 1.0},
        "bands": BANDS,
        # the column behind a target is then one column of the radiance model
        "sea": {"temperature_texture": 0.0},
        "atmosphere": {"water_vapour_texture": 0.0},
        "view": {"zenith": zenith, "azimuth": float(random.uniform(0.0, 360.0))},
        "slant": {"parallax": "on" if random.random() < 0.5 else "off", "shadows": "off"},
        "motion": {"platform_speed": float(random.choice([0.0, random.uniform(-100.0, 100.0)]))},
        "output": {"variables": ["radiance"], "certificate": 0},
        "sensor": {"parameters": parameters},
    }  # fmt: skip
    if CLOUDS[clouds]:
        raw["clouds"] = CLOUDS[clouds]
    about = {"sensor": sensor, "clouds": clouds, "integration_s": integration_s, "pixel_m": pixel_m, "zenith": zenith}
    return raw, about | ({"sigma": sigma} if sensor != "airy" else {})


def targets(number, plan, about, seed=40):
    """Return the target of each frame: place in the image, velocity on the ground, strength."""
    random, found = np.random.default_rng([seed, number, 1]), []
    pixel_m, speed = about["pixel_m"], plan.assembly.motion.platform_speed_m_s
    for frame in range(FRAMES):
        kind, time_s = KINDS[int(random.integers(4))], float(plan.frame_times_s[frame])
        row, column = _place(random, plan, time_s)
        # up to 6 pixels of motion against the image within the integration time
        shift = random.uniform(0.0, 6.0) * (random.random() < 0.7)
        angle, within = random.uniform(0.0, 2.0 * math.pi), about["integration_s"] or 0.02
        velocity = shift * pixel_m / within * np.array([math.cos(angle), math.sin(angle)]) + (speed, 0.0)
        altitude = float(random.choice([0.0, 300.0, 905.0, 2000.0, 9000.0]))
        target = {"kind": kind, "time": time_s, "row": row, "column": column, "altitude": altitude}
        target |= {"velocity": velocity.tolist()}
        area_m2 = pixel_m**2 * math.cos(math.radians(about["zenith"]))
        if kind == "plume":
            target["intensity"] = float(area_m2 * 10.0 ** random.uniform(-1.0, 2.0))
        else:
            low, high = {"hot": (350.0, 1100.0), "cold": (215.0, 265.0), "ambient": (285.0, 295.0)}[kind]
            target["temperature"] = float(random.uniform(low, high))
            target["area"] = float(area_m2 * random.uniform(0.02, 0.9))
            target["emissivity"] = 1.0 if random.random() < 0.6 else float(random.uniform(0.3, 1.0))
        found.append(target)
    return found


def _place(random, plan, time_s):
    """A subpixel place in the middle of the image; with clouds, half of the time next to the edge of one."""
    samples = plan.samples_per_pixel
    points = slice(0, SIDE * samples)
    clouds = [each.thickness_m(time_s, points, points) for each in plan.assembly.generators]
    for attempt in range(200):
        row, column = random.uniform(16.0, SIDE - 16.0, 2).tolist()
        if not clouds or (attempt == 0 and random.random() < 0.5):
            break
        y, x = int(row * samples), int(column * samples)
        beside = ((0, 0), (samples, 0), (0, samples), (-samples, 0), (0, -samples))
        around = [clouds[0][y + dy, x + dx] for dy, dx in beside]
        if min(around) > 0.0 or max(around) == 0.0:
            continue
        break
    return row, column


def table(plan, about, all_targets, plume):
    """Return the CSV file of the plumes or the bodies: each is there around the time of its frame."""
    pixel_m, speed, lines = about["pixel_m"], plan.assembly.motion.platform_speed_m_s, []
    names = "intensity" if plume else "temperature, area" + ", emissivity" * EMISSIVITY
    for number, target in enumerate(all_targets):
        if (target["kind"] == "plume") != plume:
            continue
        north = east = 0.0
        if plan.assembly.slant.parallax:
            away = target["altitude"] * math.tan(math.radians(about["zenith"]))
            azimuth = math.radians(plan.view.azimuth_deg)
            north, east = away * math.cos(azimuth), away * math.sin(azimuth)
        y = (target["row"] - 0.5 * SIDE) * pixel_m + north
        x = (target["column"] - 0.5 * SIDE) * pixel_m + east + speed * target["time"]
        strength = [target[name] for name in names.split(", ")]
        for later in (-0.25, 0.25):
            place = x + later * target["velocity"][0], y + later * target["velocity"][1], target["altitude"]
            lines.append(", ".join(repr(float(each)) for each in (number, target["time"] + later, *place, *strength)))
    return "\n".join([f"source, time, x, y, altitude, {names}", *lines, ""]) if lines else ""
