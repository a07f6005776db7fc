"""Wrong variables."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from changed import Changed, Wrong, on_argument
from wrong_clouds import TIME

VALUES = {
    "double": ("doubled", lambda x: 2.0 * x),
    "half": ("halved", lambda x: 0.5 * x),
    "negative": ("with the other sign", lambda x: -x),
    "percent": ("in percent", lambda x: 100.0 * x),
    "from-percent": ("divided by 100", lambda x: 0.01 * x),
    "km": ("divided by 1000", lambda x: 1e-3 * x),
    "complement": ("1 minus it", lambda x: 1.0 - x),
    "square": ("squared", np.square),
    "root": ("its square root", np.sqrt),
    "log": ("its logarithm", np.log),
    "radians": ("in radians", np.radians),
    "kelvin": ("plus 273.15", lambda x: x + 273.15),
    "celsius": ("less 273.15", lambda x: x - 273.15),
    "transposed": ("with exchanged axes", lambda x: x.swapaxes(-1, -2)),
    "rows-reversed": ("from the last row", lambda x: x[..., ::-1, :]),
    "rolled": ("off by one column", lambda x: np.roll(x, 1, axis=-1)),
    "mean": ("the mean for all", lambda x: np.full_like(x, np.nanmean(x))),
    "relative": ("over the largest", lambda x: x / np.nanmax(x)),
    "zero": ("0", np.zeros_like),
    "missing": ("missing", lambda x: np.full_like(x, np.nan)),
    "present": ("0 where missing or negative", lambda x: np.where(x > 0.0, x, 0.0)),
    "integer": ("as an integer", lambda x: np.nan_to_num(x).astype(np.int32)),
    "text": ("as text", lambda x: x.astype(str)),
    "other-shape": ("with one axis more", lambda x: x[None]),
    "first-row": ("the first row for all", lambda x: np.broadcast_to(x[..., :1, :], x.shape)),
    "last-row-lost": ("without the last row", lambda x: x[..., :-1, :]),
}

BANDS = {
    "bands-reversed": ("with exchanged bands", lambda x: x[::-1]),
    "first-band": ("the first band for all", lambda x: np.broadcast_to(x[:1], x.shape)),
    "band-mean": ("the mean over the bands", lambda x: np.broadcast_to(x.mean(0), x.shape)),
    "one-band": ("the first band only", lambda x: x[0]),
}

FLAG = {
    "from-1": ("counted from 1", lambda x: x + np.uint8(1)),
    "exchanged": ("of the other meaning", lambda x: np.uint8(1) - x),
    "mask": ("as 0 and 255", lambda x: np.uint8(255) * x),
    "float": ("as a float", lambda x: x.astype(float)),
    "transposed": ("with exchanged axes", lambda x: x.T),
    "zero": ("0", np.zeros_like),
    "rows-reversed": ("from the last row", lambda x: x[::-1]),
    "rolled": ("off by one column", lambda x: np.roll(x, 1, axis=1)),
    "last-row-lost": ("without the last row", lambda x: x[:-1]),
}

ANGLE = {
    "radians": ("taken for radians", np.degrees),
    "degrees": ("in radians", np.radians),
    "complement": ("as an elevation", lambda x: 90.0 - x),
    "negative": ("with the other sign", lambda x: -x),
    "dropped": ("0", np.zeros_like),
    "double": ("doubled", lambda x: 2.0 * x),
}

DEPTH = {
    "km": ("in km", lambda x: 1e-3 * x),
    "double": ("doubled", lambda x: 2.0 * x),
    "half": ("halved", lambda x: 0.5 * x),
    "negative": ("with the other sign", lambda x: -x),
    "dropped": ("the mean for all", lambda x: np.full_like(x, x.mean())),
    "transposed": ("with exchanged axes", lambda x: x.swapaxes(-1, -2)),
    "rolled": ("off by one column", lambda x: np.roll(x, 1, axis=-1)),
}

KELVIN = {
    "celsius": ("in degrees Celsius", lambda x: x - 273.15),
    "bands-reversed": ("with exchanged bands", lambda x: x[::-1]),
    "first-band": ("of the first band", lambda x: np.broadcast_to(x[:1], x.shape)),
    "double": ("doubled", lambda x: 2.0 * x),
    "negative": ("with the other sign", lambda x: -x),
    "rolled": ("off by one row", lambda x: np.roll(x, 1, axis=-2)),
    "integer": ("in whole kelvins", np.rint),
}

ABOUT = {
    "units-words": ("units in words", lambda v: _about(v, units="Watts per square metre")),
    "units-misspelt": ("misspelt units", lambda v: _about(v, units="kelvn")),
    "may-not-be-missing": ("no missing values", lambda v: _about(v, may_be_missing=False)),
    "integer": ("an integer type", lambda v: _about(v, may_be_missing=False, dtype="int16")),
    "below": ("an upper limit that is too low", lambda v: _about(v, highest=1e-3, lowest=0.0)),
    "per-band": (
        "one value per band",
        lambda v: {n: replace(each, per_band=not each.per_band) for n, each in v.items()},
    ),
    "renamed": ("other names", lambda v: {f"my_{name}": each for name, each in v.items()}),
    "capitals": ("names in capitals", lambda v: {name.upper(): each for name, each in v.items()}),
    "first-lost": ("one variable less", lambda v: dict(list(v.items())[1:])),
    "names": ("names alone", list),
}

NEEDS = {
    "more": ("one more", lambda needs: (*needs, "shadow_mask")),
    "lost": ("one less", lambda needs: needs[:-1]),
    "unknown": ("one that does not exist", lambda needs: (*needs[:-1], "cloud_height")),
    "list": ("a list", list),
}


def _about(variables, **changes):
    return {name: replace(each, **changes) for name, each in variables.items()}


def on_variable(right, variable, table):
    """Wrong providers with each change of ``table`` in one variable."""
    for name, (words, change) in table.items():

        def wrap(provider, inputs, change=change):
            def values(fields, time_s):
                result = dict(provider.values(fields, time_s))
                return {**result, variable: change(np.asarray(result[variable]))}

            return Changed(provider, values=values)

        yield Wrong(f"{right}.{variable}.{name}", right, f"{variable} is returned {words}", wrap)


def on_field(right, field, table):
    """Wrong providers with each change of ``table`` in one input."""
    for name, (words, change) in table.items():

        def made(fields, change=change):
            return {**fields, field: change(fields[field])} if isinstance(fields, Mapping) else fields

        wrap = lambda provider, inputs, made=made: Changed(  # noqa: E731
            provider, values=lambda fields, time_s: provider.values(made(fields), time_s)
        )
        yield Wrong(f"{right}.field-{field}.{name}", right, f"{field} is taken {words}", wrap)


def exchanged(right, one, other):
    def wrap(provider, inputs):
        def values(fields, time_s):
            return provider.values({**fields, one: fields[other], other: fields[one]}, time_s)

        return Changed(provider, values=values)

    return Wrong(f"{right}.exchanged.{one}-{other}", right, f"{one} and {other} are exchanged", wrap)


def _but(table, *names):
    """Leave out changes that change nothing here."""
    return {name: each for name, each in table.items() if name not in names}


def wrong_providers():
    """Return all of them."""
    yield from on_variable("slant", "cloud_path", VALUES)
    yield from on_variable("slant", "glint_angle", _but(VALUES, "present"))
    yield from on_variable("split-window", "split_window_difference", VALUES)
    yield from on_variable("split-window", "split_window_class", FLAG)
    yield from on_variable("solar-time", "solar_time", _but(VALUES, "present"))
    yield from on_variable("cloud-emissivity", "slant_emissivity", _but(VALUES, "present") | BANDS)
    for field in ("view_zenith", "sun_zenith"):
        yield from on_field("slant", field, ANGLE)
    yield from on_field("slant", "cloud_thickness", DEPTH)
    yield from on_field("cloud-emissivity", "cloud_optical_thickness", DEPTH | BANDS)
    yield from on_field("cloud-emissivity", "radiance", DEPTH | BANDS)
    yield from on_field("solar-time", "longitude", ANGLE)
    # A difference of temperatures is the same in degrees Celsius.
    yield from on_field("split-window", "brightness_temperature", _but(KELVIN, "celsius"))
    yield from on_field("in-celsius", "brightness_temperature", KELVIN)
    yield exchanged("slant", "view_zenith", "sun_zenith")
    yield exchanged("slant", "view_zenith", "view_azimuth")
    yield exchanged("slant", "sun_zenith", "sun_azimuth")
    yield from on_argument("solar-time", "values", 1, "time_s", TIME)
    for right in ("slant", "in-celsius"):
        for name, (words, change) in ABOUT.items():
            if (right, name) not in (("in-celsius", "may-not-be-missing"),):
                wrap = lambda provider, inputs, change=change: Changed(  # noqa: E731
                    provider, variables=change(provider.variables)
                )
                yield Wrong(f"{right}.variables.{name}", right, f"the variables are declared with {words}", wrap)
    for name, (words, change) in NEEDS.items():
        wrap = lambda provider, inputs, change=change: Changed(provider, needs=change(provider.needs))  # noqa: E731
        yield Wrong(f"slant.needs.{name}", "slant", f"needs: {words}", wrap)
    reverse = lambda inputs: replace(inputs, bands=inputs.bands[::-1])  # noqa: E731
    yield Wrong("split-window.inputs.bands-reversed", "split-window", "made with exchanged bands", inputs=reverse)
    first = lambda provider, inputs: Changed(  # noqa: E731
        provider, values=lambda fields, time_s: next(iter(provider.values(fields, time_s).values()))
    )
    yield Wrong("slant.result.array", "slant", "the result is a plain array", first)
