"""Plugins installed into an environment of their own, as users install them, and the command line.

The environments borrow the packages of the running one, so nothing is downloaded.
"""

import contextlib
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import textwrap
import tomllib
import venv
from pathlib import Path

import pytest
from command import hcss

import hcss_twin
from hcss_twin.providers.registry import Kind

# Its environments take long to make: they are made by one worker.
pytestmark = [pytest.mark.long, pytest.mark.xdist_group("plugins")]

REPOSITORY = Path(hcss_twin.__file__).parents[1]
GREY = REPOSITORY / "plugins" / "hcss-grey-atmosphere"

SCENARIO = """
place = {latitude = 35.0, longitude = 150.0}
time = 2024-04-20T12:30:00+10:00
clouds.type = "stratus"
image = {rows = 32, columns = 32}
frames.count = 2
bands = ["lwir-10.8"]
radiance.model = "as-printed"
sea.model = "cox-munk"
optics.provider = "mie"
"""


PROVIDER = """
    from hcss_twin.providers.registry import ProviderSpec, hookimpl

    @hookimpl
    def {hook}():
        return [ProviderSpec("{name}", "{module}:Gas", None, 3, "a test gas")]

    class Gas:
        def __init__(self, inputs, parameters):
            from hcss_twin.providers import AtmosphereDeclaration
            self.declares = AtmosphereDeclaration()

        def transmittance(self, wavenumber_cm1, paths):
            import numpy as np
            return {result}
"""

GOOD_RESULT = "np.ones((len(paths), wavenumber_cm1.size))"
HOOK = "hcss_register_transmittance_providers"


class Environment:
    """A virtual environment that also sees the packages of the running interpreter."""

    def __init__(self, folder):
        self.folder = folder
        self.home = folder / "env"
        venv.create(self.home, with_pip=False, symlinks=os.name != "nt")
        scripts = "Scripts" if os.name == "nt" else "bin"
        self.python = self.home / scripts / ("python.exe" if os.name == "nt" else "python")
        paths = sysconfig.get_paths(vars={"base": str(self.home), "platbase": str(self.home)}, scheme="venv")
        self.site = Path(paths["purelib"])
        borrowed = {sysconfig.get_path("purelib"), sysconfig.get_path("platlib"), str(REPOSITORY)}
        (self.site / "borrowed.pth").write_text("\n".join(sorted(borrowed)) + "\n")
        (folder / "scenario.toml").write_text(SCENARIO)

    def call(self, *arguments):
        environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
        return subprocess.run(
            [self.python, *arguments], cwd=self.folder, env=environment, capture_output=True, text=True, timeout=300
        )

    def hcss(self, *arguments):
        return self.call("-c", "from hcss_twin.cli import main; main()", *arguments)

    def run(self, cube, **settings):
        chosen = [part for key, value in settings.items() for part in ("--set", f"{key}={value}")]
        return self.hcss("run", "scenario.toml", "-o", cube, *chosen)

    def install(self, *projects):
        """Install project folders: with pip where the build backend is at hand, else file by file."""
        if importlib.util.find_spec("hatchling") and importlib.util.find_spec("pip"):
            options = ["--no-index", "--no-deps", "--no-build-isolation", "--quiet"]
            pip = [sys.executable, "-m", "pip", "--python", str(self.python), "install", *options, *map(str, projects)]
            subprocess.run(pip, check=True, timeout=300)
            return
        for project in projects:
            metadata = tomllib.loads((project / "pyproject.toml").read_text(encoding="utf-8"))["project"]
            for package in metadata_packages(project):
                shutil.copytree(package, self.site / package.name)
            self.write_distribution(metadata["name"], metadata["version"], metadata["entry-points"]["hcss_twin"])

    def install_module(self, distribution, version, source):
        """Install a distribution of one module that is its own entry point."""
        module = distribution.replace("-", "_")
        (self.site / f"{module}.py").write_text(textwrap.dedent(source))
        self.write_distribution(distribution, version, {distribution: module})

    def install_provider(self, distribution, name, hook=HOOK, result=GOOD_RESULT):
        module = distribution.replace("-", "_")
        source = PROVIDER.format(hook=hook, name=name, module=module, result=result)
        self.install_module(distribution, "0.7", source)

    def write_distribution(self, distribution, version, entry_points):
        info = self.site / f"{distribution.replace('-', '_')}-{version}.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: {version}\n")
        lines = [f"{name} = {value}" for name, value in entry_points.items()]
        (info / "entry_points.txt").write_text("\n".join(["[hcss_twin]", *lines, ""]))


