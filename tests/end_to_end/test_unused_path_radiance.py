"""A plan says by how much the path radiance of a provider differs from the one that the radiance model derives."""

import re

import numpy as np
import pytest

from hcss_twin import ProviderError, Scenario, make_plan
from hcss_twin.models.atmosphere.table import TableTransmittance
from hcss_twin.physics.paths import to_space

NIGHT = {
    "time": "2024-04-20T23:00:00+10:00",
    "image.rows": 8,
    "image.columns": 8,
    "bands": ["mwir", "lwir-10.8"],
    "sea.model": "cox-munk",
    "optics.provider": "mie",
}
TABLE = {"atmosphere": {"provider": "table"}, "view.zenith": 60.0}


def plan_and_note(**overrides):
    plan = make_plan(Scenario.load("stratus", {**NIGHT, **overrides}), keeps_results=False)
    notes = [note for note in plan.notes if "path radiance of the atmosphere" in note]
    return plan, notes[0] if notes else ""


def percent(note):
    return {band: float(share) for share, band in re.findall(r"([+-][\d.e-]+) % in band '([^']+)'", note)}


def test_the_difference_is_that_of_whole_bands():
    plan, note = plan_and_note(**TABLE)
    grid, assembly = plan.spectral_grid, plan.assembly
    terms = assembly.clear(grid.wavenumber_cm1, None)
    own = assembly.transmittance.path_radiance(grid.wavenumber_cm1, [to_space(0.0, 60.0)])[0]
    more, clear = (grid.weights_cm1 @ each for each in (own - terms["path_emission"], sum(terms.values())))
    assert "radiance model 'physical' does not use the path radiance of the atmosphere 'table'" in note
    assert list(percent(note).values()) == pytest.approx(100 * more / clear, rel=0.05)


@pytest.mark.parametrize(
    "overrides",
    [
        {},  # LOWTRAN7's band model with its own levels
        {**TABLE, "accuracy": 0.05},
        {**TABLE, "radiance.model": "as-printed"},  # uses it
        {**TABLE, "output.variables": ["cloud_mask"]},
    ],
)
def test_nothing_is_said_where_nothing_is_lost(overrides):
    assert plan_and_note(**overrides)[1] == ""


def test_imported_radiance_that_the_profile_does_not_explain_is_in_the_note(monkeypatch):
    own = TableTransmittance.path_radiance
    monkeypatch.setattr(TableTransmittance, "path_radiance", lambda *given: 0.5 * own(*given))
    plan, note = plan_and_note(**TABLE)
    wavenumber, weights = plan.spectral_grid.wavenumber_cm1, plan.spectral_grid.weights_cm1
    terms = plan.assembly.clear(wavenumber, None)
    lost = weights @ (0.5 * terms["path_emission"]) / (weights @ sum(terms.values()))
    np.testing.assert_allclose(list(percent(note).values()), -100 * lost, rtol=0.1)


def test_path_radiance_that_fails_does_not_stop_a_scene_that_does_not_use_it(monkeypatch):
    def fails(*_):
        raise ProviderError("not for this leg")

    monkeypatch.setattr(TableTransmittance, "path_radiance", fails)
    assert "the difference is unknown (not for this leg)" in plan_and_note(**TABLE)[1]
