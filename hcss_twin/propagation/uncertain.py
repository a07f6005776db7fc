"""Uncertain keys of a scenario and their distributions, declared as ``[sweep]`` declares its own."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hcss_twin.errors import Problem, ScenarioError, choose_from, closest
from hcss_twin.scenario.models import ScenarioModel
from hcss_twin.scenario.scenario import UNCERTAIN
from hcss_twin.scenario.wording import count, shown
from hcss_twin.sweeps.axis import axis_of
from hcss_twin.sweeps.design import keys_overlap

SHORT_FORMS = {
    "uniform": ("from", "to"),
    "log-uniform": ("from", "to"),
    "normal": ("mean", "standard_deviation", "from", "to"),
}
"""What the numbers of ``NAME:NUMBER:NUMBER`` mean."""

_ALLOWED = (
    'allowed: {distribution = "normal", mean = 291, standard_deviation = 0.5}, "uniform" or "log-uniform" with from '
    "and to, or in short normal:291:0.5, normal:291:0.5:271:305 (cut off), uniform:3:9, log-uniform:1:10"
)
_KEYS = 'allowed: keys of a scenario, for example "sea.temperature"'


@dataclass(frozen=True)
class UncertainKey:
    """A key of a scenario and the distribution of its value.

    Attributes
    ----------
    key : str
        Dotted.
    distribution : mapping
        As in ``[sweep]``, without ``samples`` and ``seed``.
    """

    key: str
    distribution: Mapping[str, Any]

    def values(self, draws: int, seed: int) -> tuple[Any, ...]:
        """Return independent draws, as a scenario file would have them; keys with the same seed are independent.

        Raises
        ------
        ValueError
            With what is wrong with the distribution.
        """
        # A sweep's key with the same seed has the same numbers; these must not depend on what else is drawn of it.
        text = f"propagation {seed}".encode()
        own = int.from_bytes(hashlib.sha256(text).digest()[:8], "big") >> 1
        return axis_of(self.key, {**self.distribution, "samples": draws, "seed": own}).values


def uncertain_keys(given: Mapping[str, Any], section: str = UNCERTAIN) -> tuple[UncertainKey, ...]:
    """Check what stands in ``[uncertain]`` or behind ``--uncertain``.

    Parameters
    ----------
    given : mapping
        Key, dotted or in nested tables, to a distribution: a table, or text in the short form.

    Raises
    ------
    ScenarioError
        With everything that is wrong.
    """
    problems: list[Problem] = []
    found: list[UncertainKey] = []
    for key, each in _flat(given).items():
        try:
            found.append(UncertainKey(key, _table(each)))
            found[-1].values(1, 0)
        except ValueError as error:
            problems.append(Problem(f"{section}.{key}", str(error)))
    problems += _key_problems([each.key for each in found], section)
    if problems:
        raise ScenarioError(problems, section)
    return tuple(found)


def _flat(section: Mapping[str, Any], path: str = "") -> dict[str, Any]:
    """Join keys of nested tables by dots; a table with the name of a distribution is one."""
    found: dict[str, Any] = {}
    for name, each in section.items():
        if isinstance(each, Mapping) and each and "distribution" not in each:
            found.update(_flat(each, f"{path}{name}."))
        else:
            found[f"{path}{name}"] = each
    return found


def _table(given: Any) -> Mapping[str, Any]:
    if isinstance(given, str):
        return _parsed(given)
    if not isinstance(given, Mapping) or "distribution" not in given:
        raise ValueError(f"{shown(given)} is no distribution; {_ALLOWED}")
    for name in ("samples", "seed"):
        if name in given:
            raise ValueError(
                f"{name}: the number of draws and their seed are those of all inputs; {_ALLOWED}"
            )
    return dict(given)


def _parsed(text: str) -> Mapping[str, Any]:
    name, *numbers = (part.strip() for part in text.split(":"))
    if name not in SHORT_FORMS:
        raise ValueError(f"{shown(text)}: distribution '{name}'; {choose_from(name, SHORT_FORMS)}")
    meaning = SHORT_FORMS[name]
    if not 2 <= len(numbers) <= len(meaning):
        raise ValueError(f"{shown(text)} has {count(len(numbers), 'number', 'numbers')}; {_ALLOWED}")
    values = dict(zip(meaning, map(_number, numbers), strict=False))
    return {"distribution": name, **values}


def _number(text: str) -> float | str:
    """Read a number; text with a unit stays as it is."""
    try:
        value = float(text)
    except ValueError:
        return text
    if not np.isfinite(value):
        raise ValueError(f"{text}: allowed: finite numbers")
    return value


def _key_problems(keys: list[str], section: str) -> Iterator[Problem]:
    for place, key in enumerate(keys):
        for other in keys[:place]:
            if keys_overlap(key, other):
                yield Problem(
                    f"{section}.{key}", f"overlaps {other}, which is uncertain, too; allowed: one of both"
                )
        first = key.partition(".")[0]
        if first not in ScenarioModel.model_fields:
            guess = closest(first, ScenarioModel.model_fields)
            hint = f"; closest is '{guess}'" if guess else ""
            yield Problem(f"{section}.{key}", f"no key of a scenario; {_KEYS}{hint}")
        elif first in ("seed", "output", "bands", "frames", "title"):
            yield Problem(
                f"{section}.{key}",
                "must be the same in all draws, whose results are put together; allowed: any other key",
            )
