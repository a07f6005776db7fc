"""Report page of a posterior: parameters, corner plot, traces and convergence, priors, prediction, provenance."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hcss_evaluate.errors import PosteriorError
from hcss_evaluate.matching.quantities import MAX_RATIO
from hcss_evaluate.pages import posterior_figures as figures
from hcss_evaluate.pages.posterior_figures import QUANTILES, Variogram
from hcss_evaluate.posterior.posterior_file import SUSPICIOUS, VERSION_ATTRIBUTE, Posterior, read_posterior
from hcss_twin.core.reading import Reading
from hcss_twin.providers import Array
from hcss_twin.reports.page import Markup, Page
from hcss_twin.reports.provenance import Provenance
from hcss_twin.reports.tables import Table

CORNER_PARAMETERS = 8
"""Maximum number of parameters in a corner plot; more would be too small to read."""

_DIAGNOSTICS = {
    "autocorrelation_time_steps": ".4g",
    "bulk_effective_sample_size": ".5g",
    "tail_effective_sample_size": ".5g",
    "rank_normalized_split_r_hat": ".4f",
}
_OF_FILE = {"title", "inputs", "priors", "converged", "Conventions", VERSION_ATTRIBUTE}
_SHOWN = {"predictive_p_value", "unlikeness", "doubts"} | _OF_FILE


@dataclass(frozen=True)
class PosteriorContents:
    """A posterior with all contents of its file that the page shows.

    Attributes
    ----------
    posterior : Posterior
    attributes : mapping
        Attributes of each variable: meaning, prior, diagnostics.
    traces : dict of str to ndarray (chain, step)
        All steps, burn-in included; empty where the file has none.
    variogram : Variogram or None
    """

    posterior: Posterior
    attributes: Mapping[str, Mapping[str, Any]]
    traces: dict[str, Array]
    variogram: Variogram | None

    def parameters(self, dimensions: int) -> dict[str, Array]:
        """Return scalar parameters (chain, draw) or, with 3 dimensions, those with a value for each image."""
        return {name: draws for name, draws in self.posterior.chains.items() if draws.ndim == dimensions}

    def meaning(self, name: str) -> str:
        """Return the description of a parameter."""
        return str(self.attributes[name].get("long_name", name))

    def prior(self, name: str) -> str:
        """Return the prior of a parameter as given, or an empty string."""
        return str(self.attributes[name].get("prior", ""))


def read_contents(path: Path) -> PosteriorContents:
    """Read a posterior.

    Raises
    ------
    PosteriorError
        If it is not a posterior, has not converged or is damaged.
    """
    posterior = read_posterior(path)
    with Reading(path, PosteriorError).netcdf() as file:
        file.set_auto_mask(False)
        chains = {name: file[name] for name in posterior.chains}
        attributes = {
            name: {attribute: chain.getncattr(attribute) for attribute in chain.ncattrs()}
            for name, chain in chains.items()
        }
        return PosteriorContents(posterior, attributes, _traces(file), _variogram(file))


def _texts(variable: Any) -> list[str]:
    """Return labels, stored as strings or as character arrays."""
    values = np.asarray(variable[...])
    if values.dtype.kind == "S" and values.ndim > 1 and values.dtype.itemsize == 1:
        return [b"".join(row).decode() for row in values]
    return [value.decode() if isinstance(value, bytes) else str(value) for value in values]


def _traces(file: Any) -> dict[str, Array]:
    if not {"trace", "parameter"} <= set(file.variables):
        return {}
    values = np.asarray(file["trace"][...], dtype=np.float64)
    return dict(zip((name.rstrip("\0 ") for name in _texts(file["parameter"])), values, strict=True))


def _variogram(file: Any) -> Variogram | None:
    names = ("lag", "quantile", "variogram_observed", "variogram_error", "variogram_predicted")
    if not {"axis", *names} <= set(file.variables):
        return None
    lag, quantiles, observed, error, predicted = (np.asarray(file[name][...], dtype=np.float64) for name in names)
    if observed.ndim == 2:  # one image
        observed, error, predicted = observed[None], error[None], predicted[:, None]
    return Variogram(lag, tuple(_texts(file["axis"])), observed, error, quantiles, predicted)


def posterior_page(path: Path) -> Page:
    """Return the page of a posterior.

    Raises
    ------
    PosteriorError
        If it is not a posterior, has not converged or is damaged.
    """
    contents = read_contents(path)
    shape = next(iter(contents.posterior.chains.values())).shape
    sections = [
        Page.Section("Parameters", [_parameters(contents), *_doubts(contents)]),
        Page.Section("Corner plot", list(_corner(contents))),
    ]
    if contents.parameters(3):
        sections.append(Page.Section("Images", list(_images(contents))))
    sections += [
        Page.Section("Convergence", list(_convergence(contents))),
        Page.Section("Priors and posteriors", [_priors(contents)]),
        Page.Section("Prediction", list(_prediction(contents))),
        Page.Section("Provenance", list(_provenance(contents, path))),
    ]
    title = str(contents.posterior.attributes.get("title") or f"Posterior {path.name}")
    return Page(title, f"Posterior {path.name}: {shape[0]} chains of {shape[1]} draws", sections)


def _parameters(contents: PosteriorContents) -> Table:
    rows = []
    for name, draws in contents.parameters(2).items():
        low, middle, high = np.quantile(draws, QUANTILES)
        numbers = (middle, low, high, draws.mean(), draws.std())
        rows.append([name, contents.meaning(name), *(f"{value:.4g}" for value in numbers)])
    rows += [[name, "fixed", f"{value:.4g}", *[""] * 4] for name, value in contents.posterior.fixed.items()]
    header = ["parameter", "meaning", "median", "5 %", "95 %", "mean", "standard deviation"]
    return Table(header, rows, "Of all draws; 90 % of them lie between 5 % and 95 %.", text_columns=2)


def _doubts(contents: PosteriorContents) -> Iterator[Markup.Block]:
    doubts = contents.posterior.doubts
    if doubts:
        rows = [[str(doubt["image"]), ", ".join(doubt["parameters"]), str(doubt["reason"])] for doubt in doubts]
        caption = "Reasons to doubt the intervals of these parameters."
        yield Table(["image", "doubtful", "reason"], rows, caption, text_columns=3)
    last = contents.posterior.last_octave
    if last is not None:
        values, counts = np.unique(last, return_counts=True)
        parts = ", ".join(f"{value} in {count / last.size:.0%}" for value, count in zip(values, counts, strict=True))
        yield Markup.paragraph(
            f"The last octave of the fractal sum is unknown; each draw has its own: {parts} of the draws."
        )


def _corner(contents: PosteriorContents) -> Iterator[Markup.Block]:
    scalars = contents.parameters(2)
    draws = {name: values.ravel() for name, values in list(scalars.items())[:CORNER_PARAMETERS]}
    if not draws:
        yield Markup.note("There is no scalar parameter.")
        return
    caption = (
        "Lines enclose 50 % (solid) and 90 % (dashed) of the draws; in the histograms they are median and 5 % and "
        f"95 %.{_first_of(len(draws), len(scalars), 'parameters')}"
    )
    yield Markup.drawing(figures.corner_plot(draws), f"corner plot of {', '.join(draws)}", caption, wide=True)
    if len(draws) > 1:
        correlation = np.corrcoef(np.array(list(draws.values())))
        rows = [[name, *(f"{value:.2f}" for value in row)] for name, row in zip(draws, correlation, strict=True)]
        yield Markup.folded("Correlations", Table(["", *draws], rows))


def _first_of(shown: int, count: int, name: str) -> str:
    return f" The first {shown} of {count} {name}." if shown < count else ""


def _images(contents: PosteriorContents) -> Iterator[Markup.Block]:
    yield Markup.paragraph("Median and 90 % interval of each image's parameters.")
    yield Markup.beside(
        *(
            Markup.drawing(figures.of_images(name, draws), f"{name} of each image", contents.meaning(name))
            for name, draws in contents.parameters(3).items()
        )
    )


def _convergence(contents: PosteriorContents) -> Iterator[Markup.Block]:
    yield Markup.element("p", Markup.badge("converged", "good"))  # without convergence there is no page
    rows = [
        [name, *(f"{float(diagnostics[key]):{digits}}" for key, digits in _DIAGNOSTICS.items())]
        for name, diagnostics in contents.posterior.diagnostics.items()
    ]
    header = ["parameter", "autocorrelation time, steps", "bulk ESS", "tail ESS", "rank-normalized split R-hat"]
    draws = next(iter(contents.posterior.chains.values()))
    caption = (
        f"Effective sample sizes (ESS) of the {draws.shape[0] * draws.shape[1]} stored draws, for their location "
        "(bulk) and for their 5 and 95 % quantiles (tail), and R-hat, which is 1 where the halves of all chains agree "
        "(Vehtari et al. 2021); each walker is a chain."
    )
    yield Table(header, rows, caption)
    traced = contents.traces or contents.parameters(2)
    if traced:
        shown = dict(list(traced.items())[:CORNER_PARAMETERS])
        steps = "all steps, burn-in included, evenly thinned" if contents.traces else "the draws, without burn-in"
        chains = next(iter(shown.values())).shape[0]
        some = f" Some of {chains} chains." if chains > figures.DRAWN_WALKERS else ""
        caption = f"Traces: {steps}.{some}{_first_of(len(shown), len(traced), 'parameters')}"
        yield Markup.drawing(figures.traces(shown), "traces of the chains", caption)


def _priors(contents: PosteriorContents) -> Markup.Block:
    return Markup.beside(
        *(
            Markup.drawing(
                figures.prior_and_posterior(name, draws.ravel(), contents.prior(name)),
                f"prior and posterior of {name}",
                f"{name}: prior {contents.prior(name) or 'unknown'}.",
            )
            for name, draws in contents.parameters(2).items()
        )
    )


def _prediction(contents: PosteriorContents) -> Iterator[Markup.Block]:
    p_values = contents.posterior.predictive_p_values
    if p_values:
        caption = (
            "Fraction of the images drawn from the posterior whose variogram lies at least as far from the mean as the "
            f"image's. Below {SUSPICIOUS:g}, no fractal field has such a variogram, and intervals are too narrow."
        )
        rows = [[name, f"{p:.2g}"] for name, p in p_values]
        yield Table(["image", "posterior predictive p-value"], rows, caption, text_columns=1)
        unlike = np.atleast_1d(contents.posterior.attributes.get("unlikeness", [])).tolist()
        if unlike:
            caption = (
                "How far an image is from images drawn from its posterior in kurtosis, skewness and local direction, "
                "which the fit does not use, over how far these are from each other. Above "
                f"{MAX_RATIO:g}, no drawn image looks like it."
            )
            ratios = [[name, f"{ratio:.2f}"] for (name, _), ratio in zip(p_values, unlike, strict=True)]
            yield Table(["image", "unlikeness"], ratios, caption, text_columns=1)
    variogram = contents.variogram
    if variogram is None:
        yield Markup.note("The file holds no variogram to compare with.")
        return
    count = variogram.observed.shape[0]
    shown = min(count, figures.DRAWN_IMAGES)
    if count > shown:
        yield Markup.paragraph(_first_of(shown, count, "images").strip())
    one = "Observed, and as predicted for images drawn from the posterior."
    yield Markup.beside(
        *(
            Markup.drawing(
                figures.variogram(variogram, image),
                "observed and predicted variogram",
                one if count == 1 else f"Image {image}.",
            )
            for image in range(shown)
        )
    )


def _provenance(contents: PosteriorContents, path: Path) -> Iterator[Markup.Block]:
    attributes = contents.posterior.attributes
    keys = {"source": "source", "seed": "seed", "hcss_version": "hcss-twin"}
    inputs = [
        (str(source.get("name")), str(source.get("sha256"))) for source in Provenance.value(attributes, "inputs", [])
    ]
    file = f"{path.name}, {path.stat().st_size / 1e6:.2f} MB"
    yield from Provenance.blocks(attributes, file, keys, inputs, Provenance.names_in(_SHOWN, "fixed_"))
    priors = Provenance.value(attributes, "priors", {})
    if priors:
        rows = [[str(name), str(text)] for name, text in priors.items()]
        yield Table(["parameter", "prior"], rows, "Priors as given.", text_columns=2)
