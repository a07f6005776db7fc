"""Whether the pixels of a scene need views of their own, and at how many nodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import Problem, ProviderError, ScenarioError
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.omissions.bounds import SAFETY_FACTOR, FewColumns, few_columns
from hcss_twin.plan.views import ImageViews, Values, ViewAxis, place_axis
from hcss_twin.providers import Sun
from hcss_twin.scenario.scenario import Scenario

MAX_ORDER = 16
"""Along either axis."""

MAX_NODES = 200
"""Each has tables of its own."""


def choose_views(
    scenario: Scenario, assembly: Assembly, suns: Sequence[Sun | None], tolerance: float
) -> ViewAxis | None:
    """Choose the views that a scene has tables for; None where that of the image centre stands for all.

    That is so where the sensor's altitude is not known, where the change over the image keeps the tolerance, and where
    providers do not know other views, which the ledger tells.

    Parameters
    ----------
    suns : sequence of Sun or None
        Of some frames; empty where no radiance is wanted.
    tolerance : float
        Relative to the total radiance of the band.

    Raises
    ------
    ScenarioError
        If pixels need views of their own beside what cannot be had with them.
    """
    if assembly.lines_of_sight is None or not suns:
        return None
    views = ImageViews(assembly.grid, assembly.lines_of_sight)
    low, high = assembly.transmittance.declares.valid.get("view_zenith", (0.0, 90.0))
    corners = views.at([(x, y) for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
    if not all(low <= view.zenith_deg <= high for view in corners):
        return None
    # Few columns show less than all of them may.
    each = 0.5 * tolerance / SAFETY_FACTOR
    try:
        values = _columns(assembly, views, suns)
        (x, x_error), (y, y_error) = (place_axis(values, along_x, each, MAX_ORDER) for along_x in (True, False))
    except (ProviderError, ScenarioError):
        return None
    if x == y == 0:
        return None
    _refuse_beside(scenario, tolerance)
    found = SAFETY_FACTOR * (x_error + y_error)
    if found > tolerance or (x + 1) * (y + 1) > MAX_NODES:
        message = (
            f"{scenario.accuracy}: the view changes so much over the image that {x + 1} x {y + 1} views leave "
            f"{found:.1e} of the radiance, where {tolerance:.1e} is allowed; allowed: a lower "
            f"accuracy or a smaller image, with which up to {MAX_NODES} views do"
        )
        raise ScenarioError([Problem("accuracy", message)])
    return ViewAxis(x, y, found)


def _columns(assembly: Assembly, views: ImageViews, suns: Sequence[Sun | None]) -> Values:
    """Return terms of clear sky and of few clouds under the suns as a function of the place; each is computed once."""
    columns = _few(assembly)
    known: dict[tuple[float, float], Array] = {}

    def values(x: float, y: float) -> Array:
        if (x, y) not in known:
            model = assembly.model_toward(views.at([(x, y)])[0])
            under = [columns.terms(model, sun) for sun in suns]
            known[x, y] = np.concatenate([np.stack(list(terms.values()), axis=1) for terms in under])
        return known[x, y]

    return values


def _few(assembly: Assembly) -> FewColumns:
    """Columns that bound the scene, and a middling cloud of each layer alone."""
    columns = few_columns(assembly)
    middling = [
        np.sqrt(layer.thickness_min_m * layer.thickness_max_m) * np.eye(len(assembly.layers))[index]
        for index, (layer, cloudy) in enumerate(zip(assembly.layers, assembly.cloudy_layers, strict=True))
        if cloudy
    ]
    if not middling:
        return columns
    return replace(columns, thickness_m=np.concatenate((columns.thickness_m, np.array(middling))))


def _refuse_beside(scenario: Scenario, tolerance: float) -> None:
    """Refuse what is made for one view of all pixels."""
    beside = {
        "slant.shadows": (scenario.slant.shadows, "false"),
        "slant.parallax": (scenario.slant.parallax, "false"),
        "sea.waves": (scenario.sea.waves != "averaged", "'averaged'"),
    }
    problems = [
        Problem(
            field,
            "is made for one view, and here pixels need views of their own: the view changes the radiance over the "
            f"image by more than {tolerance:.1e}; allowed: {allowed}, a smaller image, a lower accuracy, or no "
            "platform.altitude",
        )
        for field, (wanted, allowed) in beside.items()
        if wanted
    ]
    if problems:
        raise ScenarioError(problems)
