"""Recipe of the cases of ``hcss bench cases``: clouds, optics, plane-parallel columns, and Monte Carlo radiance.

    python plugins/hcss-light/benchmarks/cases.py                      # writes all cases
    python plugins/hcss-light/benchmarks/cases.py step-night           # writes some
    python plugins/hcss-light/benchmarks/cases.py --check step-night   # Monte Carlo with other photons, and compares
    python plugins/hcss-light/benchmarks/cases.py --gradient           # emission with a gradient of temperature

Clouds are powers of random waves, droplets and ice those of Mie theory (miepython) with the refractive indices of the
catalog, and the radiance of uniform columns is that of discrete ordinates (PythonicDISORT): nothing of it comes from
the models that the cases judge. Monte Carlo is :mod:`hcss_light.monte_carlo`. All eight take about ten minutes of
processor time.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import miepython
import netCDF4
import numpy as np
from hcss_light.cases.case import FOLDER, Case, load_case, read_case
from hcss_light.monte_carlo import radiance
from hcss_light.source import Direction
from hcss_light.voxels import Voxels
from numpy.typing import NDArray
from PythonicDISORT.pydisort import pydisort
from PythonicDISORT.subroutines import interpolate

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.refractive_index import load_refractive_index

Array = NDArray[np.float64]

SEA_K, LAPSE_K_M = 290.0, 0.007
"""Temperature at altitude 0, and by how much a metre of height is colder."""

IRRADIANCE = {3.7: 11.0}
"""Of the sun, W m-2 um-1; it is left out in the other thermal bands."""

DROPLET_UM = 10.0
"""Effective radius."""

STREAMS, MOMENTS = 64, 400
"""Of discrete ordinates (32 are off by up to 5 % in thin clouds), and how many Legendre moments are written."""

ANGLES_DEG = np.concatenate((np.arange(0.0, 15.0, 0.25), np.arange(15.0, 180.5, 1.0)))
"""Scattering angles at which phase functions are given."""

NIGHT_VIEWS = Direction(0.0, 0.0), Direction(60.0, 30.0)


@dataclass(frozen=True)
class Particles:
    """Properties (B,) of one kind, and its phase function (B, A) at cosines (A,)."""

    relative: Array
    albedo: Array
    phase: Array


@dataclass(frozen=True)
class Layer:
    """Clouds of one kind: amounts that uniform columns may have, and which each pixel (X, Y) has."""

    base_m: float
    level_m: float
    particles: str
    profiles: Array
    """Extinction (N, Z) of the columns; the first is clear."""
    chosen: NDArray[np.int64]


def cosines() -> Array:
    """Return the cosines of the scattering angles, ascending from -1 to 1."""
    cosine = np.cos(np.radians(ANGLES_DEG[::-1]))
    cosine[0], cosine[-1] = -1.0, 1.0
    return cosine


def moments_of(cosine: Array, phase: Array) -> Array:
    """Return the Legendre moments of a function that is linear between its points."""
    # Three nodes of Gauss in parts of each interval integrate the highest polynomial exactly enough.
    node, weight = np.polynomial.legendre.leggauss(12)
    half, middle = 0.5 * np.diff(cosine), 0.5 * (cosine[1:] + cosine[:-1])
    place, share = (middle[:, None] + half[:, None] * node).ravel(), (half[:, None] * weight).ravel()
    value = share * np.interp(place, cosine, phase)
    before, now, result = np.ones_like(place), place.copy(), [np.sum(value), np.sum(value * place)]
    for degree in range(1, MOMENTS - 1):
        before, now = now, ((2 * degree + 1) * place * now - degree * before) / (degree + 1)
        result.append(np.sum(value * now))
    return np.array(result) / result[0]


def indices(table: str, wavelengths_um: Sequence[float]) -> list[complex]:
    """Return the refractive indices n - ik of a table of the catalog."""
    index = load_refractive_index(Catalog(), table)
    n, k = (np.interp(wavelengths_um, index.wavelength_um, values) for values in (index.n, index.k))
    return list(n - 1j * k)


def spheres(refractive: Sequence[complex], radius_um: float, wavelengths_um: Sequence[float]) -> Particles:
    """Return spheres of an effective radius and refractive indices, with effective variance .1, by Mie theory."""
    radius, step = np.linspace(0.1, 3.5, 60, retstep=True)
    number = radius ** (1.0 / 0.1 - 3.0) * np.exp(-radius / 0.1) * step
    relative, albedo, phases = [], [], []
    for index, wavelength in zip(refractive, wavelengths_um, strict=True):
        cosine, extinct, scattered, area = cosines(), 0.0, 0.0, 0.0
        phase = np.zeros_like(cosine)
        for r, count in zip(radius * radius_um, number, strict=True):
            x = 2.0 * np.pi * r / wavelength
            extinction, scattering, _, _ = miepython.efficiencies_mx(index, x)
            area += count * r**2
            extinct += count * r**2 * extinction
            scattered += count * r**2 * scattering
            phase += count * r**2 * scattering * miepython.i_unpolarized(index, x, cosine, norm="4pi")
        relative.append(extinct / (2.0 * area))
        albedo.append(scattered / extinct)
        phases.append(phase / (0.5 * np.trapezoid(phase, cosine)))
    return Particles(np.array(relative), np.array(albedo), np.array(phases))


def particles_of(name: str, wavelengths_um: Sequence[float]) -> Particles:
    """Return the particles of this name at some wavelengths."""
    if name == "published":
        return Particles(np.ones(2), np.array([1.0, 0.99]), np.stack([_tabulated(0.85)] * 2))
    if name == "droplets":
        return spheres(indices("water-segelstein", wavelengths_um), DROPLET_UM, wavelengths_um)
    ice = spheres(indices("ice", wavelengths_um), 30.0, wavelengths_um)
    asymmetry = [0.5 * np.trapezoid(phase * cosines(), cosines()) for phase in ice.phase]
    return replace(ice, phase=np.stack([_tabulated(g) for g in asymmetry]))


def _tabulated(asymmetry: float) -> Array:
    """Return Henyey and Greenstein's function at the cosines, with the mean 1 of its table."""
    phase = (1.0 - asymmetry**2) / (1.0 + asymmetry**2 - 2.0 * asymmetry * cosines()) ** 1.5
    return np.asarray(phase / (0.5 * np.trapezoid(phase, cosines())))


