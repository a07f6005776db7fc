"""One fit, from its start or from where it was interrupted, to chains that have converged."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import PosteriorError
from hcss_twin.uncertainty.chains import Chains, begin, converge, walkers_of
from hcss_twin.uncertainty.checkpoint import Checkpoint, State
from hcss_twin.uncertainty.convergence import Convergence
from hcss_twin.uncertainty.fit_options import FitOptions
from hcss_twin.uncertainty.image_likelihood import ImageLikelihood
from hcss_twin.uncertainty.population_model import PopulationModel
from hcss_twin.uncertainty.posterior_model import SingleModel
from hcss_twin.uncertainty.priors import Prior
from hcss_twin.uncertainty.space import Space
from hcss_twin.uncertainty.usual_priors import SPREAD
from hcss_twin.version import __version__

Array = NDArray[np.float64]

Progress = Callable[[str, float], None]
"""Is told what is being done, and which part of that is done."""


class FitRun:
    """One fit: its checkpoint, its progress, and what it is about."""

    def __init__(
        self,
        output: Path,
        options: FitOptions,
        space: Space,
        spreads: tuple[Prior, ...],
        data: str,
        progress: Progress | None,
    ) -> None:
        if not output.absolute().parent.is_dir():
            raise PosteriorError(f"cannot write {output}: there is no folder {output.absolute().parent}")
        self._options = options
        self._space = space
        self._spreads = spreads
        self.told: Progress = progress or (lambda _what, _part: None)
        text = json.dumps([__version__, data, self.about(), options.seed, sorted(space.fixed.items())])
        digest = hashlib.sha256(text.encode()).hexdigest()
        self._checkpoint = Checkpoint(output.with_name(f"{output.name}.state"), digest)

    def about(self) -> dict[str, Any]:
        """Return attributes of the file that say what was asked."""
        priors = {name: prior.text for name, prior in self._space.priors.items()}
        for name, prior in zip(self._space.names, self._spreads, strict=False):
            priors[f"{SPREAD}{name}"] = prior.text
        chosen = asdict(self._options)
        return {
            "priors": json.dumps(priors),
            "octaves": list(chosen["octaves"]),
            "smallest_lag": chosen["smallest_lag"],
            "misfit": chosen["misfit"],
        }

    def resume(self) -> State | None:
        """Return what an earlier run left."""
        return self._checkpoint.read()

    def sample(
        self,
        model: SingleModel | PopulationModel,
        likelihoods: tuple[ImageLikelihood, ...],
        pilots: Sequence[Array],
        state: State | None,
    ) -> tuple[Chains, Convergence]:
        """Run chains to their end.

        Raises
        ------
        PosteriorError
            If they have not converged.
        """
        options = self._options
        noises = tuple(each.noise for each in likelihoods if each.noise is not None)
        chains = self._start(model, pilots) if state is None else state.chains

        def told(chains: Chains, found: Convergence | None) -> None:
            self._checkpoint.write(State(noises, chains))
            self.told("sampling", 0.0 if found is None else min(found.fraction, 1.0))

        chains, found = converge(model, chains, options.samples, options.most_steps, told)
        if not found.has_converged:
            self._checkpoint.write(State(noises, chains), now=True)
            raise PosteriorError(_refusal(found, model.names, options, chains))
        return chains, found

    def done(self) -> None:
        """Forget the state: the posterior has been written."""
        self._checkpoint.remove()

    def _start(self, model: SingleModel | PopulationModel, pilots: Sequence[Array]) -> Chains:
        rng = np.random.default_rng(np.random.SeedSequence([self._options.seed, 2]))
        walkers = walkers_of(len(model.names))
        drawn = [pilot[rng.permutation(pilot.shape[0])[:walkers]] for pilot in pilots]
        start = model.start(rng, drawn) if isinstance(model, PopulationModel) else drawn[0]
        return begin(model.log_probability, start, int(rng.integers(0, 2**31)))


def _refusal(found: Convergence, names: tuple[str, ...], options: FitOptions, chains: Chains) -> str:
    lines = "\n  ".join(found.complaints(names))
    return (
        f"not converged after {chains.positions.shape[0]} steps; no posterior is written\n  {lines}\n"
        f"allow more steps (now {options.most_steps}; the chains so far are kept and gone on with), fix a parameter "
        "that the data do not tell (gamma), or give narrower priors"
    )
