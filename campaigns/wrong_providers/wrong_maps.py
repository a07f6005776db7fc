"""Wrong surfaces."""

from dataclasses import replace

import numpy as np
from changed import Changed, Wrong, on_argument, on_result
from wrong_clouds import TIME, WINDOW

NUMBER = {
    "from-1": ("counted from 1", lambda x: x + 1),
    "exchanged": ("of the other class", lambda x: 1 - x),
    "signed": ("with the other sign", lambda x: -x.astype(int)),
    "float": ("as a float", lambda x: x.astype(float)),
    "bool": ("as a truth value", lambda x: x > 0),
    "mask": ("as 0 and 255", lambda x: np.uint8(255) * x),
    "transposed": ("with exchanged axes", lambda x: x.T),
    "rows-reversed": ("from the last row", lambda x: x[::-1]),
    "columns-reversed": ("from the last column", lambda x: x[:, ::-1]),
    "rolled": ("off by one column", lambda x: np.roll(x, 1, axis=1)),
    "rolled-rows": ("off by one row", lambda x: np.roll(x, 1, axis=0)),
    "first-row": ("the first row for all", lambda x: np.repeat(x[:1], len(x), axis=0)),
    "last-row-lost": ("without the last row", lambda x: x[:-1]),
    "first": ("the first class everywhere", np.zeros_like),
    "flat": ("as one axis", np.ravel),
}

KELVIN = {
    "celsius": ("in degrees Celsius", lambda x: x - 273.15),
    "fahrenheit": ("in degrees Fahrenheit", lambda x: 1.8 * x - 459.67),
    "double": ("doubled", lambda x: 2.0 * x),
    "half": ("halved", lambda x: 0.5 * x),
    "millikelvin": ("in mK", lambda x: 1e3 * x),
    "negative": ("with the other sign", lambda x: -x),
    "warmer": ("10 K too warm", lambda x: x + 10.0),
    "colder": ("10 K too cold", lambda x: x - 10.0),
    "transposed": ("with exchanged axes", lambda x: x.T),
    "rows-reversed": ("from the last row", lambda x: x[::-1]),
    "rolled": ("off by one column", lambda x: np.roll(x, 1, axis=1)),
    "mean": ("the mean for all", lambda x: np.full_like(x, x.mean())),
    "zero": ("0", np.zeros_like),
    "missing": ("missing", lambda x: np.full_like(x, np.nan)),
    "lost": ("not at all", lambda x: None),
    "integer": ("as an integer", lambda x: x.astype(int)),
    "scalar": ("one for all", lambda x: x[:1, :1]),
}

GROUND = {
    "exchanged": ("latitude and longitude exchanged", lambda a, b: (b, a)),
    "south": ("the other sign of the latitude", lambda a, b: (-a, b)),
    "west": ("the other sign of the longitude", lambda a, b: (a, -b)),
    "radians": ("radians", lambda a, b: (np.radians(a), np.radians(b))),
    "latitude-dropped": ("the latitude of the first point for all", lambda a, b: (np.full_like(a, a[0, 0]), b)),
    "longitude-dropped": ("the longitude of the first point for all", lambda a, b: (a, np.full_like(b, b[0, 0]))),
    "transposed": ("exchanged axes", lambda a, b: (a.T, b.T)),
    "rows-reversed": ("the last row first", lambda a, b: (a[::-1], b[::-1])),
    "columns-reversed": ("the last column first", lambda a, b: (a[:, ::-1], b[:, ::-1])),
    "whole": ("whole degrees", lambda a, b: (np.rint(a), np.rint(b))),
    "half-degree": ("half a degree too far", lambda a, b: (a + 0.5, b + 0.5)),
}

PLACE = {
    "time-dropped": ("the ground of the start", lambda t, y, x: (0.0, y, x)),
    "time-negative": ("the ground at the opposite time", lambda t, y, x: (-t, y, x)),
    "time-ms": ("the ground of a time in ms", lambda t, y, x: (1e3 * t, y, x)),
    "rows-shifted": ("the ground of the next row", lambda t, y, x: (t, slice(y.start + 1, y.stop + 1), x)),
    "columns-shifted": ("the ground of the next column", lambda t, y, x: (t, y, slice(x.start + 1, x.stop + 1))),
    "start-dropped": ("the ground from the first row", lambda t, y, x: (t, slice(0, y.stop - y.start), x)),
    "exchanged": ("the ground of rows and columns exchanged", lambda t, y, x: (t, x, y)),
}

CLASSES = {
    "reversed": ("classes in the other order", lambda c: c[::-1]),
    "twice": ("the first class twice", lambda c: (c[0], *c)),
    "lost": ("the first class only", lambda c: c[:1]),
    "list": ("a list of classes", list),
    "names": ("names of classes", lambda c: tuple(each.name for each in c)),
    "celsius": ("limits in degrees Celsius", lambda c: _limits(c, lambda t: t - 273.15)),
    "double": ("limits doubled", lambda c: _limits(c, lambda t: 2.0 * t)),
    "half": ("limits halved", lambda c: _limits(c, lambda t: 0.5 * t)),
    "warmer": ("limits 30 K too warm", lambda c: _limits(c, lambda t: t + 30.0)),
    "from-high": ("limits from high to low", lambda c: _each(c, lambda t: t[::-1])),
    "equal": ("the upper limit for both", lambda c: _each(c, lambda t: (t[1], t[1]))),
}

