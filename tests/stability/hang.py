"""An end for code that does not end by itself."""

import signal
from contextlib import contextmanager


class Hang(BaseException):
    """Code has taken longer than allowed; no ``except Exception`` catches this."""


@contextmanager
def limited(seconds=60):
    """Raise :class:`Hang` in the block after so many seconds of processor time."""

    def end(*_):
        raise Hang(f"more than {seconds} s")

    before = signal.signal(signal.SIGPROF, end)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
