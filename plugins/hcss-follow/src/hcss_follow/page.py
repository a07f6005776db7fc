"""The page of ``hcss follow``: the image, the twin's image, their difference, and what is uncertain."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

import hcss_twin
from hcss_follow.analysis import Image, doubts
from hcss_follow.clear_sky import ClearSky
from hcss_follow.coefficients import read_coefficients
from hcss_follow.scenario import Made
from hcss_follow.sky import FollowedSky
from hcss_follow.state import Field, State
from hcss_twin.reports.figures import Figures
from hcss_twin.reports.page import Markup, Page
from hcss_twin.reports.tables import Table

_MEMBERS, _LATER_S = 8, 900.0


def write_page(path: Path, scenario: Path, state: State, image: Image, made: Made) -> None:
    """Write the page; the scenario and its state are in their files."""
    first = hcss_twin.Scenario.load(str(scenario), {"frames.count": 1, "clouds.parameters.lead": 0.0})
    frame = next(iter(hcss_twin.Twin(first).frames([0])))
    twin = np.asarray(frame.variables["brightness_temperature"])
    rows, columns = twin.shape[1:]
    top, left = (state.shape[0] - rows) // 2, (state.shape[1] - columns) // 2
    part = slice(top, top + rows), slice(left, left + columns)
    pairs = [("first channel", image.kelvin[part], twin[0])]
    if image.second_K is not None and len(twin) > 1:
        pairs.append(("second channel", image.second_K[part], twin[1]))
    at = [np.arange(low, low + count) - 0.5 * (side - 1) for low, count, side in
          zip((top, left), (rows, columns), state.shape, strict=True)]  # fmt: skip
    spread = np.std([FollowedSky(state, 1, n).at(_LATER_S, *at)[..., 0] for n in range(_MEMBERS)], axis=0, ddof=1)
    numbers = []
    for name, measured, simulated in pairs:
        off = simulated - measured
        numbers.append(
            (name, f"{np.sqrt(np.nanmean(off**2)):.3f}", f"{np.nanmean(off):+.3f}",
             f"{np.nanpercentile(np.abs(off), 99.0):.3f}")
        )  # fmt: skip
    table = Table(("channel", "difference, K rms", "bias, K", "99 % within, K"), tuple(numbers))
    of = read_coefficients()
    uncertain: list[Markup.Block] = [
        Markup.paragraph(
            f"Spread of {_MEMBERS} members {_LATER_S / 60.0:.0f} min after the image; coefficients of {of.data}."
        ),
        _pictures((("standard deviation, K", spread, None),), "Where the forecast is uncertain"),
        Markup.bullets([*made.lines, *made.notes, *doubts(state)]),
    ]
    if made.clear_sky is not None:
        uncertain.append(_posterior(made.clear_sky))
    at_once: list[Markup.Block] = [table, *(_beside(*pair) for pair in pairs)]
    Page(
        f"Followed sky of {state.time.isoformat()}",
        f"{state.source}; {rows} x {columns} pixels of {state.pixel_size_m:g} m",
        [Page.Section("Image and twin at lead 0", at_once), Page.Section("What is uncertain", uncertain)],
    ).write(path)


def _beside(name: str, measured: Field, simulated: Field) -> Markup:
    """Return an image, the twin's and their difference."""
    limits = tuple(float(limit) for limit in np.nanpercentile(measured, [0.5, 99.5]))
    far = max(float(np.nanpercentile(np.abs(simulated - measured), 99.5)), 1e-3)
    return _pictures(
        (
            (f"{name}, measured, K", measured, limits),
            ("twin, K", simulated, limits),
            ("twin less measured, K", simulated - measured, (-far, far)),
        ),
        f"{name}: measured, twin, difference",
    )


def _pictures(parts: Sequence[tuple[str, Field, tuple[float, ...] | None]], caption: str) -> Markup:
    """Return maps side by side; cold is white."""
    figure = Figures.new(3.4 * len(parts), 3.0)
    for number, (title, values, limits) in enumerate(parts, 1):
        axis = figure.add_subplot(1, len(parts), number)
        low, high = limits or (None, None)
        signed = limits is not None and limits[0] == -limits[1]
        colours = "RdBu_r" if signed else "gray_r" if limits else "magma"
        drawn = axis.imshow(values, origin="lower", cmap=colours, vmin=low, vmax=high)
        axis.set(title=title, xticks=[], yticks=[])
        figure.colorbar(drawn, ax=axis, shrink=0.8)
    return Markup.picture(figure, caption, caption)


def _posterior(sky: ClearSky) -> Markup:
    """Return the joint posterior of sea and vapour."""
    figure = Figures.new(4.0, 3.2)
    axis = figure.add_subplot()
    axis.plot(*sky.draws.T, ".", markersize=1.5, alpha=0.3)
    axis.set(xlabel="sea, K", ylabel="vapour, parts of the climatology's")
    return Markup.picture(
        figure, "joint posterior", "Sea and vapour that explain the clear pixels: one trades for the other."
    )
