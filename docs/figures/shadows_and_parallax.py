"""Draw cumulus in the 3-5 um glint without and with shadows and parallax.

::

    python docs/figures/shadows_and_parallax.py            # writes docs/images/shadows-and-parallax.png
    python docs/figures/shadows_and_parallax.py other.png

Also prints the numbers that docs/shadows-and-parallax.md quotes.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from hcss_twin import Scenario, simulate

IMAGE = Path(__file__).parents[1] / "images" / "shadows-and-parallax.png"
OPTIONS = {
    "no shadows, no parallax": {"slant.shadows": "off", "slant.parallax": "off"},
    "shadows": {"slant.shadows": "on", "slant.parallax": "off"},
    "shadows and parallax": {"slant.shadows": "on", "slant.parallax": "on"},
}
# In the afternoon, looking toward the glint.
SCENE = {
    "time": "2024-04-20T15:00:00+10:00",
    "view.zenith": 45.0,
    "view.azimuth": 65.0,
    "image.rows": 400,
    "image.columns": 400,
    "frames.count": 1,
    "bands": ["mwir"],
    "sea.waves": "off",
    "clouds.coverage": 0.15,
    "clouds.coverage_mode": "field",
    "clouds.base": 700.0,
    "clouds.top": 1900.0,
    "clouds.edge_taper": 0.5,
    "output.variables": ["radiance", "radiance_sea_reflected_sun", "cloud_mask", "shadow_mask"],
    "output.certificate": 0,
}


def cube(options: dict[str, object]) -> xr.Dataset:
    """The scene with some options."""
    scene = dict(SCENE)
    if options["slant.shadows"] == "off":
        scene["output.variables"] = SCENE["output.variables"][:-1]
    return simulate(Scenario.load("cumulus", scene | options))


def main() -> int:
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else IMAGE
    cubes = {title: cube(options) for title, options in OPTIONS.items()}
    plain = cubes["no shadows, no parallax"]
    values = [each.radiance.values[0, 0] for each in cubes.values()]
    low, high = min(map(np.min, values)), max(map(np.max, values))
    figure, axes = plt.subplots(1, 3, figsize=(13.5, 4.9), layout="constrained", sharey=True)
    for axis, (title, each) in zip(axes, cubes.items(), strict=True):
        x, y = each.x.values / 1000, each.y.values / 1000
        extent = (x[0], x[-1], y[0], y[-1])
        shown = axis.imshow(each.radiance[0, 0], origin="lower", extent=extent, cmap="gray", vmin=low, vmax=high)
        axis.set(title=title, xlabel="east, km")
    axes[0].set_ylabel("north, km")
    figure.colorbar(shown, ax=axes, label="radiance 3-5 um, W m-2 sr-1", shrink=0.9)
    sun = float(plain.solar_zenith_angle[0]), float(plain.solar_azimuth_angle[0])
    figure.suptitle(
        f"Sun at zenith {sun[0]:.0f} deg, azimuth {sun[1]:.0f} deg; sensor at {SCENE['view.zenith']:g} deg, "
        f"{SCENE['view.azimuth']:g} deg"
    )
    figure.savefig(target, dpi=110)
    clear = plain.cloud_mask[0] == 0
    share = float((plain.radiance_sea_reflected_sun / plain.radiance)[0, 0].where(clear).max())
    shaded = cubes["shadows"]
    print(f"glint in the clear radiance: {share:.1%}")
    print(f"clear pixels in shadow: {float(shaded.shadow_mask[0].where(clear).mean()):.1%}")
    change = (plain.radiance / shaded.radiance)[0, 0]
    print(f"darkest shadow: 1 / {float(change.max()):.1f} of the sunlit sea")
    return 0


if __name__ == "__main__":
    sys.exit(main())
