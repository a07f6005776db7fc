"""Runs the kit on a provider, in this process, with a time limit for each law."""

import os
import signal
import tempfile
import threading
from pathlib import Path
from types import ModuleType
from unittest import mock

import pytest

LIMIT_S = 30.0
"""Processor time of one law."""


def kit_of(right, wrong, folder):
    """Return the kit class of a right provider, or of a wrong one that wraps it."""
    kit = right.kit(folder)
    if wrong is None:
        return kit

    def make_provider(self, inputs):
        return wrong.wrap(kit.make_provider(self, wrong.inputs(inputs)), inputs)

    return type("TestProvider", (kit,), {"make_provider": make_provider})


def laws_broken(right, wrong=None, only=None, most=1):
    """Return the laws that refuse a provider, in the order of the kit, each once; empty: it passes.

    Parameters
    ----------
    right : Right
    wrong : Wrong, optional
        A change of it.
    only : str, optional
        A pytest expression that selects laws.
    most : int
        Stop after so many refusals; 0: never.
    """
    plain = mock.patch.dict(os.environ, {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"})
    with tempfile.TemporaryDirectory() as folder, plain:
        run = _Run(kit_of(right, wrong, Path(folder)))
        options = [f"--maxfail={most}", "--capture=no", *(["-k", only] if only else [])]
        for name in ("cacheprovider", "terminal", "warnings", "faulthandler"):
            options += ["-p", f"no:{name}"]
        pytest.main([__file__, "-c", os.devnull, "--rootdir", folder, *options], plugins=[run])
    if not run.laws:
        raise RuntimeError(f"no law of the kit was run on {right.name}")
    return list(dict.fromkeys(run.broken))


class _Run:
    """A pytest plugin that collects one class and notes what fails."""

    def __init__(self, kit):
        self._kit = kit
        self.laws = 0
        self.broken = []

    def pytest_collect_file(self, file_path, parent):
        if file_path == Path(__file__):
            module = _Module.from_parent(parent, path=file_path)
            module.kit = self._kit
            return module
        return None

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item):
        if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "setitimer"):
            return (yield)
        before = signal.signal(signal.SIGPROF, _too_long)
        signal.setitimer(signal.ITIMER_PROF, LIMIT_S)
        try:
            return (yield)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            signal.signal(signal.SIGPROF, before)

    def pytest_runtest_logreport(self, report):
        self.laws += report.when == "call"
        if report.failed:
            law = report.nodeid.rpartition("::")[2].partition("[")[0].removeprefix("test_")
            self.broken.append(law)


class _Module(pytest.Module):
    def _getobj(self):
        module = ModuleType("kit_of_one_provider")
        module.TestProvider = self.kit
        return module


def _too_long(number, frame):
    raise TimeoutError(f"the law took more than {LIMIT_S:g} s of processor time")