EMISSIVITY = {
    "percent": ("in percent", lambda x: 100.0 * x),
    "from-percent": ("divided by 100", lambda x: 0.01 * x),
    "half": ("halved", lambda x: 0.5 * x),
    "complement": ("1 minus it", lambda x: 1.0 - x),
    "negative": ("with the other sign", lambda x: -x),
    "transposed": ("with exchanged axes", lambda x: x.T),
    "zero": ("0", np.zeros_like),
    "above": ("20 % larger", lambda x: 1.2 * x),
    "first-row": ("without directions", lambda x: x[0]),
}

BRDF = {
    "times-pi": ("as an albedo", lambda x: np.pi * x),
    "over-pi": ("divided by pi", lambda x: x / np.pi),
    "percent": ("in percent", lambda x: 100.0 * x),
    "negative": ("with the other sign", lambda x: -x),
    "complement": ("1 minus it", lambda x: 1.0 - x),
    "transposed": ("with exchanged axes", lambda x: x.T),
    "tenfold": ("ten times as large", lambda x: 10.0 * x),
}


def _each(classes, change):
    fields = [isinstance(each.temperature_K, tuple) for each in classes]
    return tuple(
        replace(each, temperature_K=change(each.temperature_K)) if field else each
        for each, field in zip(classes, fields, strict=True)
    )


def _limits(classes, change):
    made = _each(classes, lambda ends: tuple(change(each) for each in ends))
    return tuple(
        replace(each, temperature_K=change(each.temperature_K)) if isinstance(each.temperature_K, float) else each
        for each in made
    )


def _boundaries(classes, change):
    return tuple(each if each.boundary is None else replace(each, boundary=change(each.boundary)) for each in classes)


def of_result(member, change):
    """Map a boundary to one with another result of a member."""
    return lambda boundary: Changed(
        boundary, **{member: lambda *given: change(np.asarray(getattr(boundary, member)(*given)))}
    )


def absorbed(boundary):
    """Reflect what is to be emitted, and emit what is to be reflected."""
    emissivity = lambda nu, mu: 1.0 - boundary.emissivity(nu, mu)  # noqa: E731
    brdf = lambda nu, mu, *others: boundary.emissivity(nu, mu) / np.pi  # noqa: E731
    return Changed(boundary, emissivity=emissivity, brdf=brdf)


def oblique(boundary):
    """Reflect more where the sun is higher."""
    return Changed(boundary, brdf=lambda nu, out, into, turn: boundary.brdf(nu, out, into, turn) * into[:, None] * 1.5)


def with_classes(right, label, words, change):
    wrap = lambda provider, inputs: Changed(provider, classes=change(provider.classes))  # noqa: E731
    return Wrong(f"{right}.{label}", right, words, wrap)


def wrong_providers():
    """Return all of them."""
    for right in ("ice-map", "coast", "raster"):
        yield from on_result(
            right, "surface", NUMBER, lambda v: v.number, lambda v, new: replace(v, number=new), "number"
        )
    for right in ("ice-map", "raster"):
        yield from on_result(
            right,
            "surface",
            KELVIN,
            lambda v: v.temperature_K,
            lambda v, new: replace(v, temperature_K=new),
            "temperature_K",
        )
    for right in ("coast", "ice-map"):
        for name, (words, change) in GROUND.items():
            yield Wrong(f"{right}.ground.{name}", right, f"the ground is taken with {words}", inputs=_ground(change))
    for name, (words, change) in PLACE.items():
        yield Wrong(f"ice-map.place.{name}", "ice-map", f"the surface is that of {words}", inputs=_place(change))
    for right in ("ice-map", "coast"):
        for place, name in ((1, "rows"), (2, "columns")):
            yield from on_argument(right, "surface", place, name, WINDOW)
    yield from on_argument("tidal-flat", "surface", 0, "time_s", TIME)
    for right in ("floe", "raster"):
        for name, (words, change) in CLASSES.items():
            yield with_classes(right, f"classes.{name}", words, change)
    for member, table in (("emissivity", EMISSIVITY), ("brdf", BRDF)):
        for name, (words, change) in table.items():
            made = lambda c, member=member, change=change: _boundaries(c, of_result(member, change))  # noqa: E731
            yield with_classes("floe", f"{member}.{name}", f"{member} is returned {words}", made)
    for change in (absorbed, oblique):
        made = lambda c, change=change: _boundaries(c, change)  # noqa: E731
        yield with_classes(
            "floe", f"boundary.{change.__name__}", change.__doc__[0].lower() + change.__doc__[1:-1], made
        )
    for name, words, change in (
        ("celsius", "air temperature in degrees Celsius", lambda t: t - 273.15),
        ("double", "twice the air temperature", lambda t: 2.0 * t),
        ("dropped", "an air temperature of 0 K", lambda t: 0.0),
    ):
        made = lambda i, change=change: replace(i, air_temperature_K=change(i.air_temperature_K))  # noqa: E731
        yield Wrong(f"tidal-flat.inputs.{name}", "tidal-flat", f"the surface is made with {words}", inputs=made)
    for name, change in (("tuple", lambda v: (v.number, v.temperature_K)), ("array", lambda v: v.number)):
        wrap = lambda provider, inputs, change=change: Changed(  # noqa: E731
            provider, surface=lambda *given: change(provider.surface(*given))
        )
        yield Wrong(f"floe.result.{name}", "floe", f"the result is a plain {name}", wrap)


def _ground(change):
    return lambda inputs: replace(inputs, ground=lambda *given: change(*inputs.ground(*given)))


def _place(change):
    return lambda inputs: replace(inputs, ground=lambda *given: inputs.ground(*change(*given)))
