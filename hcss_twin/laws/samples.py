"""Analytic providers, scenes and sample inputs of the laws."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.physics.paths import Path
from hcss_twin.physics.profile import GASES, Profile, airmass_of_legs
from hcss_twin.physics.squares import segments
from hcss_twin.providers import (
    Array,
    AtmosphereDeclaration,
    CloudLayer,
    ColumnSetting,
    ElementInputs,
    ElementPixels,
    ElementProvider,
    Microphysics,
    OpticsDeclaration,
    ProviderError,
    RadianceInputs,
    SeaDeclaration,
    SightPath,
    SingleScattering,
    Sun,
    View,
)

__all__ = ["PlainGas", "PlainOptics", "PlainScene", "PlainSea", "StillScene", "sample_radiance_inputs"]


class PlainSea:
    """A grey Lambertian sea: BRDF (1 - emissivity) / pi."""

    def __init__(self, emissivity: float = 0.98) -> None:
        self._emissivity = emissivity
        self.declares = SeaDeclaration(depends_on=frozenset())

    def emissivity(self, wavenumber_cm1: Array, mu: Array) -> Array:
        """Return the same emissivity (M, V) everywhere."""
        return np.full((mu.size, wavenumber_cm1.size), self._emissivity)

    def brdf(self, wavenumber_cm1: Array, mu_out: Array, mu_in: Array, relative_azimuth: Array) -> Array:
        """Return the same BRDF (M, V) in sr-1 everywhere."""
        return np.full((mu_out.size, wavenumber_cm1.size), (1.0 - self._emissivity) / np.pi)


class PlainOptics:
    """Grey particles of a given extinction cross-section, albedo and asymmetry (Henyey-Greenstein)."""

    def __init__(self, cross_section_m2: float = 1e-10, albedo: float = 0.6, asymmetry: float = 0.8) -> None:
        self._cross_section_m2 = cross_section_m2
        self._albedo = albedo
        self._asymmetry = asymmetry
        self.declares = OpticsDeclaration()

    def single_scattering(self, cloud: Microphysics, wavenumber_cm1: Array) -> SingleScattering:
        """Return extinction in proportion to the number of particles, the same at all wavenumbers."""
        ones = np.ones(wavenumber_cm1.size)
        return SingleScattering(
            extinction_m1=cloud.number_density_m3 * self._cross_section_m2 * ones,
            albedo=self._albedo * ones,
            moments=np.stack((ones, self._asymmetry * ones)),
        )


class PlainGas:
    """A grey gas, well mixed: T = exp(-depth m) with the pressure-weighted air mass m of the whole path."""

    def __init__(self, profile: Profile, vertical_depth: float = 0.3) -> None:
        self._profile = profile
        self._weights = -np.diff(profile.pressure_Pa) / (profile.pressure_Pa[0] - profile.pressure_Pa[-1])
        self._vertical_depth = vertical_depth
        self.declares = AtmosphereDeclaration()

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return transmittance (P, V), the same at all wavenumbers."""
        legs = [leg for path in paths for leg in path.legs]
        path_of = np.repeat(np.arange(len(paths)), [len(path.legs) for path in paths])
        mass = np.bincount(path_of, airmass_of_legs(self._profile, legs) @ self._weights, len(paths))
        return np.repeat(np.exp(-self._vertical_depth * mass)[:, None], wavenumber_cm1.size, axis=1)


