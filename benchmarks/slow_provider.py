"""Time of a scene with a slow gas provider of another package: 0.5 ms per wavenumber and call.

    python benchmarks/slow_provider.py [scenario] [--thread-safe]

Prints the number of calls, wavenumbers and paths asked for, and the seconds of plan, tables and certificate, with paths
gathered into few calls (as a run does) and one call for each leg (as version 0.1.0 did).
"""

import argparse
import importlib
import os
import tempfile
import threading
import time
from unittest import mock

from hcss_twin import Scenario, make_plan
from hcss_twin.engine.simulate import run
from hcss_twin.models.radiance.physical import gathered_paths
from hcss_twin.providers import AtmosphereDeclaration
from hcss_twin.providers.registry import Origin, ProviderSpec, Registry, hookimpl
from hcss_twin.testing import PlainGas

SECONDS_PER_WAVENUMBER = 5e-4


class SlowGas(PlainGas):
    """Grey gas that computes for a fixed time per wavenumber and call, outside Python's lock."""

    thread_safe = False
    calls, wavenumbers, paths = 0, 0, 0
    lock = threading.Lock()

    def __init__(self, inputs, parameters):
        super().__init__(inputs.profile)
        self.declares = AtmosphereDeclaration()

    def transmittance(self, wavenumber_cm1, paths):
        """Return transmittance (P, V) after the time it takes."""
        with SlowGas.lock:
            SlowGas.calls += 1
            SlowGas.wavenumbers += wavenumber_cm1.size
            SlowGas.paths += len(paths)
        time.sleep(SECONDS_PER_WAVENUMBER * wavenumber_cm1.size)
        return super().transmittance(wavenumber_cm1, paths)


class Plugin:
    """Registers it."""

    @hookimpl
    def hcss_register_transmittance_providers(self):
        """Return the provider."""
        return [ProviderSpec("slow-gas", "slow_provider:SlowGas", None, 2, "grey gas that takes its time")]


def measured(scenario, gathers):
    """Run a scene without cached results and print what it took."""
    SlowGas.calls = SlowGas.wavenumbers = SlowGas.paths = 0
    registry = Registry.defaults_only()
    registry.add(Plugin(), Origin("slow", "hcss-slow", "1"))
    discover = mock.patch.object(Registry, "discover", classmethod(lambda cls: registry))
    apart = mock.patch.object(gathered_paths, "GATHERS", gathers)
    with tempfile.TemporaryDirectory() as folder, discover, apart, mock.patch.dict(os.environ, HCSS_CACHE_DIR=folder):
        start = time.perf_counter()
        plan = make_plan(Scenario.load(scenario, {"atmosphere.provider": "slow-gas"}))
        planned = time.perf_counter()
        run(plan, f"{folder}/cube.nc")
        ended = time.perf_counter()
    how = "gathered" if gathers else "one by one"
    print(
        f"{how:<12}{SlowGas.calls:6d} calls {SlowGas.wavenumbers:8d} wavenumbers {SlowGas.paths:9d} paths  "
        f"plan {planned - start:6.1f} s  run {ended - planned:6.1f} s",
        flush=True,
    )
    return ended - start


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", default="stratus")
    parser.add_argument("--thread-safe", action="store_true", help="declare the provider so")
    given = parser.parse_args()
    SlowGas.thread_safe = given.thread_safe
    few, many = (measured(given.scenario, gathers) for gathers in (True, False))
    print(f"ratio {many / few:.1f}")


if __name__ == "__main__":
    importlib.import_module("slow_provider").main()  # the registry imports the provider by the name of its module