def waves(points: int, seed: int, power: float) -> Array:
    """Return a periodic random field whose spectrum falls with a power of the wave number."""
    number = np.hypot(*np.meshgrid(*[np.fft.fftfreq(points, 1.0 / points)] * 2))
    number[0, 0] = np.inf
    field = np.fft.ifft2(np.fft.fft2(np.random.default_rng(seed).standard_normal((points, points))) * number**-power)
    return np.asarray(field.real / np.std(field.real))


def heaps(base_m: float, level_m: float, levels: int, extinction_m1: float, cover: float, seed: int,
          points: int = 40, power: float = 1.8) -> Layer:  # fmt: skip
    """Return water clouds with a flat base and as many levels as random waves are high above a threshold."""
    field = waves(points, seed, power)
    height = field - np.quantile(field, 1.0 - cover)
    chosen = np.ceil(levels * np.clip(height / np.max(height), 0.0, 1.0) - 1e-12).astype(np.int64)
    profiles = extinction_m1 * np.tri(levels + 1, levels, -1)
    return Layer(base_m, level_m, "droplets", profiles, chosen)


def anvil(points: int, seed: int) -> Layer:
    """Return ice of 0, 400, 700 or 1000 m thickness above 8 km."""
    field = waves(points, seed, 2.0)
    chosen = np.searchsorted(np.quantile(field, [0.4, 0.6, 0.8]), field.ravel()).reshape(field.shape)
    thickness = np.array([0, 4, 7, 10])
    profiles = 1.5e-3 * (np.arange(10) < thickness[:, None])
    return Layer(8000.0, 100.0, "ice", profiles, chosen)


