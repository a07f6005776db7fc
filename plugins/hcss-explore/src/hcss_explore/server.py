"""The page and its questions over HTTP, for the browser of this machine alone.

Only who knows the token in the address gets an answer, and only under the names of this machine: a page of another site
cannot ask (``Origin``), nor can a name that somebody points at this machine (``Host``). What the page loads comes from
here: the policy that is sent with it forbids all else.
"""

from __future__ import annotations

import hmac
import json
import secrets
import sys
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from typing import Any

import click

from hcss_explore.explorer import Explorer, Picture, problems_of
from hcss_twin import HcssError
from hcss_twin.core.json_numbers import json_value

LARGEST_REQUEST = 100_000
"""Bytes; the page sends some thousand."""

LONG_S = 0.5
"""Seconds of waiting for another request of which a page is told."""

MOST_PAGES = 32
"""Open pages whose newest request is remembered."""

_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)

_SITE = {
    "": ("page.html", "text/html; charset=utf-8"),
    "page.css": ("page.css", "text/css; charset=utf-8"),
    "page.js": ("page.js", "text/javascript; charset=utf-8"),
}


class Dropped(Exception):
    """The page has asked for something newer."""


class Refused(Exception):
    """A request that gets no answer: the status, and what is allowed."""

    def __init__(self, status: int, message: str) -> None:
        super().__init__(message)
        self.status = status


class Newest:
    """Lets one request compute at a time, and of those that a page has asked only the newest.

    An older request ends before its next step: it is answered as dropped, and never waits in a queue.
    """

    def __init__(self) -> None:
        self._lock, self._computing, self._running = threading.Lock(), threading.Lock(), threading.Lock()
        self._closed = False
        self._number, self._newest = 0, OrderedDict[tuple[str, str], int]()

    def ask(self, page: str, kind: str) -> Callable[[], bool]:
        """Register a request; return whether it still is the newest of its kind: a frame ends spectra of pixels."""
        with self._lock:
            self._number += 1
            number = self._newest[page, kind] = self._number
            if kind == "frame":
                self._newest[page, "pixel"] = number
            self._newest.move_to_end((page, kind))
            while len(self._newest) > MOST_PAGES:
                self._newest.popitem(last=False)
        return lambda: not self._closed and self._newest.get((page, kind)) == number

    def compute(
        self,
        wanted: Callable[[], bool],
        work: Callable[[Callable[[], None]], Any],
        waits: Callable[[], None] = lambda: None,
    ) -> Any:
        """Return what work returns; it is given a check that raises Dropped once the request is not wanted.

        Parameters
        ----------
        waits : callable
            Called if other requests are computed first, and that takes long.
        """

        def check() -> None:
            if not wanted():
                raise Dropped

        if not self._computing.acquire(timeout=LONG_S):
            waits()
            self._computing.acquire()
        try:
            check()
            return work(check)
        finally:
            self._computing.release()

    def run(self, wanted: Callable[[], bool], work: Callable[[], Any]) -> Any:
        """Return the result of a process, one of which runs at a time, beside what is computed here."""
        with self._running:
            if not wanted():
                raise Dropped
            return work()

    def close(self) -> None:
        """End all requests, and wait a few seconds for a process and its folder to go."""
        self._closed = True
        if self._running.acquire(timeout=10.0):
            self._running.release()