class PlainScene:
    """A scene of grey air without clouds, for element providers: an ``ElementScene``."""

    def __init__(self, inputs: ElementInputs, sun: Sun | None = None, seed: int = 1) -> None:
        self._inputs = inputs
        self.sun, self.random = sun, np.random.default_rng(seed)

    def project(self, x_m: Array, y_m: Array, altitude_m: Array) -> tuple[Array, Array]:
        """Return row and column of points, without parallax and motion."""
        grid = self._inputs.grid
        return y_m / grid.pixel_size_m + 0.5 * grid.rows, x_m / grid.pixel_size_m + 0.5 * grid.columns

    def path(self, x_m: float, y_m: float, altitude_m: float) -> SightPath:
        """Return air whose optical depth of 0.3 falls off over 8 km."""
        transmittance = np.full(len(self._inputs.bands), np.exp(-0.3 * np.exp(-altitude_m / 8e3)))
        emission = (1.0 - transmittance) * self._inputs.black_body(260.0)
        return SightPath(transmittance, emission, np.ones_like(transmittance))

    def shown(self, provider: ElementProvider, time_s: float, rows: slice, columns: slice) -> list[ElementPixels]:
        """Return what a provider gives for a window, with small elements in the pixels that hold them, as in cubes."""
        grid, found = self._inputs.grid, []
        area_m2 = grid.pixel_size_m**2 * math.cos(math.radians(self._inputs.view.zenith_deg))
        for part in provider.pixels(time_s, rows, columns, self):
            if isinstance(part, ElementPixels):
                found.append(part)
                continue
            covers = 1.0 if part.area_m2 is None else part.area_m2 / area_m2
            side = part.side_m / grid.pixel_size_m
            if part.area_m2 is not None and covers > 1.0:
                side = max(side, math.sqrt(covers))
            position = self.project(*(np.array([value]) for value in (part.x_m, part.y_m, part.altitude_m)))
            pieces = [
                segments(float(at[0]), side, pixels) for at, pixels in zip(position, (rows, columns), strict=True)
            ]
            (y, up), (x, along) = (
                _by_pixel(piece[0], (piece[3] - piece[2]) / side if side else np.ones(piece[0].size))
                for piece in pieces
            )
            if not y.size or not x.size:
                continue
            at_y, at_x = (every.ravel() for every in np.meshgrid(y, x, indexing="ij"))
            truth = {name: np.full(at_y.size, value) for name, value in part.truth.items()}
            share, strength = covers * np.outer(up, along).ravel(), (part.radiance, part.intensity)
            found.append(ElementPixels(at_y, at_x, share, part.altitude_m, *strength, part.temperature_K, truth))
        return found


def _by_pixel(pixel: NDArray[np.intp], share: Array) -> tuple[NDArray[np.intp], Array]:
    """Return distinct pixels along one axis, and the sum of the shares in each."""
    distinct, which = np.unique(pixel, return_inverse=True)
    total: Array = np.bincount(which, share, distinct.size).astype(np.float64)
    return distinct, total


class StillScene:
    """``SensorInputs.scene_at`` of the kit: the measured frame at all times, or one that brightens with time.

    Attributes
    ----------
    calls : list of (float, slice, slice)
        Time, rows and columns of each call since the frame began.
    change_per_s : float
        Relative change of the radiance.
    time_s : float
        Of the frame that is measured.
    """

    def __init__(self) -> None:
        self.calls: list[tuple[float, slice, slice]] = []
        self.change_per_s, self.time_s = 0.0, 0.0
        self._radiance = frozen([])

    def begin(self, radiance: Array, time_s: float) -> None:
        """Take the frame that is measured, and its time."""
        self._radiance, self.time_s, self.calls = radiance, time_s, []

    @contextlib.contextmanager
    def brightening(self, change_per_s: float) -> Iterator[None]:
        """Let the scene brighten with time for a while."""
        self.change_per_s = change_per_s
        try:
            yield
        finally:
            self.change_per_s = 0.0

    def __call__(self, time_s: float, rows: slice, columns: slice) -> Array:
        """Return a window of the frame at a time."""
        self.calls.append((time_s, rows, columns))
        return frozen(self._radiance[:, rows, columns] * (1.0 + self.change_per_s * (time_s - self.time_s)))


class BoundedScene(StillScene):
    """A still scene that is known within the declared instants of a sensor alone, as in a run."""

    def __init__(self, instants: tuple[float, float]) -> None:
        super().__init__()
        self._instants = instants

    def __call__(self, time_s: float, rows: slice, columns: slice) -> Array:
        """Return a window of the frame at a time."""
        late, (low, high) = time_s - self.time_s, self._instants
        if not low - 1e-9 <= late <= high + 1e-9:
            raise ProviderError(
                f"scene_at: {late:.9g} s after the frame is not among the instants {low:g} to {high:g} s"
            )
        return super().__call__(time_s, rows, columns)


_WELL_MIXED = {"co2": 4.2e-4, "n2o": 3.3e-7, "co": 1.5e-7, "ch4": 1.9e-6, "o2": 0.2095}
"""Mole fractions of gases that do not change with altitude here."""


