"""Runs the kit on a provider, in this process, with a time limit for each law."""

import os
import signal
import tempfile
import threading
from collections import Counter
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


def laws_broken(cases, most=1):
    """Return the laws that refuse each provider, in the order of the kit, and the seconds that they took.

    Many providers at once share the start of pytest, a third of a second.

    Parameters
    ----------
    cases : list of (Right, Wrong or None, str or None)
        A right provider, the change that makes it wrong, and the only law to be tried; None: all laws.
    most : int
        Stop after so many refusals of one provider; 0: never.
    """
    # options of the run around this one, such as those of .ci/run, may belong to plugins that are not loaded here
    plain = mock.patch.dict(os.environ, {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTEST_ADDOPTS": ""})
    with tempfile.TemporaryDirectory() as folder, plain:
        kits, laws = {}, {}
        for number, (right, wrong, law) in enumerate(cases):
            own = Path(folder) / str(number)
            own.mkdir()
            kits[f"TestProvider{number}"], laws[f"TestProvider{number}"] = kit_of(right, wrong, own), law
        run = _Run(kits, laws, most)
        options = ["--capture=no"]
        for name in ("cacheprovider", "terminal", "warnings", "faulthandler"):
            options += ["-p", f"no:{name}"]
        pytest.main([__file__, "-c", os.devnull, "--rootdir", folder, *options], plugins=[run])
    for (right, _, law), name in zip(cases, kits, strict=True):
        if name not in run.broken:
            raise RuntimeError(f"no law of the kit was run on {right.name}: {law or 'all'}")
    return [(list(dict.fromkeys(run.broken[name])), run.seconds[name]) for name in kits]


class _Run:
    """A pytest plugin that collects classes by name, and notes the laws that fail."""

    def __init__(self, kits, laws, most):
        self._kits, self._laws, self._most = kits, laws, most
        self.broken, self.seconds = {}, Counter()

    def pytest_collect_file(self, file_path, parent):
        if file_path == Path(__file__):
            module = _Module.from_parent(parent, path=file_path)
            module.kits = self._kits
            return module
        return None

    def pytest_collection_modifyitems(self, items):
        only = {item: self._laws[item.parent.name] for item in items}
        items[:] = [item for item, law in only.items() if law is None or item.originalname == f"test_{law}"]

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item):
        """Leave out the laws after those that have refused a provider."""
        if self._most and len(self.broken.get(item.parent.name, ())) >= self._most:
            pytest.skip("refused already")

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
        *_, kit, law = report.nodeid.split("::")
        self.seconds[kit] += report.duration
        if report.when == "call":
            self.broken.setdefault(kit, [])
        if report.failed:
            self.broken.setdefault(kit, []).append(law.partition("[")[0].removeprefix("test_"))


class _Module(pytest.Module):
    def _getobj(self):
        module = ModuleType("kits")
        vars(module).update(self.kits)
        return module


def _too_long(number, frame):
    raise TimeoutError(f"the law took more than {LIMIT_S:g} s of processor time")
