"""Pipes, sockets and devices in place of files: refused by every command and reader, which would wait for ever."""

import os
import signal
import socket
from contextlib import contextmanager

import click
import pytest
from click.testing import CliRunner
from file_readers import FAST, SLOW
from hang import Hang

from hcss_twin import HcssError, Scenario, ScenarioError, make_plan
from hcss_twin.cli.main import cli
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.core.reading import Reading

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes with names are of POSIX")


@contextmanager
def at_once(seconds=20.0):
    """End the block after so many seconds: waiting for a pipe takes no processor time."""

    def end(*_):
        raise Hang("it waits")

    before = signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


@pytest.fixture
def pipe(tmp_path):
    os.mkfifo(tmp_path / "pipe.nc")
    return tmp_path / "pipe.nc"


def test_every_kind_of_stream_is_named_also_behind_a_link(tmp_path, pipe, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind("socket")
        for name, target in (("a", "pipe.nc"), ("b", "a"), ("c", "/dev/zero")):
            os.symlink(target, name)
        reader, writer = os.pipe()
        kinds = {"pipe.nc": "pipe", "a": "pipe", "b": "pipe", "c": "device", "socket": "socket", "/dev/zero": "device"}
        for path, kind in {**kinds, f"/dev/fd/{reader}": "pipe"}.items():
            with at_once(), pytest.raises(CatalogError, match=rf"{path}: it is a {kind}; allowed: a file"):
                Reading(path, CatalogError).first_bytes()
        os.close(reader)
        os.close(writer)
    (tmp_path / "file").write_bytes(b"abc")
    os.symlink("file", "link")
    assert Reading("link", CatalogError).first_bytes() == b"abc"


def commands(command, words=()):
    if isinstance(command, click.Group):
        of_plugins = command.plugin_commands()[0] if command is cli else ()
        for name in (*command.list_commands(click.Context(command)), *of_plugins):
            yield from commands(command.get_command(click.Context(command), name), (*words, *name.split()))
    else:
        yield words, command


def takes_input(parameter):
    return isinstance(parameter.type, click.Path) and parameter.type.exists


def test_every_command_refuses_a_pipe_at_once(pipe, monkeypatch):
    monkeypatch.chdir(pipe.parent)
    tried = set()
    for words, command in commands(cli):
        required = [each for each in command.params if each.required]
        given = []
        for each in required:
            number = isinstance(each.type, click.types.IntParamType | click.types.FloatParamType)
            choice = each.type.choices[0] if isinstance(each.type, click.Choice) else None
            value = choice or ("1" if number else "out.nc" if each.name in ("output", "folder") else str(pipe))
            given += [value] if isinstance(each, click.Argument) else [each.opts[0], value]
        others = [each for each in command.params if not each.required and takes_input(each)]
        for extra in [
            [],
            *([*(each.opts[:1] if isinstance(each, click.Option) else []), str(pipe)] for each in others),
        ]:
            if str(pipe) not in [*given, *extra] or words[0] == "check":  # a package, not a file
                continue
            with at_once():
                result = CliRunner().invoke(cli, [*words, *given, *extra])
            tried.add(words[0])
            assert result.exit_code, (words, extra)
            assert isinstance(result.exception, HcssError | SystemExit), (words, extra, result.exc_info)
    assert {"report", "verify", "atmosphere", "run", "sense", "export", "evaluate", "fit", "sweep"} <= tried


def test_every_reader_refuses_a_pipe_at_once(tmp_path):
    folders = ("libradtran", "scene", "sweep", "cache")
    for name, readers in (FAST | SLOW).items():
        if name in folders or name == "fit.state":
            continue
        os.mkfifo(tmp_path / name)
        for reader in readers.values():
            with at_once(), pytest.raises(HcssError, match=r"pipe|no cloud type|no such"):
                reader(tmp_path / name)


KEYS = {
    "atmosphere.profile": "pipe.csv",
    "bands": [{"name": "mine", "response": "pipe.csv"}],
    "clouds.type": "pipe.toml",
    "clouds": {"generator": "imagery", "parameters": {"image": "pipe.npy"}},
    "optics.parameters.refractive_index": "pipe.csv",
    "surfaces": {"provider": "raster", "parameters": {"file": "pipe.nc", "classes": {"0": "sea"}}},
    "sensor": {"parameters": {"psf": "file", "psf_file": "pipe.txt"}},
    "sensor.name": "pipe.toml",
    "atmosphere": {"provider": "table", "parameters": {"file": "pipe.nc"}},
}


@pytest.mark.parametrize("key", KEYS)
def test_every_key_that_names_a_file_refuses_a_pipe_at_once(tmp_path, key):
    for suffix in ("csv", "toml", "npy", "nc", "txt"):
        os.mkfifo(tmp_path / f"pipe.{suffix}")
    scenario = Scenario.load("stratus").to_json()
    (tmp_path / "s.json").write_text(scenario)
    with at_once(), pytest.raises((ScenarioError, CatalogError)):
        make_plan(Scenario.load(tmp_path / "s.json", {key: KEYS[key], "radiance.model": "as-printed"}))


def test_a_pipe_of_the_name_of_an_entry_is_named_and_not_suggested(tmp_path):
    (tmp_path / "clouds").mkdir()
    os.mkfifo(tmp_path / "clouds" / "sea.nc")
    with at_once(), pytest.raises(CatalogError, match=r"clouds/sea.nc: it is a pipe; allowed: a file"):
        Catalog(base=tmp_path).find("sea", "clouds", ".nc", beside=True)
