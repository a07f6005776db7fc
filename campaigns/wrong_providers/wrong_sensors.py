"""Wrong sensors."""

from dataclasses import replace

import numpy as np
from changed import Changed, Wrong, on_argument, on_result

RADIANCE = {
    "double": ("doubled", lambda x: 2.0 * x),
    "half": ("halved", lambda x: 0.5 * x),
    "negative": ("with the other sign", lambda x: -x),
    "milliwatt": ("in mW", lambda x: 1e3 * x),
    "hemispherical": ("over the hemisphere, times pi", lambda x: np.pi * x),
    "over-pi": ("divided by pi", lambda x: x / np.pi),
    "per-cm2": ("per cm2", lambda x: 1e-4 * x),
    "transposed": ("with exchanged axes", lambda x: x.swapaxes(1, 2)),
    "rows-reversed": ("from the last row", lambda x: x[:, ::-1]),
    "columns-reversed": ("from the last column", lambda x: x[:, :, ::-1]),
    "bands-reversed": ("with exchanged bands", lambda x: x[::-1]),
    "first-band": ("the first band for all", lambda x: np.broadcast_to(x[:1], x.shape)),
    "band-mean": ("the mean over the bands", lambda x: np.broadcast_to(x.mean(0), x.shape)),
    "frame-mean": ("the mean over the frame", lambda x: np.broadcast_to(x.mean((1, 2), keepdims=True), x.shape)),
    "shifted": ("off by one column", lambda x: np.roll(x, 1, axis=2)),
    "shifted-rows": ("off by one row", lambda x: np.roll(x, 1, axis=1)),
    "last-row-lost": ("without the last row", lambda x: x * (np.arange(x.shape[1]) < x.shape[1] - 1)[:, None]),
    "complement": ("1 minus it", lambda x: 1.0 - x),
    "zero": ("0", np.zeros_like),
    "relative": ("over the frame's largest", lambda x: x / x.max()),
}

COUNTS = {
    "negative": ("with the other sign", lambda x: -x),
    "float": ("as a float", lambda x: x.astype(float)),
    "inverted": ("from the other end", lambda x: x.max() - x),
    "zero": ("0", np.zeros_like),
    "transposed": ("with exchanged axes", lambda x: x.swapaxes(1, 2)),
    "bands-reversed": ("with exchanged bands", lambda x: x[::-1]),
    "rows-reversed": ("from the last row", lambda x: x[:, ::-1]),
}

RATE = {
    "negative": ("with the other sign", lambda x: -x),
    "zero": ("0", np.zeros_like),
    "per-hour": ("per hour", lambda x: 3600.0 * x),
    "transposed": ("with exchanged axes", lambda x: x.swapaxes(1, 2)),
    "bands-reversed": ("with exchanged bands", lambda x: x[::-1]),
    "columns-reversed": ("from the last column", lambda x: x[:, :, ::-1]),
    "complement": ("of the darkness", lambda x: x.max() - x),
    "square": ("squared", np.square),
}

INPUTS = {
    "seed-dropped": ("one seed for all", lambda i: replace(i, seed=1)),
    "corner-dropped": ("the corner of the image", lambda i: replace(i, corner=(0, 0))),
    "corner-exchanged": ("row and column of the corner exchanged", lambda i: replace(i, corner=i.corner[::-1])),
    "bands-um": (
        "wavelengths in nm",
        lambda i: replace(i, bands=tuple(replace(band, wavelength_um=1e3 * band.wavelength_um) for band in i.bands)),
    ),
}


def wrong_providers():
    right = "counting"
    for part, table in (("radiance", RADIANCE), ("digital_number", COUNTS), ("photon_rate", RATE)):
        yield from on_result(
            right,
            "measure",
            table,
            pick=lambda value, part=part: getattr(value, part),
            put=lambda value, new, part=part: replace(value, **{part: new}),
            label=part,
        )
    yield from on_argument(
        right,
        "measure",
        1,
        "frame",
        {"dropped": ("ignored", lambda frame: 0), "half": ("in pairs", lambda frame: frame // 2)},
    )
    for name, (words, change) in INPUTS.items():
        yield Wrong(f"{right}.inputs.{name}", right, f"the sensor is made with {words}", inputs=change)
    inverted = lambda provider, inputs: Changed(  # noqa: E731
        provider, measure=lambda *given: _inverted(provider.measure(*given))
    )
    yield Wrong("counting.saturated.inverted", "counting", "saturated marks the pixels that are not", inverted)


def _inverted(measured):
    return replace(measured, saturated=(measured.saturated == 0).astype(np.uint8))
