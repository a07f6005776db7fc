"""Cached results of a plugin are not used after any change of what it computes with, and are after all else."""

import os
import subprocess
import sys

import pytest
from layouts import outcome

SAMPLE = [("change", "same size and times", "module", ""), ("accident", "array in the package", "installed", "moved")]
PLUGIN = {
    "st_a.py": """
from hcss_twin.providers import ProviderSpec, hookimpl

@hookimpl
def hcss_register_sea_models():
    return [ProviderSpec("st-sea", "st_ap.p:Sea", None, 3, "A sea.")]
""",
    "st_ap/__init__.py": "",
    "st_ap/p.py": """
import numpy as np
import st_lib
from hcss_twin.providers import SeaDeclaration

class Sea:
    declares = SeaDeclaration()

    def __init__(self, inputs, parameters):
        self.cache_token = st_lib.TOKEN

    def emissivity(self, wavenumber_cm1, cosine):
        return np.full((cosine.size, wavenumber_cm1.size), st_lib.E)

    def brdf(self, wavenumber_cm1, a, b, c):
        return np.full((a.size, wavenumber_cm1.size), (1.0 - st_lib.E) / np.pi)
""",
    "st_a-0.1.dist-info/entry_points.txt": "[hcss_twin]\nst = st_a\n",
    "st_a-0.1.dist-info/METADATA": "Metadata-Version: 2.1\nName: st-a\nVersion: 0.1\n",
}
SCENE = """
from hcss_twin import Scenario, make_plan
from hcss_twin.engine.tables.table_key import table_key

scene = {
    "time": "2024-04-20T22:30:00+10:00", "place": {"latitude": 35.0, "longitude": 150.0}, "bands": ["lwir-10.8"],
    "image": {"rows": 4, "columns": 4, "pixel_size": 100.0}, "radiance": {"model": "as-printed"},
    "sea": {"model": "st-sea", "temperature": 290.0}, "output": {"certificate": 0},
}
print(table_key(make_plan(Scenario.from_dict(scene))))
"""


@pytest.mark.parametrize("case", SAMPLE, ids=lambda case: case[1])
def test_a_sample_is_right(case, tmp_path):
    assert outcome(case, tmp_path / "plugin") == "right"


@pytest.mark.long
def test_tables_of_a_changed_helper_are_others(tmp_path):
    for path, text in PLUGIN.items():
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_text(text)

    def key(helper):
        (tmp_path / "st_lib.py").write_text(helper)
        own = {"PYTHONPATH": str(tmp_path), "HCSS_CACHE_DIR": str(tmp_path / "cache")}
        done = subprocess.run([sys.executable, "-c", SCENE], env=os.environ | own, capture_output=True, check=True)
        return done.stdout

    assert key("E, TOKEN = 0.98, None\n") != key("E, TOKEN = 0.60, None\n")
