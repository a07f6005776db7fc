"""Scripts of benchmarks/, whose statistics tests hold, too."""

import importlib.util
import sys
from pathlib import Path

FOLDER = Path(__file__).parents[1] / "benchmarks"


def benchmark_module(name):
    """Import a script that imports no other."""
    spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look for their module while they are made
    try:
        spec.loader.exec_module(module)
    finally:
        del sys.modules[name]
    return module
