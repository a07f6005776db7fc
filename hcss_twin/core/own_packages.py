"""What the packages in ``plugins/`` of this project bring, for messages where they are not installed."""

from __future__ import annotations

from collections.abc import Mapping

COMMANDS: Mapping[str, str] = {
    "atmosphere import": "hcss-modtran",
    "atmosphere plot": "hcss-modtran",
    "bench": "hcss-bench",
    "check": "hcss-author",
    "clouds": "hcss-evaluate",
    "dataset": "hcss-dataset",
    "evaluate": "hcss-evaluate",
    "explore": "hcss-explore",
    "export": "hcss-export",
    "fit": "hcss-evaluate",
    "follow": "hcss-follow",
    "import": "hcss-evaluate",
    "match": "hcss-evaluate",
    "new-plugin": "hcss-author",
    "propagate": "hcss-uncertainty",
    "reference": "hcss-light",
    "reproduce": "hcss-paper",
    "passes": "hcss-payload",
    "serve": "hcss-payload",
    "score": "hcss-dataset",
    "skies": "hcss-skies",
    "sweep": "hcss-sweep",
}
"""Package of each command of ``hcss``."""

PROVIDERS: Mapping[str, str] = {
    **dict.fromkeys(("example", "fall-streaks", "simulation", "surrogate", "volume"), "hcss-skies"),
    **dict.fromkeys(("bad-pixels", "detector-drift", "integration", "non-linearity", "stray-light"), "hcss-payload"),
    "followed": "hcss-follow",
    "fractal-relief": "hcss-light",
    "lowtran7": "hcss-lowtran7",
}
"""Package of each provider."""

LIGHT: Mapping[str, str] = dict.fromkeys(("reference", "slant", "source"), "hcss-light")
"""Package of each value of ``radiance.light``."""

SECTIONS: Mapping[str, str] = dict.fromkeys(("attitude", "camera", "jitter", "orbit"), "hcss-payload")
"""Package of each section of a scenario."""

PAGES: Mapping[str, str] = {
    "hcss_posterior_version": "hcss-evaluate",
    "hcss_propagation_version": "hcss-uncertainty",
    "hcss_sweep": "hcss-sweep",
}
"""Package of each page of ``hcss report``, by the global attribute that marks its files."""

PAGES_OF_FOLDERS: Mapping[str, str] = {"index.json": "hcss-sweep"}
"""Package of each page of ``hcss report`` on a folder, by the name of the file that marks the folder."""


NEEDS: Mapping[str, tuple[str, ...]] = {
    "hcss-dataset": ("hcss-sweep",),
    "hcss-follow": ("hcss-skies",),
    "hcss-paper": ("hcss-evaluate",),
    "hcss-uncertainty": ("hcss-sweep", "hcss-evaluate"),
}
"""Packages that another one needs and that no index has."""


def comes_with(table: Mapping[str, str], name: str) -> str:
    """Return which package of a table brings a name, and how to install it; an empty text if none does."""
    package = table.get(name)
    return f"It comes with {package}: {how_to_install(package)}" if package else ""


def how_to_install(package: str) -> str:
    """Return how to install a package of ``plugins/``."""
    folders = " ".join(f"./plugins/{each}" for each in (*NEEDS.get(package, ()), package))
    return f"pip install {folders} in a checkout of hcss_twin"
