"""Contents of a sweep file: a scenario, the swept keys, and the combination of their values."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any, Self

from hcss_sweep.axis import FORMS, SweptAxis, axis_of
from hcss_sweep.sensors import SENSORS, merged, sensors_of
from hcss_twin import Scenario
from hcss_twin.providers import Problem, ScenarioError

__all__ = ["joined_keys", "key_problems", "keys_overlap", "read_keys"]

SWEEP = "sweep"
"""Section of a file that describes many scenarios."""

FOLDERS = ("sweeps", "scenarios")
"""Catalog folders in which names are looked up."""

MAX_POINTS = 100_000
_COMBINATIONS = ("product", "zip")
_OPTIONS = ("combine", "dataset")


@dataclass(frozen=True)
class Design:
    """A sweep with checked keys; its points are not checked yet.

    Attributes
    ----------
    scenario, overrides : mapping
        Keys of the scenario file without ``[sweep]``, and keys replaced in all points.
    base : Path
        Base folder of relative paths.
    axes : tuple of SweptAxis
        Swept axes, in file order.
    combine : str
        ``product``: every value of each key with every value of the others, the last key changing fastest; ``zip``: the
        first values of all keys, then the second, and so on.
    dataset : str or None
        Name of the file for all points.
    sensors : mapping
        Keys of each sensor of ``[[sensors]]`` by its name; none in other sweeps. They are the last axis.
    """

    scenario: Mapping[str, Any]
    overrides: Mapping[str, Any]
    base: Path
    origin: str
    axes: tuple[SweptAxis, ...]
    combine: str
    dataset: str | None
    sensors: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """Title of the scenario, as given."""
        title = self.scenario.get("title", "")
        return title if isinstance(title, str) else ""

    @property
    def count(self) -> int:
        """Number of points."""
        lengths = [len(axis.values) for axis in self.axes]
        return math.prod(lengths) if self.combine == "product" else lengths[0]

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes of a product; the number of points of a zip."""
        return tuple(len(axis.values) for axis in self.axes) if self.combine == "product" else (self.count,)

    def values(self) -> Iterator[dict[str, Any]]:
        """Yield the swept keys of each point with their values, in the order of points."""
        columns = [axis.values for axis in self.axes]
        rows = product(*columns) if self.combine == "product" else zip(*columns, strict=True)
        for row in rows:
            yield {axis.key: value for axis, value in zip(self.axes, row, strict=True)}

    def keys_of(self, values: Mapping[str, Any]) -> tuple[Mapping[str, Any], dict[str, Any]]:
        """Return the keys of the file for a point, and the dotted keys that replace some of them."""
        changed = {key: value for key, value in values.items() if key != SENSORS}
        scene = merged(self.scenario, self.sensors[values[SENSORS]]) if self.sensors else self.scenario
        return scene, {**self.overrides, **changed}

    @classmethod
    def load(
        cls,
        source: str | Path | Mapping[str, Any] | Scenario,
        overrides: Mapping[str, Any] | None = None,
        over: Mapping[str, Any] | None = None,
    ) -> Self:
        """Read a sweep: a shipped sweep or scenario by name, a ``.toml`` or ``.json`` file, its keys, or a scenario.

        ``overrides`` (dotted key to value) are the same in all points; ``over`` has swept keys and their values as in
        ``[sweep]``, and replaces keys of the same name there. Raises ScenarioError with all errors of the section;
        points are not checked.
        """
        raw, base, origin = read_keys(source, "sweep", FOLDERS)
        return cls._checked(raw, dict(overrides or {}), dict(over or {}), base, origin)

    @classmethod
    def _checked(
        cls, raw: dict[str, Any], overrides: dict[str, Any], over: dict[str, Any], base: Path, origin: str
    ) -> Self:
        section = raw.pop(SWEEP, {})
        if not isinstance(section, Mapping):
            raise ScenarioError([Problem(SWEEP, f"{Problem.shown(section)} is not a table; {_ALLOWED}")], origin)
        options = {name: section[name] for name in _OPTIONS if name in section}
        keys = {name: content for name, content in section.items() if name not in _OPTIONS}
        given = {**joined_keys(keys, _is_nested), **over}
        problems = list(_option_problems(options))
        axes = []
        for key, values in given.items():
            try:
                axes.append(axis_of(key, values))
            except ValueError as error:
                problems.append(Problem(f"{SWEEP}.{key}", str(error)))
        sensors: Mapping[str, Mapping[str, Any]] = {}
        if SENSORS in raw:
            sensors, of_sensors = sensors_of(raw.pop(SENSORS))
            problems += of_sensors
        if not given and not sensors:
            problems.append(Problem(SWEEP, f"no key is swept; {_ALLOWED}"))
        problems += key_problems(SWEEP, [*given], "swept", _ALLOWED, overrides, _OPTIONS)
        combine = options.get("combine", "product")
        if combine == "zip" and len({len(axis.values) for axis in axes}) > 1:
            lengths = ", ".join(f"{axis.key} has {len(axis.values)}" for axis in axes)
            problems.append(Problem(f"{SWEEP}.combine", f"'zip' needs equally many values of each key; {lengths}"))
        if combine == "product":
            problems += _repeated(axes)
        elif sensors:
            problems.append(Problem(f"{SWEEP}.combine", "'zip' with [[sensors]]; allowed: 'product'"))
        if problems:
            raise ScenarioError(problems, origin)
        if sensors:
            axes.append(SweptAxis(SENSORS, tuple(sensors)))
        design = cls(raw, overrides, base, origin, tuple(axes), combine, options.get("dataset"), sensors)
        if design.count > MAX_POINTS:
            shape = " x ".join(map(str, design.shape))
            message = f"{shape} = {design.count} points; allowed: at most {MAX_POINTS}"
            raise ScenarioError([Problem(SWEEP, message)], origin)
        return design


