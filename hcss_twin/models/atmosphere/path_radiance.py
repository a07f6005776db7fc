"""Thermal emission of the air between a target and space."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.physics.paths import Path, to_space
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import Profile
from hcss_twin.providers import TransmittanceProvider

__all__ = ["path_radiance"]


def path_radiance(
    provider: TransmittanceProvider,
    profile: Profile,
    wavenumber_cm1: Array,
    target_m: Sequence[float],
    zenith_deg: float,
) -> Array:
    """Path radiance (P, V) seen from space, W m-2 sr-1 (cm-1)-1: L_atm in eq 19 and eq 20 of the HCSS paper.

    A provider may compute its own path radiance. For other providers the Planck radiances of the layers are weighted
    with transmittance differences,

        L = sum_n B(T_n) [T(top of n -> space) - T(bottom of n -> space)],

    so that an isothermal atmosphere gives (1 - T) B exactly. Paths begin at altitudes ``target_m`` (P,); the zenith
    angle is that at the surface point.
    """
    compute = getattr(provider, "path_radiance", None)
    if compute is not None:
        result: Array = compute(wavenumber_cm1, [to_space(height, zenith_deg) for height in target_m])
        return result
    return np.stack([emission_of_layers(provider, profile, wavenumber_cm1, height, zenith_deg) for height in target_m])


def emission_of_layers(
    provider: TransmittanceProvider, profile: Profile, wavenumber_cm1: Array, target_m: float, zenith_deg: float
) -> Array:
    """Return the path radiance (V,) above an altitude, with one temperature for each layer of the profile."""
    levels = np.concatenate(([target_m], profile.altitude_m[profile.altitude_m > target_m]))
    paths = [to_space(float(level), zenith_deg) for level in levels[:-1]]
    # There is no air above the last level: transmittance 1.
    transmittance = provider.transmittance(wavenumber_cm1, [*paths, Path()])
    temperature = profile.temperature_at(levels)
    layer_temperature = 0.5 * (temperature[1:] + temperature[:-1])
    source = planck(wavenumber_cm1[None, :], layer_temperature[:, None])
    result: Array = np.sum(source * np.diff(transmittance, axis=0), axis=0)
    return result
