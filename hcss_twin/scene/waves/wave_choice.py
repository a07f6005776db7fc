"""Whether a scene draws the waves that its pixels resolve, or averages over them; the bound of what that costs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcss_twin.errors import Problem, ScenarioError
from hcss_twin.providers import Grid, Sun, WaveShapes
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scene.building.assembly import Assembly
from hcss_twin.scene.building.blame import blamed_on
from hcss_twin.scene.ledger.entry import Skipped
from hcss_twin.scene.ledger.wave_bound import wave_bound

WAVES = "waves as shapes"
DRAWN_NOTE = "sea: waves are drawn in clear sky only; under clouds the sea is the mean one"

_SEED_KEY = 2**16
"""Keeps the seed of the waves apart from those of the cloud layers, which are counted from 0."""


@dataclass(frozen=True)
class DrawnWaves:
    """Waves that a scene draws.

    Attributes
    ----------
    shapes : WaveShapes
        Slopes at the points of the image.
    rms : (float, float)
        Deviations of slope, upwind and crosswind.
    point_size_m : float
        Distance between points.
    """

    shapes: WaveShapes
    rms: tuple[float, float]
    point_size_m: float


def choose_waves(
    scenario: Scenario, assembly: Assembly, suns: Sequence[Sun | None], accuracy: float
) -> tuple[DrawnWaves | None, Skipped | None]:
    """Return the waves to draw, or what is to be said about leaving them out.

    Parameters
    ----------
    suns : sequence of Sun or None
        Positions for which the bound is made; none where no radiance is needed.
    accuracy : float
        Share of the radiance below which waves do not matter.

    Raises
    ------
    ScenarioError
        If waves are asked for that the sea model does not have.
    """
    sea, mode, samples = assembly.sea, scenario.sea.waves, scenario.image.samples_per_pixel
    able = hasattr(sea, "wave_slope_rms") and hasattr(sea, "wave_field") and hasattr(sea, "tilted")
    if mode == "resolved" and not able:
        message = (
            f"'resolved' with the sea model '{scenario.sea.model}', which has no waves as shapes; allowed: 'averaged', "
            "or sea.model = 'rough-sea'"
        )
        raise ScenarioError([Problem("sea.waves", message)])
    if mode != "averaged" and scenario.slant.shadows:
        if mode == "resolved":
            message = (
                "'resolved' with slant.shadows = true: the glint of tilted parts in shadow is not known; allowed: "
                "'averaged', or slant.shadows = false"
            )
            raise ScenarioError([Problem("sea.waves", message)])
        able = False
    if not hasattr(sea, "wave_slope_rms"):
        return None, Skipped(WAVES, "the sea model does not know how long its waves are", None)
    pixel_m = assembly.grid.pixel_size_m
    points = Grid(assembly.grid.rows * samples, assembly.grid.columns * samples, pixel_m / samples)
    rms = sea.wave_slope_rms(points.pixel_size_m)
    if max(rms) == 0.0:
        return None, Skipped(WAVES, "no wind raises waves", 0.0)
    if mode != "resolved" and not assembly.has_clear_sky:
        return None, Skipped(WAVES, "cloud covers every pixel, and waves are drawn in clear sky only", 0.0)
    if mode != "resolved":
        left_out = _left_out(scenario, able, assembly, suns, accuracy)
        if left_out is not None:
            return None, left_out
    with blamed_on("sea.waves", scenario.sea.parameters):
        # Whether the facets can be divided at all is known only by trying.
        sea.tilted(0.0, 0.0, points.pixel_size_m)  # type: ignore[attr-defined]
        shapes = sea.wave_field(points, assembly.motion, wave_seed(scenario.seed))  # type: ignore[attr-defined]
    return DrawnWaves(shapes, rms, points.pixel_size_m), None


def _left_out(
    scenario: Scenario, able: bool, assembly: Assembly, suns: Sequence[Sun | None], accuracy: float
) -> Skipped | None:
    """Say why waves are left out, with the bound; None if they are to be drawn."""
    sea, bound = assembly.sea, None
    if not suns:
        bound = 0.0
    elif hasattr(sea, "mean_square_slope"):
        rms = sea.wave_slope_rms(assembly.grid.pixel_size_m)  # type: ignore[attr-defined]
        bound = wave_bound(assembly, rms, scenario.sea.wind_from, suns)
    if scenario.sea.waves == "averaged":
        return Skipped(WAVES, 'sea.waves = "averaged": every clear pixel is the mean sea', bound)
    if not able:
        return Skipped(WAVES, "the sea model has no waves as shapes, or shadows need the mean sea", bound)
    if bound is not None and bound <= accuracy:
        return Skipped(WAVES, "they would change less than the accuracy asked for", bound)
    return None


def wave_seed(seed: int) -> int:
    """Seed of the waves of a scene, independent of those of its clouds."""
    return int(np.random.SeedSequence(seed, spawn_key=(_SEED_KEY,)).generate_state(1, np.uint64)[0] >> 1)
