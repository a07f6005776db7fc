"""Names of the top level stay what they are, whatever modules are imported."""

from pathlib import Path

import pytest

import hcss_twin


@pytest.mark.parametrize("name", hcss_twin.__all__)
def test_no_module_has_the_name_of_a_function_or_class_of_the_top_level(name):
    # importing a module sets its name on the package, in place of what __getattr__ gives
    folder = Path(hcss_twin.__file__).parent
    assert not (folder / name).exists()
    assert not (folder / f"{name}.py").exists()
