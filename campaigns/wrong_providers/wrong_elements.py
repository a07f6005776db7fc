"""Wrong elements."""

from dataclasses import replace

import numpy as np
from changed import Changed, Wrong, on_argument
from wrong_clouds import TIME, WINDOW

PLACE = {
    "rows-one-off": ("rows off by one", lambda p: replace(p, rows=p.rows + 1)),
    "columns-one-off": ("columns off by one", lambda p: replace(p, columns=p.columns + 1)),
    "exchanged": ("rows and columns exchanged", lambda p: replace(p, rows=p.columns, columns=p.rows)),
    "rows-from-last": ("rows counted from the last", lambda p: replace(p, rows=47 - p.rows)),
    "columns-from-last": ("columns counted from the last", lambda p: replace(p, columns=63 - p.columns)),
    "rows-double": ("rows doubled", lambda p: replace(p, rows=2 * p.rows)),
    "from-centre": ("rows and columns from the centre", lambda p: replace(p, rows=p.rows - 24, columns=p.columns - 32)),
    "float": ("rows as floats", lambda p: replace(p, rows=p.rows.astype(float))),
    "last-lost": (
        "all pixels but the last",
        lambda p: replace(
            p,
            **{name: getattr(p, name)[:-1] for name in ("rows", "columns", "share")},
            truth={name: values[:-1] for name, values in p.truth.items()},
        ),
    ),
    "first-twice": ("the first pixel for all", lambda p: replace(p, rows=np.full_like(p.rows, p.rows[0]))),
}

SHARE = {
    "double": ("doubled", lambda x: 2.0 * x),
    "half": ("halved", lambda x: 0.5 * x),
    "percent": ("in percent", lambda x: 100.0 * x),
    "from-percent": ("divided by 100", lambda x: 0.01 * x),
    "negative": ("with the other sign", lambda x: -x),
    "complement": ("1 minus it", lambda x: 1.0 - x),
    "square": ("squared", np.square),
    "whole": ("1 for all", np.ones_like),
    "reversed": ("in reverse order", lambda x: x[::-1]),
    "column": ("of shape (N, 1)", lambda x: x[:, None]),
}

ALTITUDE = {
    "km": ("in km", lambda z: 1e-3 * z),
    "feet": ("in feet", lambda z: z / 0.3048),
    "from-feet": ("taken for feet", lambda z: 0.3048 * z),
    "negative": ("with the other sign", lambda z: -z),
    "dropped": ("0", lambda z: 0.0),
    "double": ("doubled", lambda z: 2.0 * z),
}

STRENGTH = {
    "double": ("doubled", lambda x: 2.0 * x),
    "half": ("halved", lambda x: 0.5 * x),
    "negative": ("with the other sign", lambda x: -x),
    "milliwatt": ("in mW", lambda x: 1e3 * x),
    "per-cm2": ("per cm2", lambda x: 1e-4 * x),
    "over-pi": ("divided by pi", lambda x: x / np.pi),
    "hemispherical": ("times pi", lambda x: np.pi * x),
    "per-um": ("per um instead of the band", lambda x: x * np.array([6.25e2, 1e2])),
    "per-cm1": ("per cm-1 instead of the band", lambda x: x / np.array([625.0, 100.0])),
    "bands-reversed": ("with exchanged bands", lambda x: x[..., ::-1]),
    "first-band": ("the first band for all", lambda x: np.broadcast_to(x[..., :1], x.shape)),
    "band-mean": ("the mean over the bands", lambda x: np.broadcast_to(x.mean(-1, keepdims=True), x.shape)),
    "zero": ("0", np.zeros_like),
    "complement": ("1 minus it", lambda x: 1.0 - x),
    "square": ("squared", np.square),
    "log": ("its logarithm", np.log),
    "one-band": ("the first band only", lambda x: x[..., :1]),
}

TEMPERATURE = {
    "celsius": ("in degrees Celsius", lambda t: t - 273.15),
    "double": ("doubled", lambda t: 2.0 * t),
    "half": ("halved", lambda t: 0.5 * t),
    "negative": ("with the other sign", lambda t: -t),
}

PROJECTION = {
    "exchanged": ("x and y exchanged", lambda x, y, z: (y, x, z)),
    "x-negative": ("the other sign of x", lambda x, y, z: (-x, y, z)),
    "y-negative": ("the other sign of y", lambda x, y, z: (x, -y, z)),
    "km": ("positions in km", lambda x, y, z: (1e-3 * x, 1e-3 * y, z)),
    "double": ("positions doubled", lambda x, y, z: (2.0 * x, 2.0 * y, z)),
    "half-pixel": ("half a pixel added twice", lambda x, y, z: (x + 200.0, y + 200.0, z)),
    "altitude-dropped": ("altitude 0", lambda x, y, z: (x, y, 0.0 * z)),
    "altitude-km": ("altitude in km", lambda x, y, z: (x, y, 1e-3 * z)),
    "altitude-negative": ("the other sign of the altitude", lambda x, y, z: (x, y, -z)),
    "dropped": ("the image centre for all", lambda x, y, z: (0.0 * x, 0.0 * y, z)),
}

