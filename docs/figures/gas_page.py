"""Write ``docs/development/gas.md``: effect of the fitted gas coefficients, and errors of both sets of coefficients.

::

    HCSS_SAMPLE_DATA=FOLDER HCSS_RRTMGP_DATA=FOLDER python docs/figures/gas_page.py    # two minutes

Needs the runs of MODTRAN (``tests/sample_data.py``) and the tables of RRTMGP (``benchmarks/gas_reference.py``).
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "benchmarks"))

import gas_modtran  # noqa: E402
import gas_reference  # noqa: E402

from hcss_twin import Scenario, simulate  # noqa: E402
from hcss_twin.core.one_thread import in_one_thread  # noqa: E402
from hcss_twin.models.parameters import COEFFICIENTS  # noqa: E402
from hcss_twin.physics.paths import to_space  # noqa: E402

PAGE = ROOT / "docs" / "development" / "gas.md"
SCENES = ("stratus", "cumulus", "cirrus")
BANDS = {"swir-2.7-3.0": "2.7-3.0", "mwir": "3-5", "lwir": "8-14"}
IMAGE: dict[str, Any] = {
    "bands": list(BANDS),
    "image": {"rows": 64, "columns": 64, "pixel_size": 100.0},
    "frames.count": 1,
    "output": {"variables": ["radiance", "brightness_temperature", "cloud_mask"], "certificate": 0},
}
NIGHT = "2024-04-20T00:30:00+10:00"
CASES: dict[str, dict[str, Any]] = {
    "0.1": {
        "atmosphere.coefficients": "lowtran7",
        "atmosphere.gases.others": "profile",
        "optics.parameters.ice_phase_function": "henyey-greenstein",
        "sea.temperature_texture": 0.0,
    },
    "lowtran7": {"atmosphere.coefficients": "lowtran7"},
    "now": {"atmosphere.coefficients": "rrtmgp"},
}


def means(scene: str, case: str, overrides: dict[str, Any]) -> dict[str, np.ndarray]:
    """Return mean radiance and brightness temperature (2, bands) of clear and of cloudy pixels."""
    cube = simulate(Scenario.load(scene, {**IMAGE, **CASES[case], **overrides}))
    cloudy = cube.cloud_mask[0].to_numpy() > 0
    found = [cube[name][0].transpose("band", ...).to_numpy() for name in ("radiance", "brightness_temperature")]
    return {
        pixels: np.stack([each[:, chosen].mean(axis=1, dtype=float) for each in found])
        for pixels, chosen in (("clear", ~cloudy), ("cloudy", cloudy))
    }


def scenes() -> Iterator[str]:
    """Yield the table of shipped scenes before and after."""
    yield "| scene | pixels | um | radiance, W m-2 sr-1, 0.1 → now | change | K | of which coefficients | K |"
    yield "|---|---|---|---|---|---|---|---|"
    for when, scene in product(("day", "night"), SCENES):
        by_case = {case: means(scene, case, {"time": NIGHT} if when == "night" else {}) for case in CASES}
        for pixels in ("clear", "cloudy"):
            if pixels == "clear" and scene != SCENES[0]:
                continue  # the same air and sea
            old, same_gases, now = (by_case[case][pixels] for case in CASES)
            for number, um in enumerate(BANDS.values()):
                changes = [
                    f"{100 * (now[0, number] / each[0, number] - 1):+.2f} % | {now[1, number] - each[1, number]:+.2f}"
                    for each in (old, same_gases)
                ]
                name = "clear sea" if pixels == "clear" else scene
                yield (
                    f"| {name}, {when} | {pixels} | {um} | {old[0, number]:.4g} → {now[0, number]:.4g} | "
                    f"{changes[0]} | {changes[1]} |"
                )


def against_rrtmgp() -> Iterator[str]:
    """Yield the table of errors by RRTMGP band of the LOWTRAN7 and the fitted coefficients."""
    yield "| um | radiance, % | K | mean, K | transmittance | largest | sun, two-way, % |"
    yield "|---|---|---|---|---|---|---|"
    both = [list(gas_reference.deviations(COEFFICIENTS[name])) for name in ("lowtran7", "rrtmgp")]
    for pair in zip(*both, strict=True):
        low, high = pair[0].band_cm1

        def cells(name: str, spec: str, factor: float = 1.0, pair: Any = pair) -> str:
            values = [factor * getattr(each, name) for each in pair]
            return "" if np.isnan(values[0]) else " → ".join(format(each, spec) for each in values)

        yield (
            f"| {1e4 / high:.2f}-{1e4 / low:.2f} | {cells('radiance', '.2f', 100)} | {cells('kelvin', '.2f')} | "
            f"{cells('bias_K', '+.2f')} | {cells('transmittance', '.4f')} | {cells('transmittance_max', '.3f')} | "
            f"{cells('sun', '.1f', 100)} |"
        )


def nadir() -> Iterator[str]:
    """Yield a table of the errors of nadir radiance to space."""
    yield "| um | LOWTRAN7, mean % | fitted, mean % | rms % | largest % | with all gases, mean % | rms % | largest % |"
    yield "|---|---|---|---|---|---|---|---|"
    old, new = COEFFICIENTS["lowtran7"], COEFFICIENTS["rrtmgp"]
    runs = (gas_reference.nadir(old, alike=True), *(gas_reference.nadir(new, alike=each) for each in (True, False)))
    for before, alike, whole in zip(*runs, strict=True):
        (low, high), *figures = alike
        cells = [f"{100.0 * before[1]:+.2f}"]
        for mean, rms, largest in (figures, whole[1:]):
            cells += [f"{100.0 * mean:+.2f}", f"{100.0 * rms:.2f}", f"{100.0 * largest:.1f}"]
        yield f"| {1e4 / high:.2f}-{1e4 / low:.2f} | {' | '.join(cells)} |"


def changes_with_gases() -> Iterator[str]:
    """Yield how many responses of transmittance to gas amounts are within bounds, and the bands of the others."""
    for name in ("lowtran7", "rrtmgp"):
        found = list(gas_reference.gas_changes(COEFFICIENTS[name]))
        off = [each for each in found if not gas_reference.within(each)]
        where = sorted({each[2] for each in off})
        counts = ", ".join(f"{low}-{high} ({sum(each[2] == (low, high) for each in off)})" for low, high in where)
        worst = max(100 * abs(each[4] - each[3]) for each in off)
        yield (
            f"* `{name}`: {len(found) - len(off)} of {len(found)}. The others differ by up to {worst:.1f} percentage "
            f"points; their number by band in cm-1: {counts}."
        )


@in_one_thread
def cost() -> str:
    """Return the processor time of a path with fitted coefficients relative to LOWTRAN7's, for three bands."""
    names = ("lowtran7", "rrtmgp")
    gases = [gas_modtran.provider(COEFFICIENTS[name], "us-standard-1976", "maritime") for name in names]
    grid = gases[0].declares.native_grid_cm1
    assert grid is not None
    ratios = []
    for low, high in ((3333.0, 3704.0), (2000.0, 3333.0), (714.0, 1250.0)):
        nodes = grid[(grid >= low) & (grid <= high)]
        for emission in (False, True):
            best = [np.inf, np.inf]
            for repeat in range(7):
                for which, gas in enumerate(gases):
                    paths = [to_space(100.0 * k + repeat, 30.0) for k in range(20 if emission else 150)]
                    start = time.process_time()
                    (gas.path_radiance if emission else gas.transmittance)(nodes, paths)
                    best[which] = min(best[which], time.process_time() - start)
            ratios.append(best[1] / best[0])
    return (
        f"A transmittance costs {ratios[0]:.2f}, {ratios[2]:.2f} and {ratios[4]:.2f} times as much as with LOWTRAN7's "
        f"coefficients (2.7-3.0, 3-5, 8-14 um), an emission {ratios[1]:.2f}, {ratios[3]:.2f} and {ratios[5]:.2f} times."
    )


