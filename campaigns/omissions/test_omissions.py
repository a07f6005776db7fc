"""A pixel beyond the bound of an omission is seen."""

from dataclasses import replace

import omission_scenes as scenes

SMALL = {"image.rows": 24, "image.columns": 24, "bands": [[10.5, 11.0]], "sea.model": "cox-munk"}
PARALLAX = ("parallax of clouds",)


def test_a_pixel_beyond_its_bound_is_seen(monkeypatch):
    planned = scenes.make_plan

    def promising_less(scenario):
        plan = planned(scenario)
        return replace(plan, omissions=tuple(replace(each, bound=each.bound and 1e-4) for each in plan.omissions))

    (kept,) = scenes.check(0, PARALLAX, **SMALL)
    assert kept.beyond == 0
    monkeypatch.setattr(scenes, "make_plan", promising_less)
    (broken,) = scenes.check(0, PARALLAX, **SMALL)
    assert broken.beyond > 0
