"""The page of a posterior."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin.analysis.uncertainty.posterior_file import VERSION_ATTRIBUTE
from hcss_twin.report.page.page import (
    Markup,
    Page,
    Section,
    badge,
    beside,
    element,
    facts,
    folded,
    note,
    paragraph,
    table,
)
from hcss_twin.report.page.pictures import drawing
from hcss_twin.report.posterior_report import figures
from hcss_twin.report.posterior_report.contents import Contents, read_contents
from hcss_twin.report.posterior_report.figures import QUANTILES, corner_plot

CORNER_PARAMETERS = 8
"""Most parameters in a corner plot: more would be too small to read."""

_TOLD_APART = {
    "title",
    "source",
    "inputs",
    "priors",
    "seed",
    "hcss_version",
    "converged",
    "Conventions",
    VERSION_ATTRIBUTE,
}


def posterior_page(path: Path) -> Page:
    """Return the page of a posterior.

    Raises
    ------
    PosteriorError
        If it is none, has not converged or is damaged.
    """
    found = read_contents(path)
    shape = next(iter(found.posterior.chains.values())).shape
    sections = [Section("Parameters", list(_parameters(found))), Section("Corner plot", list(_corner(found)))]
    if found.of_images:
        sections.append(Section("Images", list(_images(found))))
    sections += [
        Section("Convergence", list(_convergence(found))),
        Section("Priors and posteriors", list(_priors(found))),
        Section("Prediction", list(_prediction(found))),
        Section("Provenance", list(_provenance(found, path))),
    ]
    title = str(found.posterior.attributes.get("title") or f"Posterior {path.name}")
    return Page(title, f"Posterior {path.name}: {shape[0]} chains of {shape[1]} draws", sections)


def _parameters(found: Contents) -> Iterator[Markup]:
    rows = []
    for name, values in found.scalars.items():
        low, middle, high = np.quantile(values, QUANTILES)
        numbers = [middle, low, high, values.mean(), values.std()]
        rows.append([name, found.meanings[name], *(f"{value:.4g}" for value in numbers)])
    rows += [[name, "fixed", f"{value:.4g}", *[""] * 4] for name, value in found.posterior.fixed.items()]
    header = ["parameter", "meaning", "median", "5 %", "95 %", "mean", "standard deviation"]
    yield table(header, rows, "Of all draws; 90 % of them lie between 5 % and 95 %.", text_columns=2)


def _corner(found: Contents) -> Iterator[Markup]:
    draws = {name: values.ravel() for name, values in list(found.scalars.items())[:CORNER_PARAMETERS]}
    if not draws:
        yield note("No parameter is one number.")
        return
    more = len(found.scalars) - len(draws)
    rest = f" The first {len(draws)} of {len(found.scalars)} parameters." if more > 0 else ""
    caption = (
        "Lines hold 50 % (solid) and 90 % (dashed) of the draws; in the histograms they are median and 5 % and 95 %."
        + rest
    )
    yield drawing(corner_plot(draws), f"corner plot of {', '.join(draws)}", caption, wide=True)
    if len(draws) > 1:
        correlation = np.corrcoef(np.array(list(draws.values())))
        rows = [[name, *(f"{value:.2f}" for value in row)] for name, row in zip(draws, correlation, strict=True)]
        yield folded("Correlations", table(["", *draws], rows))


def _images(found: Contents) -> Iterator[Markup]:
    yield paragraph("Median and 90 % interval of each image's parameters.")
    yield beside(
        *(
            drawing(figures.of_images(name, values), f"{name} of each image", found.meanings[name])
            for name, values in found.of_images.items()
        )
    )


def _convergence(found: Contents) -> Iterator[Markup]:
    converged = found.posterior.attributes.get("converged") == "true"
    yield element("p", badge("converged", "good") if converged else badge("not converged", "bad"))
    rows = [
        [name, f"{steps:.4g}", f"{size:.5g}", f"{r_hat:.4f}"]
        for name, (steps, size, r_hat) in found.diagnostics.items()
    ]
    header = ["parameter", "autocorrelation time, steps", "effective sample size", "split R-hat"]
    yield table(header, rows, "Of all steps after burn-in; split R-hat is 1 where the halves of all chains agree.")
    traced = found.traces or found.scalars
    if traced:
        shown = dict(list(traced.items())[:CORNER_PARAMETERS])
        which = "all steps, burn-in included, evenly thinned" if found.traces else "the draws, without burn-in"
        walkers = next(iter(shown.values())).shape[0]
        some = f" Some of {walkers} chains." if walkers > figures.DRAWN_WALKERS else ""
        some += f" The first {len(shown)} of {len(traced)} parameters." if len(traced) > len(shown) else ""
        yield drawing(figures.traces(shown), "traces of the chains", f"Traces: {which}.{some}")


def _priors(found: Contents) -> Iterator[Markup]:
    shown = [
        drawing(
            figures.prior_and_posterior(name, values.ravel(), found.priors[name]),
            f"prior and posterior of {name}",
            f"{name}: prior {found.priors[name] or 'not told'}.",
        )
        for name, values in found.scalars.items()
    ]
    yield beside(*shown)


def _prediction(found: Contents) -> Iterator[Markup]:
    variogram = found.variogram
    if variogram is None:
        yield note("The file holds no variogram to compare with.")
        return
    count = variogram.observed.shape[0]
    shown = [
        drawing(
            figures.variogram(variogram, image),
            "observed and predicted variogram",
            "Observed, and what images drawn from the posterior would show." if count == 1 else f"Image {image}.",
        )
        for image in range(min(count, figures.DRAWN_IMAGES))
    ]
    if count > figures.DRAWN_IMAGES:
        yield paragraph(f"The first {figures.DRAWN_IMAGES} of {count} images.")
    yield beside(*shown)


def _provenance(found: Contents, path: Path) -> Iterator[Markup]:
    attributes = found.posterior.attributes
    pairs = [("file", f"{path.name}, {path.stat().st_size / 1e6:.2f} MB")]
    for name, key in (("source", "source"), ("seed", "seed"), ("hcss-twin", "hcss_version")):
        if key in attributes:
            pairs.append((name, str(attributes[key])))
    yield facts(pairs)
    inputs = _json(attributes.get("inputs"), [])
    if inputs:
        rows = [[str(each.get("name")), str(each.get("sha256"))] for each in inputs]
        yield table(["file", "SHA-256"], rows, "Files that were read.", text_columns=2)
    priors = _json(attributes.get("priors"), {})
    if priors:
        rows = [[str(name), str(text)] for name, text in priors.items()]
        yield table(["parameter", "prior"], rows, "Priors as they were given.", text_columns=2)
    others = [
        (str(name), str(value))
        for name, value in attributes.items()
        if name not in _TOLD_APART and not str(name).startswith("fixed_")
    ]
    if others:
        yield folded("All other global attributes", facts(others))


def _json(text: object, default: Any) -> Any:
    try:
        found = json.loads(str(text))
    except ValueError:
        return default
    return found if isinstance(found, type(default)) else default
