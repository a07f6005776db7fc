"""Draws of a posterior as keys of a scenario."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin.analysis.uncertainty.posterior_file import PARAMETERS, Posterior, read_posterior
from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import PosteriorError, Problem, ScenarioError, shown
from hcss_twin.providers.registry.registry import OWN_DISTRIBUTION
from hcss_twin.scenario.models import ScenarioModel

_GENERATORS = ("fractal", f"{OWN_DISTRIBUTION}/fractal")
_OF_POPULATION = ("mean_", "spread_")
_PAIR = ("Lx", "Ly")


@dataclass(frozen=True)
class PosteriorDraws:
    """A posterior as scenarios take it.

    Attributes
    ----------
    names : tuple of str
        Free parameters, a few of ``PARAMETERS`` in their order.
    samples : ndarray (n, parameter)
        All draws; those of several images one image after the other.
    fixed : mapping of str to float
        Parameters that the posterior holds fixed.
    octaves : (int, int) or None
        First and last octave of the fractal sum, with which alone its parameters mean what they say; None where the
        file does not tell.
    images : int
        Images that it is of; draws take all parameters from the same one.
    file, sha256 : str
        Name and hash of the file.
    about : mapping
        Global attributes of the file.
    """

    names: tuple[str, ...]
    samples: Array
    fixed: Mapping[str, float]
    octaves: tuple[int, int] | None
    images: int
    file: str
    sha256: str
    about: Mapping[str, Any]

    @classmethod
    def read(cls, path: str | Path) -> PosteriorDraws:
        """Read the file of a posterior.

        Raises
        ------
        PosteriorError
            If it is missing, no posterior, not converged, damaged, or of parameters that no scenario has.
        """
        path = Path(path)
        posterior = read_posterior(path)
        names, columns, images = _columns(posterior, path)
        fixed = {name: value for name, value in posterior.fixed.items() if name in PARAMETERS}
        for name in _PAIR:
            if (name in (*names, *fixed)) != (_PAIR[0] in (*names, *fixed)):
                raise PosteriorError(f"cannot use {path}: it has only one of Lx and Ly, allowed: both or none")
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        about = {name: value for name, value in posterior.attributes.items() if isinstance(value, str)}
        octaves = _octaves(posterior, path)
        return cls(names, columns, fixed, octaves, images, path.name, digest, about)

    def rows(self, count: int, seed: np.random.SeedSequence) -> Array:
        """Return so many independent draws (count, parameter) of the posterior, each as likely as any other."""
        chosen = np.random.default_rng(seed).integers(self.samples.shape[0], size=count)
        return np.asarray(self.samples[chosen])

    def keys(self, layer: str) -> tuple[str, ...]:
        """Return the keys of a scenario that the posterior has values for.

        Parameters
        ----------
        layer : str
            ``clouds``, or ``clouds.layers.0`` and so on.
        """
        return tuple(self.overrides(layer, np.zeros(len(self.names))))

    def overrides(self, layer: str, row: Array) -> dict[str, Any]:
        """Return the keys of a scenario with the values of one draw (parameter,)."""
        value = {**self.fixed, **dict(zip(self.names, map(float, row), strict=True))}
        found: dict[str, Any] = {f"{layer}.parameters.{name}": value[name] for name in ("H", "gamma") if name in value}
        if "Lx" in value:
            found[f"{layer}.parameters.L"] = [value["Lx"], value["Ly"]]
        if self.octaves is not None:
            found[f"{layer}.parameters.k"] = list(self.octaves)
        if "coverage" in value:
            found[f"{layer}.coverage"] = value["coverage"]
        return found


def _columns(posterior: Posterior, path: Path) -> tuple[tuple[str, ...], Array, int]:
    """Return the free parameters, their draws (n, parameter), and the number of images."""
    samples = {name: values for name, values in posterior.samples.items() if not name.startswith(_OF_POPULATION)}
    unknown = [name for name in samples if name not in PARAMETERS]
    if unknown or not samples:
        listed = ", ".join(unknown) or "none"
        raise PosteriorError(f"cannot use {path}: its free parameters are {listed}; allowed: {', '.join(PARAMETERS)}")
    names = tuple(name for name in PARAMETERS if name in samples)
    images = max(values.shape[1] if values.ndim == 2 else 1 for values in samples.values())
    wide = [np.broadcast_to(samples[name].reshape(samples[name].shape[0], -1).T, (images, samples[name].shape[0]))
            for name in names]  # fmt: skip
    return names, np.stack([each.ravel() for each in wide], axis=1), images


def _octaves(posterior: Posterior, path: Path) -> tuple[int, int] | None:
    given = posterior.attributes.get("octaves")
    if given is None:
        return None
    numbers = np.atleast_1d(given)
    if numbers.shape != (2,) or numbers.dtype.kind != "i":
        raise PosteriorError(f"cannot use {path}: octaves {given}, allowed: two whole numbers")
    return int(numbers[0]), int(numbers[1])


def layer_of(scenario: ScenarioModel, layer: int | None, origin: str) -> str:
    """Return the part of a scenario that the parameters of clouds belong to.

    Parameters
    ----------
    layer : int or None
        Number of the layer; needed where there are several.

    Raises
    ------
    ScenarioError
        If there is no such layer, or its clouds are not those that a posterior is of.
    """
    layers = scenario.clouds.layers
    if layer is None and len(layers) != 1:
        told = f"{len(layers)} layers; say which the posterior is of, allowed: layer 0 to {len(layers) - 1}"
        if not layers:
            told = "the scenario has no clouds; allowed: a cloud layer"
        raise ScenarioError([Problem("clouds.layers", told)], origin)
    number = layer or 0
    if not 0 <= number < len(layers):
        told = f"layer {number} given; allowed: 0 to {len(layers) - 1}"
        raise ScenarioError([Problem("clouds.layers", told)], origin)
    path = "clouds" if len(layers) == 1 else f"clouds.layers.{number}"
    if layers[number].generator not in _GENERATORS:
        told = f"{shown(layers[number].generator)}; a posterior is of clouds of the generator, allowed: 'fractal'"
        raise ScenarioError([Problem(f"{path}.generator", told)], origin)
    return path


def notes_of(draws: PosteriorDraws, scenario: ScenarioModel, layer: str, count: int) -> tuple[str, ...]:
    """Return what users of a posterior should know.

    Parameters
    ----------
    count : int
        Draws that are taken.
    """
    notes = []
    number = int(layer.rpartition(".")[2]) if layer != "clouds" else 0
    if "coverage" in draws.names and scenario.clouds.layers[number].coverage_mode == "frame":
        notes.append(
            f"the posterior's coverage is that of the unbounded sky, but {layer}.coverage_mode is 'frame', where "
            "each frame has exactly that coverage: the spread by seed lacks that of coverage "
            f"(--set {layer}.coverage_mode=field)"
        )
    if draws.images > 1:
        notes.append(
            f"the posterior is of {draws.images} images: each draw has all parameters of one of them, chosen at random"
        )
    if count > draws.samples.shape[0]:
        notes.append(
            f"{count} draws are taken of the {draws.samples.shape[0]} that the posterior has, some more than once"
        )
    if draws.fixed or draws.octaves is not None:
        told = ", ".join(f"{name} = {value:g}" for name, value in draws.fixed.items())
        if draws.octaves is not None:
            told += f"{', ' if told else ''}octaves k = {draws.octaves[0]} to {draws.octaves[1]}"
        notes.append(f"fixed by the posterior, whatever the scenario says: {told}")
    return tuple(notes)


def images_of(draws: PosteriorDraws) -> Any:
    """Return what the posterior was made from, as its file says: names and hashes; None where it does not say."""
    text = draws.about.get("inputs")
    return None if text is None else json.loads(text)
