"""Run the conformance kit on an installed provider, without a test file of its author (``hcss check``).

The kit runs in a process of its own, which writes what happens to a file (:mod:`hcss_author.law_events`). A call
that does not return in time, or that ends the process, is a failure of the law that made it, and is named; another
process tries the laws that remain. The result is kept, and cubes made with the provider quote it.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

from hcss_author.extension_entries import Extension, ExtensionEntry, find_extension
from hcss_twin.core.errors import OptionError
from hcss_twin.providers import Kind, ProviderError, choose_from
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.registry import Registry

Outcome = Literal["passed", "failed", "expected failure", "not applicable", "not run"]

START_LIMIT_S = 120.0
"""Time for the start of Python and the import of the kit, before any law runs."""

POLL_S = 0.05

MOST_STOPS = 2
"""Calls of a member that do not return; laws that need it are not run after that."""

_TEST_FILE = """from hcss_author.law_events import contract_of

TestInstalled = contract_of({kind!r}, {name!r}, {parameters!r}, {events!r}, {blocked!r})
"""


@dataclass
class Law:
    """One law of the kit and how the provider fared.

    Attributes
    ----------
    name : str
        What the law says, in a few words, with the case in parentheses.
    meaning : str
        The law in one sentence.
    outcome : {"passed", "failed", "expected failure", "not applicable", "not run"}
    why : str
        Numbers of a failure; why it is expected, why the law does not apply, or was not run.
    seconds : float
        Time it took.
    """

    name: str
    meaning: str
    outcome: Outcome = "not run"
    why: str = ""
    seconds: float = 0.0


@dataclass(frozen=True)
class Cost:
    """Time of the calls of one member, in seconds."""

    member: str
    calls: int
    median_s: float
    most_s: float


@dataclass
class Check:
    """Result of all laws.

    Attributes
    ----------
    title : str
        Kind, name, distribution and version of the provider.
    laws : list of Law
        Every law of the kit, in its order.
    costs : list of Cost
        Per member, for the arguments of the kit.
    """

    title: str
    laws: list[Law] = field(default_factory=list)
    costs: list[Cost] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Whether all laws passed that apply, but for expected failures."""
        return bool(self.laws) and all(law.outcome not in ("failed", "not run") for law in self.laws)

    @property
    def count(self) -> dict[str, int]:
        """Number of laws of each outcome that occurs."""
        return dict(sorted(Counter(law.outcome for law in self.laws).items(), reverse=True))

    def as_dict(self) -> dict[str, Any]:
        """Return everything as JSON has it."""
        return {"passed": self.passed, "count": self.count, **asdict(self)}


def find(registry: Registry, name: str, kind: str | None = None) -> Entry | ExtensionEntry:
    """Return the only provider of a plain or qualified name, or the extension of a name.

    Raises
    ------
    OptionError
        If the kind is unknown, nothing has the name, or providers of several kinds have it.
    ProviderError
        If several of one kind have it.
    """
    if kind is not None and kind not in (*Kind, *Extension):
        raise OptionError(f"--kind is '{kind}'; {choose_from(kind, (*Kind, *Extension))}")
    of_kind = () if kind in list(Extension) else registry.entries(kind)
    kinds = sorted({str(entry.kind) for entry in of_kind if name in (entry.name, entry.qualified_name)})
    if not kinds and (extension := find_extension(name, kind)) is not None:
        return extension
    if not kinds:
        of_kinds = sorted({entry.name for entry in of_kind})
        broken = "".join(f"; broken: {plugin}" for plugin in registry.broken)
        raise OptionError(f"no {kind or 'provider'} is called '{name}'; {choose_from(name, of_kinds)}{broken}")
    if len(kinds) > 1:
        raise OptionError(f"'{name}' is the name of providers of several kinds; allowed: --kind {' or '.join(kinds)}")
    return registry.resolve(kinds[0], name)


def check_provider(
    entry: Entry | ExtensionEntry, parameters: Mapping[str, Any] | None = None, limit_s: float = 120.0
) -> Check:
    """Hold a provider to the kit of its kind.

    Parameters
    ----------
    entry : Entry
        From :func:`find`.
    parameters : mapping, optional
        Parameters of the provider, as in a scenario; by default those of its model.
    limit_s : float
        Seconds that a call, or anything between two calls, may take.

    Raises
    ------
    ProviderError
        If the kit cannot begin: the provider needs parameters, or its parameters cannot be imported.
    """
    with TemporaryDirectory(prefix="hcss-check-") as name:
        folder = Path(name)
        events, log = folder / "events.jsonl", folder / "log.txt"
        events.touch()
        test = folder / "test_installed.py"
        given = {"kind": str(entry.kind), "name": entry.qualified_name, "parameters": dict(parameters or {})}
        run = _Run(Check(f"{entry.kind.human} {entry.name}  [{entry.origin}]"))
        while True:
            test.write_text(_TEST_FILE.format(**given, events=str(events), blocked=run.blocked), encoding="utf-8")
            start = events.stat().st_size
            with log.open("wb") as output:
                command = _command(test, events, run.finished)
                process = subprocess.Popen(command, stdout=output, stderr=output, env=_environment())
            try:
                stopped = _follow(process, events, start, run, limit_s)
            finally:
                process.kill()
                process.wait()
            said = log.read_text(encoding="utf-8", errors="replace").strip().splitlines()[-1:]
            if run.ended(entry, stopped, process.returncode, "".join(said)):
                return run.result()


