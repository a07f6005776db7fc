"""Twenty columns of thin sunlit cloud over a rough sea near the glint, drawn before any result was known.

A column has no gas, so that only scattering and reflection are compared: one homogeneous cloud of water droplets over a
sea with isotropic Cox-Munk slopes that reflects once, without foam, at one wavenumber. The view is a node of
Gauss's rule with 64 nodes per hemisphere, where discrete ordinates need no interpolation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

SEED, SCENES, NODES = 40, 20, 64


@dataclass(frozen=True)
class GlintScene:
    """One column.

    Attributes
    ----------
    wavelength_um, mode_radius_um : float
        The latter of droplets with n(r) = a r^6 exp(-6 r / r_mode).
    optical_thickness : float
        Of the cloud.
    wind_m_s : float
    mu_view, mu_sun : float
        Cosines of the zenith angles.
    azimuth_deg : float
        Between the bearings toward sensor and sun; 180 is the glint.
    """

    wavelength_um: float
    mode_radius_um: float
    optical_thickness: float
    wind_m_s: float
    mu_view: float
    mu_sun: float
    azimuth_deg: float


def glint_scenes() -> list[GlintScene]:
    """Return the scenes, always the same."""
    rng = np.random.default_rng(SEED)
    nodes = 0.5 * (1.0 + np.polynomial.legendre.leggauss(NODES)[0])
    scenes = []
    for _ in range(SCENES):
        wanted = np.cos(np.radians(rng.uniform(50.0, 74.0)))
        scenes.append(
            GlintScene(
                wavelength_um=float(rng.uniform(3.4, 4.1)),
                mode_radius_um=float(rng.uniform(4.0, 8.0)),
                optical_thickness=float(np.exp(rng.uniform(np.log(0.05), np.log(1.5)))),
                wind_m_s=float(rng.uniform(3.0, 17.0)),
                mu_view=float(nodes[np.argmin(np.abs(nodes - wanted))]),
                mu_sun=float(np.cos(np.radians(rng.uniform(40.0, 72.0)))),
                azimuth_deg=float(rng.uniform(125.0, 180.0)),
            )
        )
    return scenes
