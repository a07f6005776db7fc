"""The command line: answers, exit codes, and what is left behind when a run is stopped."""

import contextlib
import io
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from cheap import CHEAP_OPTIONS
from click.testing import CliRunner

from hcss_twin import Scenario
from hcss_twin.cli.main import cli, main
from hcss_twin.core.environment import COMPILING

HCSS = [sys.executable, "-m", "hcss_twin"]
SMALL = ["--set", "image.rows=24", "--set", "image.columns=24", "--set", "frames.count=2", *CHEAP_OPTIONS]


def hcss_alone(*arguments, cwd):
    """The command in a process of its own, which takes a second to start."""
    return subprocess.run([*HCSS, *arguments], cwd=cwd, capture_output=True, text=True, timeout=120)


def hcss(*arguments, cwd):
    """What a process of its own would answer; an error that would be a traceback is raised."""
    out, err, code = io.StringIO(), io.StringIO(), 0
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        patch.chdir(cwd)
        patch.setattr(sys, "argv", ["hcss", *arguments])
        try:
            main()
        except SystemExit as left:
            code = left.code
        finally:
            for number, handler in handlers.items():
                signal.signal(number, handler)
    return subprocess.CompletedProcess(arguments, code, out.getvalue(), err.getvalue())


def test_run_and_preview_make_a_cube_and_pictures(tmp_path):
    bands = ("--set", 'bands=["mwir-3.7", "lwir-10.8"]')
    done = hcss_alone("run", "stratus", *SMALL, *bands, "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    # quiet in a pipe, but for what the first run on a machine does
    assert done.stderr in ("", f"{COMPILING}\n")
    answer = json.loads(done.stdout)
    assert answer["cube"] == "stratus.nc"
    assert answer["bytes"] == (tmp_path / "stratus.nc").stat().st_size
    pictures = json.loads(hcss("preview", "stratus.nc", "--json", cwd=tmp_path).stdout)
    assert sum(name.endswith(".png") for name in pictures) == 2
    assert sum(name.endswith(".gif") for name in pictures) == 2
    from PIL import Image

    for name in pictures:
        with Image.open(tmp_path / name) as picture:
            assert getattr(picture, "n_frames", 1) == (2 if name.endswith(".gif") else 1)
            low, high = picture.convert("L").getextrema()
            assert low < high


def test_an_existing_cube_is_kept_unless_forced(tmp_path):
    cube = tmp_path / "stratus.nc"
    cube.write_text("precious")  # no NetCDF: somebody's own
    for force, message in (((), "--force"), (("--force",), "the file there is no NetCDF")):
        refused = hcss("run", "stratus", *SMALL, *force, cwd=tmp_path)
        assert refused.returncode == 1
        assert message in refused.stderr
        assert cube.read_text() == "precious"
    cube.write_bytes(b"\x89HDF\r\n, damaged")
    assert hcss("run", "stratus", *SMALL, "--force", cwd=tmp_path).returncode == 0


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("fit", "image.npy", "--fix", "Q=1"), 2, "'Q' given, allowed: H, Lx"),
        (("fit", "image.npy", "--prior", "H=foo:1:2"), 2, "'foo' given, allowed: lognormal"),
        (("run", "stratus", "--workers", "0"), 2, "0 is not in the range"),
        (("plugins", "fractl"), 2, "closest is 'fractal'"),
        (("report", "image.npy"), 1, "not a NetCDF file"),
    ],
)
def test_a_wrong_command_line_ends_in_2_and_a_wrong_file_in_1(tmp_path, arguments, code, message):
    np.save(tmp_path / "image.npy", np.ones((64, 64)))
    done = hcss(*arguments, cwd=tmp_path)
    assert done.returncode == code, done.stderr
    assert message in done.stderr


