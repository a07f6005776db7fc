"""Propagation: draw all uncertain inputs, compute the scenes, and summarise the scatter of radiance."""

from __future__ import annotations

import json
import logging
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from hcss_twin import Scenario, make_plan
from hcss_twin.core.arguments import checked
from hcss_twin.core.environment import announce_compilation
from hcss_twin.core.errors import CertificateWarning
from hcss_twin.core.files import Writing
from hcss_twin.engine.certificate.certificate import Certificate
from hcss_twin.engine.parts import Workers
from hcss_twin.engine.simulate import run
from hcss_twin.providers import ScenarioError, choose_from
from hcss_uncertainty.dataset import (
    VERSION,
    VERSION_ATTRIBUTE,
    drawn_dataset,
    sample_attributes,
    with_summary,
    write_propagation,
)
from hcss_uncertainty.draw_statistics import DrawStatistics, require_room
from hcss_uncertainty.draws import (
    UncertainScenario,
    layer_of,
    numbers_of,
    overlap_problems,
    scenarios_of,
    uncertain_keys,
    with_draw,
)
from hcss_uncertainty.errors import PropagationError, PropagationOptionError
from hcss_uncertainty.joint_budget import MODEL_ERRORS
from hcss_uncertainty.joint_sample import DRAWS, JointSample, PosteriorDraws, joint_sample, notes_of
from hcss_uncertainty.pixel_maps import PixelMaps, require_room_for_maps
from hcss_uncertainty.scenes import DrawResult, DrawTask, TableCount, draws_made
from hcss_uncertainty.sea_family import sea_temperatures

if TYPE_CHECKING:
    import xarray as xr


SHARES = ("regression", "pick-freeze")
FEW_DRAWS = 40

FEWEST, MAX = 2, 100_000
"""Draws."""

_T = TypeVar("_T")
Progress = Callable[[Iterable[_T], int], Iterable[_T]]


