"""The process in which ``hcss check`` runs the kit: the contract class of a provider, and a pytest plugin.

Both append what happens to one file, line by line, which :mod:`hcss_author.check` reads while it grows.
"""

from __future__ import annotations

import functools
import itertools
import json
import threading
import time
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any

import pytest

import hcss_author
from hcss_author.contract import expect_failures
from hcss_author.extension_entries import Extension
from hcss_author.new_plugin.write import contract_name
from hcss_twin.providers import Catalog, HcssError, Kind
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.registry import Registry

USUAL_CLOUD_TYPE = "stratus"
"""Its shape is that of ``CloudInputs.type_parameters``: a scene always has a cloud type."""


class NotRun(Exception):
    """A law needs a member that did not return in earlier laws."""


class Events:
    """A file that grows by one JSON object per line; any thread may write.

    Parameters
    ----------
    path : Path
    blocked : collection of str
        Members that must not be called.
    """

    def __init__(self, path: Path, blocked: Collection[str] = ()) -> None:
        self.blocked = blocked
        self._file = path.open("a", encoding="utf-8", buffering=1)
        self._lock = threading.Lock()

    def write(self, **event: Any) -> None:
        """Append one event."""
        with self._lock:
            self._file.write(json.dumps(event) + "\n")


class Timed:
    """A provider whose calls are announced and timed; in all else it is the provider."""

    def __init__(self, provider: Any, events: Events, numbers: Any) -> None:
        self._provider, self._events, self._numbers = provider, events, numbers

    def __getattr__(self, name: str) -> Any:
        # copying and unpickling look up attributes before there is a provider
        if name.startswith("__") or name in ("_provider", "_events", "_numbers"):
            raise AttributeError(name)
        value = getattr(self._provider, name)
        return timed(value, name, self._events, next(self._numbers)) if callable(value) else value

    def __reduce__(self) -> tuple[Any, ...]:
        return _itself, (self._provider,)


def _itself(value: Any) -> Any:
    return value


def timed(function: Callable[..., Any], name: str, events: Events, number: int) -> Callable[..., Any]:
    """Return a function that writes to ``events`` before and after each call."""

    @functools.wraps(function)
    def call(*arguments: Any, **keywords: Any) -> Any:
        if name in events.blocked:
            raise NotRun(f"{name}() did not return in earlier laws")
        given = [_shape(argument) for argument in arguments] + [
            f"{key}={_shape(value)}" for key, value in keywords.items()
        ]
        events.write(call=number, text=f"{name}({', '.join(given)})")
        start = time.perf_counter()
        try:
            return function(*arguments, **keywords)
        finally:
            events.write(returned=number, member=name, seconds=time.perf_counter() - start)

    return call


def _shape(value: Any) -> str:
    """Write an argument as numbers, slices and text are, arrays and lists by their shape, others by their type."""
    if isinstance(value, int | float | str | slice | None):
        return repr(value)
    if isinstance(value, list | tuple):
        return f"{type(value).__name__} of {len(value)}"
    shape = getattr(value, "shape", None)
    return type(value).__name__ if shape is None else f"array {shape}"


