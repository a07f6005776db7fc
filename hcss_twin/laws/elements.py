"""Laws of element providers: a pixel is the same in any window, and a body shines by its temperature."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from hcss_twin.laws.law import Inapplicable, Law, at_least, at_most, require
from hcss_twin.laws.samples import PlainScene, frozen
from hcss_twin.providers import ElementInputs, ElementPixels, ElementProvider

Pixel = dict[tuple[int, int], list[tuple[float, ...]]]
"""Values of each pixel, by row and column, part by part."""

TIMES_S = (0.0, 2.0, 7.5)
"""Times of the calls."""


def a_window_has_the_pixels_of_the_image(
    provider: ElementProvider, inputs: ElementInputs, times_s: Sequence[float] = TIMES_S
) -> None:
    """Windows that cut through elements, and rows outside the image, change no bit of a pixel."""
    rows, columns, appears = inputs.grid.rows, inputs.grid.columns, False
    for time_s in times_s:
        whole, pieces = (
            pixels_of(PlainScene(inputs).shown(provider, time_s, slice(0, rows), slice(0, columns))),
            Pixel(),
        )
        appears = appears or bool(whole)
        row, column = next(iter(whole), (rows // 7, columns // 2))
        cuts = (
            (slice(-3, row), slice(row, row + 1), slice(row + 1, rows)),
            (slice(0, column + 1), slice(column + 1, columns + 2)),
        )
        for window in ((row_cut, column_cut) for row_cut in cuts[0] for column_cut in cuts[1]):
            found = pixels_of(PlainScene(inputs).shown(provider, time_s, *window))
            inside = all(one.start <= n < one.stop for at in found for n, one in zip(at, window, strict=True))
            require(inside, f"pixels outside the window {window} at {time_s:g} s")
            pieces |= found
        pieces = {at: piece for at, piece in pieces.items() if 0 <= at[0] < rows and 0 <= at[1] < columns}
        differ = sorted(at for at in pieces.keys() | whole.keys() if pieces.get(at) != whole.get(at))
        require(not differ, f"{len(differ)} pixels differ with the window at {time_s:g} s, first {differ[:1]}")
    if not appears:
        raise Inapplicable("nothing appears in the image at the times of the law")


def times_may_come_in_any_order(
    make: Callable[[ElementInputs], ElementProvider], inputs: ElementInputs, times_s: Sequence[float] = TIMES_S
) -> None:
    """Results depend on time and seed alone, not on earlier calls."""
    image = slice(0, inputs.grid.rows), slice(0, inputs.grid.columns)
    one, other = make(inputs), make(inputs)
    forward = [pixels_of(PlainScene(inputs).shown(one, time_s, *image)) for time_s in times_s]
    backward = [pixels_of(PlainScene(inputs).shown(other, time_s, *image)) for time_s in reversed(times_s)]
    require(forward == backward[::-1], f"pixels differ with the order of the times {', '.join(map(str, times_s))} s")


def a_body_shines_by_its_temperature(
    provider: ElementProvider, inputs: ElementInputs, times_s: Sequence[float] = TIMES_S
) -> None:
    """By night at most like a black body of ``temperature_K`` and with a similar spectrum, to a factor of 2."""
    image = slice(0, inputs.grid.rows), slice(0, inputs.grid.columns)
    for part in PlainScene(inputs).shown(provider, times_s[0], *image):
        if part.temperature_K is None:
            continue
        light = part.intensity if part.radiance is None else part.radiance
        emissivity = frozen(light) / inputs.black_body(part.temperature_K)
        what = f"of a body of {part.temperature_K:g} K over that of a black one"
        least, most = float(np.min(emissivity, initial=np.inf)), float(np.max(emissivity, initial=0.0))
        at_most(f"light {what} in one band", most, 2.0 * least)
        if part.radiance is not None:
            at_least(f"radiance {what}", least, 0.01)
            at_most(f"radiance {what}", most, 1.0 + 1e-6)


LAWS: tuple[Law, ...] = (
    a_window_has_the_pixels_of_the_image,
    times_may_come_in_any_order,
    a_body_shines_by_its_temperature,
)


def pixels_of(parts: list[ElementPixels]) -> Pixel:
    """Return the values of each pixel, part by part."""
    found: Pixel = {}
    for part in parts:
        given = frozen(part.intensity if part.radiance is None else part.radiance)
        values = np.broadcast_to(given, (part.rows.size, given.shape[-1]))
        for n, at in enumerate(zip(part.rows.tolist(), part.columns.tolist(), strict=True)):
            facts = (part.altitude_m, float(part.share[n]), *values[n].tolist())
            found.setdefault(at, []).append((*facts, *(float(truth[n]) for truth in part.truth.values())))
    return found