def lines() -> Iterator[str]:
    """Yield the lines of the page."""
    yield "# What the new gas changed"
    yield ""
    yield "*Written by `python docs/figures/gas_page.py`; do not edit.*"
    yield ""
    yield "Since version 0.2 the band model uses coefficients fitted to RRTMGP's gas optics"
    yield '([air](optics-sea-and-air.md#air)). `coefficients = "lowtran7"` selects those of LOWTRAN7,'
    yield '`gases.others = "profile"` the gas amounts of version 0.1.'
    yield ""
    yield "## Scenes before and after"
    yield ""
    yield "Mean radiance and brightness temperature of the clear or cloudy pixels of shipped scenes, 64 x 64 pixels"
    yield "of 100 m. The last two columns are the effect of the coefficients alone. The gas amounts of the scene's year"
    yield "cause the rest of the change, in `cirrus` also the phase function of ice."
    yield ""
    yield from scenes()
    yield ""
    yield "## Against RRTMGP"
    yield ""
    yield "Root-mean-square errors, LOWTRAN7 → fitted, for 40 profiles that are not part of the fit: black targets at"
    yield "0, 3, 6 and 10 km, zenith 0 to 80 deg, only gases that both models include. The columns of means and largest"
    yield "errors are labelled."
    yield ""
    yield from against_rrtmgp()
    yield ""
    yield "## Nadir to space"
    yield ""
    yield "Radiance of a black sea seen from space at nadir, the same 40 profiles. At 3.08-4.18 um the fit gives such"
    yield "paths more weight. Gases that only the band model has there (CH4, O3, SO2, N2O) absorb what RRTMGP leaves"
    yield "out: *with all gases* is the model as it is used."
    yield ""
    yield from nadir()
    yield ""
    yield "At 8.47-12.20 um the references disagree: 5 km of tropical air at the sea transmit 0.171 by RRTMGP (MT_CKD)"
    yield "and 0.185 by LOWTRAN7, which MODTRAN confirms for 8-14 um to .2 %. For warm horizontal paths the fit follows"
    yield "LOWTRAN7, for all others RRTMGP, and transmits 0.183 there. It moves nadir radiance by .1 % (.1 K)."
    yield ""
    yield "## Response to gases"
    yield ""
    yield "Response of transmittance to CO2, CH4, N2O, O3 and CO (factors 0.5, 1.3 and 2): number of cases within 10 %"
    yield "or 0.15 percentage points of RRTMGP's response."
    yield ""
    yield from changes_with_gases()
    yield ""
    yield "## Against MODTRAN"
    yield ""
    yield "Means over wavenumbers. The MODTRAN runs are not part of the fit, but they determined where LOWTRAN7's"
    yield "coefficients, continua and spectral structure are kept."
    yield ""
    yield from gas_modtran.table()
    yield ""
    yield "## Cost"
    yield ""
    yield cost()


if __name__ == "__main__":
    PAGE.write_text("\n".join(lines()) + "\n", encoding="utf-8")
