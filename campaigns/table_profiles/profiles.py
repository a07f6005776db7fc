"""Profiles beside a table of the 1976 US Standard: 100 of the same air, written in another way, and 100 of other air.

The numbers are those of ``catalogs/atmospheres/us-standard-1976.csv``, read here without the package's reader.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2] / "catalogs" / "atmospheres"
GASES = ("h2o", "co2", "o3", "n2o", "co", "ch4", "o2")
MODELS = ("tropical", "midlatitude-summer", "midlatitude-winter", "subarctic-summer", "subarctic-winter")

Columns = dict[str, np.ndarray]


def model(name: str = "us-standard-1976") -> Columns:
    """Return the columns of a model atmosphere."""
    lines = [line for line in (ROOT / f"{name}.csv").read_text().splitlines() if not line.startswith("#")]
    names = lines[0].split(",")
    values = np.array([[float(each) for each in line.split(",")] for line in lines[1:]])
    columns = dict(zip(names, values.T, strict=True))
    return {each: columns[each] for each in ("altitude_m", "pressure_Pa", "temperature_K", *GASES)}


def text(columns: Columns, digits: int = 7) -> str:
    """Return a profile as CSV."""
    rows = [",".join(columns)]
    rows += [",".join(f"{each:.{digits}g}" for each in row) for row in zip(*columns.values(), strict=True)]
    return "\n".join(rows) + "\n"


def _finer(columns: Columns, levels: int) -> Columns:
    """Return a profile with levels between its own, by the laws of the format's description."""
    z = columns["altitude_m"]
    extra = np.linspace(150.0, 19_850.0, levels)
    new = np.unique(np.concatenate((z, extra)))
    logs = {
        each: np.exp(np.interp(new, z, np.log(columns[each])))
        for each in columns
        if each not in ("altitude_m", "temperature_K")
    }
    return {
        "altitude_m": new,
        "pressure_Pa": logs.pop("pressure_Pa"),
        "temperature_K": np.interp(new, z, columns["temperature_K"]),
        **logs,
    }


def good(number: int) -> str:
    """Return profile ``number`` of the same air."""
    random, columns = np.random.default_rng([1, number]), model()
    kind = number % 10
    if kind == 1:  # other units
        columns = {
            "altitude_km": columns.pop("altitude_m") / 1e3,
            "pressure_hPa": columns.pop("pressure_Pa") / 1e2,
            **columns,
        }
    elif kind == 2:
        columns["temperature_C"] = columns.pop("temperature_K") - 273.15
    elif kind == 3:  # other order of columns
        columns = {each: columns[each] for each in random.permutation(list(columns))}
    elif kind == 4:  # more levels
        columns = _finer(columns, int(random.integers(5, 40)))
    elif kind == 5:  # all gases but water vapour left to the model
        columns = {each: columns[each] for each in ("altitude_m", "pressure_Pa", "temperature_K", "h2o")}
    elif kind == 6:  # some gases left to the model
        columns = {each: columns[each] for each in columns if each not in random.choice(GASES[1:], 3, replace=False)}
    elif kind == 7:  # ends below the top
        last = int(random.integers(28, 45))
        columns = {each: values[:last] for each, values in columns.items()}
    elif kind == 8:  # temperatures as printed, to .1 K
        columns["temperature_K"] = np.round(columns["temperature_K"], 1)
    elif kind == 9:  # pressure and water vapour to three digits
        for each in ("pressure_Pa", "h2o"):
            columns[each] = np.array([float(f"{value:.3g}") for value in columns[each]])
    return text(columns, int(random.integers(5, 9)) if kind != 4 else 8)


def bad(number: int) -> str:
    """Return profile ``number`` of other air."""
    random, columns = np.random.default_rng([2, number]), model()
    z, kind = columns["altitude_m"], number % 10
    if kind == 0:  # the surface's water vapour alone
        columns["h2o"][0] *= random.choice([0.25, 0.5, 1.2, 1.3])
    elif kind == 1:  # all water vapour
        columns["h2o"] *= random.choice([0.2, 0.5, 0.9, 1.1, 1.5])
    elif kind == 2:  # another gas
        columns[GASES[1 + number // 10 % 6]] *= random.choice([0.9, 1.06, 1.3])
    elif kind == 3:  # temperature of a layer
        middle, width = random.uniform(0.0, 18e3), random.uniform(2e3, 6e3)
        columns["temperature_K"] += random.choice([-1.5, 1.5, 3.0]) * np.exp(-(((z - middle) / width) ** 2))
    elif kind == 4:  # all temperatures
        columns["temperature_K"] += random.choice([-5.0, -1.0, 1.0, 1.9])
    elif kind == 5:  # surface pressure
        columns["pressure_Pa"] *= random.choice([0.97, 0.985, 1.015, 1.025])
    elif kind == 6:  # another model atmosphere
        columns = model(MODELS[number // 10 % 5])
    elif kind == 7:  # an inversion between the levels
        columns = _finer(columns, 60)
        base = random.uniform(600.0, 2500.0)
        inside = (columns["altitude_m"] > base) & (columns["altitude_m"] < base + 900.0)
        columns["temperature_K"] = columns["temperature_K"] + random.uniform(2.0, 6.0) * inside
    elif kind == 8:  # a dry or moist layer
        inside = (z >= 2000.0 * (number // 10 % 4)) & (z <= 2000.0 * (number // 10 % 4) + 3000.0)
        columns["h2o"] = columns["h2o"] * np.where(inside, random.choice([0.4, 0.8, 1.15]), 1.0)
    else:  # humidity of the upper troposphere
        columns["h2o"] = columns["h2o"] * np.where((z >= 6e3) & (z <= 12e3), random.choice([0.3, 0.5, 1.5]), 1.0)
    return text(columns)


def cases() -> Iterator[tuple[str, int, str]]:
    """Yield kind (``good``, ``bad``), number and file content of all 200."""
    for number in range(100):
        yield "good", number, good(number)
    for number in range(100):
        yield "bad", number, bad(number)
