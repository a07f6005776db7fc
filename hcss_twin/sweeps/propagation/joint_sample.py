"""Uncertain keys of a scenario and their distributions, declared as ``[sweep]`` declares its own.

What is drawn: two independent samples of all inputs, and the mixtures of them that are computed.

The samples A and B are those of Saltelli et al., "Variance based sensitivity analysis of model output", Computer
Physics Communications 181 (2010) 259-270: whatever is computed has each input from the one or the other.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import Problem, ScenarioError, choose_from, closest, count, shown
from hcss_twin.scenario.models import ScenarioModel
from hcss_twin.scenario.scenario import UNCERTAIN
from hcss_twin.sweeps.axis import axis_of
from hcss_twin.sweeps.design import keys_overlap
from hcss_twin.sweeps.propagation.posterior_draws import PosteriorDraws

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
            raise ValueError(f"{name}: the number of draws and their seed are those of all inputs; {_ALLOWED}")
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
                yield Problem(f"{section}.{key}", f"overlaps {other}, which is uncertain, too; allowed: one of both")
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


A, B = 0, 1

SEED = "seed"
"""Name of the input that chooses the realisation of clouds, and of waves where they are drawn."""

POSTERIOR = "posterior"
"""Name of the input that all free parameters of a posterior are together: they depend on each other."""

DRAWS, OTHER_SEED, ALL_OTHERS = "draws", "other seed", "all others"

_SEED_KEY = {"posterior": 1, "scene": 2, "bootstrap": 3}


@dataclass(frozen=True)
class Mixture:
    """What is computed for each draw.

    Attributes
    ----------
    name : str
    exchanged : frozenset of str
        Independent inputs that come from B; the others come from A.
    """

    name: str
    exchanged: frozenset[str]

    def source(self, name: str) -> int:
        """Return the sample, A or B, that an input comes from."""
        return B if name in self.exchanged else A


@dataclass(frozen=True)
class JointSample:
    """Draws of all inputs.

    Attributes
    ----------
    posterior : PosteriorDraws or None
    layer : str
        Part of the scenario that the posterior's parameters belong to.
    rows : ndarray (2, draw, parameter)
        Of the posterior, in A and B; no columns without one.
    keys : tuple of UncertainKey
    values : mapping of str to tuple
        Of each uncertain key, those of A followed by those of B, as a scenario file has them.
    seeds : ndarray of int64 (2, draw)
        Of the scene.
    mixtures : tuple of Mixture
        In the order in which they are kept: the draws, the same with other seeds, and what pick-freeze needs.
    """

    posterior: PosteriorDraws | None
    layer: str
    rows: Array
    keys: tuple[UncertainKey, ...]
    values: Mapping[str, tuple[Any, ...]]
    seeds: NDArray[np.int64]
    mixtures: tuple[Mixture, ...] = field(default=())

    @property
    def count(self) -> int:
        """Number of draws."""
        return int(self.seeds.shape[1])

    @property
    def groups(self) -> tuple[str, ...]:
        """Inputs that are independent of each other, but for the seed."""
        return (*((POSTERIOR,) if self.posterior is not None else ()), *(each.key for each in self.keys))

    @property
    def inputs(self) -> tuple[str, ...]:
        """Inputs one by one: parameters of the posterior, then keys."""
        names = () if self.posterior is None else self.posterior.names
        return (*names, *(each.key for each in self.keys))

    def overrides(self, mixture: Mixture, draw: int) -> dict[str, Any]:
        """Return the keys of the scenario of one draw, with their values."""
        found: dict[str, Any] = {}
        if self.posterior is not None:
            row = self.rows[mixture.source(POSTERIOR), draw]
            found.update(self.posterior.overrides(self.layer, row))
        for each in self.keys:
            found[each.key] = self.values[each.key][mixture.source(each.key) * self.count + draw]
        found[SEED] = int(self.seeds[mixture.source(SEED), draw])
        return found


def joint_sample(
    posterior: PosteriorDraws | None,
    layer: str,
    keys: Sequence[UncertainKey],
    count: int,
    seed: int,
    *,
    pick_freeze: bool,
) -> JointSample:
    """Draw all inputs, independently of each other; parameters of a posterior are drawn together.

    The first draws are the same whatever else is uncertain, and whether or not more is computed for them.

    Parameters
    ----------
    seed : int
        Of the scenario: it fixes all draws.
    pick_freeze : bool
        Whether also what has one input exchanged is computed.
    """
    rows = np.empty((2, count, 0))
    if posterior is not None:
        rows = np.stack([posterior.rows(count, source) for source in _sources(seed, "posterior")])
    seeds = np.stack([np.random.default_rng(each).integers(2**63 - 1, size=count) for each in _sources(seed, "scene")])
    sample = JointSample(
        posterior, layer, rows, tuple(keys), {each.key: each.values(2 * count, seed) for each in keys}, seeds
    )
    mixtures = [Mixture(DRAWS, frozenset()), Mixture(OTHER_SEED, frozenset({SEED}))]
    if pick_freeze:
        mixtures.append(Mixture(ALL_OTHERS, frozenset({SEED, *sample.groups})))
        mixtures += [Mixture(f"other {name}", frozenset({name})) for name in sample.groups]
    return JointSample(posterior, layer, rows, sample.keys, sample.values, sample.seeds, tuple(mixtures))


def _sources(seed: int, what: str) -> list[np.random.SeedSequence]:
    return [np.random.SeedSequence(seed, spawn_key=(_FAMILY, _SEED_KEY[what], which)) for which in (A, B)]


def bootstrap_seed(seed: int) -> np.random.SeedSequence:
    """Return the seed of the errors of a propagation."""
    return np.random.SeedSequence(seed, spawn_key=(_FAMILY, _SEED_KEY["bootstrap"]))


_FAMILY = 2**18
"""Keeps these draws apart from the seeds of clouds, waves and certificates."""
