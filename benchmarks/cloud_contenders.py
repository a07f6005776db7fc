"""Other ways to the same clouds, each as a function that makes frames and says how many pixels it made."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from cloud_scenes import MOTION, PIXEL_M, cells_per_pixel, make_generator, shape_of
from numba import njit

from hcss_twin.models.clouds.fractal.lattice import fill_row, plane_key
from hcss_twin.models.clouds.fractal.octaves import Octave

GSTOOLS_PIXELS = 4096
SLOW_FRAMES = 8


class Missing(Exception):
    """A package or function that a contender needs is not there."""


@dataclass(frozen=True)
class Contender:
    """One row of the table.

    Attributes
    ----------
    name, remark : str
        What it is, and what differs from ours.
    run : callable
        Makes its frames and returns the number of pixels made.
    """

    name: str
    remark: str
    run: Callable[[], int]


def contenders(kind: str, pixels: int, frames: int) -> tuple[list[Contender], list[str]]:
    """Return the rows that can run here, ours first, and a line for each that cannot."""
    makers: tuple[Callable[[str, int, int], Contender], ...] = (
        lambda *scene: field(*scene, threads=1),
        lambda *scene: field(*scene, threads=2),
        thickness,
        map_coordinates,
        fft_noise,
        fast_noise_lite,
        gstools_srf,
        standard_normal,
        hashed_normal,
        copied_plane,
    )
    found, missing = [], []
    for maker in makers:
        try:
            found.append(maker(kind, pixels, frames))
        except Missing as error:
            missing.append(str(error))
    return found, missing


def field(kind: str, pixels: int, frames: int, threads: int = 1) -> Contender:
    plane = np.empty((pixels, pixels), dtype=np.float32)

    def run() -> int:
        generator = make_generator(kind, pixels, threads=threads)
        window = slice(0, pixels)
        for frame in range(frames):
            generator.field(frame * MOTION.frame_interval_s, window, window, plane)
        return frames * pixels * pixels

    return Contender(f"ours, field V, {threads} thread{'s' if threads > 1 else ''}", "", run)


def thickness(kind: str, pixels: int, frames: int) -> Contender:
    def run() -> int:
        generator = make_generator(kind, pixels)
        window = slice(0, pixels)
        for frame in range(frames):
            generator.thickness_m(frame * MOTION.frame_interval_s, window, window)
        return frames * pixels * pixels

    return Contender("ours, thickness, 1 thread", "field, exact coverage and eq 7", run)


def map_coordinates(kind: str, pixels: int, frames: int) -> Contender:
    from scipy import ndimage

    frames = min(frames, SLOW_FRAMES)
    shape = shape_of(kind)
    octaves = list(range(shape["k"][0], shape["k"][1] + 1))
    white = [k for k in octaves if max(cells_per_pixel(shape, k, axis) for axis in (0, 1)) >= Octave.NEAREST_FROM]
    speed = (MOTION.platform_speed_m_s - MOTION.cloud_velocity_m_s[0]) / PIXEL_M

    def lattice(rng: np.random.Generator, octave: int) -> tuple[Any, tuple[float, float, float]]:
        per_t = shape["gamma"] ** octave / MOTION.evolution_time_s * MOTION.frame_interval_s
        per_x, per_y = (cells_per_pixel(shape, octave, axis) for axis in (0, 1))
        size = (
            math.ceil(per_t * frames) + 4,
            math.ceil(per_y * pixels) + 4,
            math.ceil(per_x * (pixels + speed * frames)) + 4,
        )
        return ndimage.spline_filter(rng.standard_normal(size), order=3), (per_t, per_y, per_x)

    def run() -> int:
        rng = np.random.default_rng(1)
        lattices = {k: lattice(rng, k) for k in octaves if k not in white}
        coordinates = np.empty((3, pixels, pixels))
        places = np.arange(pixels) + 0.5
        for frame in range(frames):
            total = np.zeros((pixels, pixels))
            for octave, (nodes, (per_t, per_y, per_x)) in lattices.items():
                coordinates[0] = 1.0 + per_t * frame
                coordinates[1] = (1.0 + per_y * places)[:, None]
                coordinates[2] = 1.0 + per_x * (places + speed * frame * MOTION.frame_interval_s)
                total += shape["gamma"] ** (-octave * shape["H"]) * ndimage.map_coordinates(
                    nodes, coordinates, order=3, prefilter=False
                )
            if white:
                power = sum(shape["gamma"] ** (-2.0 * octave * shape["H"]) for octave in white)
                total += math.sqrt(power) * rng.standard_normal((pixels, pixels))
        return frames * pixels * pixels

    told = f"{len(octaves)} octaves, cubic spline, 2-D + time, stored lattice"
    return Contender("scipy map_coordinates", told + (f"; octaves {white[0]}+ as white noise" if white else ""), run)


def fft_noise(kind: str, pixels: int, frames: int) -> Contender:
    from scipy import fft

    exponent = -(1.0 + shape_of(kind)["H"])
    frequency = np.hypot(fft.fftfreq(pixels)[:, None], fft.rfftfreq(pixels)[None, :]).astype(np.float32)
    frequency[0, 0] = np.inf
    amplitude = frequency**exponent

    def run() -> int:
        rng = np.random.default_rng(1)
        for _ in range(frames):
            white = fft.rfft2(rng.standard_normal((pixels, pixels), dtype=np.float32))
            fft.irfft2(white * amplitude, s=(pixels, pixels))
        return frames * pixels * pixels

    return Contender("scipy FFT of noise", "power law; frames have nothing to do with each other, edges repeat", run)


def fast_noise_lite(kind: str, pixels: int, frames: int) -> Contender:
    try:
        library = importlib.import_module("pyfastnoiselite.pyfastnoiselite")
    except ImportError as error:
        raise Missing("FastNoiseLite: package pyfastnoiselite is not installed") from error
    frames = min(frames, SLOW_FRAMES)
    shape = shape_of(kind)
    octaves = shape["k"][1] - shape["k"][0] + 1
    noise = library.FastNoiseLite(1)
    noise.noise_type = library.NoiseType.NoiseType_ValueCubic
    noise.fractal_type = library.FractalType.FractalType_FBm
    noise.fractal_octaves = octaves
    noise.fractal_lacunarity = shape["gamma"]
    noise.fractal_gain = shape["gamma"] ** -shape["H"]
    noise.frequency = 1.0
    per_x, per_y = (cells_per_pixel(shape, shape["k"][0], axis) for axis in (0, 1))

    def run() -> int:
        coordinates = np.empty((3, pixels, pixels), dtype=np.float32)
        places = np.arange(pixels) + 0.5
        for frame in range(frames):
            coordinates[0] = per_x * (places + 50.0 * frame)
            coordinates[1] = (per_y * places)[:, None]
            coordinates[2] = frame / MOTION.evolution_time_s
            noise.gen_from_coords(coordinates.reshape(3, -1))
        return frames * pixels * pixels

    return Contender("FastNoiseLite ValueCubic 3-D", f"{octaves} octaves; uniform nodes, variance not kept", run)


def gstools_srf(kind: str, pixels: int, frames: int) -> Contender:
    try:
        import gstools
    except ImportError as error:
        raise Missing("GSTools: package gstools is not installed") from error
    gstools.config.NUM_THREADS = 1
    cells = cells_per_pixel(shape_of(kind), 0, 0)
    model = gstools.Stable(dim=3, var=1.0, len_scale=1.0 / cells, alpha=2.0 * shape_of(kind)["H"])
    field = gstools.SRF(model, mode_no=1000, seed=1)
    edge = int(math.sqrt(GSTOOLS_PIXELS))
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(float(edge)), np.arange(float(edge))))
    time = np.zeros(x.size)

    def run() -> int:
        field((x, y, time), mesh_type="unstructured")
        return int(x.size)

    return Contender(
        "GSTools SRF, 1000 modes", f"measured on {edge} x {edge} pixels: its cost per pixel is constant", run
    )


def standard_normal(kind: str, pixels: int, frames: int) -> Contender:
    def run() -> int:
        rng = np.random.default_rng(1)
        for _ in range(frames):
            rng.standard_normal((pixels, pixels), dtype=np.float32)
        return frames * pixels * pixels

    return Contender("numpy standard_normal", "one float32 per pixel, no cloud", run)


def hashed_normal(kind: str, pixels: int, frames: int) -> Contender:
    plane = np.empty((pixels, pixels), dtype=np.float32)

    def run() -> int:
        for frame in range(frames):
            _fill(np.uint64(plane_key(1, 0, frame)), plane)
        return frames * pixels * pixels

    return Contender("floor: one lattice normal per pixel", "the project's own hash, no interpolation", run)


@njit(nogil=True)
def _fill(key: Any, plane: Any) -> None:
    bits = np.empty(plane.shape[1], np.uint32)
    for row in range(plane.shape[0]):
        fill_row(key, row, 0, plane[row], bits)


def copied_plane(kind: str, pixels: int, frames: int) -> Contender:
    # Ones: untouched zeros would all be one page of memory.
    source, target = (np.ones((pixels, pixels), dtype=np.float32) for _ in range(2))

    def run() -> int:
        for _ in range(frames):
            np.copyto(target, source)
        return frames * pixels * pixels

    return Contender("floor: copying a float32 plane", "", run)
