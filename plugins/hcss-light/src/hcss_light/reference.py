"""Radiance of pixels by Monte Carlo, for each weighted wavenumber of the radiance tables.

Gas absorbs and emits within the cloud layer, with the absorption that the transmittance along the view has there; above
it the transmittance of whole paths is used. The sea is rough: its emission and its sunlight are chosen so that clear
sky has the radiance of the scene's radiance model, and facets mirror what is above them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hcss_light.bands import sky_radiance, sunlight_of_air
from hcss_light.monte_carlo import Sunlight, radiance
from hcss_light.sea_surface import RoughSea, facets, index_of
from hcss_light.sea_surface import glint as glint_of
from hcss_light.slices import Field, Slices
from hcss_light.source import Direction, Particles
from hcss_light.voxels import ScatteringTable, Voxels
from hcss_twin.models.atmosphere.path_radiance import path_radiance
from hcss_twin.providers import Array, Sun, planck, to_space
from hcss_twin.providers.light import LightInputs

LEAST_LEVELS = 64
"""Levels of the voxels, so that cloud tops are sharp."""

LEAST_PHOTONS = 100
"""Of each wavenumber."""

LEVELS_BELOW = 8
"""Levels of the air below the cloud layer."""

MEAN_SQUARE_SLOPE = 0.04
"""Of seas that do not state theirs."""

MOST_STRENGTH = 10.0
"""Largest factor by which sunlight is brought to that of the scene's sea."""

OPAQUE = 1e-4
"""Transmittance of the gas below which what is beneath does not matter."""


@dataclass(frozen=True)
class Air:
    """Gas and light of one wavenumber.

    Attributes
    ----------
    weight : float
        Of the wavenumber in the band, cm-1.
    particles : tuple of Particles
        Of each cloud layer.
    gas_m1, emitted : ndarray (Z,)
        Absorption and Planck radiance of each level, from the sea to the highest cloud.
    sky, below, sunlight : float
        Radiance of the sky above the layer and of the water, and the sun's irradiance above the layer.
    sea : RoughSea
    through, above : float
        Transmittance and radiance of the air above the layer.
    """

    weight: float
    particles: tuple[Particles, ...]
    gas_m1: Array
    emitted: Array
    sky: float
    below: float
    sunlight: float
    sea: RoughSea
    through: float
    above: float

    @property
    def signal(self) -> float:
        """Radiance that shares out the photons."""
        light = float(np.max(self.emitted)) + self.below + self.sunlight / math.pi
        return self.weight * (self.through * light + 1e-6 * self.above)


def reference_radiance(
    inputs: LightInputs,
    slices: Slices,
    thickness_m: Field,
    points: Array | NDArray[np.intp],
    sun: Sun | None,
    photons: int,
    seed: int = 0,
    shares: Field | None = None,
) -> tuple[Array, Array]:
    """Return the radiance (N, B) of points among broken clouds, and its standard error.

    Parameters
    ----------
    slices : Slices
        Of the tier that is compared; levels here are at least as thin (:func:`levels_of`).
    thickness_m : ndarray of float32 (y, x)
        Cloud, continued periodically.
    points : ndarray of int (N, 2)
        Rows and columns.
    photons : int
        For each point and band.
    shares : ndarray (Z, y, x), optional
        Of each column in each level.
    """
    fine = levels_of(slices)
    layers = [(fine, fine.density(thickness_m, inputs.shape, shares))]
    return radiance_of_layers(inputs, layers, points, sun, photons, seed)