def contract_of(
    kind: str, name: str, parameters: Mapping[str, Any], events_path: str, blocked: Collection[str] = ()
) -> type:
    """Return the test class of a provider, with default inputs.

    A transmittance provider of one profile only gets this profile; a cloud generator the shape of a usual cloud type.

    Parameters
    ----------
    kind, name : str
        Of the provider; the name with its distribution.
    parameters : mapping
        As in a scenario.
    events_path : str
        File of the events.
    blocked : collection of str
        Members that must not be called.
    """
    events = Events(Path(events_path), blocked)
    if kind in list(Extension):
        return type("Installed", (getattr(hcss_author, Extension(kind).contract),), extension_members(name, parameters))
    registry = Registry.discover()
    entry = registry.resolve(kind, name)
    numbers = itertools.count()
    try:
        chosen = _parameters(registry, entry, parameters)
        profile = registry.bound_profile(entry, chosen, Catalog()) if entry.kind is Kind.ATMOSPHERE else None
    except HcssError as error:
        events.write(error=str(error))
        raise
    base: Any = getattr(hcss_author, contract_name(entry.kind))

    def construct(inputs: Any) -> Any:
        return registry.create(entry, inputs, chosen, hcss_author.sample_scene())

    create = timed(construct, entry.spec.target.partition(":")[2], events, next(numbers))

    class Installed(base):  # type: ignore[misc]
        def test_registration_is_sound(self) -> None:
            """Class and parameters can be imported; parameters are described, immutable, and refuse unknown keys."""
            hcss_author.assert_registered(entry.kind, entry.name, entry.distribution)

        def make_provider(self, inputs: Any) -> Any:
            return Timed(create(inputs), events, numbers)

        if profile is not None:

            @pytest.fixture
            def inputs(self) -> Any:
                return hcss_author.sample_atmosphere_inputs(profile)

        if entry.kind is Kind.CLOUDS:

            def make_inputs(self, coverage: float = 0.5, seed: int = 1) -> Any:
                catalog = Catalog()
                shape = catalog.toml(catalog.find(USUAL_CLOUD_TYPE, "cloud_types", ".toml"))["fractal"]
                return hcss_author.sample_cloud_inputs(coverage, seed, type_parameters=shape)

    try:
        expect_failures(Installed, getattr(registry.provider_class(entry), "expected_failures", {}))
    except ValueError as error:
        events.write(error=str(error))
        raise
    return Installed


def extension_members(name: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the attributes of the test class of an extension: its name, and keys of its section."""
    return {"name": name, "settings": dict(settings)}


def _parameters(registry: Registry, entry: Entry, given: Mapping[str, Any]) -> Any:
    """Return the parameters of a provider; raises HcssError where they are missing or not allowed."""
    model = registry.parameters_model(entry)
    if model is None:
        if given:
            raise HcssError(f"it has no parameters; given: {', '.join(given)}")
        return None
    from pydantic import ValidationError

    try:
        return model(**given)
    except ValidationError as error:
        problems = (": ".join([*map(str, problem["loc"]), problem["msg"]]) for problem in error.errors())
        raise HcssError(f"parameters (--set KEY=VALUE): {'; '.join(problems)}") from error


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the file of the events."""
    parser.addoption("--hcss-events", type=Path, required=True)


def pytest_configure(config: pytest.Config) -> None:
    """Write the events of the tests."""
    config.pluginmanager.register(LawEvents(Events(config.getoption("--hcss-events"))))


class LawEvents:
    """Writes which laws there are, and how each ends."""

    def __init__(self, events: Events) -> None:
        self._events = events

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """Write all laws."""
        self._events.write(laws=[_law(item) for item in session.items])

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        """Write that a law begins."""
        self._events.write(begins=nodeid)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Write how a law ended; a failure to set it up is one, too."""
        if report.skipped and hasattr(report, "wasxfail"):
            outcome, why = "expected failure", report.wasxfail.removeprefix("reason: ")
        elif report.skipped:
            outcome, why = "not applicable", str(report.longrepr[-1]).removeprefix("Skipped: ")  # type: ignore[index]
        elif report.failed:
            crash = getattr(report.longrepr, "reprcrash", None)
            outcome, why = "failed", str(report.longrepr) if crash is None else crash.message
            _, not_run, reason = why.partition(f"{NotRun.__name__}: ")
            if not_run:
                outcome, why = "not run", reason
        elif report.when == "call":
            outcome, why = "passed", ""
        else:
            return
        self._events.write(ended=report.nodeid, outcome=outcome, why=why, seconds=report.duration)


def _law(item: Any) -> dict[str, str]:
    function, _, case = item.name.partition("[")
    words = function.removeprefix("test_").replace("_", " ")
    meaning = " ".join((item.obj.__doc__ or "").strip().partition("\n\n")[0].split())
    return {"id": item.nodeid, "name": f"{words} ({case[:-1]})" if case else words, "meaning": meaning}
