"""Small models of cloud fields, each from its own mechanism: heights p and x in m at 3 km per pixel, periodic.

Every function takes a random generator and shape parameters, and returns p, the height of an opaque cloud of the same
brightness temperature above a clear sky of 0 m, and x, the cloud top above it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, map_coordinates
from scipy.spatial import cKDTree

SIDE = 192
Field = NDArray[np.float64]


def wavenumbers() -> tuple[Field, Field]:
    """Return wavenumbers along y and x in cycles per pixel, for ``rfft2``."""
    return np.meshgrid(np.fft.fftfreq(SIDE), np.fft.rfftfreq(SIDE), indexing="ij")


def fractal(rng: np.random.Generator, exponent: float, longest: float = SIDE, stretch: float = 1.0) -> Field:
    """Return a normal field with a power spectrum k^-exponent along a line; longer than ``longest`` pixels, flat."""
    ky, kx = wavenumbers()
    k = np.hypot(ky * stretch, kx)
    amplitude = np.maximum(k, 1.0 / longest) ** (-0.5 * (exponent + 1.0))
    amplitude[0, 0] = 0.0
    field = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((SIDE, SIDE))) * amplitude, (SIDE, SIDE))
    return field / field.std()


def bent(field: Field, rng: np.random.Generator, pixels: float, longest: float = 48.0) -> Field:
    """Return a field carried by a random flow without divergence."""
    ky, kx = wavenumbers()
    psi = np.fft.rfft2(fractal(rng, 4.0, longest))
    moves = [np.fft.irfft2(2j * np.pi * sign * k * psi, (SIDE, SIDE)) for sign, k in ((1.0, kx), (-1.0, ky))]
    scale = pixels / np.sqrt(np.mean(moves[0] ** 2))
    y, x = np.mgrid[:SIDE, :SIDE]
    return map_coordinates(field, (y + scale * moves[0], x + scale * moves[1]), order=3, mode="grid-wrap")


def rank(field: Field) -> Field:
    """Return the share of pixels below each pixel, 0 to 1."""
    order = np.empty(field.size)
    order[np.argsort(field, axis=None)] = (np.arange(field.size) + 0.5) / field.size
    return order.reshape(field.shape)


def clear_sea(rng: np.random.Generator) -> Field:
    """Return the texture of clear sea and vapour: a standard deviation of 40 m, 0.26 K."""
    return 40.0 * fractal(rng, 1.8, 64.0)


def swift_hohenberg(
    rng: np.random.Generator, cell: float, forcing: float, quadratic: float, steps: int, across: float = 0.0
) -> Field:
    """Return convection cells of ``cell`` pixels (J. Swift and P. C. Hohenberg, Phys. Rev. A 15, 319, 1977).

    u_t = [r - (1 + del^2)^2] u + g u^2 - u^3 from noise; r varies slowly, ``across`` damps variation along x.
    """
    ky, kx = wavenumbers()
    square = (ky**2 + kx**2) * cell**2
    linear = -((1.0 - square) ** 2) - across * (kx * cell) ** 2
    local = forcing * (1.0 + 0.5 * fractal(rng, 3.0, 96.0))
    u, dt = 0.3 * rng.standard_normal((SIDE, SIDE)), 0.2
    for _ in range(steps):
        push = local * u + quadratic * u**2 - u**3 + 0.12 * rng.standard_normal((SIDE, SIDE))
        u = np.fft.irfft2((np.fft.rfft2(u + dt * push)) / (1.0 - dt * linear), (SIDE, SIDE))
    return u / u.std()


def polygons(rng: np.random.Generator, cell: float) -> Field:
    """Return distance from the walls of cells in units of the cell, which grow from random centres until they meet."""
    centres = SIDE * rng.random((round((SIDE / cell) ** 2), 2))
    y, x = np.mgrid[:SIDE, :SIDE] + 0.5
    points = np.stack([y.ravel(), x.ravel()], axis=1)
    for _ in range(2):  # cells of equal strength push their centres apart
        owner = cKDTree(centres, boxsize=SIDE).query(points)[1]
        away = (points - centres[owner] + SIDE / 2) % SIDE - SIDE / 2
        count = np.maximum(np.bincount(owner, minlength=len(centres)), 1)
        centres += 0.7 * np.stack([np.bincount(owner, each, len(centres)) / count for each in away.T], axis=1)
        centres %= SIDE
    near = cKDTree(centres, boxsize=SIDE).query(points, k=2)[0]
    return (near[:, 1] - near[:, 0]).reshape(SIDE, SIDE) / cell


def open_cells(rng: np.random.Generator, cell: float, cover: float) -> tuple[Field, Field]:
    """Return walls of cumulus around clear cells, as where cold pools collide; broken, with clusters at corners."""
    walls = bent(polygons(rng, cell), rng, 0.25 * cell, 4.0 * cell)
    wall = np.exp(-((walls / 0.28) ** 2)) * np.exp(0.6 * fractal(rng, 1.5, cell) + 0.6 * fractal(rng, 2.6, 96.0))
    height = np.clip((rank(wall + 0.02 * fractal(rng, 1.8, cell)) - (1.0 - cover)) / cover, 0.0, 1.0)
    p = 1800.0 * height**1.3 * (1.0 + 0.2 * fractal(rng, 2.0, 64.0)) + clear_sea(rng)
    return p, np.zeros_like(p)


def closed_cells(rng: np.random.Generator, cell: float, cover: float) -> tuple[Field, Field]:
    """Return cloud over cells, separated by cracks of sinking air that widen where the layer is thin."""
    distance = bent(polygons(rng, cell), rng, 0.3 * cell, 4.0 * cell)
    moist = fractal(rng, 2.8, 160.0)
    depth = distance * np.exp(0.3 * fractal(rng, 1.6, cell)) + 0.28 * moist + 0.07 * fractal(rng, 1.6, 2.0 * cell)
    edge = np.clip(rank(depth) - (1.0 - cover), 0.0, None)
    sheet = 1.0 - np.exp(-edge * 9.0)
    top = 1050.0 + 100.0 * fractal(rng, 2.8, 160.0) + 120.0 * np.minimum(distance, 0.6) + 35.0 * fractal(rng, 1.6, 24.0)
    p = sheet * top + clear_sea(rng)
    return p, np.zeros_like(p)


def streets(rng: np.random.Generator, roll: float, cover: float) -> tuple[Field, Field]:
    """Return rolls of convection along the wind with cumulus on them."""
    rolls = bent(swift_hohenberg(rng, roll, 0.3, 0.2, 200, across=0.25), rng, 0.4 * roll, 64.0)
    rough = 0.9 * rolls + 0.8 * fractal(rng, 1.7, 10.0, 1.8) + 0.9 * fractal(rng, 2.6, 160.0, 1.5)
    height = np.clip((rank(rough) - (1.0 - cover)) / cover, 0.0, 1.0)
    p = 1500.0 * np.tanh(1.6 * height) * (1.0 + 0.1 * fractal(rng, 2.0, 64.0)) + clear_sea(rng)
    return p, np.zeros_like(p)


def trade_cumulus(rng: np.random.Generator, clusters: int, largest: float) -> tuple[Field, Field]:
    """Return plumes around random centres, with a power law of sizes, more of them where air converges."""
    where = np.exp(1.3 * fractal(rng, 2.6, 96.0, 1.6))
    centres = rng.choice(SIDE * SIDE, clusters, p=(where / where.sum()).ravel())
    mask = np.zeros((SIDE, SIDE))
    for centre in centres:
        size = min(largest, 0.8 * (1.0 - rng.random()) ** (-1.0 / 1.7))
        plumes = rng.poisson(2.0 + 1.5 * size**1.5)
        y = (centre // SIDE + 1.1 * size * rng.standard_normal(plumes)).astype(int) % SIDE
        x = (centre % SIDE + 1.8 * size * rng.standard_normal(plumes)).astype(int) % SIDE
        np.add.at(mask, (y, x), rng.gamma(2.0, 0.5 + 0.25 * size, plumes))
    soft = gaussian_filter(mask, 0.7, mode="wrap") + 0.45 * gaussian_filter(mask, 2.2, mode="wrap")
    rough = bent(soft, rng, 1.0, 12.0) * np.exp(0.5 * fractal(rng, 1.8, 16.0))
    p = 2200.0 * (1.0 - np.exp(-np.clip(rough - 0.1, 0.0, None) * 0.9)) + clear_sea(rng)
    return p, np.zeros_like(p)


def stratus_sheet(rng: np.random.Generator, cover: float, cell: float) -> tuple[Field, Field]:
    """Return a sheet with the texture of turbulence, cells in relief, and breaks where it is thinnest."""
    relief = bent(swift_hohenberg(rng, cell, 0.2, 0.6, 80), rng, 2.0, 40.0)
    thick = fractal(rng, 2.7, 160.0) + 0.35 * fractal(rng, 1.8, 30.0) + 0.3 * relief
    edge = np.clip(rank(bent(thick, rng, 2.0, 24.0)) - (1.0 - cover), 0.0, None)
    sheet = 1.0 - np.exp(-edge * 14.0)
    p = sheet * (
        1000.0 + 180.0 * fractal(rng, 3.0, 192.0) + 45.0 * relief + 30.0 * fractal(rng, 1.6, 24.0)
    ) + clear_sea(rng)
    return p, np.zeros_like(p)


def cirrus_fibres(rng: np.random.Generator, length: float, cover: float) -> tuple[Field, Field]:
    """Return fall streaks: ice from random heads falls through sheared wind, which draws it out into fibres."""
    heads = np.clip(fractal(rng, 1.2, 8.0) + 0.7 * fractal(rng, 2.8, 96.0) - 0.6, 0.0, None) ** 1.5
    streak, spectrum = np.zeros((SIDE, SIDE)), np.fft.rfft2(heads)
    ky, kx = wavenumbers()
    # ice that fell for a time t is t + shear t^2 downwind and a little across; it sublimates
    for t in np.linspace(0.0, 3.0, 60):
        along, across = length * (0.35 * t + 0.2 * t**2), length * 0.1 * t**1.5
        streak += np.exp(-t) * np.fft.irfft2(spectrum * np.exp(-2j * np.pi * (kx * along + ky * across)), (SIDE, SIDE))
    fibres = bent(streak / streak.std(), rng, 4.0, 80.0) + 0.25 * fractal(rng, 1.9, 30.0, 3.0)
    sheet = 0.7 * fractal(rng, 2.8, 160.0, 1.8)
    depth = np.clip((rank(fibres + sheet) - (1.0 - cover)) / cover, 0.0, 1.0)
    top = 10_500.0 + 500.0 * fractal(rng, 3.0, 160.0)
    opacity = 1.0 - np.exp(-2.6 * depth**2.2)
    p = top * opacity + clear_sea(rng)
    return p, np.where(depth > 0.0, np.clip(top - p, 0.0, None), 0.0)


def anvils(rng: np.random.Generator, towers: int, shear: float) -> tuple[Field, Field]:
    """Return towers in the moist regions of an aggregating atmosphere, with anvils that spread and thin downwind.

    Moisture grows where it is high and diffuses (G. C. Craig and J. M. Mack, J. Geophys. Res. 118, 8761, 2013).
    """
    moisture = 0.5 + 0.25 * fractal(rng, 2.2, 64.0)
    for _ in range(60):
        moisture += 0.05 * moisture * (1.0 - moisture) * (moisture - moisture.mean()) * 8.0
        moisture = np.clip(gaussian_filter(moisture, 0.8, mode="wrap"), 0.0, 1.0)
    chance = np.exp(5.0 * rank(moisture)).ravel()
    depth = np.zeros((SIDE, SIDE))
    y, x = np.mgrid[:SIDE, :SIDE].astype(float)
    for centre in rng.choice(SIDE * SIDE, towers, p=chance / chance.sum()):
        age, strength = rng.random(), 1.5 * (1.0 - rng.random()) ** -0.5
        radius = min(2.0 + 3.5 * np.sqrt(age) * strength, 26.0)
        dy, dx = (
            (each - at + SIDE / 2) % SIDE - SIDE / 2
            for each, at in ((y, centre // SIDE), (x, centre % SIDE + shear * radius))
        )
        distance = np.hypot(dy, dx / (1.0 + abs(shear))) / radius
        depth += 3.0 * strength * (1.0 - 0.6 * age) * np.exp(-(distance**2) * 2.5)
    ragged = bent(depth, rng, 4.0, 40.0) * np.exp(0.6 * fractal(rng, 2.2, 48.0, 1.3))
    opacity = 1.0 - np.exp(-0.8 * np.clip(ragged - 0.2, 0.0, None))
    top = 12_500.0 + 500.0 * fractal(rng, 2.6, 64.0)
    low, _ = trade_cumulus(rng, 350, 3.0)
    p = np.maximum(top * opacity**1.2, low) + 350.0 * opacity * gaussian_filter(
        fractal(rng, 1.8, 20.0), 0.5, mode="wrap"
    )
    return p, np.where(opacity > 0.02, np.clip(top - p, 0.0, None), 0.0)


def altocumulus(rng: np.random.Generator, wave: float, cover: float) -> tuple[Field, Field]:
    """Return mid-level sheets that gravity waves break into rows, in patches."""
    ky, kx = wavenumbers()
    packet = np.exp(-(((np.abs(ky) * wave - 1.0) / 0.2) ** 2) - (kx * wave / 0.35) ** 2)
    rows = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((SIDE, SIDE))) * packet, (SIDE, SIDE))
    rows = bent(rows / rows.std(), rng, 3.0, 80.0)
    sheet = fractal(rng, 2.6, 128.0, 1.4) + 0.4 * fractal(rng, 1.8, 16.0)
    depth = np.clip((rank(bent(sheet, rng, 5.0, 64.0) + 0.35 * rows) - (1.0 - cover)) / cover, 0.0, 1.0)
    top = 5200.0 + 500.0 * fractal(rng, 3.0, 160.0)
    opacity = 1.0 - np.exp(-2.4 * depth)
    p = top * opacity * (1.0 + 0.05 * rows * np.sqrt(opacity)) + clear_sea(rng)
    return p, np.where(depth > 0.0, np.clip(top - p, 0.0, None), 0.0)


def multi_layer(rng: np.random.Generator, length: float, cover: float) -> tuple[Field, Field]:
    """Return cirrus above broken low cloud, and altocumulus between them."""
    low = streets(rng, 9.0, 0.45)[0] if rng.random() < 0.5 else closed_cells(rng, 8.0, 0.6)[0]
    middle, _ = altocumulus(rng, 7.0, 0.35)
    high, excess = cirrus_fibres(rng, length, cover)
    below = np.maximum(low, middle)
    # thin cirrus lets the warmth below through
    through = np.clip(1.0 - high / np.maximum(high + excess, 1.0), 0.0, 1.0)
    p = np.clip(high, 0.0, None) + through * below
    return p, np.where(high > 300.0, np.clip(high + excess - p, 0.0, None), 0.0)
