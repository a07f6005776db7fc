"""Small models of cloud fields, each from its own mechanism: heights p and x in m at 3 km per pixel.

Every function takes a random generator and shape parameters, and returns p, the height of an opaque cloud of the same
brightness temperature above a clear sky of 0 m, and x, the cloud top above it. Models are periodic; :func:`drawn_out`
then bends them by the wind, so that the fields are not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, map_coordinates, zoom
from scipy.spatial import cKDTree

SIDE = 256
SMOOTH, ROUGH = 6.5, 4.0  # exponents of the spectra of stream functions
Field = NDArray[np.float64]


def wavenumbers() -> tuple[Field, Field]:
    """Return wavenumbers along y and x in cycles per pixel, for ``rfft2``."""
    return np.meshgrid(np.fft.fftfreq(SIDE), np.fft.rfftfreq(SIDE), indexing="ij")


def fractal(
    rng: np.random.Generator, exponent: float, longest: float = SIDE, stretch: float = 1.0, angle: float = 0.0
) -> Field:
    """Return a normal field with a power spectrum k^-exponent along a line; longer than ``longest`` pixels, flat.

    It is drawn out by ``stretch`` along ``angle`` (rad, from x).
    """
    ky, kx = wavenumbers()
    along, across = np.cos(angle) * kx + np.sin(angle) * ky, np.cos(angle) * ky - np.sin(angle) * kx
    k = np.hypot(across, along * stretch)
    amplitude = np.maximum(k, 1.0 / longest) ** (-0.5 * (exponent + 1.0))
    amplitude[0, 0] = 0.0
    field = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((SIDE, SIDE))) * amplitude, (SIDE, SIDE))
    return field / field.std()


def flow(rng: np.random.Generator, pixels: float, longest: float, exponent: float) -> tuple[Field, Field]:
    """Return displacements along y and x of a random flow without divergence."""
    ky, kx = wavenumbers()
    psi = np.fft.rfft2(fractal(rng, exponent, longest))
    moves = [np.fft.irfft2(2j * np.pi * sign * k * psi, (SIDE, SIDE)) for sign, k in ((1.0, kx), (-1.0, ky))]
    scale = pixels / np.sqrt(np.mean(moves[0] ** 2))
    return scale * moves[0], scale * moves[1]


def bent(
    field: Field, rng: np.random.Generator, pixels: float, longest: float = 48.0, exponent: float = SMOOTH
) -> Field:
    """Return a field carried by a random flow without divergence; smooth with larger exponents."""
    dy, dx = flow(rng, pixels, longest, exponent)
    y, x = np.mgrid[:SIDE, :SIDE]
    return map_coordinates(field, (y + dy, x + dx), order=3, mode="grid-wrap")


def drawn_out(
    rng: np.random.Generator,
    *fields: Field,
    stretch: float = 1.5,
    angle: float = 0.0,
    pixels: float = 10.0,
    exponent: float = SMOOTH,
) -> list[Field]:
    """Return fields that a sheared wind drew out along ``angle`` (rad, from x), and that large eddies bent."""
    dy, dx = flow(rng, pixels, 160.0, exponent)
    y, x = np.mgrid[:SIDE, :SIDE] - 0.5 * SIDE
    along, across = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
    along, across = along / np.sqrt(stretch) + dx, across * np.sqrt(stretch) + dy
    at = (across * np.cos(angle) + along * np.sin(angle), along * np.cos(angle) - across * np.sin(angle))
    return [map_coordinates(field, at, order=3, mode="grid-wrap") for field in fields]


def rank(field: Field) -> Field:
    """Return the share of pixels below each pixel, 0 to 1."""
    order = np.empty(field.size)
    order[np.argsort(field, axis=None)] = (np.arange(field.size) + 0.5) / field.size
    return order.reshape(field.shape)


def smoothly_above(field: Field, cover: float, width: float) -> Field:
    """Return 0 outside of the highest part ``cover`` of a field, and a smooth rise to 1 inside over ``width`` of it."""
    level = field.std() * width
    above = np.clip(field - np.quantile(field, 1.0 - cover), 0.0, None) / level
    return 1.0 - np.exp(-above)


def clear_sea(rng: np.random.Generator, metres: float = 40.0, haze: float = 0.0) -> Field:
    """Return the texture of clear sea and vapour, and thin high cloud in places: 40 m are .26 K."""
    thin = np.clip(fractal(rng, 2.8, 160.0, 2.5) + 0.5, 0.0, None) ** 2
    return metres * fractal(rng, 2.2, 96.0) + haze * thin


def capped(depth: Field, width: float) -> Field:
    """Return the opacity of a layer under an inversion: cloud of any depth above ``width`` has the same top."""
    return 1.0 - np.exp(-np.clip(depth, 0.0, None) / width)


def seen(depth: Field, width: float) -> Field:
    """Return the opacity of pixels whose parts of a third of their side are ``capped``: gaps are narrower than 3 km."""
    parts = zoom(np.pad(depth, 2, mode="wrap"), 3, order=1, grid_mode=True, mode="grid-wrap")[6:-6, 6:-6]
    return capped(parts, width).reshape(SIDE, 3, SIDE, 3).mean(axis=(1, 3))


def under_veil(rng: np.random.Generator, low: Field, of: dict[str, float]) -> tuple[Field, Field]:
    """Return p and x of low cloud over the sea below a band of cirrus, fibres that the wind draws out with all else.

    x is 0 for the cirrus, too, which covers little: a second field would double the files.
    """
    angle = of["angle"] + 0.4
    fibres = fractal(rng, 2.8, 256.0, 2.0, angle) + 0.35 * fractal(rng, 1.9, 40.0, 3.0, angle)
    opacity = 0.9 * smoothly_above(fibres, of["veil"], 1.5) ** 1.5
    height = of["height"] * (1.0 + 0.06 * fractal(rng, 2.8, 160.0))
    low, opacity, height = drawn_out(rng, low, opacity, height, **_wind(of))
    opacity = np.clip(opacity, 0.0, 1.0)
    p = opacity * height + (1.0 - opacity) * (low + clear_sea(rng, **_sea(of)))
    return p, np.zeros_like(p)


def polygons(rng: np.random.Generator, size: Field, unequal: float) -> Field:
    """Return distance from the walls of cells in units of the cell, which grow from random centres until they meet.

    Cells are as wide as ``size`` says in their place, and push their centres apart (F. Glassmeier and G. Feingold,
    Proc. Natl. Acad. Sci. 114, 10578, 2017: networks of cells are Voronoi's). Stronger cells begin earlier: their lead
    has a standard deviation of ``unequal`` cells.
    """
    density = 1.0 / size**2
    first = rng.choice(SIDE * SIDE, round(density.sum()), p=(density / density.sum()).ravel())
    centres = np.stack([first // SIDE, first % SIDE], axis=1) + rng.random((first.size, 2))
    y, x = np.mgrid[:SIDE, :SIDE] + 0.5
    points = np.stack([y.ravel(), x.ravel()], axis=1)
    for _ in range(2):
        owner = cKDTree(centres % SIDE, boxsize=SIDE).query(points)[1]
        away = (points - centres[owner] + SIDE / 2) % SIDE - SIDE / 2
        count = np.maximum(np.bincount(owner, minlength=first.size), 1)
        centres += 0.6 * np.stack([np.bincount(owner, component, first.size) / count for component in away.T], axis=1)
    lead = unequal * size.ravel()[first] * rng.standard_normal(first.size)
    far, which = cKDTree(centres % SIDE, boxsize=SIDE).query(points, k=8)
    near = np.sort(far - lead[which], axis=1)
    return (near[:, 1] - near[:, 0]).reshape(SIDE, SIDE) / size


def cells(rng: np.random.Generator, cell: float, of: dict[str, float]) -> Field:
    """Return distance from the walls of ragged cells, ``cell`` pixels wide in the mean, wider in some regions."""
    size = cell * np.exp(of["sizes"] * fractal(rng, 3.0, 200.0))
    return bent(bent(polygons(rng, size, of["unequal"]), rng, 0.2 * cell, 5.0 * cell), rng, of["ragged"], 12.0, ROUGH)


def moisture(rng: np.random.Generator, of: dict[str, float]) -> Field:
    """Return moisture, which varies around ``regime`` by ``patchiness`` over hundreds of km, mostly at fronts."""
    return of["regime"] + of["patchiness"] * np.tanh(of["front"] * fractal(rng, 2.6, 200.0, 1.8, of["angle"]))


def open_cells(rng: np.random.Generator, **of: float) -> tuple[Field, Field]:
    """Return walls of cumulus around clear cells, as where cold pools collide, in a layer that closes elsewhere.

    With moisture below 0 the sky is clear, above 1 a sheet with cracks that close with more. Tops are at the inversion.
    """
    cell = of["cell"]
    distance, moist = np.clip(cells(rng, cell, of) / 0.45, 0.0, 1.0), moisture(rng, of)
    texture = of["rough"] * fractal(rng, 1.7, 1.5 * cell)
    open_depth = 0.4 - distance + 0.5 * (moist - 0.5) + texture
    closed_depth = distance + 0.6 * (moist - 1.2) - of["crack"] + texture
    closed = np.clip(2.0 * (moist - 0.75), 0.0, 1.0)
    opacity = capped((1.0 - closed) * open_depth + closed * closed_depth, of["width"])
    thin = 1.0 - of["lull"] * np.clip(fractal(rng, 2.6, 128.0, 1.8, of["angle"]), 0.0, 2.0)
    top = 1100.0 * (1.0 + of["slope"] * fractal(rng, 3.0, 200.0) + of["grain"] * fractal(rng, 1.3, 8.0))
    return under_veil(rng, opacity * thin * top, of)


def convective_layer(
    rng: np.random.Generator, cell: float, of: dict[str, float], rolls: Field | float = 0.0
) -> tuple[Field, Field]:
    """Return a layer that is deepest where air rises in the middle of cells, and thins to gaps where it sinks.

    Liquid water has its mesoscale variance from cells (R. Wood and D. L. Hartmann, J. Climate 19, 1748, 2006) and the
    spectrum of turbulence, k^-5/3, within (R. F. Cahalan and J. B. Snider, Remote Sens. Environ. 28, 95, 1989). Where
    moisture is low, gaps widen until cells are islands; where it is high, they close.
    """
    domes = np.clip(cells(rng, cell, of) / 0.7, 0.0, 1.0) ** of["dome"]
    depth = moisture(rng, of) + of["crack"] * (domes - 0.7) + rolls
    depth = depth + of["rough"] * fractal(rng, 1.7, of["eddies"] * cell, 1.5, of["angle"])
    top = 1.0 + of["slope"] * fractal(rng, 3.0, 200.0) + of["grain"] * fractal(rng, 1.7, 1.5 * cell)
    top = 1500.0 * (top + of["relief"] * np.clip(depth, 0.0, 3.0))
    low = seen(depth, of["width"]) * top
    if of["small"] > 0.0:  # clouds far smaller than a pixel, in rows
        low = low + of["small"] * np.exp(0.8 * fractal(rng, 1.6, 48.0, 1.8, of["angle"]))
    return under_veil(rng, low, of)


def closed_cells(rng: np.random.Generator, **of: float) -> tuple[Field, Field]:
    """Return cloud over cells, separated by cracks of sinking air that widen where the layer is thin."""
    return convective_layer(rng, of["cell"], of)


def _wind(shape: dict[str, float]) -> dict[str, float]:
    return {name: shape[name] for name in ("stretch", "angle", "pixels")}


def _sea(shape: dict[str, float]) -> dict[str, float]:
    return {"metres": shape["sea"], "haze": shape["haze"]}


def streets(rng: np.random.Generator, **of: float) -> tuple[Field, Field]:
    """Return clouds over cells in rows along the wind, as rolls of convection break up downstream.

    B. W. Atkinson and J. W. Zhang, Rev. Geophys. 34, 403, 1996. Rolls are of unequal strength and distance.
    """
    ky, kx = wavenumbers()
    roll, angle = of["roll"], of["angle"]
    along, across = np.cos(angle) * kx + np.sin(angle) * ky, np.cos(angle) * ky - np.sin(angle) * kx
    packet = np.exp(-(((np.abs(across) * roll - 1.0) / 0.5) ** 2) - (along * roll * of["length"]) ** 2)
    rolls = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((SIDE, SIDE))) * packet, (SIDE, SIDE))
    rolls = bent(rolls / rolls.std(), rng, 0.15 * roll, 6.0 * roll)
    return convective_layer(rng, of["puff"] * roll, of, of["rolls"] * rolls)


def trade_cumulus(rng: np.random.Generator, **of: float) -> tuple[Field, Field]:
    """Return plumes around random centres, with a power law of sizes, more of them where air converges."""
    where = np.exp(of["clustering"] * fractal(rng, 2.6, 128.0, 1.8, of["angle"]))
    centres = rng.choice(SIDE * SIDE, round(of["clusters"]), p=(where / where.sum()).ravel())
    mask = np.zeros((SIDE, SIDE))
    sizes = np.minimum(of["largest"], 0.8 * (1.0 - rng.random(centres.size)) ** (-1.0 / 1.7))
    plumes = rng.poisson(2.0 + 1.5 * sizes**1.5)
    plume_centres, size = np.repeat(centres, plumes), np.repeat(sizes, plumes)
    y = (plume_centres // SIDE + 1.2 * size * rng.standard_normal(plume_centres.size)).astype(int) % SIDE
    x = (plume_centres % SIDE + 1.4 * size * rng.standard_normal(plume_centres.size)).astype(int) % SIDE
    np.add.at(mask, (y, x), rng.gamma(2.0, 0.5 + 0.25 * size))
    soft = gaussian_filter(mask, of["soft"], mode="wrap") + of["halo"] * gaussian_filter(mask, 2.2, mode="wrap")
    rough = bent(soft, rng, of["ragged"], 12.0, ROUGH) * np.exp(of["rough"] * fractal(rng, 1.8, 16.0))
    # clouds far smaller than a pixel, in rows
    small = of["small"] * np.exp(0.8 * fractal(rng, 1.6, 48.0, 1.8, of["angle"]))
    return under_veil(rng, 2200.0 * capped(rough - of["least"], of["width"]) + small, of)


def anvils(rng: np.random.Generator, **of: float) -> tuple[Field, Field]:
    """Return towers in the moist regions of an aggregating atmosphere, with anvils that spread and thin downwind.

    Moisture grows where it is high and diffuses (G. C. Craig and J. M. Mack, J. Geophys. Res. 118, 8761, 2013).
    """
    moisture = 0.5 + 0.25 * fractal(rng, 2.2, 96.0)
    for _ in range(30):
        moisture += 0.8 * moisture * (1.0 - moisture) * (moisture - moisture.mean())
        moisture = np.clip(gaussian_filter(moisture, 1.1, mode="wrap"), 0.0, 1.0)
    chance = np.exp(5.0 * rank(moisture)).ravel()
    depth, shear = np.zeros((SIDE, SIDE)), of["shear"]
    y, x = np.mgrid[:SIDE, :SIDE].astype(float)
    for centre in rng.choice(SIDE * SIDE, round(of["towers"]), p=chance / chance.sum()):
        age, strength = rng.random(), 1.5 * (1.0 - rng.random()) ** -0.5
        radius = min(2.0 + 3.5 * np.sqrt(age) * strength, 30.0)
        dy, dx = (
            (coordinate - at + SIDE / 2) % SIDE - SIDE / 2
            for coordinate, at in ((y, centre // SIDE), (x, centre % SIDE + shear * radius))
        )
        distance = np.hypot(dy, dx / (1.0 + abs(shear))) / radius
        depth += 3.0 * strength * (1.0 - 0.6 * age) * np.exp(-(distance**2) * 2.5)
    outflow = of["outflow"] * np.clip(fractal(rng, 3.0, 200.0, 2.0) + 1.5 * (rank(moisture) - 0.5), 0.0, None)
    ragged = bent(depth + outflow, rng, 5.0, 48.0, ROUGH) * np.exp(of["rough"] * fractal(rng, 2.4, 64.0, 2.0))
    opacity = 1.0 - np.exp(-of["opacity"] * np.clip(ragged - 0.05, 0.0, None))
    top = 12_500.0 + 500.0 * fractal(rng, 2.6, 64.0)
    middle = smoothly_above(fractal(rng, 2.4, 128.0) + 0.8 * (rank(moisture) - 0.5), of["middle"], 0.7)
    low = smoothly_above(fractal(rng, 1.9, 64.0) + 0.4 * fractal(rng, 1.4, 10.0), 0.5, 0.5)
    opacity, top, middle, low = drawn_out(rng, opacity, top, middle, low, **_wind(of), exponent=ROUGH)
    opacity = np.clip(opacity, 0.0, 1.0)
    below = np.maximum(4500.0 * middle, of["low"] * low) + clear_sea(rng, **_sea(of))
    p = top * opacity**1.2 + (1.0 - opacity**1.2) * below
    p = p + of["bumps"] * opacity * gaussian_filter(fractal(rng, 1.8, 20.0), 0.5, mode="wrap")
    return p, np.where(opacity > 0.02, np.clip(top - p, 0.0, None), 0.0)