def frozen(values: Any) -> Array:
    """Return values as a float64 array that cannot be written to, as providers must not."""
    array: Array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


def sample_profile(temperature_K: float | None = None) -> Profile:
    """Return an atmosphere of scale height 8 km up to 80 km with all gases of ``GASES``.

    Water vapour falls off over 2 km from 1 % at the surface, ozone has its most at 34 km, the others are well mixed.

    Parameters
    ----------
    temperature_K : float, optional
        Of an isothermal atmosphere; by default 288 K at the surface, falling by 6.5 K per km to 216.5 K.
    """
    altitude = np.concatenate((np.arange(0.0, 20e3, 1e3), np.arange(20e3, 80.1e3, 5e3)))
    temperature = np.maximum(288.0 - 6.5e-3 * altitude, 216.5)
    if temperature_K is not None:
        temperature = np.full_like(altitude, temperature_K)
    name = "sample" if temperature_K is None else f"isothermal {temperature_K:g} K"
    gases = {name: np.full_like(altitude, share) for name, share in _WELL_MIXED.items()}
    gases["h2o"] = np.maximum(1e-2 * np.exp(-altitude / 2e3), 4e-6)
    gases["o3"] = 3e-8 + 8e-6 * np.exp(-(((altitude - 34e3) / 9e3) ** 2))
    return Profile(
        name,
        frozen(altitude),
        frozen(101_325.0 * np.exp(-altitude / 8e3)),
        frozen(temperature),
        {gas: frozen(gases[gas]) for gas in GASES},
    )


def sample_microphysics(material: str = "water") -> Microphysics:
    """Return particles: water droplets or other particles with a mode radius of 4 um, or ice particles of 20 um.

    n(r) = a r^6 exp(-6 r / r_mode): the modified gamma distribution with its mode at r_mode.
    """
    mode_um, density_m3 = (20.0, 1e5) if material == "ice" else (4.0, 1e8)
    return Microphysics(
        material=material,
        alpha=6.0,
        b=6.0 / mode_um,
        nu=1.0,
        number_density_m3=density_m3,
        radius_range_um=(mode_um / 50.0, mode_um * 10.0),
        density_kg_m3=None if material in ("water", "ice") else 2500.0,
    )


def sample_layer(coverage: float = 0.5) -> CloudLayer:
    """Return a low water cloud between 1000 m and 1800 m with a minimum thickness of 50 m."""
    return CloudLayer(
        name="sample",
        base_m=1000.0,
        top_m=1800.0,
        anchor="base",
        thickness_min_m=50.0,
        coverage=coverage,
        temperature_K=None,
        microphysics=sample_microphysics(),
    )


def sample_high_layer(coverage: float = 0.5) -> CloudLayer:
    """Return a high ice cloud between 8000 m and 10 000 m, above that of :func:`sample_layer`."""
    return CloudLayer(
        name="sample high",
        base_m=8000.0,
        top_m=10_000.0,
        anchor="base",
        thickness_min_m=100.0,
        coverage=coverage,
        temperature_K=None,
        microphysics=sample_microphysics("ice"),
    )


def sample_radiance_inputs(
    profile: Profile | None = None, layers: tuple[CloudLayer, ...] | None = None
) -> RadianceInputs:
    """Return inputs of a radiance model from these plain providers.

    Parameters
    ----------
    profile : Profile, optional
        By default :func:`sample_profile`.
    layers : tuple of CloudLayer, optional
        From the lowest to the highest; by default :func:`sample_layer` alone.
    """
    profile = profile or sample_profile()
    setting = ColumnSetting(
        view=View(zenith_deg=30.0, azimuth_deg=90.0),
        sun=None,
        sea=PlainSea(),
        sea_temperature_K=290.0,
        profile=profile,
        transmittance=PlainGas(profile),
        layers=(sample_layer(),) if layers is None else layers,
    )
    return RadianceInputs(setting, PlainOptics(), flat_sun)


def flat_sun(wavenumber_cm1: Array) -> Array:
    """Return the same solar irradiance at all wavenumbers, 0.01 W m-2 (cm-1)-1 at 1 au."""
    return np.full(wavenumber_cm1.shape, 0.01)