def metadata_packages(project):
    configuration = tomllib.loads((project / "pyproject.toml").read_text(encoding="utf-8"))
    return [project / name for name in configuration["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]]


def radiance(path):
    import netCDF4

    with netCDF4.Dataset(path) as cube:
        return cube["radiance"][:].data


@pytest.fixture(scope="module")
def grey(tmp_path_factory):
    environment = Environment(tmp_path_factory.mktemp("grey"))
    environment.install(GREY)
    return environment


def test_installed_plugin_is_listed(grey):
    listed = json.loads(grey.hcss("plugins", "--json").stdout)
    # Other plugins of the running environment, borrowed in part, do not matter here.
    assert "hcss-grey-atmosphere" not in {each["distribution"] for each in listed["broken"]}
    [provider] = [each for each in listed["providers"] if each["name"] == "grey"]
    assert provider["distribution"] == "hcss-grey-atmosphere"


def test_installed_plugin_makes_a_cube_that_differs_from_the_default(grey):
    for name in ("table", "grey"):
        done = grey.run(f"{name}.nc", **{"atmosphere.provider": name})
        assert done.returncode == 0, done.stderr
    assert (radiance(grey.folder / "table.nc") != radiance(grey.folder / "grey.nc")).any()


def test_parameters_of_an_installed_plugin_are_checked_and_have_effect(grey):
    done = grey.run("clear.nc", **{"atmosphere.provider": "grey", "atmosphere.parameters.optical_depth": "0.0"})
    assert done.returncode == 0, done.stderr
    done = grey.run("thick.nc", **{"atmosphere.provider": "grey", "atmosphere.parameters.optical_depth": "2.0"})
    assert done.returncode == 0, done.stderr
    # air colder than the sea: the thicker it is, the less arrives in the thermal infrared
    assert radiance(grey.folder / "thick.nc")[:, -1].mean() < radiance(grey.folder / "clear.nc")[:, -1].mean()
    done = grey.run("bad.nc", **{"atmosphere.provider": "grey", "atmosphere.parameters.optical_dept": "1.0"})
    assert done.returncode != 0
    assert "optical_dept" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (grey.folder / "bad.nc").exists()


def test_plugins_own_tests_pass_where_it_is_installed(grey):
    tests = GREY / "tests" / "test_grey_atmosphere.py"
    shutil.copy(tests, grey.folder)
    done = grey.call("-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "error", tests.name)
    assert done.returncode == 0, done.stdout
    assert " passed" in done.stdout


@pytest.fixture(scope="module")
def crowded(tmp_path_factory):
    """An environment with one plugin for everything that can go wrong."""
    environment = Environment(tmp_path_factory.mktemp("crowded"))
    environment.install(GREY)
    environment.install_module("bad-import", "0.7", "raise RuntimeError('the licence server is down')")
    environment.install_module("bad-exit", "0.7", "import sys; sys.exit('no display')")
    environment.install_provider("bad-hook", "misspelt", hook="hcss_register_transmitance_providers")
    environment.install_provider("second-grey", "grey")
    environment.install_provider("bad-shape", "wrong-shape", result="np.ones((wavenumber_cm1.size, len(paths) + 1))")
    environment.install_provider("bad-range", "amplifies", result="np.full((len(paths), wavenumber_cm1.size), 1.5)")
    return environment


def test_default_scenario_runs_beside_broken_plugins(crowded):
    done = crowded.run("default.nc")
    assert done.returncode == 0, done.stderr
    assert (crowded.folder / "default.nc").is_file()


def test_broken_plugins_are_listed_with_their_errors(crowded):
    done = crowded.hcss("plugins", "--json")
    assert done.returncode == 0, done.stderr
    errors = {each["distribution"]: each["error"] for each in json.loads(done.stdout)["broken"]}
    assert set(errors) >= {"bad-import", "bad-exit", "bad-hook"}
    assert "the licence server is down" in errors["bad-import"]
    assert "no display" in errors["bad-exit"]
    assert "did you mean 'hcss_register_transmittance_providers'" in errors["bad-hook"]
    assert "the licence server is down" in crowded.hcss("plugins").stdout


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("misspelt", ["bad-hook 0.7", "did you mean", "the licence server is down"]),
        ("grey", ["second-grey 0.7", "hcss-grey-atmosphere 0.1.0", '"second-grey/grey"']),
        ("wrong-shape", ["transmittance provider 'wrong-shape' of bad-shape 0.7", "transmittance()", "expected shape"]),
        ("amplifies", ["transmittance provider 'amplifies' of bad-range 0.7", "transmittance()", "1.5"]),
        ("tabel", ["closest is 'table'"]),
    ],
)
def test_only_who_selects_a_broken_provider_gets_its_error(crowded, name, parts):
    done = crowded.run(f"{name}.nc", **{"atmosphere.provider": name})
    assert done.returncode not in (0, -9)
    for part in parts:
        assert part in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(crowded.folder.glob(f"{name}.nc*"))


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("hcss-grey-atmosphere/grey", marks=pytest.mark.campaign),
        "second-grey/grey",
        pytest.param("hcss-twin/table", marks=pytest.mark.campaign),
    ],
)
def test_qualified_name_selects_among_duplicates(crowded, name):
    done = crowded.run(f"{name.replace('/', '-')}.nc", **{"atmosphere.provider": name})
    assert done.returncode == 0, done.stderr


