"""Names of the top level stay what they are, whatever modules are imported."""

import sys
from pathlib import Path

import pytest

import hcss_twin


@pytest.mark.parametrize("name", hcss_twin.__all__)
def test_no_module_has_the_name_of_a_function_or_class_of_the_top_level(name):
    # importing a module sets its name on the package, in place of what __getattr__ gives
    folder = Path(hcss_twin.__file__).parent
    assert not (folder / name).exists()
    assert not (folder / f"{name}.py").exists()


@pytest.mark.parametrize("name", ["EvaluationChoice", "evaluate", "fit", "fit_dimension"])
def test_a_name_that_moved_to_a_plugin_warns_or_names_the_plugin(monkeypatch, name):
    plugin = pytest.importorskip("hcss_evaluate", reason="plugins/hcss-evaluate has the names")
    with pytest.warns(DeprecationWarning, match=f"is now hcss_evaluate.{name}"):
        assert getattr(hcss_twin, name) is getattr(plugin, name)
    monkeypatch.setitem(sys.modules, "hcss_evaluate", None)
    with pytest.raises(AttributeError, match=r"pip install ./plugins/hcss-evaluate"):
        getattr(hcss_twin, name)
