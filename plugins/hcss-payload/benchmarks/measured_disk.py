"""Water vapour image of a geostationary imager beside ours: brightness temperature against view zenith, and a picture.

    python plugins/hcss-payload/benchmarks/measured_disk.py OR_ABI-L1b-RadF-M6C08_G16_....nc --picture disk.png

FILE is an image of GOES ABI, channel 8 (5.8 to 6.6 um), full disk or sector. Around 6.2 um the air above 3 km hides the
sea: the 90th percentile of places with one view zenith is that of air without high clouds, and falls toward the limb.
Ours has air by latitude and season (`camera.climate = "latitude"`), low clouds, and a box for a response.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import xarray

import hcss_twin
from hcss_twin import Scenario
from hcss_twin.core.arrays import Array
from hcss_twin.physics.planck import planck

PIXELS, STEP_RAD, BAND_UM = 200, 1.55e-3, (5.8, 6.6)


def measured(path: Path) -> tuple[xarray.DataArray, float, str]:
    """Return brightness temperature over the fixed grid, the longitude of the satellite, and the time."""
    with xarray.open_dataset(path) as file:
        fk1, fk2, bc1, bc2 = (float(file[f"planck_{name}"]) for name in ("fk1", "fk2", "bc1", "bc2"))
        kelvin = (fk2 / np.log(fk1 / file["Rad"] + 1.0) - bc1) / bc2
        longitude = float(file["goes_imager_projection"].attrs["longitude_of_projection_origin"])
        return kelvin.load(), longitude, str(file.attrs["time_coverage_start"])[:19] + "Z"


def simulated(longitude: float, time: str, accuracy: float) -> xarray.Dataset:
    """Return a cube of the disk of that satellite and time."""
    scenario = Scenario.from_dict(
        {
            "seed": 3,
            "time": time,
            "bands": [{"name": "vapour", "limits": list(BAND_UM)}],
            "accuracy": accuracy,
            "place": {"latitude": 0.0, "longitude": longitude},
            "image": {"rows": 64, "columns": 64, "pixel_size": 3000.0},
            "frames": {"count": 1},
            "clouds": {"type": "stratus", "coverage": 0.5, "coverage_mode": "field"},
            "sea": {"wind_speed": 8.0},
            "output": {"certificate": 8},
            "camera": {
                "rows": PIXELS,
                "columns": PIXELS,
                "focal_length": 1.0,
                "detector_pitch": STEP_RAD,
                "points": 1,
                "beyond": "limb",
                "climate": "latitude",
            },
            "orbit": {"provider": "geostationary", "longitude": longitude},
        }
    )
    return hcss_twin.simulate(scenario)


def kelvin_of(radiance: Array) -> Array:
    """Return the temperature of a black body with the radiance of the box."""
    wavenumber = np.linspace(1e4 / BAND_UM[1], 1e4 / BAND_UM[0], 101)
    table = np.arange(100.0, 330.0, 0.5)
    known = np.array([np.trapezoid(planck(wavenumber, np.float64(each)), wavenumber) for each in table])
    return np.asarray(np.interp(radiance, known, table))


def main(options: argparse.Namespace) -> None:
    """Print brightness temperatures by view zenith, and draw both disks."""
    real, longitude, time = measured(options.file)
    cube = simulated(longitude, time, options.accuracy)
    ours = kelvin_of(cube["radiance"].values[0, 0].astype(float))
    zenith, kind = cube["pixel_view_zenith"].values[0], cube["pixel_kind"].values[0]
    angle = np.arctan((np.arange(PIXELS) - 0.5 * (PIXELS - 1)) * STEP_RAD)
    # The fixed grid counts x eastward and y northward; the first row is the northern one.
    x, y = np.meshgrid(angle, -angle)
    half = 0.5 * STEP_RAD
    there = np.full(ours.shape, np.nan)
    inside = (
        (x > float(real.x.min())) & (x < float(real.x.max())) & (y < float(real.y.max())) & (y > float(real.y.min()))
    )
    for row, column in np.argwhere(inside):
        own = real.sel(
            x=slice(x[row, column] - half, x[row, column] + half), y=slice(y[row, column] + half, y[row, column] - half)
        )
        there[row, column] = own.median()
    print(str(cube.attrs["hcss_certificate"])[:180])
    print("zenith, deg   places   measured 90th, 50th percentile, K   ours 90th, 50th, K")
    for low in range(15, 90, 10):
        here = (zenith >= low) & (zenith < low + 10) & ~np.isnan(there) & (kind <= 1)
        if np.count_nonzero(here) > 20:
            figures = [np.nanpercentile(each[here], share) for each in (there, ours) for share in (90, 50)]
            print(f"{low} to {low + 10}{np.count_nonzero(here):12}" + "".join(f"{each:14.1f}" for each in figures))
    if options.picture:
        import matplotlib.pyplot as plt

        figure, axes = plt.subplots(1, 2, figsize=(12, 6))
        for axis, image, title in zip(axes, (there, ours), ("measured", "simulated"), strict=True):
            shown = axis.imshow(image, vmin=210, vmax=260, cmap="gray_r")
            axis.set_title(f"{title}, {BAND_UM[0]} to {BAND_UM[1]} um, {time}")
        figure.colorbar(shown, ax=axes, label="brightness temperature, K")
        figure.savefig(options.picture)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path)
    parser.add_argument("--accuracy", type=float, default=0.03)
    parser.add_argument("--picture", type=Path)
    main(parser.parse_args())
