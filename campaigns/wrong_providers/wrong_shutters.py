"""Wrong sensors that ask for the scene at other instants."""

from dataclasses import replace

import numpy as np
from changed import Changed, Wrong, on_argument, on_result
from wrong_clouds import TIME
from wrong_sensors import RADIANCE

LATE = {
    "double": ("twice as late", lambda late: 2.0 * late),
    "half": ("half as late", lambda late: 0.5 * late),
    "negative": ("as early as it should be late", lambda late: -late),
    "ms": ("with a delay in ms", lambda late: 1e3 * late),
    "from-ms": ("with a delay taken for ms", lambda late: 1e-3 * late),
    "dropped": ("at the time of the frame", lambda late: 0.0),
    "later": ("a frame later", lambda late: late + 2.0),
    "largest": ("with the delay of the last row", lambda late: 4.7e-3),
}

SEEN = {
    "rows-shifted": ("of the next row", lambda t, y, x: (t, slice(y.start + 1, y.stop + 1), x)),
    "columns-shifted": ("of the next column", lambda t, y, x: (t, y, slice(x.start + 1, x.stop + 1))),
    "exchanged": ("of rows and columns exchanged", lambda t, y, x: (t, x, y)),
    "start-dropped": ("of the first rows", lambda t, y, x: (t, slice(0, y.stop - y.start), x)),
    "stop-lost": ("without the last row", lambda t, y, x: (t, slice(y.start, max(y.stop - 1, y.start + 1)), x)),
    "columns-lost": ("without the last column", lambda t, y, x: (t, y, slice(x.start, x.stop - 1))),
    "start-of-scenario": ("at the start of the scenario", lambda t, y, x: (0.0, y, x)),
    "arguments": ("with the time last", lambda t, y, x: (y, x, t)),
}

GIVEN = {
    name: RADIANCE[name]
    for name in ("double", "negative", "milliwatt", "transposed", "rows-reversed", "columns-reversed", "bands-reversed")
} | {
    "first-band": ("the first band for all", lambda x: np.broadcast_to(x[:1], x.shape)),
    "exposures-summed": ("summed over the exposure", lambda x: 5.0 * x),
    "per-second": ("over the exposure in s", lambda x: x / 0.05),
}

CORNER = {
    "dropped": ("the corner of the image", lambda corner: (0, 0)),
    "exchanged": ("row and column of the corner exchanged", lambda corner: corner[::-1]),
    "negative": ("the other sign of the corner", lambda corner: (-corner[0], -corner[1])),
    "double": ("twice the corner", lambda corner: (2 * corner[0], 2 * corner[1])),
}

INSTANTS = {
    "ms": ("in ms", lambda ends: (1e3 * ends[0], 1e3 * ends[1])),
    "from-ms": ("taken for ms", lambda ends: (1e-3 * ends[0], 1e-3 * ends[1])),
    "half": ("halved", lambda ends: (0.5 * ends[0], 0.5 * ends[1])),
    "negative": ("with the other sign", lambda ends: (-ends[0], -ends[1])),
    "exchanged": ("from the latest to the earliest", lambda ends: ends[::-1]),
    "span": ("as a duration", lambda ends: ends[1] - ends[0]),
    "none": ("as those of the frame", lambda ends: (0.0, 0.0)),
    "lost": ("not at all", lambda ends: None),
}


def wrong_providers():
    """Return all of them."""
    for right in ("rolling-shutter", "exposure"):
        for name, (words, change) in LATE.items():
            if (right, name) != ("exposure", "largest"):
                yield Wrong(f"{right}.late.{name}", right, f"the scene is asked for {words}", inputs=_late(change))
        for name, (words, change) in SEEN.items():
            # All rows at once begin with the first; a row alone is not shortened.
            if (right, name) not in (("exposure", "start-dropped"), ("rolling-shutter", "stop-lost")):
                yield Wrong(f"{right}.seen.{name}", right, f"the scene is that {words}", inputs=_seen(change))
        for name, (words, change) in INSTANTS.items():
            wrap = lambda provider, inputs, change=change: Changed(  # noqa: E731
                provider, instants=change(provider.instants)
            )
            yield Wrong(f"{right}.instants.{name}", right, f"instants are given {words}", wrap)
        yield from on_result(
            right, "measure", GIVEN, lambda v: v.radiance, lambda v, new: replace(v, radiance=new), "radiance"
        )
        yield from on_argument(right, "measure", 2, "time_s", {k: v for k, v in TIME.items() if k != "negative"})
        clean = lambda provider, inputs: Changed(  # noqa: E731
            provider, measure=lambda radiance, *given: replace(provider.measure(radiance, *given), radiance=radiance)
        )
        yield Wrong(f"{right}.clean", right, "the frame is returned as it is", clean)
    for name, (words, change) in CORNER.items():
        made = lambda inputs, change=change: replace(inputs, corner=change(inputs.corner))  # noqa: E731
        yield Wrong(f"rolling-shutter.corner.{name}", "rolling-shutter", f"made with {words}", inputs=made)
    made = lambda inputs: replace(inputs, seed=1)  # noqa: E731
    yield Wrong("jitter.inputs.seed-dropped", "jitter", "made with one seed for all", inputs=made)
    yield from on_argument("jitter", "measure", 1, "frame", {"dropped": ("ignored", lambda frame: 0)})


def _late(change):
    """Ask at another time after the frame."""

    def made(inputs):
        scene = inputs.scene_at

        def scene_at(time_s, *window):
            return scene(scene.time_s + change(time_s - scene.time_s), *window)

        return replace(inputs, scene_at=scene_at)

    return made


def _seen(change):
    return lambda inputs: replace(inputs, scene_at=lambda *given: inputs.scene_at(*change(*given)))