@dataclass(frozen=True)
class Propagation:
    """Result of a propagation: the contents of the file, its path, and counts of compiled radiance tables.

    ``cubes`` are the cubes of the requested draws, ``certificates`` their certificates.
    """

    dataset: xr.Dataset
    path: Path | None
    tables: TableCount
    cubes: tuple[Path, ...] = ()
    certificates: tuple[Certificate, ...] = ()

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes for users."""
        return tuple(json.loads(self.dataset.attrs["notes"]))


@checked
def propagate(
    source: str | Path | Mapping[str, Any] | Scenario,
    output: str | Path | None = None,
    *,
    draws: int,
    posterior: str | Path | None = None,
    uncertain: Mapping[str, Any] | None = None,
    overrides: Mapping[str, Any] | None = None,
    layer: int | None = None,
    shares: str = "regression",
    cubes_of: Sequence[int] = (),
    maps: bool = False,
    workers: int = 1,
    progress: Progress[Any] | None = None,
) -> Propagation:
    """Propagate the uncertainty of inputs into radiance and, if the scenario has a sensor, into its measurements.

    Each draw has values of all inputs and two seeds, which separate the scatter at fixed parameters from the scatter
    due to the parameters.

    Parameters
    ----------
    source : str, Path, mapping or Scenario
        Scenario, as for :meth:`Scenario.load`; a file may have a section ``[uncertain]``.
    output : path, optional
        NetCDF file; it appears once it is complete.
    draws : int
        At least 2.
    posterior : path, optional
        Posterior file of fractal clouds, whose draws replace the parameters of one cloud layer.
    uncertain : mapping, optional
        Dotted key to distribution, as in ``[uncertain]``; replaces keys of the same name there.
    overrides : mapping, optional
        Dotted key to value, the same in all draws.
    layer : int, optional
        Cloud layer of the posterior; required if there are two.
    shares : str
        ``regression``: first-order Sobol indices from the draws alone; ``pick-freeze``: also total-effect indices, for
        which each draw is recomputed with each input exchanged in turn.
    cubes_of : sequence of int
        Draws, by number, whose cubes are written next to ``output``: ``NAME.draw-0017.nc``.
    maps : bool
        Also write mean and standard deviation over draws of each pixel of each frame.
    workers : int
        Processes that compute draws; the result does not depend on it. With more than 1, a script needs ``if __name__
        == "__main__":``.
    progress : callable, optional
        Wraps the iterable of finished draws; called with it and the number of draws.

    Raises
    ------
    ScenarioError
        If a key, a distribution or a draw is invalid; names the key, draw and value.
    PosteriorError
        If the posterior cannot be used.
    PropagationError
        If nothing is uncertain, or numbers are out of range.
    ProviderError, CubeError
        As for :func:`hcss_twin.simulate`.
    """
    path = None if output is None else Path(output)
    _check(draws, shares, cubes_of, workers, path)
    uncertain_scenario = UncertainScenario.load(source, overrides)
    keys = uncertain_keys({**uncertain_scenario.uncertain, **(uncertain or {})})
    scenario = uncertain_scenario.scenario()
    drawn = None if posterior is None else PosteriorDraws.read(posterior)
    if drawn is None and not keys:
        message = "nothing is uncertain; allowed: a posterior, a section [uncertain], or --uncertain KEY=DISTRIBUTION"
        raise PropagationOptionError(message)
    part = "clouds" if drawn is None else layer_of(scenario, layer, uncertain_scenario.origin)
    posterior_keys = () if drawn is None else drawn.keys(part)
    problems = list(overlap_problems(uncertain_scenario, [key.key for key in keys], posterior_keys))
    if problems:
        raise ScenarioError(problems, uncertain_scenario.origin)
    sample = joint_sample(drawn, part, keys, draws, scenario.seed, pick_freeze=shares == "pick-freeze")
    scenarios = scenarios_of(uncertain_scenario, sample)
    notes = [] if drawn is None else list(notes_of(drawn, scenario, part, draws))
    if draws < FEW_DRAWS:
        notes.append(f"{draws} draws give inaccurate shares of the variance: use {FEW_DRAWS} or more")
    if any(key.key.partition(".")[0] == "image" for key in keys) and maps:
        raise PropagationOptionError("maps: the image varies between draws; allowed: maps of one grid of pixels")
    of_draws = list(zip(*(scenarios[mixture.name] for mixture in sample.mixtures), strict=True))
    temperatures = sea_temperatures([scenario for of_mixtures in of_draws for scenario in of_mixtures])
    with announce_compilation(logging.getLogger(__name__).warning):
        try:
            cache, sea = uncertain_scenario.cache, temperatures[0]
            plan = make_plan(scenarios[DRAWS][0], shelf=cache, family=None if sea is None else sea.family(cache))
            require_room(plan)
            if maps:
                require_room_for_maps(plan)
        except ScenarioError as error:
            raise with_draw(error, sample, sample.mixtures[0], 0) from error
        collected = _Collected(sample)
        of_scenes = iter(temperatures)
        tasks = [DrawTask(of_mixtures, maps, tuple(islice(of_scenes, len(of_mixtures)))) for of_mixtures in of_draws]
        with Workers.of(min(workers, draws)) as pool:
            made = enumerate(draws_made(tasks, uncertain_scenario.cache, pool))
            for draw, result in made if progress is None else progress(made, draws):
                collected.take(draw, result)
        attributes = {
            VERSION_ATTRIBUTE: np.int32(VERSION),
            "title": f"Propagated uncertainty: {scenario.title or uncertain_scenario.origin}",
            "scenario": scenario.to_json(),
            "seed": np.int64(scenario.seed),
            "shares": shares,
            **sample_attributes(sample),
            "notes": json.dumps(notes),
            "hcss_versions": json.dumps(cache.versions()),
            # of the first draw: the models are those of all
            MODEL_ERRORS: json.dumps(Certificate.budget_of(plan).as_dict()),
        }
        dataset = with_summary(collected.dataset(numbers_of(sample, scenarios[DRAWS]), attributes))
        if maps:
            dataset = dataset.merge(collected.maps.dataset(plan))
        if path is not None:
            write_propagation(dataset, path)
        certificates: list[Certificate] = []
        draw_cubes = [
            _cube(uncertain_scenario, sample, number, path, certificates) for number in cubes_of if path is not None
        ]
    return Propagation(dataset, path, collected.tables, tuple(draw_cubes), tuple(certificates))


def cube_path(output: Path, draw: int) -> Path:
    """Return the path of a draw's cube, in the folder of the propagation file."""
    name = output.name.removesuffix(".nc").removesuffix(".propagation")
    return output.with_name(f"{name}.draw-{draw:04d}.nc")


