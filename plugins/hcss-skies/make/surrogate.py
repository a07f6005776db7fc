"""Surrogate clouds: what borders leak, what iterations bring, what a frame costs beside a fractal one.

::

    python plugins/hcss-skies/make/surrogate.py

One thread. Made images; where the environment variable HCSS_SAMPLE_DATA names a folder of images, those too.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import tempfile
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from hcss_skies.surrogate.generator import SurrogateClouds
from hcss_skies.surrogate.parameters import SurrogateParameters
from hcss_skies.surrogate.template import periodic_component

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.providers import CloudGenerator, CloudInputs, Grid, Motion
from hcss_twin.testing.samples import sample_layer

WHOLE = slice(None)


def power_law(size: int, beta: float, seed: int) -> np.ndarray:
    """Return a normal field of unit variance (size, size) whose power falls as k^-beta."""
    frequency = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None, :])
    frequency[0, 0] = np.inf
    white = np.fft.rfft2(np.random.default_rng(seed).normal(size=(size, size)))
    field = np.fft.irfft2(white * frequency ** (-beta / 2), s=(size, size))
    return field / field.std()


def wavenumbers(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the wavenumbers along y and x, in cycles per image."""
    cycles = np.rint(np.fft.fftfreq(size) * size)
    ky, kx = np.meshgrid(cycles, cycles, indexing="ij")
    return ky, kx


