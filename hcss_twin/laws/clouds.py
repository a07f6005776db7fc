"""Laws of cloud generators: the sizes and the amount of cloud."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import HcssError
from hcss_twin.laws.law import Inapplicable, Law, at_least, at_most, near, require
from hcss_twin.providers import CloudGenerator, CloudInputs, CloudLayer, Motion
from hcss_twin.providers.common import THICKNESS_TOLERANCE

Make = Callable[[CloudInputs], CloudGenerator]
"""Maps inputs to the generator under test."""

TIMES_S = (0.0, 7.0, 3600.0)
"""Times of the frames."""


def thickness_stays_within_the_layer(
    provider: CloudGenerator, inputs: CloudInputs, times_s: Sequence[float] = TIMES_S
) -> None:
    """0, or between the minimum and maximum thickness of the layer."""
    for time_s in possible(provider, inputs, times_s):
        within_layer(whole(provider, inputs, time_s), inputs.layer)


def windows_equal_the_whole(provider: Any, inputs: CloudInputs) -> None:
    """Any tiling gives the same field, for tileable generators and those with frame summaries."""
    time_s = possible(provider, inputs, (0.0, 4.0))[-1]
    part = provider.thickness_m
    if not provider.declares.tileable:
        if not hasattr(provider, "frame_summary"):
            raise Inapplicable("not tileable: the engine asks for whole frames only")
        part = functools.partial(provider.thickness_in_frame_m, summary=provider.frame_summary(time_s))
    field, (rows, columns) = whole(provider, inputs, time_s), (inputs.grid.rows, inputs.grid.columns)
    for window in (
        (slice(0, (rows + 6) // 7), slice(0, columns)),
        (slice(rows // 9, rows - rows // 3), slice(columns // 4, columns // 4 + 1)),
        (slice(rows - 1, rows), slice(columns - (columns + 15) // 16, columns)),
    ):
        same = np.array_equal(part(time_s, *window), field[window])
        require(same, f"rows {window[0]}, columns {window[1]} at {time_s:g} s are not those of the whole frame")


def declared_time_matters(make: Make, inputs: CloudInputs) -> None:
    """Frames differ where clouds move and the generator declares time."""
    provider = make(inputs)
    if "time" not in (provider.declares.depends_on or ()):
        raise Inapplicable("the generator does not declare time")
    first, *later = possible(provider, inputs, (0.0, 4.0, 60.0, 600.0, 3600.0))
    frame = whole(provider, inputs, first)
    if np.all(frame == frame.flat[0]):
        raise Inapplicable("the field is even")
    changes = [not np.array_equal(frame, whole(provider, inputs, time_s)) for time_s in later]
    require(any(changes), "declares time, which does not matter")


def frozen_field_only_translates(make: Make, inputs: CloudInputs) -> None:
    """A platform that moves by whole pixels sees the same pixels again, shifted, if shapes are frozen.

    The same holds for wind: the image moves over the clouds with platform minus wind velocity.
    """
    step = inputs.grid.pixel_size_m
    for platform, wind, columns, rows in (
        (step, (0.0, 0.0), 3, 0),
        (0.0, (0.0, step), 0, -3),
        (2.0 * step, (step, -step), 3, 3),
    ):
        motion = Motion(
            platform_speed_m_s=platform, cloud_velocity_m_s=wind, evolution_time_s=np.inf, frame_interval_s=1.0
        )
        moving = replace(inputs, motion=motion)
        provider = make(moving)
        if provider.declares.evolves or not provider.declares.tileable:
            raise Inapplicable("evolves, or normalises each frame")
        before, after = whole(provider, moving), whole(provider, moving, 3.0)
        height, width = before.shape
        if abs(rows) >= height or abs(columns) >= width:
            continue  # nothing is seen again
        top, left = max(rows, 0), max(columns, 0)
        seen_again = before[top : height + min(rows, 0), left : width + min(columns, 0)]
        top, left = max(-rows, 0), max(-columns, 0)
        now = after[top : height - max(rows, 0), left : width - max(columns, 0)]
        share = float(np.mean(now != seen_again))
        require(
            share == 0.0, f"{share:.0%} of the pixels are not those {columns} columns and {rows} rows on, 3 s before"
        )


def seed_matters(make: Make, inputs: CloudInputs) -> None:
    """Other seeds give other fields, except of a generator with ``image_coverage``, which is given its picture."""
    if hasattr(make(inputs), "image_coverage"):
        raise Inapplicable("the fields are given, not drawn")
    fields = [whole(make(replace(inputs, seed=seed)), inputs) for seed in (1, 2, 3)]
    if all(np.all(field > 0.0) or not np.any(field) for field in fields):
        raise Inapplicable("every field is all clear or all cloud")
    given = "a generator of given fields has image_coverage"
    require(not np.array_equal(fields[0], fields[1]), f"seeds 1 and 2 give the same field; {given}")
    require(not np.array_equal(fields[1], fields[2]), f"seeds 2 and 3 give the same field; {given}")


def undeclared_time_has_no_influence(make: Make, inputs: CloudInputs) -> None:
    """If nothing moves or evolves, or time is not declared, all frames are equal.

    A generator that declares time and ``evolves`` without any motion has a film of its own.
    """
    still = replace(inputs, motion=Motion(0.0, (0.0, 0.0), np.inf, inputs.motion.frame_interval_s))
    asked = False
    for candidate in (still, inputs):
        declares = (provider := make(candidate)).declares
        declared = declares.depends_on
        if (candidate is inputs or declares.evolves) and (declared is None or "time" in declared):
            continue
        asked, later = True, possible(provider, candidate, (0.0, 4.0, 60.0))[-1]
        same = np.array_equal(whole(provider, candidate), whole(provider, candidate, later))
        why = "does not declare time" if candidate is inputs else "nothing moves or evolves"
        require(same, f"{why}, and the frame at {later:g} s is another one")
    if not asked:
        raise Inapplicable("the generator has a film of its own")


def field_does_not_depend_on_earlier_calls(make: Make, inputs: CloudInputs) -> None:
    """The same times in another order, with another instance, give bit-identical results."""
    forward, backward = make(inputs), make(inputs)
    times = possible(forward, inputs, (0.0, 4.0, 2.0, 600.0))
    one = {time_s: whole(forward, inputs, time_s) for time_s in times}
    other = {time_s: whole(backward, inputs, time_s) for time_s in reversed(times)}
    for time_s in times:
        require(np.array_equal(one[time_s], other[time_s]), f"the frame at {time_s:g} s differs with those before it")


LAWS: tuple[Law, ...] = (
    thickness_stays_within_the_layer,
    windows_equal_the_whole,
    declared_time_matters,
    undeclared_time_has_no_influence,
    frozen_field_only_translates,
    field_does_not_depend_on_earlier_calls,
    seed_matters,
)
"""Laws of any generator."""


def within_layer(field: NDArray[np.float32], layer: CloudLayer) -> None:
    """Raise ``LawBroken`` if a thickness is neither 0 nor between the limits of the layer."""
    require(np.isfinite(field), "a thickness is not finite")
    cloudy = field[field != 0.0]
    at_least("thickness of cloud in m", cloudy, layer.thickness_min_m * (1 - THICKNESS_TOLERANCE))
    at_most("thickness of cloud in m", cloudy, layer.thickness_max_m * (1 + THICKNESS_TOLERANCE))


def cloudy_fraction_is(coverage: float, fields: Sequence[NDArray[np.float32]], tolerance: float) -> None:
    """Raise ``LawBroken`` if the mean fraction of cloudy pixels is not the coverage, within the tolerance."""
    near(f"cloudy fraction of {len(fields)} seeds", np.mean(np.stack(fields) > 0.0), coverage, atol=tolerance)


def whole(provider: CloudGenerator, inputs: CloudInputs, time_s: float = 0.0) -> NDArray[np.float32]:
    """Return a whole frame."""
    return provider.thickness_m(time_s, slice(0, inputs.grid.rows), slice(0, inputs.grid.columns))


def own_coverage(provider: CloudGenerator) -> float | None:
    """Return the coverage that replaces that of the layer, if there is one."""
    coverage = getattr(provider, "image_coverage", None)
    return None if coverage is None else float(coverage)


def possible(provider: CloudGenerator, inputs: CloudInputs, times: Sequence[float]) -> list[float]:
    """Return those times that a generator has; beyond the first it may refuse some with an ``HcssError``."""

    def has(time_s: float) -> bool:
        try:
            whole(provider, inputs, time_s)
        except HcssError:
            return False
        return True

    return [times[0], *(time_s for time_s in times[1:] if has(time_s))]
