"""Sunlight that thirty layers of cloud reflect, against the discrete ordinates of PythonicDISORT.

    python benchmarks/thirty_layers.py            # the table of accuracy-and-speed.md, three minutes

Ten layers of ice crystals, ten of droplets within 5 deg of the glory or the cloudbow, ten with view or sun between 75
and 85 deg from the zenith, over black. Geometry, air and sea are those of ``random_accuracy.py``, with numbers that it
does not use; cloud type, wavelength and thickness are drawn from ``SEED``. The reference has as many moments as streams
in both hemispheres, 64, 128 or the first of ``MOST`` that leaves no moment above ``RESOLVED`` (other layers are not in
the table), and light scattered once of the full phase function toward the very view. It shares moments and albedo with
ours, and no code; moments that end early go on as they end. Ours has the level that a plan takes for the band at 1e-3,
and the finest that it may take. The control, which must fail, is that level with light scattered once alone exact.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass

import numpy as np
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

SEED, EACH, FIRST, ACCURACY, RESOLVED = 20261129, 10, 1000, 1e-3, 1e-6
BANDS, THICKNESS, FEW, MOST = ((2.7, 3.0), (3.0, 5.0), (8.0, 14.0)), (0.1, 30.0), 64, (128, 256, 384, 512)
HEAD = "| layers | our streams | plan, of the radiance | plan | finest | plan of 128 | 64 of 128 | 128 | control |"
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

    def moments(self) -> Array:
        """Moments up to the most streams; droplets have 128, of which the last one counts at 2.7 um."""
        known = self.slab[2][:, 0]
        falls = (known[-1] / known[-17]) ** (1 / 16) if known[-1] > RESOLVED else 0.0
        return np.append(known, known[-1] * falls ** np.arange(1, MOST[-1] + 2))

    def reference(self, streams: int) -> float:
        """Brdf, sr-1, by discrete ordinates in both hemispheres."""
        (thickness, albedo, _), (view, sun, azimuth), every = self.slab, self.toward, self.moments()
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
    angles = f"view {view.zenith_deg:.1f}, sun {zenith:.1f}, azimuth {turned:.1f} deg"
    name = f"{group} {number}: {cloud}, {wavelength:.3f} um, thickness {depth:.3g}, {angles}"
    chosen = levels(PhysicalParameters(), plan.numerics.sunlight_steps)[plan.numerics.level]
    return Layer(name, slab, (up, sun, azimuth), chosen, plan.assembly.solar_irradiance(at)[0] * sun / emission)


def main() -> None:
    """Print each layer and the table."""
    warnings.filterwarnings("ignore")  # of the reference: sharp peaks, many modes, moments that all fit
    lines = [HEAD, "|---" * (HEAD.count("|") - 1) + "|"]
    for group in GROUPS:
        rows = []
        for layer in (drawn(group, number) for number in range(EACH)):
            most = next((count for count in MOST if layer.moments()[count] < RESOLVED), MOST[-1])
            exact, many, few = (layer.reference(count) for count in (most, MOST[0], FEW))
            plan, finest, control = (layer.ours(*at) for at in ((layer.chosen,), (LEVELS[-2],), (layer.chosen, 1)))
            pairs = (plan, exact), (finest, exact), (plan, many), (few, many), (many, exact), (control, exact)
            errors = [abs(a / b - 1.0) for a, b in pairs]
            errors.insert(0, errors[0] / (1.0 + 1.0 / (exact * layer.sun_to_emission)))
            print(f"{layer.name}; {layer.chosen.sun_streams}, {most} streams:", *map("{:.1e}".format, errors))
            if layer.moments()[most] < RESOLVED:
                rows.append([layer.chosen.sun_streams, *errors])
        least, median, largest = np.min(rows, 0), np.median(rows, 0), np.max(rows, 0)
        cells = [f"{a:.1e}, {b:.1e}" for a, b in zip(median[1:], largest[1:], strict=True)]
        lines.append(f"| {group}, {len(rows)} | {least[0]:.0f} to {largest[0]:.0f} | " + " | ".join(cells) + " |")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
