"""Connection to a Dask cluster: every failure of Dask is one of our errors, and a cluster without workers is reported.

Importing this module does not import Dask.
"""

from __future__ import annotations

import logging
import re
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

from hcss_twin.core.errors import HcssError
from hcss_twin.core.processes import silenced

__all__ = ["Cluster"]

CONNECT_S = 10
"""Time in which a scheduler must answer."""

LOOK_S = 2.0
"""Time between two looks at the workers while none of them finishes anything."""

FIRST_NOTICE_S, LAST_NOTICE_S = 10.0, 300.0
"""Shortest and longest time between two notices; it doubles from one to the next."""

_ADDRESS = re.compile(r"(?:t(?:cp|ls)://)?([^:/\[\]]+|\[[^\]/]+\]):([0-9]{1,5})")
_NOISY = ("distributed", "tornado", "asyncio")
"""Loggers that print tracebacks of lost connections, which are reported here."""


class Cluster:
    """A client of a Dask scheduler.

    Attributes
    ----------
    client : distributed.Client
    scheduler : str
        Its address.
    """

    def __init__(self, client: Any, scheduler: str, error: type[HcssError], wait_s: float | None) -> None:
        self.client, self.scheduler = client, scheduler
        self._error, self._wait_s = error, wait_s

    def workers(self) -> tuple[str, ...]:
        """Return the addresses of the workers now.

        Raises
        ------
        HcssError
            If the scheduler does not answer.
        """
        if self.client.status != "running":
            raise self._error(self.lost)
        return tuple(self.client.nthreads())

    def wait(self, is_ready: Callable[[], bool]) -> None:
        """Wait until something is ready; report a cluster without workers, sparsely.

        Raises
        ------
        HcssError
            If the scheduler does not answer, or there has been no worker for as long as is allowed.
        """
        look = time.monotonic() + LOOK_S
        since: float | None = None
        pause_s, notice_s, next_notice = 1e-3, FIRST_NOTICE_S, 0.0
        while not is_ready():
            time.sleep(pause_s)
            pause_s = min(2.0 * pause_s, 0.05)
            now = time.monotonic()
            if now < look:
                continue
            look = now + LOOK_S
            if self.workers():
                since = None
                continue
            since = now if since is None else since
            if self._wait_s is not None and now - since >= self._wait_s:
                raise self._error(
                    f"no workers at {self.scheduler} for {now - since:.0f} s; start some (dask worker "
                    f"{self.scheduler}) and run the command again: finished points of a sweep are kept"
                )
            if now >= next_notice:
                logging.getLogger(__name__).warning("no workers at %s; waiting", self.scheduler)
                next_notice, notice_s = now + notice_s, min(2.0 * notice_s, LAST_NOTICE_S)

    @property
    def lost(self) -> str:
        """The message for a scheduler that has gone."""
        return _lost(self.scheduler)

    @staticmethod
    @contextmanager
    def connected(scheduler: str, error: type[HcssError], wait_s: float | None = None) -> Iterator[Cluster]:
        """Connect to a scheduler; exceptions of Dask in the block become ``error``.

        Parameters
        ----------
        scheduler : str
            ``tcp://HOST:PORT`` or ``tls://HOST:PORT``.
        error : type
            Of the errors.
        wait_s : float, optional
            Longest time without workers; by default there is none.

        Raises
        ------
        HcssError
            If ``distributed`` is not installed, or no scheduler answers.
        """
        try:
            from distributed import Client
        except ImportError as cause:
            raise error(
                f"the scheduler {scheduler} needs Dask, which is not installed: pip install 'hcss-twin[dask]'"
            ) from cause
        _require_answer(scheduler, error)
        with ExitStack() as stack:
            for name in _NOISY:
                stack.enter_context(silenced(name))
            try:
                client = Client(scheduler, set_as_default=False, timeout=CONNECT_S)
            except Exception as cause:
                raise error(f"no Dask scheduler answers at {scheduler}: {_said(cause)}") from cause
            try:
                yield Cluster(client, scheduler, error, wait_s)
            except HcssError:
                raise
            except Exception as cause:
                gone = isinstance(cause, OSError) or client.status != "running"
                text = _lost(scheduler) if gone else f"the Dask cluster at {scheduler} failed"
                raise error(f"{text} ({_said(cause)})") from cause
            finally:
                with suppress(Exception):  # the scheduler may be gone
                    client.close(timeout=CONNECT_S)


def _lost(scheduler: str) -> str:
    return (
        f"the connection to the Dask scheduler at {scheduler} is lost; run the command again: finished points of a "
        "sweep are kept"
    )


def _require_answer(scheduler: str, error: type[HcssError]) -> None:
    """Check that a scheduler is listening, because Dask alone would keep retrying."""
    address = _ADDRESS.fullmatch(scheduler)
    if address is None:
        raise error(
            f"'{scheduler}' is not the address of a Dask scheduler; allowed: tcp://HOST:PORT or tls://HOST:PORT, "
            "for example tcp://127.0.0.1:8786"
        )
    host, port = address.groups()
    try:
        socket.create_connection((host.strip("[]"), int(port)), CONNECT_S).close()
    except (OSError, OverflowError, UnicodeError) as cause:
        raise error(f"no Dask scheduler answers at {scheduler}: {cause}") from cause


def _said(cause: BaseException) -> str:
    """Return an exception as one short line."""
    text = " ".join(str(cause).split())
    return f"{type(cause).__name__}: {text[:200]}" if text else type(cause).__name__