INPUTS = {
    "pixel-km": ("the pixel size in km", lambda i: _grid(i, pixel_size_m=1e-3 * i.grid.pixel_size_m)),
    "pixel-double": ("twice the pixel size", lambda i: _grid(i, pixel_size_m=2.0 * i.grid.pixel_size_m)),
    "pixel-dropped": ("a pixel size of 1 m", lambda i: _grid(i, pixel_size_m=1.0)),
    "black-body-half": ("half of Planck's function", lambda i: _black_body(i, lambda r: 0.5 * r)),
    "black-body-pi": ("the emittance of a black body", lambda i: _black_body(i, lambda r: np.pi * r)),
    "black-body-celsius": ("temperatures in Celsius", lambda i: _colder(i)),
}


def _grid(inputs, **changes):
    return replace(inputs, grid=replace(inputs.grid, **changes))


def _black_body(inputs, change):
    return replace(inputs, black_body=lambda kelvin: change(inputs.black_body(kelvin)))


def _colder(inputs):
    return replace(inputs, black_body=lambda kelvin: inputs.black_body(max(kelvin - 273.15, 1.0)))


class _Scene:
    """A scene with another projection."""

    def __init__(self, scene, change):
        self._scene, self._change = scene, change

    def __getattr__(self, name):
        return getattr(self._scene, name)

    def project(self, *place):
        return self._scene.project(*self._change(*place))


def on_parts(right, label, table, change):
    """Wrong providers that change each part; ``change`` maps part and entry to the new part."""
    for name, (words, made) in table.items():

        def wrap(provider, inputs, made=made):
            return Changed(provider, pixels=lambda *given: [change(each, made) for each in provider.pixels(*given)])

        yield Wrong(f"{right}.{label}.{name}", right, f"{label}: {words}", wrap)


def stronger(part, made):
    name = "intensity" if part.radiance is None else "radiance"
    return replace(part, **{name: made(getattr(part, name))})


def wrong_providers():
    for right in ("tracks", "deck"):
        yield from on_parts(right, "pixels", PLACE, lambda part, made: made(part))
        # The shares of the deck are 1 everywhere: some changes leave them as they are.
        table = (
            SHARE if right == "tracks" else {name: SHARE[name] for name in ("double", "half", "percent", "negative")}
        )
        yield from on_parts(right, "share", table, lambda part, made: replace(part, share=made(part.share)))
        yield from on_parts(
            right, "altitude_m", ALTITUDE, lambda part, made: replace(part, altitude_m=made(part.altitude_m))
        )
    for right in ("hot-body", "deck"):
        yield from on_parts(right, "strength", STRENGTH, stronger)
        yield from on_parts(
            right,
            "temperature_K",
            TEMPERATURE,
            lambda part, made: replace(part, temperature_K=made(part.temperature_K)),
        )
    yield from on_argument("tracks", "pixels", 0, "time_s", {**TIME, "next": ("of the next frame", lambda t: t + 2.0)})
    for place, name in ((1, "rows"), (2, "columns")):
        yield from on_argument("tracks", "pixels", place, name, WINDOW)
    yield from on_argument(
        "tracks",
        "pixels",
        3,
        "project",
        {
            name: (words, lambda scene, change=change: _Scene(scene, change))
            for name, (words, change) in PROJECTION.items()
        },
    )
    for name, (words, change) in INPUTS.items():
        right = "hot-body" if name.startswith("black") else "tracks"
        yield Wrong(f"{right}.inputs.{name}", right, f"the element is made with {words}", inputs=change)
    both = {
        "radiance": ("intensity as radiance", lambda p: replace(p, radiance=p.intensity, intensity=None)),
        "twice": ("both", lambda p: replace(p, radiance=p.intensity)),
        "truth-lost": ("no truth", lambda p: replace(p, truth={})),
        "truth-nan": (
            "truth that is not a number",
            lambda p: replace(p, truth={n: v * np.nan for n, v in p.truth.items()}),
        ),
        "truth-scalar": (
            "one truth for all pixels",
            lambda p: replace(p, truth={n: v[:1] for n, v in p.truth.items()}),
        ),
    }
    yield from on_parts("tracks", "parts", both, lambda part, made: made(part))
    for name, words, change in (
        ("first-lost", "the first part is lost", lambda parts: parts[1:]),
        ("first-twice", "the first part appears twice", lambda parts: [*parts[:1], *parts]),
        ("none", "nothing appears", lambda parts: []),
    ):
        wrap = lambda provider, inputs, change=change: Changed(  # noqa: E731
            provider, pixels=lambda *given: change(list(provider.pixels(*given)))
        )
        yield Wrong(f"tracks.parts.{name}", "tracks", words, wrap)
