"""What code of a plugin prints, raises, logs, and learns of its scene: an installed package, as a user has it."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import xarray
from cheap import CHEAP_OPTIONS

HOOKS = """
from hcss_twin.providers import CommandSpec, ProviderSpec, SectionSpec, hookimpl

print("hello from the import")

@hookimpl
def hcss_register_sea_models():
    print("hello from the hook")
    names = ("chatty", "clumsy", "summery")
    return [ProviderSpec(name, f"chatterbox.seas:{name.title()}", None, 3, "for a test") for name in names]

@hookimpl
def hcss_commands():
    print("hello from the hook of commands")
    return [CommandSpec("stumble", "chatterbox.seas:stumble", "for a test")]

@hookimpl
def hcss_sections():
    return [SectionSpec("fog", "chatterbox.seas:Fog", "for a test", effect="chatterbox.seas:fog")]
"""
SEAS = """
import os
import click
import numpy as np
from pydantic import BaseModel
from hcss_twin.providers import SeaDeclaration

print("hello from the provider's import")

class Chatty:
    declares = SeaDeclaration(depends_on=frozenset())
    grey = 0.95
    def __init__(self, inputs, parameters):
        print("hello from the constructor")
    def emissivity(self, wavenumber_cm1, mu):
        print("hello from emissivity")
        os.system("echo hello from a child")
        return np.full((mu.size, wavenumber_cm1.size), self.grey)
    def brdf(self, wavenumber_cm1, mu_out, mu_in, relative_azimuth):
        return np.full((mu_out.size, wavenumber_cm1.size), (1 - self.grey) / np.pi)

class Clumsy(Chatty):
    def emissivity(self, wavenumber_cm1, mu):
        return np.full((mu.size, wavenumber_cm1.size), self.grey) + np.ones(3, int).reshape(2, 2)  # LINE

class Summery(Chatty):
    def __init__(self, inputs, parameters, *, scene):
        self.grey = 0.9 if scene.time.month in (6, 7, 8) else 0.96
        scene.log.warning("%s %.1f %.0f", scene.time.date(), scene.latitude_deg, scene.sun_at(0.0).zenith_deg)

class Fog(BaseModel):
    depth: float = 0.1

def fog(scenario, catalog):
    return {}["thickness"]  # FOG

@click.command()
def stumble():
    [][1]  # STUMBLE
"""
SMALL = [*CHEAP_OPTIONS, "--set", "image.rows=8", "--set", "image.columns=8", "--set", 'bands=["lwir-10.8"]']


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Return the environment of a process in which the package is installed."""
    folder = tmp_path_factory.mktemp("site")
    package = folder / "chatterbox"
    package.mkdir()
    (package / "__init__.py").write_text(HOOKS)
    (package / "seas.py").write_text(SEAS)
    info = folder / "chatterbox-2.1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: chatterbox\nVersion: 2.1\n")
    groups = ("hcss_twin", "hcss_twin.commands", "hcss_twin.sections")
    (info / "entry_points.txt").write_text("\n".join(f"[{group}]\nchatterbox = chatterbox\n" for group in groups))
    paths = filter(None, [str(folder), os.environ.get("PYTHONPATH")])
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "HCSS_CACHE_DIR": str(folder / "cache")}


def hcss(installed, tmp_path, *arguments):
    command = [sys.executable, "-m", "hcss_twin", *arguments]
    return subprocess.run(command, env=installed, cwd=tmp_path, capture_output=True, text=True, timeout=120)


def place_of(installed, mark):
    file = Path(installed["PYTHONPATH"].split(os.pathsep)[0]) / "chatterbox" / "seas.py"
    lines = file.read_text().splitlines()
    return f"at {file}:{1 + next(n for n, line in enumerate(lines) if f'# {mark}' in line)}"


def test_what_a_plugin_prints_leaves_the_answer_in_json_alone(installed, tmp_path):
    options = ["run", "stratus", *SMALL, "--set", "sea.model=chatty", "--set", "frames.count=2", "--workers", "2"]
    done = hcss(installed, tmp_path, *options, "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["cube"] == "stratus.nc"
    for place in ("the import", "the hook", "the provider's import", "the constructor", "emissivity", "a child"):
        assert f"hello from {place}" in done.stderr


def test_prints_of_hooks_of_commands_leave_the_answer_alone(installed, tmp_path):
    done = hcss(installed, tmp_path, "plugins", "chatty", "--json")
    assert json.loads(done.stdout)[0]["name"] == "chatty"
    assert "hello from the hook" in done.stderr
    unknown = hcss(installed, tmp_path, "new-plugin", "--help")  # a command of a plugin: all hooks are asked
    assert "hello" not in unknown.stdout
    assert "hello from the hook of commands" in unknown.stderr


def test_an_accident_of_a_provider_is_one_message_with_its_file_and_line(installed, tmp_path):
    done = hcss(installed, tmp_path, "run", "stratus", *SMALL, "--set", "sea.model=clumsy")
    assert done.returncode == 1
    (message,) = [line for line in done.stderr.splitlines() if "hello" not in line]
    assert message.startswith(
        "error: sea model 'clumsy' of chatterbox 2.1: emissivity() raised ValueError: cannot resh"
    )
    assert f"{place_of(installed, 'LINE')} in emissivity(); arguments: wavenumber_cm1 of shape" in message


@pytest.mark.parametrize(
    ("arguments", "mark", "words"),
    [
        (["stumble"], "STUMBLE", "error: chatterbox 2.1: IndexError: list index out of range"),
        (["run", "stratus", *SMALL, "--set", "fog.depth=0.2"], "FOG", "section 'fog' of chatterbox 2.1: fog() raised"),
    ],
)
def test_an_accident_of_other_code_of_a_plugin_is_one_message(installed, tmp_path, arguments, mark, words):
    done = hcss(installed, tmp_path, *arguments)
    (message,) = [line for line in done.stderr.splitlines() if "hello" not in line]
    assert words in message
    assert place_of(installed, mark) in message
    assert done.returncode == 1
    if mark == "STUMBLE":
        shown = hcss({**installed, "HCSS_TRACEBACK": "1"}, tmp_path, *arguments)
        assert "Traceback" in shown.stderr


def test_a_provider_learns_date_place_and_sun_and_its_log_is_shown(installed, tmp_path):
    emitted = {}
    for date in ("2020-01-15T12:00:00Z", "2020-07-15T12:00:00Z"):
        options = ["--set", "sea.model=summery", "--set", f"time={date}", "--set", "sea.temperature=290"]
        options += ["--set", 'output.variables=["radiance_sea_emission"]', "--set", "clouds.coverage=0"]
        output = ["-o", f"{date[:7]}.nc"]
        done = hcss(installed, tmp_path, "run", "stratus", *SMALL, *options, *output)
        assert done.returncode == 0, done.stderr
        assert f"warning: sea.summery: {date[:10]} " in done.stderr
        with xarray.open_dataset(tmp_path / f"{date[:7]}.nc") as cube:
            emitted[date] = float(cube["radiance_sea_emission"].mean())
    january, july = emitted.values()
    assert july < january  # kept tables of one month are not those of the other
