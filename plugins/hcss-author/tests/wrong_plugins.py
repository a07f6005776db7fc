"""Wrong packages: which does the kit (``hcss check``) refuse, and which does a run, before and during its first frames?

    python plugins/hcss-author/tests/wrong_plugins.py              # all, about two minutes
    python plugins/hcss-author/tests/wrong_plugins.py --match Sea

Writes ``wrong_plugins.csv``: the law that refuses each package first, and whether a run does.
"""

import argparse
import csv
import os
import sys
import tempfile
import warnings
from pathlib import Path

import hcss_author
import numpy as np
import pytest
from hcss_author.new_plugin.write import contract_name
from wrong_of_templates import WRONG

import hcss_twin
from hcss_twin import HcssError
from hcss_twin.providers import Kind, ProviderSpec, hookimpl
from hcss_twin.providers.registry import Origin, Registry

HERE = Path(__file__).parent
sys.path.append(str(HERE.parents[2] / "campaigns" / "wrong_providers"))

from kit_run import laws_broken  # noqa: E402 - of the campaign

SCENE = """
place = {latitude = 35.0, longitude = 150.0}
time = 2024-04-20T12:30:00+10:00
image = {rows = 24, columns = 32, pixel_size = 200.0}
motion = {platform_speed = 100.0, wind_speed = 7.0, wind_from = 300.0}
frames = {count = 2, interval = 2.0}
bands = ["mwir-3.7", "lwir-10.8"]
view = {zenith = 30.0}
accuracy = 1e-2
output.certificate = 4
clouds = {type = "stratus", coverage = 0.4}
radiance.model = "as-printed"
sea.model = "cox-munk"
optics.provider = "mie"
slant = {shadows = "off", parallax = "off"}
"""

KEYS = {
    "clouds": lambda name: {"clouds.generator": name},
    "sea": lambda name: {"sea.model": name},
    "optics": lambda name: {"optics.provider": name},
    "atmosphere": lambda name: {"atmosphere.provider": name},
    "radiance": lambda name: {"radiance.model": name},
    "elements": lambda name: {"elements": [{"provider": name}]},
    "surfaces": lambda name: {"surfaces.provider": name},
    "variables": lambda name: {
        "output.derived": [{"provider": name}],
        "output.variables": ["radiance", "brightness_temperature", "temperature_difference", "difference_flag"],
    },
    "sensors": lambda name: {"sensor.model": name},
}
"""Changes of the scenario that select a provider of a kind."""


def refused_by_kit(cases, most=1):
    """Return the laws that refuse each (kind, class): the first, or with ``most`` of 0 all."""
    return [laws for laws, _ in laws_broken([(Case(kind, cls), None, None) for kind, cls in cases], most)]


class Case:
    """A provider class as ``laws_broken`` takes it: each is held to the kit with the parameters of its template."""

    def __init__(self, kind, cls):
        self.name, self._kind, self._cls = cls.__name__, Kind(kind), cls

    def kit(self, folder):
        module, cls = parameters_of(self._kind), self._cls

        def make_provider(self, inputs):
            return cls(inputs, module.Parameters())

        contract = getattr(hcss_author, contract_name(self._kind))
        return type(f"Test{self.name}", (contract,), {"make_provider": make_provider})


def parameters_of(kind):
    """Return the template of a kind."""
    return __import__(f"hcss_author.new_plugin.templates.{kind}", fromlist=["Parameters"])


def refused_by_run(kind, cls):
    """Return the error of a run with a provider class, or nothing; the package is installed for the run alone."""

    def specs(self):
        parameters = f"hcss_author.new_plugin.templates.{kind}:Parameters"
        target = f"{cls.__module__}:{cls.__name__}"
        return [ProviderSpec("mine", target, parameters, 3, "a package under test")]

    hook = Kind(kind).hook
    specs.__name__ = hook
    registry = Registry.defaults_only()
    registry.add(type("Hooks", (), {hook: hookimpl(specs)})(), Origin("mine", "hcss-mine", "1.0"))
    with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        patch.setattr(Registry, "discover", classmethod(lambda cls: registry))
        try:
            scenario = hcss_twin.Scenario.from_toml(SCENE, KEYS[kind]("mine"))
            cube = hcss_twin.simulate(scenario)
            if kind == "sensors":
                cube = hcss_twin.sense(cube, scenario)
            if not np.all(np.isfinite(cube["radiance"])):
                return "radiance is not finite"
            if cube.attrs.get("hcss_certificate_passed", "true") in ("false", 0, False):
                return "the certificate does not pass"
        except HcssError as error:
            return str(error)
    return ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    count = len({wrong.name for wrong in WRONG})
    assert count == len(WRONG), "names are not unique"
    parser.add_argument("--match", default="", help="only names that contain this")
    given = parser.parse_args()
    chosen = [wrong for wrong in WRONG if given.match in wrong.name]
    with tempfile.TemporaryDirectory() as cache:
        os.environ["HCSS_CACHE_DIR"] = cache
        by_kit = refused_by_kit([(wrong.kind, wrong.cls) for wrong in chosen])
        rows = []
        for wrong, laws in zip(chosen, by_kit, strict=True):
            by_run = refused_by_run(wrong.kind, wrong.cls)
            rows.append({"kind": wrong.kind, "name": wrong.name, "mistake": wrong.sentence, "kit": laws, "run": by_run})
            print(f"{wrong.name:<40} {laws[0] if laws else 'PASSES THE KIT':<55} {by_run[:90] or 'RUNS'}", flush=True)
    if not given.match:
        with (HERE / "wrong_plugins.csv").open("w", encoding="utf-8", newline="") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(["kind", "mistake", "law of the kit", "refused by a run"])
            for row in rows:
                table.writerow(
                    [row["kind"], row["mistake"], *(row["kit"] or ["none"])[:1], "yes" if row["run"] else "no"]
                )
    for what in ("kit", "run"):
        count = sum(bool(row[what]) for row in rows)
        print(f"refused by the {what}: {count} of {len(rows)}, {count / len(rows):.1%}")


if __name__ == "__main__":
    main()