def step(base_m: float, levels: int, particles: str) -> Layer:
    """Return the step cloud of the Intercomparison of 3D Radiation Codes: 250 m, optical thickness 2 and 18."""
    amounts = np.array([0.0, 0.5, 1.0, 2.0, 4.0, 7.0, 11.0, 18.0])
    profiles = np.repeat(amounts[:, None] / 250.0, levels, axis=1)
    return Layer(base_m, 250.0 / levels, particles, profiles, np.repeat([3, 7], 16)[:, None])


@dataclass(frozen=True)
class Recipe:
    """What a case consists of."""

    summary: str
    layers: tuple[Layer, ...]
    pixel_m: float
    wavelengths_um: tuple[float, float]
    photons: tuple[int, int]
    """For each pixel and view, by band."""
    views: tuple[Direction, ...] = NIGHT_VIEWS
    sun: Direction | None = None


def recipes() -> dict[str, Recipe]:
    """Return all cases by name; clouds, views and photons were chosen before any was computed."""
    stratocumulus = heaps(600.0, 25.0, 16, 0.04, 0.7, 1)
    cumulus = heaps(800.0, 60.0, 20, 0.03, 0.3, 2, power=2.2)
    both = heaps(800.0, 25.0, 16, 0.04, 0.5, 3, points=32), anvil(32, 4)
    return {
        "step-published": Recipe(
            "I3RC phase I, case 1: step cloud, albedo 1 (experiment 2) and .99 (experiment 4), sun at 60 deg",
            (step(0.0, 10, "published"),), 15.625, (0.67, 0.67), (120_000, 120_000),
            (Direction(60.0, 0.0), Direction(60.0, 180.0)), Direction(60.0, 180.0),
        ),
        "step-night": Recipe("step cloud at 1 km by night", (step(1000.0, 10, "droplets"),), 15.625, (8.5, 10.8),
                             (30_000, 30_000)),
        "stratocumulus-night": Recipe("broken stratocumulus by night", (stratocumulus,), 50.0, (3.7, 10.8),
                                      (1200, 1200)),
        "stratocumulus-day": Recipe("the same stratocumulus, sun at 55 deg", (stratocumulus,), 50.0, (3.7, 8.5),
                                    (2500, 1000), sun=Direction(55.0, 80.0)),
        "cumulus-night": Recipe("cumulus by night", (cumulus,), 80.0, (3.7, 12.0), (1200, 1200)),
        "cumulus-day": Recipe("the same cumulus, sun at 40 deg", (cumulus,), 80.0, (3.7, 10.8), (4000, 1000),
                              (Direction(0.0, 0.0), Direction(45.0, 200.0)), Direction(40.0, 80.0)),
        "two-layers-night": Recipe("stratocumulus under cirrus by night", both, 100.0, (8.5, 12.0), (1000, 1000),
                                   (Direction(0.0, 0.0), Direction(45.0, 30.0))),
        "two-layers-day": Recipe("the same two layers, sun at 50 deg", both, 100.0, (3.7, 10.8), (3000, 1000),
                                 (Direction(0.0, 0.0), Direction(45.0, 30.0)), Direction(50.0, 150.0)),
    }  # fmt: skip