def _command(test: Path, events: Path, finished: list[str]) -> list[str]:
    # -P: not the folder in which the user happens to be; -c: no settings of a project around it
    pytest = [sys.executable, "-P", "-m", "pytest", "-q", "-c", os.devnull, f"--rootdir={test.parent}", "--noconftest"]
    return [
        *pytest, "-p", "no:cacheprovider", "-p", "hcss_author.law_events", f"--hcss-events={events}",
        *(f"--deselect={law}" for law in finished), str(test)
    ]  # fmt: skip


def _environment() -> dict[str, str]:
    """Return the environment of the process: the packages of this one, and of pytest's plugins only its own."""
    ours = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST_")}
    return {**ours, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}


def _follow(process: subprocess.Popen[bytes], events: Path, start: int, run: _Run, limit_s: float) -> str:
    """Take events from byte ``start`` until the process ends; return why it was stopped, or nothing."""
    with events.open(encoding="utf-8") as lines:
        lines.seek(start)
        last, patience, rest = time.monotonic(), max(limit_s, START_LIMIT_S), ""
        while True:
            ended = process.poll() is not None
            text = rest + lines.read()
            complete, newline, rest = text.rpartition("\n")
            if newline:
                for line in complete.splitlines():
                    run.take(json.loads(line))
                last, patience = time.monotonic(), limit_s if run.now is not None else patience
            elif ended:
                return ""
            elif time.monotonic() - last > patience:
                return f"{run.doing} did not return within {patience:g} s; the process was stopped (--limit)"
            else:
                time.sleep(POLL_S)


class _Run:
    """What the events of the process say so far."""

    def __init__(self, check: Check) -> None:
        self.check = check
        self.now: Law | None = None
        self._error = ""
        self._laws: dict[str, Law] = {}
        self._open: dict[int, str] = {}
        self._seconds: dict[str, list[float]] = defaultdict(list)
        self._stops: Counter[str] = Counter()

    @property
    def doing(self) -> str:
        """The calls that have not returned, or what the process does between calls."""
        between = "the start of the kit" if self.now is None else f"the law '{self.now.name}', between calls,"
        return " and ".join(self._open.values()) or between

    def take(self, event: dict[str, Any]) -> None:
        """Take one event."""
        match event:
            case {"error": text}:
                self._error = text
            case {"laws": laws}:
                self._laws = {law["id"]: Law(law["name"], law["meaning"]) for law in laws} | self._laws
                self.check.laws = self.check.laws or list(self._laws.values())
            case {"begins": law}:
                self.now = self._laws[law]
            case {"ended": law, "outcome": outcome, "why": why, "seconds": seconds}:
                ended = self._laws[law]
                ended.outcome, ended.why, ended.seconds = outcome, why, seconds
            case {"call": number, "text": text}:
                self._open[number] = text
            case {"returned": number, "member": member, "seconds": seconds}:
                self._open.pop(number, None)
                self._seconds[member].append(seconds)

    @property
    def blocked(self) -> list[str]:
        """Members that have failed to return too often to be called again."""
        return [member for member, stops in self._stops.items() if stops >= MOST_STOPS]

    @property
    def finished(self) -> list[str]:
        """Identities of the laws that have an outcome."""
        return [key for key, law in self._laws.items() if law.outcome != "not run" or law.why]

    def ended(self, entry: Entry | ExtensionEntry, stopped: str, code: int, said: str) -> bool:
        """Take the end of a process; return whether no law remains for another one.

        ``code`` and ``said`` are the exit code of the process and its last line.
        """
        if self._error:
            raise ProviderError(f"{entry.label}: {self._error}")
        unfinished = [law for law in self.check.laws if law.outcome == "not run" and not law.why]
        if not self.check.laws or (unfinished and not stopped):
            stopped = stopped or f"{self.doing} ended the process (exit code {code}); its last line: {said}"
        if not self.check.laws:
            raise ProviderError(f"{entry.label}: {stopped}")
        failed, self.now = self.now, None
        self._stops.update(text.partition("(")[0] for text in self._open.values())
        self._open.clear()
        if failed not in unfinished:
            for law in unfinished:
                law.why = stopped
            return True
        assert failed is not None
        failed.outcome, failed.why = "failed", stopped
        return len(unfinished) == 1

    def result(self) -> Check:
        """Return the check with the costs."""
        self.check.costs = [
            Cost(member, len(seconds), statistics.median(seconds), max(seconds))
            for member, seconds in self._seconds.items()
        ]
        return self.check
