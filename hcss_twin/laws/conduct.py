"""Laws of providers of all kinds on how they treat arguments, results, earlier calls and random numbers."""

from __future__ import annotations

import contextlib
import dataclasses
import io
import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.laws.clouds import possible
from hcss_twin.laws.law import Inapplicable, Law, require
from hcss_twin.laws.samples import PlainScene, StillScene
from hcss_twin.physics.paths import to_space
from hcss_twin.providers import (
    CloudInputs,
    ColumnSetting,
    ColumnStates,
    ElementInputs,
    Microphysics,
    RadianceModel,
    SensorInputs,
    Sun,
    SurfaceInputs,
)

Arguments = Callable[[], tuple[Any, ...]]
"""Returns new arguments at each call, which a provider could write to."""

DEPTH = 4
"""Levels of dataclasses, mappings and sequences in which arrays are looked for."""

LATER_S = 2.0
"""Time from one call to another."""

ROUNDING = 1e-9
"""Allowed relative difference of results that must be the same."""


Question = tuple[str, Arguments, Arguments]
"""Name of a method of a provider, and two sets of arguments."""


def arguments_are_left_as_they_were(provider: Any, inputs: Any, questions: Sequence[Question]) -> None:
    """A provider writes into no array that it is given, in a call or in its inputs."""
    of_inputs = _copies(inputs)
    for member, one, _ in questions:
        given = one()
        before = _copies(given)
        getattr(provider, member)(*given)
        for array, copy in zip(arrays_in(given), before, strict=True):
            require(_same(array, copy), f"{member}() changes an argument of shape {array.shape}")
    for array, copy in zip(arrays_in(inputs), of_inputs, strict=True):
        require(_same(array, copy), f"an array of shape {array.shape} in the inputs is changed")


def no_later_call_changes_a_result(provider: Any, questions: Sequence[Question]) -> None:
    """A returned array is neither an argument nor a buffer of the provider that it fills again."""
    for member, one, other in questions:
        given = one()
        arrays = list(arrays_in(getattr(provider, member)(*given)))
        copies = _copies(arrays)
        for array in arrays:
            shared = any(np.shares_memory(array, argument) for argument in arrays_in(given))
            require(not shared, f"{member}() returns the memory of an argument, shape {array.shape}")
        _ask(provider, member, other)
        kept = all(map(_same, arrays, copies))
        require(kept, f"a later {member}() overwrites what an earlier one returned")


def results_belong_to_the_caller(provider: Any, questions: Sequence[Question]) -> None:
    """What is done to a returned array changes no later result: it is a copy, or cannot be written to."""
    for member, one, _ in questions:
        arrays = list(arrays_in(_ask(provider, member, one)))
        copies = _copies(arrays)
        for array in arrays:
            if array.flags.writeable:
                array[...] = np.nan if array.dtype.kind == "f" else 0
        again = list(arrays_in(_ask(provider, member, one)))
        kept = len(again) == len(copies) and all(map(_same, again, copies))
        require(kept, f"a change of what {member}() returned changes what it returns later: return a copy")


def results_do_not_depend_on_earlier_calls(
    make: Callable[[Any], Any], inputs: Any, questions: Sequence[Question]
) -> None:
    """The same call gives the same result, after others and by another instance."""
    provider = make(inputs)
    if getattr(provider.declares, "remembers", False):
        raise Inapplicable("the sensor remembers earlier frames")
    for member, one, other in questions:
        first = _copies(_ask(provider, member, one))
        _ask(provider, member, other)
        again, fresh = make(inputs), make(inputs)
        _ask(again, member, other)
        for who, asked in (
            ("the same call after another one", provider),
            ("another instance", fresh),
            ("another instance after another call", again),
        ):
            found = list(arrays_in(_ask(asked, member, one)))
            same = len(found) == len(first) and all(map(_same, found, first))
            require(same, f"{member}(): {who} gives another result")