def radiance_of_layers(
    inputs: LightInputs,
    layers: Sequence[tuple[Slices, Field]],
    points: Array | NDArray[np.intp],
    sun: Sun | None,
    photons: int,
    seed: int = 0,
) -> tuple[Array, Array]:
    """Return the same among the clouds of one layer or more: levels, and densities (Z, y, x) on them, of each."""
    edges_m = _edges([slices for slices, _ in layers])
    density, parts = np.zeros((*layers[0][1].shape[1:], edges_m.size - 1)), []
    for slices, layer_density in layers:
        first = int(np.searchsorted(edges_m, slices.base_m))
        parts.append(slice(first, first + slices.count))
        density[:, :, parts[-1]] = np.moveaxis(layer_density, 0, 2)
    bands = inputs.weights_cm1.shape[0]
    result = np.zeros((2, len(points), bands))
    for band in range(bands):
        airs = list(_airs(inputs, edges_m, sun, band))
        total = sum(air.signal for air in airs)
        for number, air in enumerate(airs):
            photons_of = max(round(photons * air.signal / total), LEAST_PHOTONS)
            draws = seed + 1000 * band + number
            mean, error = _of_wavenumber(inputs, edges_m, density, parts, air, points, sun, photons_of, draws)
            result[0, :, band] += air.weight * (air.through * mean + air.above)
            result[1, :, band] += (air.weight * air.through * error) ** 2
    return result[0], np.sqrt(result[1])


def levels_of(slices: Slices) -> Slices:
    """Return the levels of the voxels."""
    return replace(slices, count=slices.count * math.ceil(LEAST_LEVELS / slices.count))


def _edges(layers: Sequence[Slices]) -> Array:
    """Return the altitudes between the levels, from the sea on."""
    edges, top = [np.zeros(1)], 0.0
    for layer in layers:
        if layer.base_m > top:
            edges.append(np.linspace(top, layer.base_m, LEVELS_BELOW + 1)[1:])
        edges.append(layer.edges_m[1:])
        top = layer.top_m
    return np.concatenate(edges)


def scattering_table(particles: Particles) -> ScatteringTable:
    """Return the phase function on points that are dense in its forward peak."""
    cosine = np.concatenate((np.linspace(-1.0, 0.9, 400), 1.0 - np.geomspace(0.1, 1e-7, 1500)[1:], [1.0]))
    return ScatteringTable(cosine, particles.phases(cosine))


def _airs(inputs: LightInputs, edges: Array, sun: Sun | None, band: int) -> Iterator[Air]:
    used = np.flatnonzero(inputs.weights_cm1[band] > 0.0)
    wavenumber, view, top_m = inputs.wavenumber_cm1[used], inputs.view, float(edges[-1])
    clouds = [cloud.optics.single_scattering(cloud.layer.microphysics, wavenumber) for cloud in inputs.stack]
    height_m, middle_m = np.diff(edges)[:, None], 0.5 * (edges[1:] + edges[:-1])
    up = [to_space(float(edge), view.zenith_deg) for edge in edges]
    gas = np.maximum(inputs.transmittance.transmittance(wavenumber, up), 1e-30)
    across = math.cos(math.radians(view.zenith_deg))
    absorption = np.maximum(np.diff(np.log(gas), axis=0), 0.0) * across / height_m
    (above,) = path_radiance(inputs.transmittance, inputs.profile, wavenumber, [top_m], view.zenith_deg)
    kelvin = inputs.profile.temperature_at(middle_m)
    black = planck(wavenumber[None], kelvin[:, None])
    through = gas[-1]
    depth = absorption * height_m / across
    passed = np.cumsum(depth[::-1], axis=0)[::-1] - depth
    emission = np.sum(black * -np.expm1(-depth) * np.exp(-passed), axis=0)
    open_share = np.exp(-np.sum(depth, axis=0))
    clear = inputs.clear(sun)[used]
    above = above + sunlight_of_air(inputs, sun)[used]
    seen = through * open_share > OPAQUE
    below = np.where(
        seen, ((clear - above) / np.where(seen, through, 1.0) - emission) / np.where(seen, open_share, 1.0), black[0]
    )
    sky = sky_radiance(inputs, wavenumber, top_m)
    sunlight = np.zeros_like(wavenumber)
    if sun is not None:
        (both,) = inputs.transmittance.transmittance(wavenumber, [up[-1] + to_space(top_m, sun.zenith_deg)])
        sunlight = inputs.solar_irradiance(wavenumber) / sun.distance_au**2 * both / through
    glint = np.zeros_like(wavenumber) if sun is None else inputs.sea_sun(sun)[used] / np.where(seen, through, 1.0)
    glint = np.where(seen, glint / np.where(seen, open_share, 1.0), 0.0)
    emitted = black.copy()
    for layer in (cloud.layer for cloud in inputs.stack):
        if layer.temperature_K is not None:
            emitted[(middle_m > layer.base_m) & (middle_m < layer.top_m)] = planck(wavenumber, layer.temperature_K)
    upright = 1.0 - inputs.sea.emissivity(wavenumber, np.ones(1))[0]
    slopes = float(getattr(inputs.sea, "mean_square_slope", MEAN_SQUARE_SLOPE))
    for index, node in enumerate(used.tolist()):
        sea = RoughSea(slopes, float(index_of(upright[index])))
        light = float(below[index]) - float(glint[index])
        mirrored, shares = facets(sea, across)
        vertical = absorption[:, index] * height_m[:, 0]
        light -= float(shares @ _downward(mirrored, vertical, black[:, index], float(sky[index])))
        if sun is not None and glint[index] > 0.0:
            to_sun = Direction(sun.zenith_deg, sun.azimuth_deg).vector
            emission = glint_of(Direction(view.zenith_deg, view.azimuth_deg).vector, to_sun, 0.5 * slopes, sea.index)
            emission *= float(sunlight[index]) * math.exp(-float(np.sum(vertical)) / float(to_sun[2]))
            sea = replace(sea, strength=min(float(glint[index]) / max(emission, 1e-300), MOST_STRENGTH))
        yield Air(
            float(inputs.weights_cm1[band, node]),
            tuple(
                Particles(float(cloud.extinction_m1[index]), float(cloud.albedo[index]), cloud.moments[:, index])
                for cloud in clouds
            ),
            absorption[:, index],
            emitted[:, index],
            float(sky[index]),
            max(light / (1.0 - float(np.sum(shares))), 0.0),
            float(sunlight[index]),
            sea,
            float(through[index]),
            float(above[index]),
        )