def cross_excess(image: np.ndarray) -> float:
    """Return the power on the axes over that beside them at the same wavenumber, mean from 16 cycles up."""
    size = image.shape[0]
    power = np.abs(np.fft.fft2(image - image.mean())) ** 2
    ky, kx = wavenumbers(size)
    ring, on_axis = np.rint(np.hypot(ky, kx)), (kx == 0) | (ky == 0)
    ratios = [power[on_axis & (ring == k)].mean() / power[~on_axis & (ring == k)].mean() for k in range(16, size // 2)]
    return float(np.mean(ratios))


def octave_power(image: np.ndarray) -> np.ndarray:
    """Return the share of the variance in octaves of the wavenumber: 1 to 2 cycles, 2 to 4, ..."""
    image = np.asarray(image, dtype=np.float64)
    size = image.shape[0]
    ring = np.hypot(*wavenumbers(size))
    power = np.abs(np.fft.fft2(image - image.mean())) ** 2
    edges = 2.0 ** np.arange(int(np.log2(size)))
    return np.array([power[(ring >= low) & (ring < 2 * low)].sum() for low in edges]) / power.sum()


def surrogate(
    folder: Path, image: np.ndarray, coverage: float, evolution_s: float, wind_m_s: float = 0.0, **parameters: object
) -> SurrogateClouds:
    """Return surrogates of an image, which is saved in the folder."""
    np.save(folder / "image.npy", image)
    inputs = CloudInputs(
        sample_layer(coverage),
        Grid(*image.shape, 20.0),
        Motion(0.0, (wind_m_s, 0.0), evolution_s, 1.0),
        1,
        Catalog(base=folder),
    )
    given = SurrogateParameters.model_validate({"image": "image.npy", "method": "coverage", **parameters})
    return SurrogateClouds(inputs, given)


def leakage() -> None:
    """Print what borders leak into the spectral axes."""
    print("power on the axes over that beside them; 256 x 256 pixels cut from fields of 512 x 512, mean of 8")
    print(f"{'power law':>12}{'plain':>10}{'mirrored':>10}{'window':>10}{'periodic':>10}")
    window = np.outer(np.hanning(256), np.hanning(256))
    for beta in (2.5, 3.0, 3.5, 4.0):
        rows = []
        for seed in range(8):
            crop = power_law(512, beta, seed)[100:356, 60:316]
            mirrored = np.block([[crop, crop[:, ::-1]], [crop[::-1], crop[::-1, ::-1]]])
            kinds = (crop, mirrored, crop * window, periodic_component(crop))
            rows.append([cross_excess(kind) for kind in kinds])
        print(f"{-beta:>12g}" + "".join(f"{value:>10.2f}" for value in np.mean(rows, axis=0)))


def iterations(folder: Path) -> None:
    """Print what iterations bring, and how much frames then change."""
    print("\nspectral error (rms of ln over octaves, mean of 15 frames) | largest change between frames .005 of")
    print("evolution_time apart, of 150 (1: independent fields), all structures alike fast; 128 x 128 pixels, k^-3")
    print(f"{'iterations':>12}" + "".join(f"{f'coverage {c:g}':>22}" for c in (0.1, 0.3, 0.5, 0.8)))
    image = power_law(128, 3.0, 3)
    for count in (0, 1, 2, 3, 4, 5, 7, 10, 20, None):
        line = f"{'frozen' if count is None else count:>12}"
        for coverage in (0.1, 0.3, 0.5, 0.8):
            evolution = np.inf if count is None else 1000.0
            clouds = surrogate(folder, image, coverage, evolution, iterations=count, evolution_exponent=0.0)
            wanted = octave_power(periodic_component(clouds.template.thickness_m.astype(np.float64)))
            times = 5.0 * np.arange(1 if count is None else 150)
            frames = [clouds.thickness_m(time_s, WHOLE, WHOLE).astype(np.float64) for time_s in times]
            error = np.mean([np.sqrt(np.mean(np.log(octave_power(frame) / wanted) ** 2)) for frame in frames[::10]])
            changes = [np.mean((b - a) ** 2) / (2 * a.var()) for a, b in pairwise(frames)]
            line += f"{error:>14.3f}" + (f" | {max(changes):<5.3f}" if changes else " |      ")
        print(line)


def structures(folder: Path) -> None:
    """Print the same for both structures."""
    print("\nstructures: columns as in the table before, and ns per pixel of a frame; 256 x 256 pixels, coverage .5")
    image = power_law(256, 3.0, 3)
    for structure in ("spectrum", "bands"):
        clouds = surrogate(folder, image, 0.5, 1000.0, structure=structure, evolution_exponent=0.0)
        wanted = octave_power(periodic_component(clouds.template.thickness_m.astype(np.float64)))
        frames = [clouds.thickness_m(5.0 * n, WHOLE, WHOLE).astype(np.float64) for n in range(150)]
        error = np.mean([np.sqrt(np.mean(np.log(octave_power(frame) / wanted) ** 2)) for frame in frames[::10]])
        change = max(np.mean((b - a) ** 2) / (2 * a.var()) for a, b in pairwise(frames))
        print(f"{structure:>12}{error:>14.3f} | {change:<5.3f}{best_ns(clouds, 256):>12.0f}")


def measured(folder: Path) -> None:
    """Print it for measured images."""
    print("\nmeasured images: middle 400 x 400 pixels, cloud by Otsu's threshold. Cross as in the first table; ")
    print("spectral errors as in the second, at time 0, the worst of 12 times, frozen; power of the finest octave")
    print("over the image's, mean of 12 times, on whole pixels and moved by half a pixel along x")
    print(f"{'':<26}{'':>9}{'cross':>26}{'error':>24}{'finest octave':>16}")
    print(
        f"{'image':<26}{'coverage':>9}{'plain':>8}{'periodic':>10}{'window':>8}"
        f"{'first':>8}{'worst':>8}{'frozen':>8}{'whole':>8}{'half':>8}"
    )
    for path in sorted(path for path in folder.iterdir() if path.suffix in (".nc", ".jpg", ".png", ".npy")):
        size = min(400, *read_image(path).values.shape)
        inputs = CloudInputs(
            sample_layer(), Grid(size, size, 1000.0), Motion(0.0, (0.0, 0.0), 3600.0, 60.0), 1, Catalog(base=folder)
        )
        given = SurrogateParameters(image=path.name, missing="clear", reinterpret_pixel_size=True)
        clouds = SurrogateClouds(inputs, given)
        template = clouds.template.thickness_m.astype(np.float64)
        component = periodic_component(template)
        window = np.outer(np.hanning(size), np.hanning(size)) * (template - template.mean())
        crosses = [cross_excess(kind) for kind in (template, component, window)]
        wanted = octave_power(component)
        frozen = replace(inputs, motion=replace(inputs.motion, evolution_time_s=np.inf))
        frozen_ratio = octave_power(SurrogateClouds(frozen, given).thickness_m(0.0, WHOLE, WHOLE)) / wanted
        whole, half = [], []
        for time_s in 1000.0 * np.arange(12):
            whole.append(octave_power(clouds.thickness_m(time_s, WHOLE, WHOLE)) / wanted)
            if time_s:
                drift = replace(inputs.motion, cloud_velocity_m_s=(500.0 / time_s, 0.0))
                moved = SurrogateClouds(replace(inputs, motion=drift), given)
                half.append(octave_power(moved.thickness_m(time_s, WHOLE, WHOLE)) / wanted)
        errors = [float(np.sqrt(np.mean(np.log(ratio) ** 2))) for ratio in whole]
        print(
            f"{path.name[:25]:<26}{clouds.template.coverage:>9.2f}"
            f"{crosses[0]:>8.1f}{crosses[1]:>10.1f}{crosses[2]:>8.1f}"
            f"{errors[0]:>8.3f}{max(errors):>8.3f}{np.sqrt(np.mean(np.log(frozen_ratio) ** 2)):>8.3f}"
            f"{np.mean(whole, axis=0)[-1]:>8.2f}{np.mean(half, axis=0)[-1]:>8.2f}"
        )


def best_ns(clouds: CloudGenerator, size: int, repeats: int = 5) -> float:
    """Return the shortest time of a frame in ns per pixel; each frame is another one."""
    times = []
    for index in range(repeats):
        start = time.perf_counter()
        clouds.thickness_m(0.7 * index, WHOLE, WHOLE)
        times.append(time.perf_counter() - start)
    return min(times) / size**2 * 1e9


def timing(folder: Path) -> None:
    """Print what a frame costs."""
    print("\nns per pixel of a frame, one thread, platform and clouds moving by parts of a pixel")
    print(f"{'pixels':>12}{'fractal':>12}{'surrogate':>12}{'ratio':>8}{'frozen':>12}{'made in s':>12}")
    shape = FractalParameters(gamma=2.0, H=0.6, L=(2.0, 2.0), k=(0, 8))
    for size in (256, 512, 800, 1600):
        image = power_law(size, 3.0, 4)
        start = time.perf_counter()
        evolving = surrogate(folder, image, 0.5, 1800.0, wind_m_s=10.0)
        made = time.perf_counter() - start
        fractal = FractalClouds(
            CloudInputs(
                sample_layer(0.5),
                Grid(size, size, 20.0),
                Motion(0.0, (10.0, 0.0), 1800.0, 1.0),
                1,
                Catalog(base=folder),
            ),
            shape,
        )
        plain, ours = best_ns(fractal, size), best_ns(evolving, size)
        frozen = best_ns(surrogate(folder, image, 0.5, np.inf, wind_m_s=10.0), size)
        print(f"{size:>12}{plain:>12.0f}{ours:>12.0f}{ours / plain:>8.1f}{frozen:>12.0f}{made:>12.2f}")


def main() -> None:
    """Print all tables."""
    leakage()
    with tempfile.TemporaryDirectory() as name:
        iterations(Path(name))
        structures(Path(name))
        timing(Path(name))
    data = os.environ.get("HCSS_SAMPLE_DATA")
    if data:
        measured(Path(data) / "images")


if __name__ == "__main__":
    main()
