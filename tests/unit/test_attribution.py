"""Notes and errors that a plugin tells of itself say whose they are."""

import dataclasses

import pytest
from hcss_author import sample_cloud_inputs

from hcss_twin.core.errors import ProviderError
from hcss_twin.providers import CloudDeclaration, CloudGenerator, OpticsDeclaration
from hcss_twin.providers.common import LAYER_OPTIONS, check_options
from hcss_twin.providers.declarations import Note, applying, attributed
from hcss_twin.providers.registry import Entry, Kind, Origin, ProviderSpec
from hcss_twin.providers.registry.guard import guard

OWN = CloudDeclaration(
    notes=("plain", Note("by day", sunlight=True), Note("in the blue", below_um=0.5)),
    own_errors=("extinction some 20 % off",),
)


def test_a_speaker_stands_before_notes_and_errors_and_conditions_stay():
    told = attributed(OWN, "optics provider ada")
    assert told.own_errors == ("optics provider ada: extinction some 20 % off",)
    everything = ("optics provider ada: plain", "optics provider ada: by day", "optics provider ada: in the blue")
    assert applying(told.notes, sunlight=True, bands={"blue": (0.4, 5.0)}) == everything
    assert applying(told.notes, sunlight=False, bands={"red": (4.0, 5.0)}) == everything[:1]
    assert dataclasses.replace(told, notes=OWN.notes, own_errors=OWN.own_errors) == OWN


def test_notes_on_a_material_have_their_speaker():
    told = attributed(OpticsDeclaration(notes_by_material={"ice": ("crystals are spheres",)}), "optics provider ada")
    assert told.notes_by_material == {"ice": ("optics provider ada: crystals are spheres",)}


class Clouds:
    def __init__(self, **attributes):
        self.declares = OWN
        vars(self).update(attributes)

    def thickness_m(self, time_s, rows, columns):
        raise NotImplementedError


def guarded(distribution="hcss-ada", honours=None, **layer):
    inputs = sample_cloud_inputs()
    inputs = dataclasses.replace(inputs, layer=dataclasses.replace(inputs.layer, **layer))
    spec = ProviderSpec(name="ada", target="a:B", parameters=None, api_version=3, summary="a toy")
    provider = Clouds() if honours is None else Clouds(honours=honours)
    return guard(Entry(Kind.CLOUDS, spec, Origin("a", distribution, "1.2")), provider, inputs)


def test_only_plugins_are_named_for_built_in_providers_name_themselves():
    assert guarded().declares == attributed(OWN, "cloud generator ada")
    assert guarded("hcss-twin", edge_taper=0.5).declares == OWN
    assert isinstance(guarded(), CloudGenerator)


@pytest.mark.parametrize("honours", [None, (), ("edge_taper",), {"coverage_mode"}, list(LAYER_OPTIONS)])
def test_keys_that_are_set_and_not_honoured_are_told(honours):
    told = guarded(honours=honours, edge_taper=0.5, coverage_mode="field").declares.notes
    silent = {each for each in LAYER_OPTIONS if any(f"honours {each} = " in note for note in told)}
    assert silent == set(LAYER_OPTIONS) - set(honours or ())


@pytest.mark.parametrize("honours", ["edge_taper", ("coverage",), None, 1])
def test_what_is_honoured_is_named_among_the_keys_that_may_be_left_aside(honours):
    with pytest.raises((AssertionError, ProviderError, ValueError), match="honours"):
        check_options(Clouds(honours=honours))