class _Collected:
    """Results of all draws, taken in order, so that they do not depend on who computed them."""

    def __init__(self, sample: JointSample) -> None:
        self._sample = sample
        self._statistics: dict[str, list[DrawStatistics]] = {mixture.name: [] for mixture in sample.mixtures}
        self._names: set[tuple[tuple[str, ...], tuple[str, ...]]] = set()
        self._keys: set[str] = set()
        self.tables = TableCount()
        self.maps = PixelMaps()

    def take(self, draw: int, result: DrawResult) -> None:
        """Take the results of a draw; raises ScenarioError if its scenario is invalid."""
        if result.problem is not None:
            mixture_number, problems, origin = result.problem
            raise with_draw(ScenarioError(problems, origin), self._sample, self._sample.mixtures[mixture_number], draw)
        self._names |= result.names
        if len(self._names) > 1:
            raise PropagationError("bands and the number of cloud layers must be the same in all draws")
        for mixture, statistics in zip(self._sample.mixtures, result.statistics, strict=True):
            self._statistics[mixture.name].append(statistics)
        if result.pixels:
            self.maps.add(*result.pixels)
        self._keys |= result.tables
        count = self.tables
        count.scenes, count.sets = count.scenes + len(result.statistics), len(self._keys)
        count.compiled += result.compiled

    def dataset(self, inputs: NDArray[np.float64], attributes: Mapping[str, Any]) -> xr.Dataset:
        """Return the values of all draws."""
        counts = {"table_sets": np.int64(self.tables.sets), "scenes": np.int64(self.tables.scenes)}
        (names,) = self._names
        return drawn_dataset(self._statistics, self._sample, inputs, *names, {**attributes, **counts})


def _cube(
    source: UncertainScenario, sample: JointSample, draw: int, path: Path, certificates: list[Certificate]
) -> Path:
    """Write the cube of a draw with all outputs that the scenario requests."""

    def report(certificate: Certificate) -> None:
        certificates.append(certificate)
        if not certificate.passed:
            warnings.warn("; ".join(certificate.summary), CertificateWarning, stacklevel=5)

    scenario = source.scenario(sample.overrides(sample.mixtures[0], draw))
    return run(make_plan(scenario, shelf=source.cache), cube_path(path, draw), report=report)


def _check(draws: int, shares: str, cubes_of: Sequence[int], workers: int, path: Path | None) -> None:
    if not FEWEST <= draws <= MAX:
        raise PropagationOptionError(f"draws: {draws} given, allowed: a whole number from {FEWEST} to {MAX}")
    if workers < 1:
        raise PropagationOptionError(f"workers: {workers} given, allowed: a whole number from 1")
    if shares not in SHARES:
        raise PropagationOptionError(f"shares: '{shares}' given, {choose_from(shares, SHARES)}")
    for number in cubes_of:
        if not 0 <= number < draws:
            raise PropagationOptionError(f"cube of draw {number}: allowed: draws 0 to {draws - 1}")
    if cubes_of and path is None:
        raise PropagationOptionError("cubes of draws are written next to the propagation file: name that, too")
    if path is not None:
        if path.suffix != ".nc":
            raise PropagationOptionError(f"{path}: allowed: a name that ends in .nc")
        Writing(path, PropagationError, "NetCDF").check()
        if not path.parent.is_dir():
            raise PropagationError(f"cannot write {path}: there is no folder {path.parent}")
