"""Forty scenes with each omission switched on and off: does any pixel change by more than the plan promises?"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from hcss_twin import Scenario, make_plan
from hcss_twin.core.errors import ProviderError, ScenarioError
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.stream import stream

SCENES = 40
PIXELS = 72
"""Rows and columns: 5184 pixels a scene, 207 360 in all."""

BANDS = ([2.75, 2.8], [3.7, 3.8], [10.5, 11.0])
CLOUDS = ("stratus", "cumulus", "cirrus")
CHEAP = {"radiance.model": "as-printed", "optics.provider": "mie"}
OFF = {
    "slant.shadows": "off",
    "slant.parallax": "off",
    "sea.waves": "off",
    "sea.temperature_texture": 0.0,
    "atmosphere.water_vapour_texture": 0.0,
}
"""What each scene is computed without."""
ACCURACY = 1e-4
ROUNDING = 2.5e-7
"""Of two radiances in single precision."""

SWITCHES: dict[str, dict[str, Any]] = {
    "view angles of single pixels": {"platform.altitude": 800e3},
    "clouds within the footprint of a pixel": {"image.samples_per_pixel": 3},
    "parallax of clouds": {"slant.parallax": "on"},
    "shadows of clouds on the sea": {"slant.shadows": "on"},
    "waves as shapes": {"sea.waves": "on"},
    "texture of the sea's temperature": {"sea.temperature_texture": 0.3},
    "texture of water vapour": {"atmosphere.water_vapour_texture": 0.05},
}
"""Keys that compute what is omitted."""


@dataclass(frozen=True)
class Row:
    """One omission of one scene.

    Attributes
    ----------
    pixels : int
        Pixels compared.
    bound, estimate : float or None
        As the plan says.
    change : float
        Largest change of a pixel in any band.
    error : float
        Sum of the errors that both runs estimate of their tables.
    beyond : int
        Pixels whose change exceeds the bound and that error.
    within_estimate : float
        Share of the pixels within the estimate.
    rms : float or None
        Of the change over the image, relative to the middle of its radiances, in the band in which it is largest; None
        where the estimate is no rms.
    """

    scene: int
    what: str
    pixels: int
    bound: float | None
    estimate: float | None
    sense: str
    change: float
    error: float
    beyond: int
    within_estimate: float
    rms: float | None


def scene(number: int) -> tuple[str, dict[str, Any]]:
    """Return the shipped scenario and the overrides of a scene, the same each time."""
    random = np.random.default_rng([18, number])
    hour = ("06:30", "09:00", "12:30", "15:00", "00:30")[int(random.integers(5))]
    overrides: dict[str, Any] = {
        **CHEAP,
        **OFF,
        "accuracy": ACCURACY,
        "bands": [list(each) for each in BANDS],
        "clouds.coverage_mode": "field",
        "clouds.coverage": round(float(random.uniform(0.1, 0.9)), 2),
        "frames.count": 1,
        "image.columns": PIXELS,
        "image.rows": PIXELS,
        "image.pixel_size": float(random.choice([2.0, 5.0, 20.0, 100.0, 500.0])),
        "output.certificate": 0,
        "output.variables": ["radiance"],
        "sea.model": "rough-sea",
        "sea.wind_speed": round(float(random.uniform(2.0, 15.0)), 1),
        "seed": number,
        "time": f"2024-04-20T{hour}:00+10:00",
        "view.azimuth": round(float(random.uniform(0.0, 359.0)), 0),
        "view.zenith": float(random.choice([0.0, 20.0, 40.0, 60.0])),
    }
    return CLOUDS[int(random.integers(len(CLOUDS)))], overrides


def radiance_of(plan: Any) -> tuple[np.ndarray, float]:
    """Return the radiance (F, B, y, x) of a plan, and the error that its tables estimate."""
    tables = compile_tables(plan)
    frames = stream(plan, tables)
    return np.stack([frame["radiance"] for frame in frames]).astype(np.float64), tables.estimated_error


def check(number: int, only: tuple[str, ...] = tuple(SWITCHES), **changes: Any) -> list[Row]:
    """Compare runs of a scene with each omission switched on with the run without; ``changes`` are more overrides.

    An omission that the plan bounds by 0, or that the scene cannot have, is left out.
    """
    name, overrides = scene(number)
    overrides |= changes
    plan = make_plan(Scenario.load(name, overrides))
    omissions = {each.what: each for each in plan.omissions}
    off, off_error = radiance_of(plan)
    rows = []
    for what in only:
        omission = omissions.get(what)
        if omission is None or not omission.bound:
            continue
        try:
            on, on_error = radiance_of(make_plan(Scenario.load(name, {**overrides, **SWITCHES[what]})))
        except (ScenarioError, ProviderError) as error:  # waves so steep that tables over slopes do not converge
            print(f"  scene {number}: {what} refused: {str(error)[:100]}")
            continue
        change = np.abs(on / off - 1.0)
        worst = np.max(change, axis=1)
        error = on_error + off_error + ROUNDING
        allowed = omission.bound + error * (1.0 + omission.bound)
        limit = np.inf if omission.estimate is None else omission.estimate + error
        rows.append(
            Row(
                number,
                what,
                int(worst.size),
                omission.bound,
                omission.estimate,
                omission.sense,
                float(worst.max()),
                error,
                int(np.count_nonzero(~(worst <= allowed))),
                float(np.mean(worst <= limit)),
                _rms(on, off) if omission.sense.startswith("rms") else None,
            )
        )
    return rows


def _rms(on: np.ndarray, off: np.ndarray) -> float:
    middle = 0.5 * (np.max(off, axis=(0, 2, 3)) + np.min(off, axis=(0, 2, 3)))
    return float(np.max(np.sqrt(np.mean((on - off) ** 2, axis=(0, 2, 3))) / middle))


def as_json(row: Row) -> dict[str, Any]:
    """Return a row with numbers of four digits."""
    return {key: float(f"{each:.4g}") if isinstance(each, float) else each for key, each in asdict(row).items()}
