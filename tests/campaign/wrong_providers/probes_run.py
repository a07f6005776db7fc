"""Which wrong providers do the probes of a run refuse alone, and do they accept all right ones?

python tests/campaign/wrong_providers/probes_run.py [--match PART ...]      # some minutes; writes results-probes.json
"""

import argparse
import json
import os
import tempfile
import time
from pathlib import Path

import numpy as np
from kit_run import kit_of
from right_providers import right_providers
from run import summary
from wrong_providers import wrong_providers

from hcss_twin.core.errors import ProviderDefect
from hcss_twin.plan.builder import Built
from hcss_twin.plan.probes import laws_of, probe
from hcss_twin.providers.registry import Entry, Kind, Origin, ProviderSpec
from hcss_twin.providers.registry.guard import guard
from hcss_twin.testing import sample_microphysics, sample_wavenumbers

RESULTS = Path(__file__).with_name("results-probes.json")


def given(kit, name, default=None):
    """The value of a fixture without parameters of a kit class."""
    found = getattr(kit, name, None)
    return default if found is None else found._get_wrapped_function()(kit())


def refusal(right, wrong=None):
    """Return the error by which the probes refuse a provider, if they do, and the laws that it does not answer."""
    with tempfile.TemporaryDirectory() as folder:
        kit = kit_of(right, wrong, Path(folder))
        inputs = kit().make_inputs() if right.kind == "clouds" else given(kit, "inputs")
        entry = Entry(Kind(right.kind), ProviderSpec("toy", "a:B", None, 3, right.sentence), Origin("a", "hcss-a", "1"))

        def make(inputs):
            return guard(entry, kit().make_provider(inputs), inputs)

        try:
            built = Built(entry, None, inputs, make(inputs), make)
            wavenumbers = sample_wavenumbers(built.provider.declares, 4)
            laws = list(laws_of(built, wavenumbers, (given(kit, "cloud", sample_microphysics()),)))
            with np.errstate(all="ignore"):
                return None, probe(right.kind, built, laws).unanswered
        except ProviderDefect as error:
            return str(error), ()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--match", nargs="+", default=[""], help="only names that contain one of these")
    parts = parser.parse_args().match
    rights = {each.name: each for each in right_providers()}
    every = {name: (right, None) for name, right in rights.items()}
    every |= {wrong.name: (rights[wrong.right], wrong) for wrong in wrong_providers()}
    rows = {}
    with tempfile.TemporaryDirectory() as cache:
        os.environ.setdefault("HCSS_CACHE_DIR", cache)
        for name, (right, wrong) in every.items():
            if any(part in name for part in parts):
                began = time.perf_counter()
                error, unanswered = refusal(right, wrong)
                rows[name] = {
                    "right": wrong is None,
                    "sentence": (wrong or right).sentence,
                    "refused_by": [] if error is None else [error],
                    "not_answered": len(unanswered),
                    "seconds": round(time.perf_counter() - began, 2),
                }
    if parts == [""]:
        RESULTS.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    print("\n".join(summary(rows, rights)))
    silent = [name for name, row in rows.items() if row["not_answered"] and not row["right"]]
    print(f"{len(silent)} wrong providers are not refused, and raise errors when they are asked")


if __name__ == "__main__":
    main()
