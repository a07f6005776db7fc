"""Wrong cloud generators."""

from dataclasses import replace

import numpy as np
from changed import Wrong, on_argument, on_result

THICKNESS = {
    "double": ("doubled", lambda x: 2.0 * x),
    "half": ("halved", lambda x: 0.5 * x),
    "km": ("in km", lambda x: 1e-3 * x),
    "cm": ("in cm", lambda x: 100.0 * x),
    "negative": ("with the other sign", lambda x: -x),
    "complement": ("as the sky between the clouds", lambda x: np.where(x > 0, 0, 400).astype(np.float32)),
    "thin-for-thick": ("thin for thick", lambda x: np.where(x > 0, 850 - x, 0).astype(np.float32)),
    "transposed": ("with exchanged axes", lambda x: x.T),
    "rows-reversed": ("from the last row", lambda x: x[::-1]),
    "columns-reversed": ("from the last column", lambda x: x[:, ::-1]),
    "first-row": ("the first row for all", lambda x: np.broadcast_to(x[:1], x.shape)),
    "first-column": ("the first column for all", lambda x: np.broadcast_to(x[:, :1], x.shape)),
    "last-row-lost": ("without the last row", lambda x: np.concatenate((x[:-1], 0 * x[-1:]))),
    "first-column-lost": ("without the first column", lambda x: np.concatenate((0 * x[:, :1], x[:, 1:]), axis=1)),
    "mask": ("as 0 and 1", lambda x: (x > 0).astype(np.float32)),
    "even": ("the mean for all cloud", lambda x: np.where(x > 0, x.mean(), 0).astype(np.float32)),
    "double-precision": ("as float64", lambda x: x.astype(np.float64)),
    "floor": ("plus the base of the layer", lambda x: x + 1000),
    "floor-under-cloud": ("as the cloud top", lambda x: np.where(x > 0, x + 1000, 0).astype(np.float32)),
}

TIME = {
    "double": ("doubled", lambda t: 2.0 * t),
    "half": ("halved", lambda t: 0.5 * t),
    "negative": ("with the other sign", lambda t: -t),
    "dropped": ("ignored", lambda t: 0.0),
    "ms": ("in ms", lambda t: 1e3 * t),
    "minutes": ("in minutes", lambda t: t / 60.0),
    "hours": ("in hours", lambda t: t / 3600.0),
}


def moved(by):
    return lambda span: slice(span.start + by, span.stop + by)


WINDOW = {
    "shifted": ("off by one", moved(1)),
    "start-dropped": ("from the start of the image", lambda span: slice(0, span.stop - span.start)),
    "stop-included": ("with the stop included", lambda span: slice(span.start, span.stop + 1)),
    "stop-lost": ("without the last", lambda span: slice(span.start, max(span.stop - 1, span.start + 1))),
}


def layer(**changes):
    def change(inputs):
        new = {name: make(getattr(inputs.layer, name)) for name, make in changes.items()}
        return replace(inputs, layer=replace(inputs.layer, **new))

    return change


def motion(**changes):
    def change(inputs):
        new = {name: make(getattr(inputs.motion, name)) for name, make in changes.items()}
        return replace(inputs, motion=replace(inputs.motion, **new))

    return change


def grid(**changes):
    def change(inputs):
        new = {name: make(getattr(inputs.grid, name)) for name, make in changes.items()}
        return replace(inputs, grid=replace(inputs.grid, **new))

    return change


INPUTS = {
    "coverage-complement": ("1 minus the coverage", layer(coverage=lambda c: 1.0 - c)),
    "coverage-half": ("half the coverage", layer(coverage=lambda c: 0.5 * c)),
    "coverage-square": ("the coverage squared", layer(coverage=lambda c: c**2)),
    "coverage-percent": ("the coverage taken for percent", layer(coverage=lambda c: 0.01 * c)),
    "coverage-dropped": ("half coverage always", layer(coverage=lambda c: 0.5)),
    "top-in-km": ("the top in km", layer(top_m=lambda top: 1e-3 * top)),
    "top-double": ("twice the top", layer(top_m=lambda top: 2.0 * top)),
    "base-dropped": ("the base at the sea", layer(base_m=lambda base: 0.0)),
    "minimum-dropped": ("no minimum thickness", layer(thickness_min_m=lambda t: 0.0)),
    "minimum-double": ("ten times the minimum thickness", layer(thickness_min_m=lambda t: 10.0 * t)),
    "minimum-half": ("half the minimum thickness", layer(thickness_min_m=lambda t: 0.5 * t)),
    "base-for-minimum": ("the greatest thickness for the least", layer(thickness_min_m=lambda t: 790.0)),
    "platform-km-h": ("platform speed in km/h", motion(platform_speed_m_s=lambda v: 3.6 * v)),
    "platform-knots": ("platform speed in knots", motion(platform_speed_m_s=lambda v: 1.944 * v)),
    "platform-negative": ("the platform backward", motion(platform_speed_m_s=lambda v: -v)),
    "platform-dropped": ("the platform at rest", motion(platform_speed_m_s=lambda v: 0.0)),
    "wind-exchanged": ("x and y of the wind exchanged", motion(cloud_velocity_m_s=lambda v: v[::-1])),
    "wind-negative": ("the bearing the wind comes from", motion(cloud_velocity_m_s=lambda v: (-v[0], -v[1]))),
    "wind-x-negative": ("the other sign of the wind along x", motion(cloud_velocity_m_s=lambda v: (-v[0], v[1]))),
    "wind-y-negative": ("the other sign of the wind along y", motion(cloud_velocity_m_s=lambda v: (v[0], -v[1]))),
    "wind-dropped": ("no wind", motion(cloud_velocity_m_s=lambda v: (0.0, 0.0))),
    "wind-y-dropped": ("no wind along y", motion(cloud_velocity_m_s=lambda v: (v[0], 0.0))),
    "wind-double": ("twice the wind", motion(cloud_velocity_m_s=lambda v: (2.0 * v[0], 2.0 * v[1]))),
    "pixel-double": ("twice the pixel size", grid(pixel_size_m=lambda p: 2.0 * p)),
    "pixel-half": ("half the pixel size", grid(pixel_size_m=lambda p: 0.5 * p)),
    "pixel-km": ("the pixel size in km", grid(pixel_size_m=lambda p: 1e-3 * p)),
    "pixel-dropped": ("a pixel size of 1 m", grid(pixel_size_m=lambda p: 1.0)),
    "seed-dropped": ("one seed for all", lambda inputs: replace(inputs, seed=1)),
    "seed-coarse": ("every hundred seeds alike", lambda inputs: replace(inputs, seed=inputs.seed // 100)),
}


def wrong_providers():
    right = "fractal-sky"
    yield from on_result(right, "thickness_m", THICKNESS)
    yield from on_argument(right, "thickness_m", 0, "time_s", TIME)
    yield from on_argument(right, "thickness_m", 1, "rows", WINDOW)
    yield from on_argument(right, "thickness_m", 2, "columns", WINDOW)
    for name, (words, change) in INPUTS.items():
        yield Wrong(f"{right}.inputs.{name}", right, f"the generator is made with {words}", inputs=change)
