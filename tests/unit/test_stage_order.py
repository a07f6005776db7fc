"""Stages run after all that write what they read, in whatever order they are found."""

import itertools

import pytest

from hcss_twin.engine.stages.derived import DerivedStage
from hcss_twin.engine.stages.elements import ElementStage
from hcss_twin.engine.stages.light import LightStage
from hcss_twin.engine.stages.scene_stages import LookUpStage, RadianceStage, ordered
from hcss_twin.engine.stages.shadows import ShadowStage
from hcss_twin.engine.stages.stage import Stage
from hcss_twin.engine.stages.surfaces import SurfaceStage
from hcss_twin.engine.stages.texture import TextureStage
from hcss_twin.engine.stages.truth import Truth
from hcss_twin.engine.stages.waves import WaveStage

EVERY = [
    Truth, LookUpStage, LightStage, TextureStage, SurfaceStage, ShadowStage, WaveStage, ElementStage, RadianceStage,
    DerivedStage,
]  # fmt: skip


def bare(kind):
    """A stage that only declares."""
    return type(kind.__name__, (Stage,), {"reads": kind.reads, "writes": kind.writes})()


@pytest.mark.parametrize("without", [None, TextureStage, SurfaceStage, ShadowStage])
def test_the_order_does_not_depend_on_that_in_which_stages_are_found(without):
    stages = [bare(kind) for kind in EVERY if kind is not without]
    for shift in range(len(stages)):
        for found in (stages[shift:] + stages[:shift], list(reversed(stages[shift:] + stages[:shift]))):
            names = [type(stage).__name__ for stage in ordered(found)]
            for first, second in itertools.pairwise(
                ("LookUpStage", "ShadowStage", "WaveStage", "ElementStage", "RadianceStage")
            ):
                if first in names and second in names:
                    assert names.index(first) < names.index(second)
            assert names[-1] == "DerivedStage"


def test_stages_that_wait_for_each_other_are_named():
    one = type("One", (Stage,), {"reads": ("b",), "writes": ("a",)})()
    two = type("Two", (Stage,), {"reads": ("a",), "writes": ("b",)})()
    with pytest.raises(ValueError, match=r"One \(reads b\), Two"):
        ordered([one, two])