def test_default_scenario_runs_beside_a_plugin_with_the_name_of_a_default(tmp_path):
    environment = Environment(tmp_path)
    environment.install_provider("second-table", "table")
    done = environment.run("default.nc")
    assert done.returncode == 0, done.stderr
    done = environment.run("chosen.nc", **{"atmosphere.provider": "table"})
    assert done.returncode != 0
    assert '"hcss-twin/table" or "second-table/table"' in done.stderr


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """An environment with a new plugin of every kind."""
    environment = Environment(tmp_path_factory.mktemp("written"))
    with contextlib.chdir(environment.folder):
        for kind in Kind:
            assert hcss("new-plugin", kind, f"own-{kind}").exit_code == 0
    environment.install(*(environment.folder / f"hcss-own-{kind}" for kind in Kind))
    return environment


def test_new_plugins_are_listed(written):
    listed = json.loads(written.hcss("plugins", "--json").stdout)
    found = {(each["kind"], each["name"]) for each in listed["providers"]}
    assert found >= {(str(kind), f"own-{kind}") for kind in Kind}


def test_the_tests_of_new_plugins_pass(written):
    folders = [f"hcss-own-{kind}" for kind in Kind]
    done = written.call("-m", "pytest", "-v", "-p", "no:cacheprovider", "-W", "error", *folders)
    assert done.returncode == 0, done.stdout
    for kind in Kind:
        test = rf"test_\w*{kind}\.py::"  # after the verdict, where several processes run the tests
        assert re.search(rf"{test}.* PASSED|PASSED .*{test}", done.stdout), done.stdout


def test_a_new_plugin_is_fully_typed(written):
    pytest.importorskip("mypy", reason="mypy comes with the extra dev")
    folders = [f"hcss-own-{kind}" for kind in Kind]
    done = written.call("-m", "mypy", "--strict", "--no-incremental", *folders)
    assert done.returncode == 0, done.stdout