_ALLOWED = f'allowed: keys of a scenario, for example "view.zenith", each with {FORMS}'


def _is_nested(table: Mapping[str, Any]) -> bool:
    # Ranges, distributions and ensembles contain scalar values; a choice should.
    return "choice" not in table and all(isinstance(item, list | tuple | Mapping) for item in table.values())


def joined_keys(
    section: Mapping[str, Any], is_nested: Callable[[Mapping[str, Any]], bool], path: str = ""
) -> dict[str, Any]:
    """Join keys of nested tables by dots: TOML reads ``view.zenith = [...]`` as a table in a table."""
    joined: dict[str, Any] = {}
    for name, content in section.items():
        if isinstance(content, Mapping) and content and is_nested(content):
            joined.update(joined_keys(content, is_nested, f"{path}{name}."))
        else:
            joined[f"{path}{name}"] = content
    return joined


def _option_problems(options: Mapping[str, Any]) -> Iterator[Problem]:
    combine, dataset = options.get("combine", "product"), options.get("dataset")
    if combine not in _COMBINATIONS:
        guess = Problem.closest(str(combine), _COMBINATIONS)
        hint = f"; closest is '{guess}'" if guess else ""
        yield Problem(
            f"{SWEEP}.combine", f"{Problem.shown(combine)}; allowed: {', '.join(map(repr, _COMBINATIONS))}{hint}"
        )
    is_name = (
        isinstance(dataset, str)
        and dataset == Path(dataset).name
        and not dataset.startswith(("point-", "."))
        and dataset.endswith(".nc")
    )
    if dataset is not None and not is_name:
        yield Problem(
            f"{SWEEP}.dataset", f"{Problem.shown(dataset)}; allowed: a name in the sweep's folder, *.nc but not point-*"
        )


def read_keys(
    source: str | Path | Mapping[str, Any] | Scenario, kind: str, folders: tuple[str, ...] = ("scenarios",)
) -> tuple[dict[str, Any], Path, str]:
    """Return the keys of a scenario or sweep, the base folder of its relative paths, and its name for messages.

    Names are looked up in ``folders`` of the catalog. Raises ScenarioError if there are no keys.
    """
    raw: Any
    if isinstance(source, Scenario):
        raw, base, origin = json.loads(source.to_json()), source.base, source.origin
    elif isinstance(source, Mapping):
        raw, base, origin = source, Path.cwd(), kind
    else:
        (raw, base), origin = Scenario.read_file(source, folders), str(source)
    if not isinstance(raw, Mapping):
        raise ScenarioError([Problem(kind, f"{Problem.shown(raw)} is not a table of keys")], origin)
    return dict(raw), base, origin


def key_problems(
    section: str,
    keys: Sequence[str],
    adjective: str,
    allowed: str,
    overrides: Iterable[str] = (),
    options: Sequence[str] = (),
) -> Iterator[Problem]:
    """Yield an error for each unknown or overlapping key of ``[sweep]`` or ``[uncertain]``."""
    for number, key in enumerate(keys):
        for other in keys[:number]:
            if keys_overlap(key, other):
                yield Problem(f"{section}.{key}", f"overlaps {other}, which is {adjective}, too; allowed: one of them")
        for other in overrides:
            if keys_overlap(key, other):
                message = f"is {adjective}, but {other} is set to one value; allowed: one of them"
                yield Problem(f"{section}.{key}", message)
        first = key.partition(".")[0]
        if first not in Scenario.model_fields:
            guess = Problem.closest(first, (*Scenario.model_fields, *options))
            hint = f"; closest is '{guess}'" if guess else ""
            yield Problem(f"{section}.{key}", f"not a scenario key; {allowed}{hint}")


def key_parts(key: str) -> list[str]:
    """Split a dotted key as scenarios do: ``clouds.KEY`` refers to the single layer."""
    parts = key.split(".")
    if parts[0] == "clouds" and len(parts) > 1 and parts[1] != "layers":
        parts[1:1] = ["layers", "0"]
    return parts


def keys_overlap(one: str, other: str) -> bool:
    """Whether two keys are equal or one contains the other."""
    a, b = (f"{'.'.join(key_parts(key))}." for key in (one, other))
    return a.startswith(b) or b.startswith(a)


def _repeated(axes: list[SweptAxis]) -> Iterator[Problem]:
    for axis in axes:
        seen: set[str] = set()
        for value in axis.values:
            text = f"{type(value).__name__} {value!r}"
            if text in seen:
                message = f"{Problem.shown(value)} is given twice; allowed: each value once, or {SWEEP}.combine = 'zip'"
                yield Problem(f"{SWEEP}.{axis.key}", message)
                break
            seen.add(text)
