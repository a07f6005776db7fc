"""Which terms of a radiance model are direct sunlight reflected by the clear sea."""

from __future__ import annotations

from hcss_twin.errors import Problem, ScenarioError
from hcss_twin.providers import RadianceModel


def sea_sun_terms(model: RadianceModel) -> tuple[str, ...]:
    """Return the terms that a radiance model says are; none if it says nothing."""
    named: frozenset[str] = getattr(model, "sea_sun_terms", frozenset())
    return tuple(name for name in model.terms if name in named)


def require_sea_sun_terms(model: RadianceModel) -> None:
    """Refuse a radiance model that does not say what a shadow weakens.

    Raises
    ------
    ScenarioError
        Naming ``slant.shadows``.
    """
    if not sea_sun_terms(model):
        message = (
            "the radiance model has no attribute sea_sun_terms and so does not say which terms a shadow weakens; "
            "allowed: false, or a radiance model that does ('as-printed' and 'physical' do)"
        )
        raise ScenarioError([Problem("slant.shadows", message)])