def case_of(name: str, recipe: Recipe) -> Case:
    """Return the case of a recipe without radiance."""
    edges, kind, parts, levels = [0.0], list[int](), list[slice](), 0
    for number, layer in enumerate(recipe.layers):
        gap = layer.base_m > edges[-1]
        edges += [layer.base_m] * gap + [layer.base_m + layer.level_m * (n + 1) for n in range(layer.profiles.shape[1])]
        kind += [number] * (gap + layer.profiles.shape[1])
        parts.append(slice(levels + gap, levels + gap + layer.profiles.shape[1]))
        levels = parts[-1].stop
    counts = [len(layer.profiles) for layer in recipe.layers]
    columns = np.zeros((*counts, levels))
    for number, (layer, part) in enumerate(zip(recipe.layers, parts, strict=True)):
        shape = [1] * len(counts) + [-1]
        shape[number] = counts[number]
        columns[..., part] = layer.profiles.reshape(shape)
    columns = columns.reshape(-1, levels)
    column_of = np.ravel_multi_index(tuple(layer.chosen for layer in recipe.layers), counts).astype(np.int64)
    published = recipe.layers[0].particles == "published"
    particles = [particles_of(layer.particles, recipe.wavelengths_um) for layer in recipe.layers]
    phase = np.stack([each.phase for each in particles])
    irradiance = np.array([1.0 if published else IRRADIANCE.get(each, 0.0) for each in recipe.wavelengths_um])
    middle = 0.5 * (np.array(edges)[1:] + np.array(edges)[:-1])
    shape = len(irradiance), len(recipe.views), *column_of.shape
    return Case(
        name, recipe.summary, (recipe.pixel_m, recipe.pixel_m), np.array(edges), SEA_K - LAPSE_K_M * middle,
        np.array(kind), columns[column_of],
        ("albedo 1", "albedo .99") if published else tuple(f"{each:g} um" for each in recipe.wavelengths_um),
        np.array(recipe.wavelengths_um), np.stack([each.relative for each in particles]),
        np.stack([each.albedo for each in particles]), cosines(), phase,
        np.array([[moments_of(cosines(), own) for own in bands] for bands in phase]),
        irradiance if recipe.sun else np.zeros(2), recipe.sun, recipe.views,
        recipe.layers[0].base_m + (250.0 if published else 0.0), SEA_K, columns,
        np.zeros((2, len(recipe.views), len(columns))), column_of, np.zeros(shape), np.zeros(shape),
        np.array(recipe.photons),
    )  # fmt: skip


def plane_parallel(case: Case, band: int, column: Array, streams: int = STREAMS) -> Array:
    """Return the radiance (V,) of a uniform column (Z,) by discrete ordinates."""
    depth = (column * case.relative[case.kind, band] * np.diff(case.edges_m))[::-1]
    cloudy = depth > 0.0
    ground = float(case.black(band, case.surface_K))
    if not np.any(cloudy):
        return np.full(len(case.views), ground)
    kind, depth = case.kind[::-1][cloudy], depth[cloudy]
    albedo = np.minimum(case.albedo[kind, band], 1.0 - 1e-9)
    moments = case.moments[kind, band]
    mu = np.cos(np.radians([view.zenith_deg for view in case.views]))
    scaled = {"NLeg": streams, "f_arr": np.maximum(moments[:, streams], 0.0)}
    source = case.black(band, case.temperature_K)[::-1][cloudy, None]
    # The source is multiplied by 1 - albedo inside.
    mean = pydisort(np.cumsum(depth), albedo, streams, moments, 0.5, 0.0, 0.0, NFourier=1, s_poly_coeffs=source,
                    b_pos=ground, **scaled)[3]  # fmt: skip
    result = np.asarray(interpolate(mean)(mu, 0.0)).reshape(-1)
    if case.sun is not None and case.is_sunlit(band):
        # Levels of one kind have the same optics: one layer for each kind.
        first = np.flatnonzero(np.diff(kind, prepend=-1))
        ends = np.cumsum(depth)[np.append(first[1:] - 1, depth.size - 1)]
        scaled["f_arr"] = scaled["f_arr"][first]
        lit = pydisort(
            ends, albedo[first], streams, moments[first], float(case.sun.vector[2]), float(case.irradiance[band]), 0.0,
            NFourier=streams, NT_cor=True, **scaled,
        )[4]  # fmt: skip
        seen = interpolate(lit, NT_cor="eval")
        for number, view in enumerate(case.views):
            turned = np.radians(view.azimuth_deg - case.sun.azimuth_deg - 180.0)
            result[number] += np.asarray(seen(mu[number], 0.0, turned)).item()
    return result