class Server(ThreadingHTTPServer):
    """Serves one explorer at ``http://127.0.0.1:PORT/TOKEN/``.

    Parameters
    ----------
    port : int
        0: any free one.

    Attributes
    ----------
    address : str
        Of the page.
    """

    daemon_threads = True

    def __init__(self, explorer: Explorer, port: int = 0) -> None:
        self.explorer, self.token, self.newest = explorer, secrets.token_urlsafe(24), Newest()
        super().__init__(("127.0.0.1", port), _Handler)
        self.hosts = {f"{name}:{self.server_port}" for name in ("127.0.0.1", "localhost")}
        self.address = f"http://127.0.0.1:{self.server_port}/{self.token}/"

    def server_close(self) -> None:
        """Also end what still is computed."""
        super().server_close()
        self.newest.close()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of pages that are closed while they wait; name all else in one line."""
        error = sys.exc_info()[1]
        if not isinstance(error, OSError):
            click.echo(f"error: {type(error).__name__}: {error}", err=True)


class _Handler(BaseHTTPRequestHandler):
    server: Server
    server_version, sys_version = "hcss-explore", ""
    timeout = 30.0  # of a client that sends nothing

    def do_GET(self) -> None:
        """Send the page, what it loads, and what it is about."""
        with self._refusing():
            path = self._path()
            if path == "about":
                explorer = self.server.explorer
                self._send_json({
                    "title": explorer.title, "scenario": explorer.source, "controls": explorer.controls
                })  # fmt: skip
            elif path in _SITE:
                name, kind = _SITE[path]
                self._send(200, kind, files("hcss_explore").joinpath("site", name).read_bytes())
            else:
                raise Refused(404, "there is no such page")

    def do_POST(self) -> None:
        """Answer a question of the page."""
        with self._refusing():
            path = self._path()
            given = self._given()
            question = {"frame": self._frame, "pixel": self._pixel, "run": self._run, "save": self._save}.get(path)
            if question is None:
                raise Refused(404, "there is no such question")
            page, changes = given.get("page"), given.get("changes")
            if not isinstance(page, str) or not isinstance(changes, dict):
                raise Refused(400, "page, changes: allowed: a text and a table")
            question(given, changes, self.server.newest.ask(page[:64], path))

    def log_message(self, *_: Any) -> None:
        """Print nothing: the terminal belongs to the user."""

    @contextmanager
    def _refusing(self) -> Iterator[None]:
        try:
            yield
        except Refused as refused:
            self._send(refused.status, "text/plain; charset=utf-8", f"{refused}\n".encode())
        except ConnectionError:
            return  # the page is closed

    def _path(self) -> str:
        """Return the path below the token; raises Refused."""
        if self.headers.get("Host") not in self.server.hosts:
            raise Refused(403, "Host: allowed: this machine's own address")
        origin = self.headers.get("Origin")
        if origin is not None and origin not in {f"http://{host}" for host in self.server.hosts}:
            raise Refused(403, "Origin: allowed: this page")
        token, slash, path = self.path.partition("?")[0].removeprefix("/").partition("/")
        if not slash or not hmac.compare_digest(token.encode(), self.server.token.encode()):
            raise Refused(403, "the address lacks its token; allowed: the address that hcss explore prints")
        return path

    def _given(self) -> dict[str, Any]:
        """Return the table that the page sends; raises Refused."""
        if self.headers.get_content_type() != "application/json":
            raise Refused(415, "Content-Type: allowed: application/json")
        length = self.headers.get("Content-Length", "")
        if not (length.isascii() and length.isdigit()) or int(length) > LARGEST_REQUEST:
            raise Refused(413, f"Content-Length: '{length[:20]}'; allowed: up to {LARGEST_REQUEST}")
        try:
            given = json.loads(self.rfile.read(int(length)))
        except (ValueError, RecursionError):
            given = None
        if not isinstance(given, dict):
            raise Refused(400, "the request is not a table in JSON")
        return given

    def _frame(self, given: Mapping[str, Any], changes: Mapping[str, Any], wanted: Callable[[], bool]) -> None:
        """Send a line for each step as it begins, then the frame: a line that describes it, and its numbers."""
        number, measured = given.get("number", 0), given.get("measured", False)
        if not isinstance(number, int):
            raise Refused(400, "number: allowed: a whole number")
        self._head(200, "application/octet-stream")

        def work(check: Callable[[], None]) -> Picture:
            def stage(name: str) -> None:
                check()
                self._line({"stage": name})

            return self.server.explorer.picture(changes, number, measured is True, stage)

        answer = self._answer(wanted, work, lambda: self._line({"stage": "turn"}))
        if isinstance(answer, Picture):
            numbers = answer.radiance, answer.kelvin, answer.thickness
            self._line({"about": answer.about, "bytes": sum(array.nbytes for array in numbers)})
            for array in numbers:
                self.wfile.write(array.astype("<f4").tobytes())
        else:
            self._line(answer)

    def _pixel(self, given: Mapping[str, Any], changes: Mapping[str, Any], wanted: Callable[[], bool]) -> None:
        where = [given.get(name) for name in ("number", "row", "column", "band")]
        if not all(type(each) is int for each in where):
            raise Refused(400, "number, row, column, band: allowed: whole numbers")
        number, row, column, band = (int(each or 0) for each in where)
        pixel = self.server.explorer.pixel
        self._send_json(self._answer(wanted, lambda check: pixel(changes, number, row, column, band, check)))

    def _run(self, given: Mapping[str, Any], changes: Mapping[str, Any], wanted: Callable[[], bool]) -> None:
        """Run the scenario beside all else, so that the image stays alive."""
        if given.get("stop") is True:  # being newer, it has stopped the run before it
            self._send_json({"text": "", "code": None})
            return
        answer = self._told(lambda: self.server.newest.run(wanted, lambda: self.server.explorer.run(changes, wanted)))
        self._send_json(answer)

    def _save(self, given: Mapping[str, Any], changes: Mapping[str, Any], wanted: Callable[[], bool]) -> None:
        name, replace = given.get("name"), given.get("replace") is True
        if not isinstance(name, str):
            raise Refused(400, "name: allowed: a text")

        def work() -> dict[str, Any]:
            return {"path": str(self.server.explorer.save(changes, name, replace))}

        self._send_json(self._told(work))

    def _answer(
        self,
        wanted: Callable[[], bool],
        work: Callable[[Callable[[], None]], Any],
        waits: Callable[[], None] = lambda: None,
    ) -> Any:
        """Return the result of work in its turn, or what hinders it."""
        return self._told(lambda: self.server.newest.compute(wanted, work, waits))

    def _told(self, work: Callable[[], Any]) -> Any:
        try:
            return work()
        except Dropped:
            return {"dropped": True}
        except HcssError as error:
            return {"problems": problems_of(error)}
        except click.ClickException as error:
            return {"problems": [{"field": "others", "message": error.format_message()}]}
        except ConnectionError:
            raise
        except MemoryError:
            return {"problems": [{"field": "", "message": "out of memory; a smaller image needs less"}]}
        except Exception as error:  # of a provider: the page stays, and other controls may do
            click.echo(f"error: {type(error).__name__}: {error}", err=True)
            return {"problems": [{"field": "", "message": f"{type(error).__name__}: {error}"}]}

    def _line(self, value: Any) -> None:
        self.wfile.write(json.dumps(json_value(value)).encode() + b"\n")
        self.wfile.flush()

    def _send_json(self, value: Any) -> None:
        self._send(200, "application/json", json.dumps(json_value(value)).encode())

    def _send(self, status: int, kind: str, content: bytes) -> None:
        self._head(status, kind, len(content))
        with suppress(ConnectionError):
            self.wfile.write(content)

    def _head(self, status: int, kind: str, length: int | None = None) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        if length is not None:
            self.send_header("Content-Length", str(length))
        self.send_header("Content-Security-Policy", _POLICY)
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