def global_random_numbers_are_left_alone(
    make: Callable[[Any], Any], inputs: Any, questions: Sequence[Question]
) -> None:
    """Results do not depend on the random numbers of ``numpy.random`` and ``random``, and draw none of them."""
    kept = np.random.get_state(), random.getstate()  # noqa: NPY002 - these are what the law is about
    try:
        for member, one, _ in questions:
            results = []
            for seed in (1, 2):
                np.random.seed(seed)  # noqa: NPY002 - these are what the law is about
                random.seed(seed)
                before = repr(np.random.get_state()), random.getstate()  # noqa: NPY002 - these are what the law is about
                results.append(_copies(_ask(make(inputs), member, one)))
                drawn = (repr(np.random.get_state()), random.getstate()) != before  # noqa: NPY002 - these are what the law is about
                require(not drawn, f"{member}() or the constructor draws or seeds global random numbers")
            same = len(results[0]) == len(results[1]) and all(map(_same, *results))
            require(same, f"{member}() depends on the seed of global random numbers")
    finally:
        np.random.set_state(kept[0])  # noqa: NPY002 - these are what the law is about
        random.setstate(kept[1])


def nothing_is_printed(make: Callable[[Any], Any], inputs: Any, questions: Sequence[Question]) -> None:
    """A provider writes nothing to stdout, where answers of commands go; it can log to the ``log`` of its scene."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        provider = make(inputs)
        for member, one, _ in questions:
            _ask(provider, member, one)
    require(not printed.getvalue(), f"printed: {printed.getvalue()[:60]!r}")


def results_are_in_double_precision(provider: Any, questions: Sequence[Question]) -> None:
    """Spectral results are float64."""
    for member, one, _ in questions:
        for array in arrays_in(_ask(provider, member, one)):
            require(array.dtype == np.float64, f"{member}() returns {array.dtype}; expected float64")


LAWS: tuple[Law, ...] = (
    arguments_are_left_as_they_were,
    no_later_call_changes_a_result,
    results_belong_to_the_caller,
    results_do_not_depend_on_earlier_calls,
    global_random_numbers_are_left_alone,
    nothing_is_printed,
)
"""Laws of providers of any kind."""


def of_clouds(provider: Any, inputs: CloudInputs) -> tuple[Question, ...]:
    """Questions to a cloud generator: the whole image, and a window of it at another time, if there is one."""
    rows, columns = inputs.grid.rows, inputs.grid.columns
    whole = slice(0, rows), slice(0, columns)
    part = slice(0, min(5, rows)), slice(min(2, columns - 1), min(9, columns))
    window = part if provider.declares.tileable else whole
    return (("thickness_m", lambda: (0.0, *whole), lambda: (possible(provider, inputs, (0.0, LATER_S))[-1], *window)),)


def of_sea(provider: Any, wavenumber_cm1: Array) -> tuple[Question, ...]:
    """Questions to a sea model."""

    def directions(*mu: float) -> Arguments:
        return lambda: (_own(wavenumber_cm1), np.array(mu))

    def pairs(*mu: float) -> Arguments:
        return lambda: (*directions(*mu)(), np.array(mu[::-1]), np.array([0.5, 2.0, 3.0]))

    one, other = (1.0, 0.8, 0.5), (0.9, 0.7, 0.3)
    questions: list[Question] = [("emissivity", directions(*one), directions(*other))]
    questions.append(("brdf", pairs(*one), pairs(*other)))
    if hasattr(provider, "reflection_weights"):
        nodes = 0.5 * (np.polynomial.legendre.leggauss(6)[0] + 1.0)
        first, second = (lambda mu=mu: (*directions(*mu)(), nodes.copy()) for mu in (one, other))
        questions.append(("reflection_weights", first, second))
    return tuple(questions)


def of_optics(cloud: Microphysics, wavenumber_cm1: Array) -> tuple[Question, ...]:
    """Questions to optics: particles, and slightly smaller ones."""
    smaller = replace(cloud, b=1.1 * cloud.b)
    one, other = (lambda given=given: (given, _own(wavenumber_cm1)) for given in (cloud, smaller))
    return (("single_scattering", one, other),)


def of_air(provider: Any, wavenumber_cm1: Array) -> tuple[Question, ...]:
    """Questions to a transmittance provider."""
    nu, low = wavenumber_cm1, float(provider.declares.valid.get("target_altitude_m", (0.0, 0.0))[0])
    zenith = np.clip([30.0, 20.0, 25.0, 35.0], *provider.declares.valid.get("view_zenith", (0.0, 90.0))).tolist()
    one, other = [to_space(low, zenith[0]), to_space(low, zenith[1])], [to_space(low, angle) for angle in zenith[2:]]
    questions: list[Question] = []
    for member in ("transmittance", "path_radiance"):
        if hasattr(provider, member):
            first, second = (lambda paths=paths: (_own(nu), list(paths)) for paths in (one, other))
            questions.append((member, first, second))
    if hasattr(provider, "absorber_amounts"):
        questions.append(("absorber_amounts", lambda: (list(one),), lambda: (list(other),)))
    return tuple(questions)


def of_radiance(provider: RadianceModel, setting: ColumnSetting, wavenumber_cm1: Array) -> tuple[Question, ...]:
    """Questions to a radiance model: columns by night and, if it knows the sun, by day."""
    settings = [setting, *([setting.under(Sun(40.0, 200.0, 1.0))] if provider.solar_terms else [])]

    def columns(*thickness_m: float) -> Arguments:
        each = [[metres] * len(setting.layers) for metres in thickness_m]
        return lambda: (ColumnStates.product(settings, np.array(each)), _own(wavenumber_cm1))

    return (("columns", columns(0.0, 200.0), columns(100.0, 400.0)),)


def of_elements(inputs: ElementInputs, time_s: float = 0.0) -> tuple[Question, ...]:
    """Questions to elements: the whole image, and a window of it later."""
    rows, columns = inputs.grid.rows, inputs.grid.columns
    windows = (slice(0, rows), slice(0, columns)), (slice(0, (rows + 1) // 2), slice(columns // 3, columns))
    times_s = time_s, time_s + LATER_S
    one, other = (lambda at=at: (at[0], *at[1], PlainScene(inputs)) for at in zip(times_s, windows, strict=True))
    return (("pixels", one, other),)


def of_surfaces(inputs: SurfaceInputs) -> tuple[Question, ...]:
    """Questions to a surface: the whole image, and a window of it later."""
    rows, columns = inputs.grid.rows, inputs.grid.columns
    return (
        (
            "surface",
            lambda: (0.0, slice(0, rows), slice(0, columns)),
            lambda: (LATER_S, slice(min(1, rows - 1), rows), slice(min(2, columns - 1), columns)),
        ),
    )


def of_variables(fields: Mapping[str, NDArray[Any]], others: Mapping[str, NDArray[Any]]) -> tuple[Question, ...]:
    """Questions to variables: two sets of fields."""
    one, other = (
        lambda given=given: ({name: np.array(values) for name, values in given.items()}, 0.0)
        for given in (fields, others)
    )
    return (("values", one, other),)


def of_sensors(inputs: SensorInputs, scene: Array, other_scene: Array) -> tuple[Question, ...]:
    """Questions to a sensor: two frames (B, y, x)."""

    def frame(number: int, radiance: Array) -> Arguments:
        def arguments() -> tuple[Any, ...]:
            time_s = number * inputs.frame_interval_s
            if isinstance(inputs.scene_at, StillScene):
                inputs.scene_at.begin(radiance, time_s)
            return np.array(radiance), number, time_s

        return arguments

    return (("measure", frame(0, scene), frame(1, other_scene)),)


def arrays_in(value: Any, depth: int = DEPTH) -> Iterator[NDArray[Any]]:
    """Yield the arrays of a value, in dataclasses, mappings and sequences, too."""
    if isinstance(value, np.ndarray):
        yield value
    elif depth:
        parts: Sequence[Any] = ()
        if isinstance(value, Mapping):
            parts = list(value.values())
        elif isinstance(value, list | tuple):
            parts = value
        elif dataclasses.is_dataclass(value) and not isinstance(value, type):
            parts = [getattr(value, field.name) for field in dataclasses.fields(value)]
        for part in parts:
            yield from arrays_in(part, depth - 1)


def _ask(provider: Any, member: str, arguments: Arguments) -> Any:
    return getattr(provider, member)(*arguments())


def _copies(value: Any) -> list[NDArray[Any]]:
    return [np.array(array) for array in arrays_in(value)]


def _own(values: Array) -> Array:
    """Return a copy that could be written to."""
    return np.array(values)


def _same(one: NDArray[Any], other: NDArray[Any]) -> bool:
    if one.shape != other.shape:
        return False
    if one.dtype.kind != "f" or other.dtype.kind != "f":
        return bool(np.array_equal(one, other))
    return bool(np.allclose(one, other, rtol=ROUNDING, atol=0.0, equal_nan=True))
