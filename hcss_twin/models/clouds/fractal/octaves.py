"""Octaves, the terms of the sum of eq 2: the sampling of their axes, and its approximations."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import Grid, Motion

__all__ = ["Octave"]

# Octaves that are white at this pixel size and whose total variance fraction is below this are merged even if all
# sensors must see the same sky.
NEGLIGIBLE_VARIANCE = 1e-5

# Maximum number of nodes for a pixel that contains several cells of an octave: moved by a fraction of its size, it sees
# other cells.
_FINEST_PHASES = 4

# Lifetimes in proportion to cells were measured down to wavelengths of 8 km. Smaller cells live in proportion to
# size^(2/3), as eddies of turbulence do (A. N. Kolmogorov, Dokl. Akad. Nauk SSSR 30 (1941) 299).
SMALLEST_MEASURED_CELL_M = 4000.0


@dataclass(frozen=True)
class Octave:
    """One term of eq 2: its number k, its share of the (unit) variance, and its axes.

    With ``is_noise``, the nodes on ``nearest`` axes form a lattice of the pixels instead of the octave's own cells.
    This has the same distribution, because a pixel contains several cells, and is fast, because the nodes are
    contiguous.

    Attributes
    ----------
    REFERENCE_LENGTH_M : float
        L counts lattice cells in this length: 800 pixels of 20 m, the paper's image.
    NEAREST_FROM : float
        From this many cells per step, the nearest node (one random number) replaces the interpolation of 4 to 64 nodes.
        This neglects the correlation of neighbours: at worst -0.11 and on average -0.05 at 2 cells, within 0.007 of 0
        from 3 cells, and 0 from 4. Octaves this fine have a small variance fraction.
    """

    REFERENCE_LENGTH_M: ClassVar = 16_000.0
    NEAREST_FROM: ClassVar = 2.5

    @dataclass(frozen=True)
    class AxisScale:
        """Sampling of an octave along one axis.

        ``step`` is in lattice cells per pixel, or per second on the time axis, and 0 on a frozen time axis; ``nearest``
        is True if the nearest node replaces the interpolation.
        """

        step: float
        nearest: bool

        @property
        def phases(self) -> int:
            """Number of nodes into which a noise pixel is divided."""
            return min(int(self.step), _FINEST_PHASES)

    k: int
    variance: float
    x: Octave.AxisScale
    y: Octave.AxisScale
    t: Octave.AxisScale
    is_noise: bool = True

    @property
    def is_white(self) -> bool:
        """Whether all pixels of a frame are independent."""
        return self.x.nearest and self.y.nearest

    @classmethod
    def separate(cls, shape: FractalParameters, grid: Grid, motion: Motion, noise: bool = True) -> tuple[Octave, ...]:
        """Return the terms of eq 2, scaled to unit total variance; ``shape`` must be complete.

        ``noise`` allows lattices of pixels; without it, nodes belong to the sky, so that all sensors agree.
        """
        gamma, hurst, cells, limits = shape.gamma, shape.H, shape.L, shape.k
        if gamma is None or hurst is None or cells is None or limits is None:
            raise ValueError("shape: gamma, H, L and k must all be given")
        numbers = range(limits[0], limits[1] + 1)
        # gamma^(-k H) of eq 2, squared; relative to the first octave, so that nothing underflows.
        powers = [gamma ** (-2.0 * hurst * (k - limits[0])) for k in numbers]
        total = math.fsum(powers)
        octaves = []
        for k, power in zip(numbers, powers, strict=True):
            per_pixel = gamma**k * grid.pixel_size_m / Octave.REFERENCE_LENGTH_M
            x, y = _scale(cells[0] * per_pixel), _scale(cells[1] * per_pixel)
            per_second = gamma**k / motion.evolution_time_s
            if motion.lifetime_s_per_m is not None:
                size_m = Octave.REFERENCE_LENGTH_M / (gamma**k * math.sqrt(cells[0] * cells[1]))
                per_second = 1.0 / lifetime_s(size_m, motion.lifetime_s_per_m)
            # A sky that all sensors share must not depend on the frame rate of one of them.
            is_new = noise and _is_new_in_every_frame(x, y, per_second, grid, motion)
            t = Octave.AxisScale(1.0 / motion.frame_interval_s, True) if is_new else Octave.AxisScale(per_second, False)
            octaves.append(cls(k, power / total, x, y, t, noise))
        return tuple(octaves)

    @staticmethod
    def merge_noise(octaves: tuple[Octave, ...]) -> tuple[Octave, ...]:
        """Replace octaves that are white in space by the coarsest of them, with the sum of their variances.

        A sum of independent white noises is white noise, so that the distribution within a frame is exact. Between
        frames, the finer octaves would change faster than the coarsest. Where nodes belong to the sky, only negligible
        octaves are merged.
        """
        white = [octave for octave in octaves if octave.is_white]
        if not all(octave.is_noise for octave in octaves):
            while white and math.fsum(octave.variance for octave in white) > NEGLIGIBLE_VARIANCE:
                white.pop(0)
        if len(white) < 2:
            return octaves
        merged = replace(white[0], variance=math.fsum(octave.variance for octave in white))
        return (*(octave for octave in octaves if octave not in white), merged)


def lifetime_s(cell_m: float, per_m: float) -> float:
    """Return the time in which structures of one size change, from that per size of large ones."""
    return per_m * cell_m * float(max(1.0, SMALLEST_MEASURED_CELL_M / cell_m) ** (1 / 3))


def _is_new_in_every_frame(
    x: Octave.AxisScale, y: Octave.AxisScale, cells_per_second: float, grid: Grid, motion: Motion
) -> bool:
    """Whether all frames of an octave are independent.

    The octave may evolve by several cells between frames, or drift by a fraction of a pixel that contains several
    cells, so that pixels see other cells. A drift by whole pixels shows the same cells again.
    """
    interval = motion.frame_interval_s
    if interval * cells_per_second >= Octave.NEAREST_FROM:
        return True
    speed_x = motion.platform_speed_m_s - motion.cloud_velocity_m_s[0]
    for scale, speed in ((x, speed_x), (y, motion.cloud_velocity_m_s[1])):
        drift = math.fmod(speed * interval / grid.pixel_size_m, 1.0)
        if scale.nearest and abs(drift - round(drift)) * scale.step >= Octave.NEAREST_FROM / 2:
            return True
    return False


def _scale(cells_per_pixel: float) -> Octave.AxisScale:
    return Octave.AxisScale(cells_per_pixel, cells_per_pixel >= Octave.NEAREST_FROM)


AXIS_Z = (
    "axis z of the 4-D field (a column is one slab)",
    "the field is computed at one z, where its law in x, y and t is the same: exact in these; clouds have the "
    "thickness of eq 7 and no shape in height",
)
"""What replaces the axis z of eq 3."""


def describe_skipped(separate: tuple[Octave, ...], merged: tuple[Octave, ...]) -> tuple[tuple[str, str], ...]:
    """List the differences from eqs 2-4 as printed, as pairs (what, why)."""
    skipped = [AXIS_Z]
    if all(octave.t.step == 0.0 for octave in separate):
        skipped.append(("time axis", "evolution_time is infinite: shapes are frozen, one time plane: exact"))
    else:
        skipped.append(
            ("lattice nodes of earlier frames", "cached; only new columns, rows and time planes are generated: exact")
        )
    for octave in separate:
        axes = [name for name, axis in (("x", octave.x), ("y", octave.y), ("t", octave.t)) if axis.nearest]
        if axes:
            units = [unit for unit, names in (("pixels", "xy"), ("frames", "t")) if set(axes) & set(names)]
            whose = "taken as independent" if octave.is_noise else "each the nearest node of this sky"
            skipped.append(
                (
                    f"interpolation of octave {octave.k} along {', '.join(axes)}",
                    f"{' and '.join(units)} are {Octave.NEAREST_FROM:g} or more cells apart, {whose}: "
                    f"neglects correlations of -.11 to .01 in {octave.variance:.1e} of the variance",
                )
            )
    gone = [octave for octave in separate if octave.k not in {octave.k for octave in merged}]
    if gone:
        first = next(octave for octave in merged if octave.k == gone[0].k - 1)
        skipped.append(
            (
                f"octaves {', '.join(str(octave.k) for octave in gone)} as separate terms",
                f"white within a frame, as octave {first.k}, which carries their variance ({first.variance:.3g} "
                f"in all): exact within a frame; {math.fsum(octave.variance for octave in gone):.1e} of the "
                "variance changes as slowly as it does",
            )
        )
    return tuple(skipped)
