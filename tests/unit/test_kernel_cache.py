"""Compiled kernels are kept until what is compiled into them changes, in whatever file it is."""

import importlib
import sys

import pytest

CONSTANT = ("FACTOR = 2", "return 2 * x")
OTHER = "from numpy import array\nfrom hcss_twin.core.kernels import kernel\n{}\n@kernel()\ndef inner(x):\n    {}\n"
OUTER = "from hcss_twin.core.kernels import kernel\nfrom other import FACTOR, inner\n@kernel()\ndef outer(x):\n"


@pytest.mark.parametrize(
    ("before", "after", "use", "value"),
    [
        (CONSTANT, ("FACTOR = 3", CONSTANT[1]), "FACTOR", 32.0),
        (CONSTANT, (CONSTANT[0], "return 3 * x"), "FACTOR", 23.0),
        (("FACTOR = array([2.0])", CONSTANT[1]), ("FACTOR = array([3.0])", CONSTANT[1]), "FACTOR[0]", 32.0),
    ],
    ids=["constant", "kernel", "array"],
)
def test_a_change_in_another_file_is_compiled_in(tmp_path, monkeypatch, before, after, use, value):
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # files of one second and size have the same stamp
    (tmp_path / "mine.py").write_text(f"{OUTER}    return inner(x) + 10 * {use}\n", encoding="utf-8")
    said = []
    for constant, function in (before, before, after):
        (tmp_path / "other.py").write_text(OTHER.format(constant, function), encoding="utf-8")
        importlib.invalidate_caches()
        try:
            outer = importlib.import_module("mine").outer
            said.append((outer(1.0), sum(outer.stats.cache_hits.values())))
        finally:
            for name in ("mine", "other"):
                sys.modules.pop(name, None)
    assert said == [(22.0, 0), (22.0, 1), (value, 0)]