@pytest.mark.parametrize(
    ("command", "code", "message"), [("fit", 2, "No such option"), ("report", 1, "not a NetCDF file")]
)
def test_a_process_ends_with_the_code_of_its_command(tmp_path, command, code, message):
    np.save(tmp_path / "image.npy", np.ones(3))
    done = hcss_alone(command, "image.npy", *(["--nonsense"] if code == 2 else []), cwd=tmp_path)
    assert (done.returncode, done.stdout) == (code, "")
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def test_plan_answers_without_computing(tmp_path):
    text = hcss("plan", "baseline", "--verbose", cwd=tmp_path)
    assert text.returncode == 0
    assert "24.389" in text.stdout
    assert "198.721" in text.stdout
    plan = json.loads(hcss("plan", "baseline", "--json", cwd=tmp_path).stdout)
    assert {"what", "why", "bound", "estimate", "sense", "needs", "decision"} == set(plan["skipped"][0])
    # The paper's own scene names the paper's models; others have the defaults.
    assert plan["providers"]["radiance"]["name"] == "as-printed"
    plan = json.loads(hcss("plan", "stratus", "--json", cwd=tmp_path).stdout)
    assert plan["providers"]["radiance"]["name"] == "physical"
    assert not list(tmp_path.iterdir())


def test_wrong_scenario_names_every_problem_and_exits_2(tmp_path):
    (tmp_path / "wrong.toml").write_text(
        "time = 2024-04-20T12:30:00\nplace = {latitude = 95, longitude = 0}\nview.zenit = 5\nclouds.coverage = 1.3\n"
    )
    for command in ("run", "plan", "validate"):
        run = hcss_alone if command == "run" else hcss
        done = run(command, "wrong.toml", cwd=tmp_path)
        assert done.returncode == 2
        for field in ("time", "place.latitude", "view.zenit", "clouds.coverage"):
            assert f"{field}:" in done.stderr
        assert "Traceback" not in done.stderr
    answer = json.loads(hcss("validate", "wrong.toml", "--json", cwd=tmp_path).stdout)
    assert answer["valid"] is False
    assert len(answer["problems"]) == 4


def test_validate_accepts_what_is_shipped():
    in_process = CliRunner()
    for name in json.loads(in_process.invoke(cli, ["scenarios", "--json"]).stdout):
        Scenario.load(name)
        # Coarse and in one thermal band, because levels are chosen anew for each accuracy and band. Scenes
        # with models of their own are run by long tests.
        cheap = [*CHEAP_OPTIONS, "--set", "accuracy=0.05", "--set", 'bands=["lwir-10.8"]']
        assert in_process.invoke(cli, ["validate", name, *cheap]).exit_code == 0


def test_unknown_scenario_gets_the_closest_name(tmp_path):
    done = hcss("run", "stratos", cwd=tmp_path)
    assert done.returncode == 2
    assert "stratus" in done.stderr


def test_preview_of_something_else_is_refused(tmp_path):
    (tmp_path / "not.nc").write_text("no cube")
    done = hcss("preview", "not.nc", cwd=tmp_path)
    assert done.returncode == 1
    assert "Traceback" not in done.stderr


def test_schema_is_json_schema(tmp_path):
    schema = json.loads(hcss("schema", cwd=tmp_path).stdout)
    assert schema["properties"]["seed"]["default"] == 0


STEADY = [*CHEAP_OPTIONS, "--set", 'bands=["lwir-10.8"]', "--set", "frames.interval=1e-3"]
"""A scene of which many frames have the tables of one."""


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """Kernels in the cache: a signal inside the compiler's callbacks would end the process there and then."""
    done = hcss("run", "stratus", *STEADY, "--set", "frames.count=1", cwd=tmp_path_factory.mktemp("compile"))
    assert done.returncode == 0


@pytest.mark.skipif(os.name == "nt", reason="POSIX signals")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_stopped_run_leaves_nothing_behind(tmp_path, compiled, number, code):
    process = subprocess.Popen(
        [*HCSS, "run", "stratus", *STEADY, "--set", "frames.count=2000"],
        cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    deadline = time.monotonic() + 60
    while not list(tmp_path.glob(".*.partial")) and time.monotonic() < deadline and process.poll() is None:
        time.sleep(0.02)
    process.send_signal(number)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == code, errors
    assert "Traceback" not in errors
    assert not list(tmp_path.iterdir())


def test_help_and_plugins_import_no_numpy(tmp_path):
    for arguments in (["--help"], ["plugins"]):
        code = (
            "import sys; sys.argv = ['hcss', *sys.argv[1:]]\n"
            "from hcss_twin.cli import main\n"
            "try:\n    main()\nexcept SystemExit:\n    pass\n"
            "sys.exit('numpy' in sys.modules or 'pydantic' in sys.modules)"
        )
        done = subprocess.run([sys.executable, "-c", code, *arguments], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
