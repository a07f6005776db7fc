"""A hundred good and a hundred bad atmospheres: trade inversions, and soundings with coarse, close or steep levels.

Good air must give absorber amounts like those of an independent integration along each ray; bad air must be refused
with the name of its key, or of its file and line.
"""

import math
from dataclasses import dataclass, field

import numpy as np

COUNT = 100
PROFILES = {
    "tropical": 299.7,
    "midlatitude-summer": 294.2,
    "midlatitude-winter": 272.2,
    "subarctic-summer": 287.2,
    "us-standard-1976": 288.2,
}
"""Model atmospheres and their temperature at the sea."""

SURFACE_PA, GAS_J_KG_K, GRAVITY_M_S2 = 101_325.0, 287.05, 9.80665


@dataclass(frozen=True)
class Air:
    """Keys of ``[atmosphere]``, the text of ``air.csv`` if it names that, and what a refusal must contain."""

    kind: str
    keys: dict = field(default_factory=dict)
    file: str | None = None
    names: tuple[str, ...] = ()


def good_air(number):
    """Return one of a hundred atmospheres that can exist."""
    draw = np.random.default_rng([40, number])
    if number % 2 == 0:
        return Air("inversion", inversion_keys(draw))
    kinds = list(_SOUNDINGS)
    kind = kinds[number // 2 % len(kinds)]
    altitude, kelvin, percent = _SOUNDINGS[kind](draw)
    return Air(kind, {"profile": "air.csv"}, sounding_text(altitude, kelvin, percent))


def inversion_keys(draw):
    """Return an inversion over air that is cold enough for it: its excess stays below 13 K, which lapses allow."""
    name = str(draw.choice([*PROFILES]))
    strength, height = float(draw.uniform(0.0, 25.0)), float(draw.uniform(200.0, 3000.0))
    warm = PROFILES[name] - strength * float(draw.uniform(0.5, 1.0))
    shares = (0.0, 1.0, float(draw.uniform(0.0, 1.0)), 1.0 - 1e-6)
    return {
        "profile": name,
        "inversion": {
            "height": height,
            "strength": strength,
            "cloud_base": height * shares[int(draw.integers(4))],
            "humidity_above": float(draw.uniform(0.01, 1.0)),
            "surface_temperature": max(warm, 250.0),
        },
    }


def sounding_text(altitude, kelvin, percent):
    """Return the lines of a file in hydrostatic balance of dry air, with exact numbers."""
    mean = 0.5 * (kelvin[1:] + kelvin[:-1])
    fall = np.concatenate(([0.0], np.cumsum(GRAVITY_M_S2 * np.diff(altitude) / (GAS_J_KG_K * mean))))
    pressure = SURFACE_PA * np.exp(-fall - altitude[0] / 8400.0) / 100.0
    rows = zip(altitude, pressure, kelvin, np.broadcast_to(percent, altitude.shape), strict=True)
    head = "altitude_m,pressure_hPa,temperature_K,relative_humidity_percent"
    return "\n".join([head, *(",".join(repr(float(each)) for each in row) for row in rows)]) + "\n"


def _usual(altitude, surface=288.0):
    return np.maximum(surface - 0.0065 * altitude, 216.7)


def _coarse(draw):
    altitude = np.arange(5) * float(draw.uniform(3000.0, 4990.0))
    return altitude, _usual(altitude), float(draw.uniform(5.0, 60.0))


def _uneven(draw):
    altitude = np.concatenate(([0.0], np.cumsum(10.0 ** draw.uniform(-1.0, 3.3, 25))))
    return altitude, _usual(altitude) + draw.uniform(-0.5, 0.5), draw.uniform(1.0, 70.0, altitude.size)


def _isothermal(draw):
    altitude = np.linspace(0.0, 12_000.0, int(draw.integers(4, 40)))
    return altitude, np.full(altitude.size, float(draw.uniform(230.0, 290.0))), float(draw.uniform(0.0, 60.0))


def _surface_inversion(draw):
    depth, jump = float(draw.uniform(20.0, 400.0)), float(draw.uniform(3.0, 25.0))
    altitude = np.concatenate((np.linspace(0.0, depth, int(draw.integers(2, 8))), [1500.0, 4000.0, 8000.0, 12_000.0]))
    kelvin = 262.0 + jump * np.minimum(altitude / depth, 1.0) - 0.006 * np.maximum(altitude - depth, 0.0)
    return altitude, kelvin, float(draw.uniform(10.0, 60.0))


def _step(draw):
    """A jump of temperature within less than a metre."""
    height, gap = float(draw.uniform(50.0, 2500.0)), float(10.0 ** draw.uniform(-1.5, 0.0))
    altitude = np.array([0.0, 0.5 * height, height, height + gap, 4500.0, 9000.0, 12_000.0])
    return altitude, _usual(altitude) + float(draw.uniform(0.5, 8.0)) * (altitude > height), 30.0


def _fine(draw):
    altitude = np.arange(140) * float(draw.uniform(0.3, 1.0))
    return np.append(altitude, [3000.0, 7000.0, 11_000.0]), _usual(np.append(altitude, [3e3, 7e3, 11e3])), 50.0


def _low_top(draw):
    altitude = np.linspace(0.0, float(draw.uniform(5.0, 500.0)), int(draw.integers(2, 6)))
    return altitude, _usual(altitude), float(draw.uniform(10.0, 90.0))


def _saturated(draw):
    altitude = np.linspace(0.0, 8000.0, int(draw.integers(5, 30)))
    return altitude, _usual(altitude, float(draw.uniform(270.0, 300.0))), 100.0


def _dry(draw):
    altitude = np.linspace(0.0, 9000.0, int(draw.integers(4, 30)))
    return altitude, _usual(altitude), np.where(draw.random(altitude.size) < 0.5, 0.0, 20.0)


def _begins_above(draw):
    altitude = float(draw.uniform(0.01, 199.0)) + np.linspace(0.0, 9000.0, 12)
    return altitude, _usual(altitude), 40.0


_SOUNDINGS = {
    "coarse": _coarse,
    "uneven": _uneven,
    "isothermal": _isothermal,
    "surface inversion": _surface_inversion,
    "step within a metre": _step,
    "levels under a metre apart": _fine,
    "top near the ground": _low_top,
    "saturated": _saturated,
    "partly dry": _dry,
    "begins above the sea": _begins_above,
}


def bad_air(number):
    """Return one of a hundred atmospheres that cannot exist, or that no key may say."""
    draw = np.random.default_rng([41, number])
    if number % 5 < 2:
        return _bad_inversion(number // 5 * 2 + number % 5, draw)
    changes = list(_CHANGES)
    kind = changes[(number // 5 * 3 + number % 5 - 2) % len(changes)]
    return _bad_sounding(kind, draw)


_BEYOND = (
    ("height", 199.99), ("height", 3000.01), ("height", math.nan), ("height", "-5 m"), ("strength", -1e-9),
    ("strength", 25.001), ("strength", math.inf), ("cloud_base", -0.1), ("cloud_base", 3000.5), ("humidity_above", 0.0),
    ("humidity_above", 1.0001), ("humidity_above", "120%"), ("surface_temperature", 249.9),
    ("surface_temperature", 310.5), ("surface_temperature", 15.0), ("strength", "ten"),
)  # fmt: skip


def _bad_inversion(number, draw):
    keys = inversion_keys(draw)
    own = keys["inversion"]
    if number < len(_BEYOND):
        name, own[name] = _BEYOND[number]
        return Air("beyond a limit", keys, None, (f"atmosphere.inversion.{name}",))
    if number % 3 == 0:
        own |= {"height": float(draw.uniform(200.0, 2900.0))}
        own["cloud_base"] = own["height"] + float(draw.uniform(0.001, 90.0))
        return Air("cloud base above", keys, None, ("atmosphere.inversion", "cloud_base"))
    if number % 3 == 1:
        own |= {"strength": 25.0, "surface_temperature": float(draw.uniform(307.0, 310.0)), "height": 300.0}
        own["cloud_base"] = 0.0
        return Air("too warm", keys | {"profile": "midlatitude-winter"}, None, ("atmosphere.inversion.strength",))
    return Air("column given", keys | {"water_vapour_column": 20.0}, None, ("water_vapour_column",))


def _bad_sounding(kind, draw):
    altitude = np.linspace(0.0, 9000.0, 13)
    text = sounding_text(altitude, _usual(altitude), 40.0)
    rows = [line.split(",") for line in text.splitlines()]
    line = int(draw.integers(2, 12))
    _CHANGES[kind](rows, line, draw)
    changed = "\n".join(",".join(row) for row in rows) + "\n"
    where = () if kind in ("unit missing", "unknown column") else (f"line {line + 1}",)
    return Air(kind, {"profile": "air.csv"}, changed, ("atmosphere.profile", "air.csv", *where))


def _set(column, value):
    def change(rows, line, draw):
        rows[line][column] = value(draw) if callable(value) else value

    return change


def _as(column, other, factor=1.0):
    """Give a cell the value of another line, times a factor."""

    def change(rows, line, draw):
        rows[line][column] = repr(float(rows[line + other][column]) * factor)

    return change


def _headed(column, name):
    def change(rows, line, draw):
        rows[0][column] = name

    return change


_CHANGES = {
    "supersaturated": _set(3, lambda draw: repr(float(draw.uniform(106.0, 190.0)))),
    "humidity below 0": _set(3, lambda draw: repr(-float(draw.uniform(0.1, 90.0)))),
    "humidity over 200": _set(3, "250"),
    "celsius as kelvin": _set(2, lambda draw: repr(float(draw.uniform(-40.0, 30.0)))),
    "too hot": _set(2, "1600"),
    "pressure rises": _as(1, -1, 1.001),
    "pressure twice": _as(1, -1),
    "altitude twice": _as(0, -1),
    "altitude falls": _as(0, -1, 0.9),
    "altitude in km": _as(0, 0, 1e-3),
    "not a number": _set(0, "nan"),
    "no pressure": _set(1, "nan"),
    "text": _set(2, "cold"),
    "infinite": _set(1, "inf"),
    "pressure below 0": _set(1, "-5"),
    "empty cell": _set(2, ""),
    "unit missing": _headed(2, "temperature"),
    "unknown column": _headed(3, "humitidy_percent"),
}