@dataclass(frozen=True)
class Gradient:
    """Cloud over a black surface of 290 K whose Planck radiance is a polynomial of the optical thickness above.

    Its top has 255 K and its base 285 K, as if it were 4 km deep: far more than between levels of the cases. The
    polynomial is linear, or a parabola whose middle has 262 K.
    """

    case: str
    kind: int
    band: int
    depth: float
    curved: bool

    ZENITHS_DEG = 0.0, 30.0, 60.0, 80.0
    LEVELS = 200
    """Of Monte Carlo, which has no slope within one: .0007 K at 80 deg, by discrete ordinates with as many."""

    def source(self, case: Case) -> Array:
        """Return the coefficients of the polynomial, constant first."""
        top, middle, base = case.black(self.band, np.array([255.0, 262.0, 285.0]))
        square = 2.0 * (base - 2.0 * middle + top) / self.depth**2 if self.curved else 0.0
        return np.array([top, (base - top) / self.depth - square * self.depth, square])

    def ordinates(self, case: Case, streams: int = STREAMS) -> Array:
        """Return the radiance (V,) by discrete ordinates, which take the polynomial itself."""
        moments = case.moments[self.kind, self.band]
        mean = pydisort(
            np.array([self.depth]), case.albedo[[self.kind], self.band], streams, moments[None], 0.5, 0.0, 0.0,
            NFourier=1, NLeg=streams, f_arr=np.array([max(moments[streams], 0.0)]),
            s_poly_coeffs=self.source(case)[None], b_pos=float(case.black(self.band, SEA_K)),
        )[3]  # fmt: skip
        return np.asarray(interpolate(mean)(np.cos(np.radians(self.ZENITHS_DEG)), 0.0)).reshape(-1)

    def traced(self, case: Case, photons: int, seed: int = 0) -> tuple[Array, Array]:
        """Return the radiance (V,) by Monte Carlo, and its standard error."""
        edges = np.linspace(0.0, 1000.0, self.LEVELS + 1)
        above = self.depth * (1.0 - 0.5 * (edges[1:] + edges[:-1]) / 1000.0)
        cloud = Voxels(
            np.full((4, 4, self.LEVELS), self.depth / 1000.0), edges, (500.0, 500.0), case.albedo[self.kind, self.band],
            np.zeros(self.LEVELS), np.asarray(np.polynomial.polynomial.polyval(above, self.source(case))),
            surface_source=float(case.black(self.band, SEA_K)),
        )  # fmt: skip
        phase = case.scattering(self.band)[self.kind]
        both = [
            radiance(cloud, phase, view_zenith_deg=zenith, photons=photons // 16, seed=100 * seed + number)
            for number, zenith in enumerate(self.ZENITHS_DEG)
        ]
        return np.array([mean.mean() for mean, _ in both]), np.array([np.sqrt(np.sum(e**2)) / e.size for _, e in both])


def gradients() -> list[Gradient]:
    """Return the clouds of the page: droplets at four wavelengths, ice at one; thin, medium and thick."""
    optics = (("cumulus-night", 0, 0), ("step-night", 0, 0), ("step-night", 0, 1), ("cumulus-night", 0, 1),
              ("two-layers-night", 1, 0))  # fmt: skip
    return [Gradient(*each, depth, curved) for each in optics for depth in (0.5, 3.0, 15.0) for curved in (False, True)]


def traced(case: Case, seed: int = 0) -> Case:
    """Return a case with its Monte Carlo radiance."""
    mean, noise = np.empty_like(case.radiance), np.empty_like(case.noise)
    for band, number in product(range(len(case.bands)), range(len(case.views))):
        view = case.views[number]
        mean[band, number], noise[band, number] = radiance(
            case.voxels(band), case.scattering(band), view_zenith_deg=view.zenith_deg,
            view_azimuth_deg=view.azimuth_deg, sun=case.sunlight(band), photons=int(case.photons[band]),
            seed=100 * seed + 10 * band + number, displaced_m=case.displaced_m(view),
        )  # fmt: skip
    return replace(case, radiance=mean, noise=noise)


RADIANCE = "W m-2 sr-1 um-1"
VARIABLES = {
    "edge_altitude": ("edge", "edges_m", "m", "altitudes between levels, from the surface on"),
    "temperature": ("level", "temperature_K", "K", "temperature of each level, constant within it"),
    "kind": ("level", "kind", "1", "number of the particles of each level"),
    "extinction": ("x y level", "extinction_m1", "m-1", "extinction at visible wavelengths, constant in each voxel"),
    "wavelength": ("band", "wavelength_um", "um", "wavelength; radiance is monochromatic"),
    "relative_extinction": ("particles band", "relative", "1", "extinction over that at visible wavelengths"),
    "single_scattering_albedo": ("particles band", "albedo", "1", "single-scattering albedo"),
    "cosine": ("angle", "cosine", "1", "cosine of the scattering angle"),
    "phase_function": ("particles band angle", "phase", "1", "linear in the cosine; its mean over the sphere is 1"),
    "legendre_moment": ("particles band degree", "moments", "1", "moments of the phase function; degree 1: asymmetry"),
    "solar_irradiance": ("band", "irradiance", "W m-2 um-1", "direct sunlight on a surface that faces the sun"),
    "column_extinction": ("column level", "columns", "m-1", "extinction of uniform clouds at visible wavelengths"),
    "column_radiance": ("band view column", "column_radiance", RADIANCE, "of uniform clouds by PythonicDISORT"),
    "column_of": ("x y", "column_of", "1", "number of the uniform cloud with the profile of the pixel's column"),
    "radiance": ("band view x y", "radiance", RADIANCE, "at the top, by backward Monte Carlo of hcss_light"),
    "radiance_error": ("band view x y", "noise", RADIANCE, "standard error of radiance"),
    "photons": ("band", "photons", "1", "photons for each pixel and view"),
}
"""Dimensions, attribute of the case, unit and description."""

DIGITS = {"radiance": 5, "radiance_error": 3}
"""Significant digits, which are far below the noise."""

COMMENT = """Monochromatic radiance of clouds over a black surface, without gas, sky or waves. Clouds are periodic along
x and y and constant in each voxel. Azimuths count from +x toward +y; that of a view points toward the sensor, that of
the sun to where it comes from. Pixel (x, y) of a view is the mean over the lines of sight that cross its square at the
altitude reference_altitude. Emission follows Planck's law at the temperature of the level and of the surface."""


def write(case: Case, path: Path) -> None:
    """Write the file of a case."""
    with netCDF4.Dataset(path, "w") as file:
        file.title, file.comment, file.license = case.summary, COMMENT, "BSD-3-Clause"
        file.Conventions = "CF-1.10"
        for axis, (name, size) in enumerate(zip("xy", case.size_m, strict=True)):
            count = case.extinction_m1.shape[axis]
            file.createDimension(name, count)
            variable = file.createVariable(name, "f8", (name,))
            variable.units, variable.long_name, variable.pixel_size = "m", f"middle of pixels along {name}", size
            variable[:] = size * (np.arange(count) + 0.5)
        file.createDimension("band", len(case.bands))
        names = file.createVariable("band", str, ("band",))
        names.long_name, names[:] = "name of the band", np.array(case.bands, dtype=object)
        for name, (dimensions, attribute, unit, description) in VARIABLES.items():
            values, axes = np.asarray(getattr(case, attribute)), dimensions.split()
            for axis, count in zip(axes, values.shape, strict=True):
                if axis not in file.dimensions:
                    file.createDimension(axis, count)
            form = "i2" if values.dtype.kind == "i" else "f4" if name in DIGITS else "f8"
            form = "i4" if name == "photons" else form
            # The index of packed values takes more room than few values.
            packed = {"zlib": True, "significant_digits": DIGITS.get(name)} if values.size > 1000 else {}
            variable = file.createVariable(name, form, axes, **packed)
            variable.units, variable.long_name, variable[...] = unit, description, values
        angles = {
            "view_zenith": ("zenith angle of the sensor", [view.zenith_deg for view in case.views], ("view",)),
            "view_azimuth": ("azimuth toward the sensor", [view.azimuth_deg for view in case.views], ("view",)),
        }
        if case.sun is not None:
            angles["sun_zenith"] = "zenith angle of the sun", [case.sun.zenith_deg], ()
            angles["sun_azimuth"] = "azimuth toward the sun", [case.sun.azimuth_deg], ()
        for name, (description, degrees, axes) in angles.items():
            variable = file.createVariable(name, "f8", axes)
            variable.units, variable.long_name, variable[...] = "degree", description, degrees
        for name, unit, value in (
            ("reference_altitude", "m", case.reference_m),
            ("surface_temperature", "K", case.surface_K),
        ):
            variable = file.createVariable(name, "f8", ())
            variable.units, variable.long_name, variable[...] = unit, name.replace("_", " "), value


def _print_gradient(cloud: Gradient, photons: int = 100_000) -> None:
    """Print a row of the page: kelvin by discrete ordinates, and by how much Monte Carlo is above, with its noise."""
    case = load_case(cloud.case)
    exact, (found, noise) = cloud.ordinates(case), cloud.traced(case, photons)
    kelvin = case.kelvin(cloud.band, exact)
    away, error = (case.kelvin(cloud.band, exact + each) - kelvin for each in (found - exact, noise))
    cells = " | ".join(f"{a:.1f}, {b:+.3f} +- {c:.3f}" for a, b, c in zip(kelvin, away, error, strict=True))
    kind, shape = ("droplets", "ice")[cloud.kind], ("linear", "parabola")[cloud.curved]
    print(f"| {kind}, {case.bands[cloud.band]} | {cloud.depth:g} | {shape} | {cells} |", flush=True)


def main() -> None:
    """Write cases, or compare them with other photons."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("cases", nargs="*", metavar="CASE", help="names; default: all")
    options.add_argument("--check", action="store_true", help="compare Monte Carlo with other photons; write nothing")
    options.add_argument("--gradient", action="store_true", help="compare emission with a gradient of temperature")
    options.add_argument("--folder", type=Path, default=FOLDER)
    given = options.parse_args()
    warnings.filterwarnings("ignore", module="PythonicDISORT")
    if given.gradient:
        for each in gradients():
            _print_gradient(each)
        return
    for name, recipe in recipes().items():
        if given.cases and name not in given.cases:
            continue
        start, path = time.process_time(), given.folder / f"{name}.nc"
        if given.check:
            case = read_case(path)
            other = traced(case, seed=1)
            away = (other.radiance - case.radiance) / np.hypot(other.noise, case.noise)
            print(
                name, "deviation over noise, rms over pixels", np.sqrt(np.mean(away**2, axis=(2, 3))).round(2).tolist()
            )
            continue
        case = case_of(name, recipe)
        table = np.array([[plane_parallel(case, band, each) for each in case.columns] for band in range(2)])
        between = time.process_time()
        case = traced(replace(case, column_radiance=np.moveaxis(table, 1, 2)))
        write(case, path)
        mean = case.radiance.mean(axis=(2, 3))
        noise = np.sqrt(np.sum(case.noise**2, axis=(2, 3))) / case.column_of.size / mean
        spent = f"columns {between - start:.0f} s, Monte Carlo {time.process_time() - between:.0f} s"
        percent = np.round(100.0 * noise, 3).tolist()
        print(f"{name}: {path.stat().st_size / 1e3:.0f} kB, {spent}, noise of means {percent} %", flush=True)


if __name__ == "__main__":
    main()