def _downward(cosine: Array, depth: Array, black: Array, sky: float) -> Array:
    """Return the radiance (N,) of the clear sky at the sea for the vertical optical thickness of levels (Z,)."""
    slanted = depth / cosine[:, None]
    below = np.cumsum(slanted, axis=1) - slanted
    radiance: Array = np.sum(-np.expm1(-slanted) * black * np.exp(-below), axis=1)
    radiance += sky * np.exp(-np.sum(slanted, axis=1))
    return radiance


def _of_wavenumber(
    inputs: LightInputs, edges_m: Array, density: Array, parts: Sequence[slice], air: Air,
    points: Array | NDArray[np.intp], sun: Sun | None, photons: int, seed: int,
) -> tuple[Array, Array]:  # fmt: skip
    view, count = inputs.view, edges_m.size - 1
    up = Direction(view.zenith_deg, view.azimuth_deg).vector
    slope = up[:2] / up[2]
    per, albedo = np.zeros((2, count))
    kind, moved = np.zeros(count, dtype=np.int64), np.zeros((count, 2))
    for number, (cloud, particles, part) in enumerate(zip(inputs.stack, air.particles, parts, strict=True)):
        per[part], albedo[part], kind[part] = particles.extinction_m1, particles.albedo, number
        # Lines of sight meet the columns of each layer at its own altitude; those of the lowest stand where they are.
        moved[part.start :] = (cloud.reference_m - inputs.reference_m) * slope
    voxels = Voxels(
        density,
        edges_m,
        (inputs.point_m, inputs.point_m),
        albedo,
        air.gas_m1,
        air.emitted,
        surface_source=air.below,
        sky_source=air.sky,
        kind=kind,
        moved_m=moved,
        per=per,
    )
    lit = sun is not None and air.sunlight > 0.0
    away = (float(edges_m[-1]) - inputs.stack[-1].reference_m) * slope
    return radiance(
        voxels,
        [scattering_table(particle) for particle in air.particles],
        view_zenith_deg=view.zenith_deg,
        view_azimuth_deg=view.azimuth_deg,
        sun=Sunlight(sun.zenith_deg, sun.azimuth_deg, air.sunlight) if lit and sun is not None else None,
        photons=photons,
        seed=seed,
        columns=np.asarray(points, dtype=np.int64),
        displaced_m=(float(away[0]), float(away[1])),
        sea=air.sea,
    )
