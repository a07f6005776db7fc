"""What one cloud layer does in one column: rows of emission, reflection and transmission that sum to one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.multiple_scattering.layer import LayerOperators, solve_layers
from hcss_twin.multiple_scattering.sun import solve_sun
from hcss_twin.multiple_scattering.two_stream import solve_layers_two_stream, solve_sun_two_stream
from hcss_twin.providers import CloudLayer, Optics
from hcss_twin.radiance.parameters import PhysicalParameters
from hcss_twin.radiance.physical.directions import VIEW, Directions

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CloudSlab:
    """One layer of one column; D directions (view and streams), N streams, V wavenumbers.

    Attributes
    ----------
    base_m, top_m : float
        Altitudes.
    top_temperature_K, base_temperature_K : float
    emissivity, far_share, direct : ndarray (D, V)
        As in :class:`LayerOperators`.
    reflection, transmission : ndarray (D, N, V)
        Share of each stream's radiance in the radiance sent toward a direction.
    sun_reflection, sun_transmission : ndarray (D, V)
        sr-1, toward the view with its azimuth, toward streams the mean over azimuth; 0 without a sun.
    sun_direct : ndarray (V,)
        Direct transmittance for the sun; 0 without one.
    """

    base_m: float
    top_m: float
    top_temperature_K: float
    base_temperature_K: float
    emissivity: Array
    far_share: Array
    direct: Array
    reflection: Array
    transmission: Array
    sun_reflection: Array
    sun_transmission: Array
    sun_direct: Array


class SlabMaker:
    """Solves layers of one optics provider for one set of directions.

    Parameters
    ----------
    optics : Optics
    parameters : PhysicalParameters
        Solver, streams and azimuth modes.
    wavenumber_cm1 : ndarray (V,)
    directions : Directions
    """

    def __init__(
        self,
        optics: Optics,
        parameters: PhysicalParameters,
        wavenumber_cm1: Array,
        directions: Directions,
    ) -> None:
        self._optics = optics
        self._parameters = parameters
        self._wavenumber = wavenumber_cm1
        self._directions = directions

    def make(self, layer: CloudLayer, thickness_m: Array, top_K: Array, base_K: Array) -> list[CloudSlab]:
        """Solve ``layer`` at every thickness.

        Parameters
        ----------
        thickness_m : ndarray (T,)
            Above 0.
        top_K, base_K : ndarray (T,)
            Temperatures of the two faces.
        """
        where = self._directions
        scattering = self._optics.single_scattering(layer.microphysics, self._wavenumber)
        depth = thickness_m[:, None] * scattering.extinction_m1
        solved = self._layers(depth, scattering.albedo, scattering.moments)
        back, through, beam = self._sunlight(solved, depth, scattering.albedo, scattering.moments)
        extras = solved.mu.size - where.count
        kept = [VIEW, *range(extras, solved.mu.size)]
        factor = 2.0 * np.pi * where.streams.mu * where.streams.weight
        # (T, V, D, N) -> (T, D, N, V)
        reflection = np.moveaxis(solved.reflection[:, :, kept, extras:] * factor, 1, -1)
        transmission = np.moveaxis(solved.transmission[:, :, kept, extras:] * factor, 1, -1)
        emissivity, far, direct = (
            np.moveaxis(each[:, :, kept], 1, -1)
            for each in (solved.emissivity, solved.far_share, solved.direct)
        )
        tops = layer.cloud_top_m(thickness_m)
        return [
            CloudSlab(
                base_m=float(tops[t] - thickness_m[t]),
                top_m=float(tops[t]),
                top_temperature_K=float(top_K[t]),
                base_temperature_K=float(base_K[t]),
                emissivity=emissivity[t],
                far_share=far[t],
                direct=direct[t],
                reflection=reflection[t],
                transmission=transmission[t],
                sun_reflection=back[t],
                sun_transmission=through[t],
                sun_direct=beam[t],
            )
            for t in range(thickness_m.size)
        ]

    def _layers(self, depth: Array, albedo: Array, moments: Array) -> LayerOperators:
        where = self._directions
        extras = [where.mu[VIEW]] if where.sun is None else [where.mu[VIEW], where.mu_sun]
        solve = (
            solve_layers if self._parameters.cloud_solver == "adding-doubling" else solve_layers_two_stream
        )
        return solve(depth, albedo, moments, np.array(extras), where.count)

    def _sunlight(
        self, solved: LayerOperators, depth: Array, albedo: Array, moments: Array
    ) -> tuple[Array, Array, Array]:
        """Kernels (T, D, V) for reflected and transmitted sunlight, and its direct part (T, V)."""
        where = self._directions
        count, size = depth.shape
        if where.sun is None:
            nothing = np.zeros((count, 1 + where.count, size))
            return nothing, nothing, np.zeros((count, size))
        view, azimuth = np.array([where.mu[VIEW]]), np.array([where.relative_azimuth])
        if self._parameters.cloud_solver == "adding-doubling":
            brdf, btdf = solve_sun(
                depth,
                albedo,
                moments,
                view,
                where.mu_sun,
                azimuth,
                streams=self._parameters.sun_streams,
                modes=self._parameters.azimuth_modes,
            )
        else:
            brdf, btdf = solve_sun_two_stream(
                depth, albedo, moments, view, where.mu_sun, azimuth, streams=where.count
            )
        sun, streams = 1, range(2, solved.mu.size)
        back = np.concatenate((brdf, solved.reflection[:, :, streams, sun]), axis=-1)
        through = np.concatenate((btdf, solved.transmission[:, :, streams, sun]), axis=-1)
        return np.moveaxis(back, 1, -1), np.moveaxis(through, 1, -1), solved.direct[:, :, sun]
