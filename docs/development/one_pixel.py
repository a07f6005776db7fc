"""The radiance of three pixels at 10.8 um, by hand: clear, thin and thick cloud, seen from straight above by night.

    python docs/development/one_pixel.py

It needs PythonicDISORT (``pip install PythonicDISORT``). Each step names the file where ``hcss run`` does the same for
all pixels at once, in tables. No table, no interpolation and no radiance model of the package is used here.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from PythonicDISORT.pydisort import pydisort
from scipy.interpolate import BarycentricInterpolator

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.core.arrays import Array
from hcss_twin.physics.paths import Leg, Path, to_space
from hcss_twin.physics.planck import planck

SCENE = {
    "time": "2024-04-20T23:30:00+09:00",
    "view.zenith": 0.0,
    "bands": ["lwir-10.8"],
    "clouds.layers.0.temperature": 280.0,
    "sea.temperature_texture": 0.0,
    "image.rows": 64,
    "image.columns": 64,
    "frames.count": 1,
    "output.variables": ["radiance", "cloud_thickness"],
}
"""Changes of the shipped scene ``stratus``: by night, a cloud of one temperature, an even sea."""

STREAMS, MOMENTS, PARTS = 32, 300, 8


def by_hand(thickness_m: float) -> float:
    """Return the radiance of a pixel under so much cloud, W m-2 sr-1, in ten steps."""
    # 1. Read the scene, fill in what it leaves out, and make the providers (scenario/, plan/assemble.py).
    scene = make_plan(Scenario.load("stratus", SCENE)).assembly
    air, profile, (layer,) = scene.transmittance, scene.profile, scene.layers
    # 2. Wavenumbers of the band and their weights: response times width (models/radiance/spectral_grid.py).
    wavenumber, (weight,) = scene.spectral_grid.wavenumber_cm1, scene.spectral_grid.weights_cm1
    # 3. The lower end of the air that is seen: the sea, or the top of the cloud (providers/clouds.py).
    bottom = float(layer.cloud_top_m(np.array([thickness_m]))[0]) if thickness_m else 0.0
    # 4. Thin parts of the air above it, from the ground up, and the temperature of each (physics/profile.py).
    levels = np.append(bottom, profile.altitude_m[profile.altitude_m > bottom])
    levels = np.unique(np.concatenate([np.linspace(*ends, PARTS + 1) for ends in pairwise(levels)]))
    black = np.array([planck(wavenumber, profile.temperature_at(z)) for z in 0.5 * (levels[1:] + levels[:-1])])
    # 5. Transmittance from each level to space (models/atmosphere/band_model/); no legs: 1.
    to_sensor = air.transmittance(wavenumber, [to_space(float(z), 0.0) for z in levels[:-1]] + [Path()])
    # 6. Emission of the air upward: what each part emits times what passes the parts above it
    #    (models/radiance/physical/air.py).
    upward = np.sum(black * np.diff(to_sensor, axis=0), axis=0)
    # 7. The sky as it is seen from that lower end, at several zenith angles: each part emits down to the lower end,
    #    where the light turns up to the sensor. The transmittance of that whole path is computed, and that of the way
    #    up is divided off: what comes down lacks the wavelengths that air absorbs, so that transmittances of bands do
    #    not multiply (models/radiance/physical/tracing.py).
    cosines = np.append(1.0, 0.5 + 0.5 * np.polynomial.legendre.leggauss(STREAMS // 2)[0])
    sky = np.empty((cosines.size, wavenumber.size))
    for number, zenith in enumerate(np.degrees(np.arccos(cosines))):
        through = [Path((Leg(bottom, float(z), float(zenith)),)) + to_space(bottom, 0.0) for z in levels]
        sky[number] = np.sum(black * -np.diff(air.transmittance(wavenumber, through), axis=0), axis=0) / to_sensor[0]
    # 8. The sea emits what it does not reflect (models/sea/rough_sea.py).
    emissivity = scene.sea.emissivity(wavenumber, np.ones(1))[0]
    sea = planck(wavenumber, scene.sea_temperature_K)
    if not thickness_m:
        return float((upward + (emissivity * sea + (1.0 - emissivity) * sky[0]) * to_sensor[0]) @ weight)
    # 9. The cloud. Mie theory gives extinction, albedo and phase function of its droplets (models/optics/mie.py).
    #    PythonicDISORT computes multiple scattering; the package has adding-doubling (physics/multiple_scattering/).
    #    The sea mirrors what the cloud sends straight down, and shines evenly: it reflects 1 % there. The air below the
    #    top of the cloud is left out.
    optics = scene.optics.single_scattering(layer.microphysics, wavenumber)
    depth, cloud = optics.extinction_m1 * thickness_m, planck(wavenumber, layer.temperature_K)
    leaving = np.empty(wavenumber.size)
    for v in range(wavenumber.size):
        of_cloud = depth[v], optics.albedo[v], optics.moments[:, v], cloud[v], sky[1:, v]
        _, downward = leaving_cloud(*of_cloud, below=0.0)
        ground = emissivity[v] * sea[v] + (1.0 - emissivity[v]) * downward
        leaving[v], _ = leaving_cloud(*of_cloud, below=ground)
    # 10. Add up, and sum over the band (engine/tables/columns.py).
    return float((upward + leaving * to_sensor[0]) @ weight)


def leaving_cloud(
    depth: float, albedo: float, moments: Array, cloud: float, sky: Array, below: float
) -> tuple[float, float]:
    """Return what leaves an isothermal cloud straight upward and downward.

    ``cloud`` is its Planck radiance, ``sky`` that of the air at the cosines of the streams, ``below`` that of the sea.
    """
    phase = np.zeros(MOMENTS)
    phase[: moments.size] = moments[:MOMENTS]
    cosine, _, _, mean = pydisort(
        np.array([depth]), np.array([albedo]), STREAMS, phase[None, :], 1.0, 0.0, 0.0,
        NLeg=STREAMS, NFourier=1, f_arr=phase[STREAMS : STREAMS + 1], b_pos=below, b_neg=sky,
        s_poly_coeffs=np.array([[cloud, 0.0]]), only_flux=True,
    )[:4]  # fmt: skip
    up = cosine > 0.0
    ends = (mean(0.0)[up], cosine[up], 1.0), (mean(depth)[~up], cosine[~up], -1.0)
    return tuple(float(BarycentricInterpolator(nodes, values)(at)) for values, nodes, at in ends)


def of_cube() -> tuple[Array, Array]:
    """Return thickness and radiance of all pixels as ``hcss run`` computes them."""
    cube = simulate(Scenario.load("stratus", SCENE))
    return cube["cloud_thickness"].values.ravel(), cube["radiance"].values.ravel()


if __name__ == "__main__":
    thickness, radiance = of_cube()
    cloudy = np.flatnonzero(thickness)
    thin, thick = (int(cloudy[find(thickness[cloudy])]) for find in (np.argmin, np.argmax))
    for pixel in (int(np.argmin(thickness)), thin, thick):
        known = by_hand(float(thickness[pixel]))
        print(f"thickness {thickness[pixel]:6.1f} m: cube {radiance[pixel]:.5f}, by hand {known:.5f} W m-2 sr-1")
