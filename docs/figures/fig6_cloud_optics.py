"""Draw Fig 6 of the HCSS paper, cloud optics at 0.3-14.3 um, with the optics providers.

::

    python docs/figures/fig6_cloud_optics.py FOLDER

writes ``fig6.png``: efficiencies and single-scattering albedo of cumulus, stratus and cirrus, and phase
functions at 3.7 and 10.8 um. Lines are provider ``bulk``, dotted ones ``mie`` (the paper's spheres).
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from hcss_twin.catalog import Catalog
from hcss_twin.optics.by_phase import BulkOptics
from hcss_twin.optics.mie import MieOptics
from hcss_twin.optics.parameters import BulkParameters, MieParameters
from hcss_twin.optics.phase_function import phase_function
from hcss_twin.optics.size_distribution import projected_area_m1
from hcss_twin.physics.henyey_greenstein import henyey_greenstein
from hcss_twin.providers import OpticsInputs
from hcss_twin.scenario.cloud_types import load_cloud_type

TYPES = {"cumulus": "tab:blue", "stratus": "tab:green", "cirrus": "tab:red"}
RANGE_UM = (0.3, 14.3)
PHASE_UM = (3.7, 10.8)


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit("usage: python docs/figures/fig6_cloud_optics.py FOLDER")
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    inputs = OpticsInputs(Catalog())
    providers = {
        "-": BulkOptics(inputs, BulkParameters()),
        ":": MieOptics(inputs, MieParameters()),
    }
    # Ice spheres are large: their forward peak has more moments than ship.
    in_full = {**providers, ":": MieOptics(inputs, MieParameters(moments=640))}
    figure = Figure(figsize=(11.0, 11.5), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(3, 2)
    efficiency, scattering, absorption, albedo, *angular = panels.ravel()
    wavelength = np.linspace(*RANGE_UM, 1401)
    angle = np.linspace(0.0, 180.0, 361)
    for name, colour in TYPES.items():
        cloud_type = load_cloud_type(name, inputs.catalog)
        cloud = cloud_type.microphysics.particles(cloud_type.layer.phase)
        area = projected_area_m1(cloud)
        for style, provider in providers.items():
            found = provider.single_scattering(cloud, 1e4 / wavelength[::-1])
            q_ext, share = found.extinction_m1[::-1] / area, found.albedo[::-1]
            look = {"color": colour, "linestyle": style, "linewidth": 1.2}
            label = name if style == "-" else None
            efficiency.plot(wavelength, q_ext, label=label, **look)
            scattering.plot(wavelength, q_ext * share, label=label, **look)
            absorption.plot(wavelength, q_ext * (1.0 - share), label=label, **look)
            albedo.plot(wavelength, share, label=label, **look)
            for axis, at_um in zip(angular, PHASE_UM, strict=True):
                moments = in_full[style].single_scattering(cloud, np.array([1e4 / at_um])).moments
                mu = np.cos(np.radians(angle))
                if moments.shape[0] == 2:
                    values = henyey_greenstein(mu, moments[1, 0])
                else:
                    values = phase_function(moments, mu)[:, 0]
                axis.semilogy(angle, values, label=label, **look)
    titles = {
        efficiency: "(a) extinction efficiency",
        scattering: "(b) scattering efficiency",
        absorption: "(c) absorption efficiency",
        albedo: "(d) single-scattering albedo",
        angular[0]: f"(e) phase function at {PHASE_UM[0]} um",
        angular[1]: f"(f) phase function at {PHASE_UM[1]} um",
    }
    for axis, title in titles.items():
        axis.set_title(title, fontsize=11)
        axis.grid(alpha=0.3)
        if axis in angular:
            axis.set_xlabel("scattering angle (deg)")
            axis.set_xlim(0.0, 180.0)
        else:
            axis.set_xlabel("wavelength (um)")
            axis.set_xlim(*RANGE_UM)
            axis.set_ylim(bottom=0.0)
    efficiency.legend(fontsize=9)
    figure.suptitle(
        "solid: provider bulk (water at 273 K, rough crystals); dotted: provider mie (water at 298 K, ice spheres)",
        fontsize=10,
    )
    figure.savefig(folder / "fig6.png", dpi=110)


if __name__ == "__main__":
    main()
