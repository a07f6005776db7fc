"""A small file of a posterior, as `hcss fit` writes them."""

import numpy as np
from hcss_evaluate.posterior.posterior_file import Diagnostic, write_posterior

TOLD = Diagnostic("parameter", "uniform:0:1", 30.0)


def example_posterior(
    path, free=("H", "Lx", "Ly", "coverage"), fixed=None, shape=(4, 50), attributes=None, last_octave=None
):
    """Write and return a posterior with means .6, 8, 8 and .5; a third number of ``shape`` is that of images."""
    rng = np.random.default_rng(0)
    every = {
        "H": rng.normal(0.6, 0.05, shape),
        "gamma": rng.normal(3.0, 0.1, shape),
        "Lx": 8.0 * np.exp(rng.normal(0.0, 0.2, shape)),
        "Ly": 8.0 * np.exp(rng.normal(0.0, 0.2, shape)),
        "coverage": np.clip(rng.normal(0.5, 0.08, shape), 0.1, 0.9),
    }
    chains = {name: every[name] for name in free}
    if len(shape) == 3:
        chains |= {f"mean_{name}": values[..., 0] for name, values in chains.items()}
    write_posterior(
        path,
        title="example",
        inputs=[("image.nc", "ab" * 32)],
        chains=chains,
        log_probability=rng.normal(size=shape[:2]),
        diagnostics=dict.fromkeys(chains, TOLD),
        fixed={"gamma": 3.0} if fixed is None else fixed,
        priors=dict.fromkeys(free, "uniform:0:1"),
        seed=7,
        attributes=attributes,
        last_octave=last_octave,
    )
    return path
