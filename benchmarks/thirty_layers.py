"""Sunlight that thirty layers of cloud reflect, against the discrete ordinates of PythonicDISORT.

    python benchmarks/thirty_layers.py            # some minutes; --write puts the table into accuracy-and-speed.md

Ten layers of ice crystals, ten of droplets within 5 deg of the glory or the cloudbow, ten with view or sun between 75
and 85 deg from the zenith. Geometry, air and sea are those of ``random_accuracy.py``, with numbers that it does not
use; cloud type, wavelength and optical thickness are drawn from ``SEED``. Below the layer it is black and cold.

The reference has 64 or 128 streams in both hemispheres with as many moments, and light scattered once of the full phase
function toward the very view (Nakajima and Tanaka). It shares moments and single-scattering albedo with ours, and no
code. Ours has the level that a plan of the scene takes for this band at 1e-3, and the finest that it may take. The
control, which must fail, is the level of the plan with light scattered once alone exact.
"""

from __future__ import annotations

import math
import sys
import time
import warnings
from dataclasses import dataclass

import numpy as np
from page import put
from PythonicDISORT.pydisort import pydisort
from PythonicDISORT.subroutines import interpolate
from random_accuracy import scenario

from hcss_twin import Scenario, make_plan
from hcss_twin.core.arrays import Array
from hcss_twin.models.parameters import PhysicalParameters
from hcss_twin.models.radiance.physical.numerics import LEVELS, Numerics, levels
from hcss_twin.physics.multiple_scattering.layer import solve_layers
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun
from hcss_twin.physics.planck import planck

SEED, EACH, FIRST, ACCURACY = 20261129, 10, 1000, 1e-3
BANDS, THICKNESS, FEW, MANY = ((2.7, 3.0), (3.0, 5.0), (8.0, 14.0)), (0.1, 30.0), 64, 128
WATER, ICE = ("stratus", "cumulus", "stratocumulus", "altocumulus"), ("cirrus", "altostratus")
GROUPS = {
    "ice": (("one layer",), ICE),
    "glory or bow": (("glory", "cloudbow"), WATER),
    "grazing": (("grazing",), WATER + ICE),
}


@dataclass(frozen=True)
class Layer:
    """A layer; cosines of view and sun, and azimuth; sizes of the plan; sunlight over emission, sr."""

    name: str
    slab: tuple[float, float, Array]
    toward: tuple[float, float, float]
    chosen: Numerics
    sun_to_emission: float

    def ours(self, sizes: Numerics, exact_orders: int = 2) -> float:
        """Brdf, sr-1."""
        (thickness, albedo, moments), (view, sun, azimuth) = self.slab, self.toward
        kept = sizes.sun_moments if exact_orders > 1 else sizes.sun_streams
        numbers = {"streams": sizes.sun_streams, "modes": kept, "kept_moments": kept, "exact_orders": exact_orders}
        return float(solve_sun([[thickness]], [albedo], moments, [view], sun, [azimuth], **numbers)[0][0, 0, 0])

    def reference(self, streams: int) -> float:
        """Brdf, sr-1, by discrete ordinates in both hemispheres."""
        (thickness, albedo, moments), (view, sun, azimuth) = self.slab, self.toward
        every = np.append(moments[:, 0], np.zeros(MANY + 1))
        sizes = {"NLeg": streams, "NFourier": streams, "f_arr": max(every[streams], 0.0)}
        field = pydisort(thickness, albedo, streams, every[np.newaxis], sun, 1.0, 0.0, **sizes)[4]
        return float(interpolate(field, "eval")(view, 0.0, math.pi - azimuth)) / sun


def drawn(group: str, number: int) -> Layer:
    """Draw a layer, and plan its scene."""
    (kinds, types), random = GROUPS[group], np.random.default_rng([SEED, list(GROUPS).index(group), number])
    band, cloud = BANDS[number % len(BANDS)], str(random.choice(types))
    wavelength, depth = float(random.uniform(*band)), float(np.exp(random.uniform(*np.log(THICKNESS))))
    scene = scenario(kinds[number % len(kinds)], FIRST + number)
    scene |= {"accuracy": ACCURACY, "bands": [list(band)], "clouds": {"layers": [{"type": cloud, "coverage": 0.5}]}}
    plan = make_plan(Scenario.from_dict(scene))
    layer, at = plan.layers[0], np.array([1e4 / wavelength])
    particles = plan.assembly.optics.single_scattering(layer.microphysics, at)
    slab = depth, float(particles.albedo[0]), particles.moments
    view, zenith, bearing = plan.view, float(plan.sun_zenith_deg[0]), float(plan.sun_azimuth_deg[0])
    turned = abs((view.azimuth_deg - bearing + 180.0) % 360.0 - 180.0)
    up, sun, azimuth = math.cos(math.radians(view.zenith_deg)), math.cos(math.radians(zenith)), math.radians(turned)
    kelvin = plan.assembly.profile.temperature_at(layer.top_m)
    emission = solve_layers([[depth]], slab[1:2], slab[2], [up], 16).emissivity[0, 0, 0] * planck(at, kelvin)[0]
    name = f"{group} {number}: {cloud}, {wavelength:.3f} um, thickness {depth:.3g}, albedo {slab[1]:.4f}"
    name += f", view {view.zenith_deg:.1f}, sun {zenith:.1f}, azimuth {turned:.1f} deg"
    chosen = levels(PhysicalParameters(), plan.numerics.sunlight_steps)[plan.numerics.level]
    return Layer(name, slab, (up, sun, azimuth), chosen, plan.assembly.solar_irradiance(at)[0] * sun / emission)


def main() -> None:
    """Print each layer and the table."""
    write = sys.argv[1:] == ["--write"]
    warnings.filterwarnings("ignore")  # of the reference: sharp peaks, many modes, moments that all fit
    begin = time.process_time()
    lines = ["| layers | streams | plan | plan, of the radiance | finest | 64 of 128 streams | control |"]
    lines += ["|---" * 7 + "|"]
    for group in GROUPS:
        rows, streams = [], []
        for layer in (drawn(group, number) for number in range(EACH)):
            exact, chosen = layer.reference(MANY), layer.chosen
            found = [layer.ours(chosen), layer.ours(LEVELS[-2]), layer.reference(FEW), layer.ours(chosen, 1)]
            (plan, finest, few, control), sunlight = (
                np.abs(np.divide(found, exact) - 1.0),
                exact * layer.sun_to_emission,
            )
            rows.append((plan, plan * sunlight / (1.0 + sunlight), finest, few, control))
            streams.append(chosen.sun_streams)
            errors = ", ".join(f"{error:.1e}" for error in rows[-1])
            print(f"{layer.name}; brdf {exact:.3g}, {streams[-1]} streams: {errors}", flush=True)
        cells = [f"{median:.1e}, {most:.1e}" for median, most in zip(np.median(rows, 0), np.max(rows, 0), strict=True)]
        lines.append(f"| {group}, {EACH} | {min(streams)} to {max(streams)} | " + " | ".join(cells) + " |")
    print("\n".join(lines), f"\n{time.process_time() - begin:.0f} s of a processor")
    if write:
        put("thirty layers", "\n".join(lines))


if __name__ == "__main__":
    main()
