"""Progress of a run: bars on a terminal, plain lines in logs, nothing with --quiet; times of stages."""

import subprocess
import sys
from contextlib import contextmanager

import pytest
from cheap import CHEAP, CHEAP_OPTIONS
from click.testing import CliRunner

from hcss_twin import Scenario, make_plan
from hcss_twin.cli import progress as shown
from hcss_twin.cli.main import cli
from hcss_twin.cli.options import Stop
from hcss_twin.core.stages import STAGES, StageTimes, stage, watched
from hcss_twin.engine.simulate import run

SMALL = {**CHEAP, "image.rows": 8, "image.columns": 8, "frames.count": 3, "output.certificate": 2}
OPTIONS = [*CHEAP_OPTIONS, *(word for key in ("rows", "columns") for word in ("--set", f"image.{key}=8"))]


class Log:
    def __init__(self):
        self.events = []

    def begin(self, name):
        self.events.append(("begin", name))

    def end(self, name):
        self.events.append(("end", name))


def test_a_run_has_its_stages_in_order_each_of_which_ends(tmp_path):
    log = Log()
    with watched(log):
        run(make_plan(Scenario.load("stratus", SMALL)), tmp_path / "c.nc")
    names = [name for what, name in log.events if what == "begin"]
    assert names == [name for name in STAGES if name != "sensor"]
    assert log.events == [(what, name) for name in names for what in ("begin", "end")]


def test_a_stage_in_a_stage_is_part_of_it_and_one_that_fails_ends():
    log = Log()
    with watched(log), pytest.raises(ZeroDivisionError), stage("sensor"), stage("planning"):
        raise ZeroDivisionError
    assert log.events == [("begin", "sensor"), ("end", "sensor")]


def test_times_of_stages_are_positive_and_start_with_the_process():
    times = StageTimes()
    with watched(times), stage("planning"), stage("tables"):
        sum(range(100_000))
    assert list(times.seconds) == ["planning"]
    assert times.seconds["planning"] > 0.0


@contextmanager
def on_terminal(monkeypatch, is_terminal):
    monkeypatch.setattr("sys.stderr.isatty", lambda: is_terminal, raising=False)
    with shown.shown_progress(lambda: None) as progress:
        yield progress


def test_a_log_has_plain_lines_about_long_runs_alone(monkeypatch, capsys):
    monkeypatch.setattr(shown, "LONG_S", 0.0)
    with on_terminal(monkeypatch, False) as progress:
        progress.expect({"tables": 50.0, "frames": 150.0})
        with stage("frames"):
            assert list(progress.each(range(3), 3)) == [0, 1, 2]
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "about 3 min: tables 50 s, frames 2 min"
    assert lines[1] == "frames: about 2 min"
    assert lines[2].startswith("1 of 3, about ")
    assert not any("\x1b" in line for line in lines)


def test_planning_shows_what_it_is_expected_to_take(monkeypatch, capsys):
    for is_terminal in (False, True):
        monkeypatch.setattr("sys.stderr.isatty", lambda is_terminal=is_terminal: is_terminal, raising=False)
        with shown.shown_progress(lambda: None, expected={"planning": 50.0}) as progress, stage("planning"):
            if is_terminal:
                (task,) = progress.bars.tasks
                assert str(progress.bars.columns[-1].render(task)) == "about 50 s left"
    assert capsys.readouterr().err.startswith("planning: about 50 s\n")


def test_commands_with_many_steps_have_lines_in_a_log(monkeypatch, capsys):
    monkeypatch.setattr(shown, "LONG_S", 0.0)
    monkeypatch.setattr("sys.stderr.isatty", lambda: False, raising=False)
    assert list(Stop().progress(range(3), 3)) == [0, 1, 2]
    assert [line.split(",")[0] for line in capsys.readouterr().err.splitlines()] == ["1 of 3", "2 of 3"]


def test_a_log_has_nothing_about_a_short_run(monkeypatch, capsys):
    with on_terminal(monkeypatch, False) as progress:
        progress.expect({"tables": 1.0, "frames": 2.0})
        with stage("frames"):
            assert list(progress.each(range(3), 3)) == [0, 1, 2]
    assert capsys.readouterr().err == ""


def test_a_terminal_has_a_bar_for_each_stage_with_the_time_left(monkeypatch):
    with on_terminal(monkeypatch, True) as progress:
        progress.expect({"tables": 50.0, "frames": 2.0})
        with stage("tables"):
            (task,) = progress.bars.tasks
            assert task.description == "tables"
            assert str(progress.bars.columns[-1].render(task)) == "about 50 s left"
        assert task.finished
        with stage("frames"):
            list(progress.each(range(3), 3))
            assert progress.bars.tasks[1].fields["count"] == "3 of 3"
        assert all(task.finished for task in progress.bars.tasks)


def test_a_quiet_run_prints_nothing_and_an_interrupt_ends_it(tmp_path):
    done = CliRunner().invoke(cli, ["run", "stratus", "-o", str(tmp_path / "c.nc"), "--quiet", *OPTIONS])
    assert (done.exit_code, done.output) == (0, "")

    def stop():
        raise KeyboardInterrupt

    with shown.shown_progress(stop, quiet=True) as progress, pytest.raises(KeyboardInterrupt):
        list(progress.each(range(3), 3))


@pytest.mark.parametrize(
    "words", [["run", "stratus", "-o", "c.nc", *OPTIONS], ["plan", "stratus", *OPTIONS], ["--help"]]
)
def test_nothing_of_rich_is_imported_without_a_terminal(tmp_path, words):
    code = (
        f"import sys; sys.argv = ['hcss', *{words!r}]\n"
        "from hcss_twin.cli.main import main\n"
        "try:\n    main()\n"
        "finally:\n    print('rich' in sys.modules, file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.stderr.split()[-1] == "False", done.stderr
