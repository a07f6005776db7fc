"""The built wheel works away from the checkout: the catalogs are in it."""

import json
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest
from cheap import CHEAP

import hcss_twin

REPOSITORY = Path(hcss_twin.__file__).parents[1]

# Its environments take long to make: they are made by one worker.
pytestmark = [pytest.mark.long, pytest.mark.xdist_group("wheel")]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    if not (REPOSITORY / "pyproject.toml").is_file():
        pytest.skip("not a source checkout")
    folder = tmp_path_factory.mktemp("wheel")
    command = [
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "--no-deps",
        "--quiet",
        "--wheel-dir",
        str(folder),
        str(REPOSITORY),
    ]
    subprocess.run(command, check=True, capture_output=True)
    return next(folder.glob("*.whl"))


def test_wheel_holds_package_catalogs_and_licence(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    files = [path for path in (REPOSITORY / "catalogs").rglob("*") if path.suffix in {".toml", ".nc", ".csv"}]
    assert {f"hcss_twin/{path.relative_to(REPOSITORY).as_posix()}" for path in files} <= names
    assert "hcss_twin/catalogs/atmospheres/us-standard-1976-lowtran7.nc" in names
    assert "hcss_twin/py.typed" in names
    assert any(name.endswith("licenses/LICENSE") for name in names)
    assert not any(name.startswith("tests/") for name in names)


def test_wheel_runs_away_from_the_checkout(wheel, tmp_path):
    home = tmp_path / "environment"
    venv.create(home, with_pip=False)
    python = home / "bin" / "python"
    site = next((home / "lib").glob("python*/site-packages"))
    # Dependencies come from the running environment; the package itself only from the wheel.
    zipfile.ZipFile(wheel).extractall(site)
    own = Path(next(path for path in sys.path if path.endswith("site-packages")))
    (site / "borrowed.pth").write_text(f"{own}\n")
    # Its kernels are compiled anew, and those of clouds take long.
    small = {"image.rows": 8, "image.columns": 8, "frames.count": 1, "clouds.coverage": 0.0, **CHEAP}
    code = (
        "import hcss_twin, json; from hcss_twin.core.catalog import catalog_root;"
        f"s = hcss_twin.Scenario.load('stratus', {small!r});"
        "c = hcss_twin.simulate(s);"
        "print(json.dumps([hcss_twin.__file__, str(catalog_root()), float(c.radiance.min())]))"
    )
    done = subprocess.run([python, "-I", "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    package, catalogs, lowest = json.loads(done.stdout)
    assert Path(package).is_relative_to(site)
    assert Path(catalogs).is_relative_to(site)
    assert lowest > 0
