"""A signal that arrives in a callback of an import, where Python ignores exceptions, is not lost."""

import signal
import sys

import pytest

from hcss_twin.cli.options import Stop


def test_signal_in_callback_of_import_is_recorded_and_raised_later():
    names = {}
    exec(compile("def cb(act): act()", "<frozen importlib._bootstrap>", "exec"), names)
    stop = Stop()
    names["cb"](lambda: stop(signal.SIGTERM, sys._getframe()))
    assert stop.signal == signal.SIGTERM
    with pytest.raises(KeyboardInterrupt):
        stop.check()


def test_signal_elsewhere_raises_at_once():
    with pytest.raises(KeyboardInterrupt):
        Stop()(signal.SIGTERM, sys._getframe())
