import dataclasses
from pathlib import Path

import hcss_author
import pytest
from hcss_author.extension_entries import Extension

from hcss_twin import providers
from hcss_twin.providers.registry import API_VERSION, Kind, ProviderSpec, specs


def spec(**changes):
    fields = {"name": "grey", "target": "a.b:C", "parameters": "a.b:D", "api_version": 1, "summary": "a gas"}
    return ProviderSpec(**(fields | changes))


@pytest.mark.parametrize("name", ["g", "grey", "us-76", "0-moment"])
def test_good_names_are_accepted(name):
    assert spec(name=name).name == name


@pytest.mark.parametrize("name", ["", "Grey", "-grey", "grey_gas", "a/b", "grå", "grey\n", 3])
def test_bad_names_are_refused(name):
    with pytest.raises(ValueError, match="name"):
        spec(name=name)


@pytest.mark.parametrize("target", ["", "a.b", "a.b:", ":C", "a..b:C", "a-b:C", "a.b:C.d", "1a:C", "a.b:C\n", None])
def test_bad_targets_are_refused(target):
    with pytest.raises(ValueError, match="target"):
        spec(target=target)
    if target is not None:
        with pytest.raises(ValueError, match="parameters"):
            spec(parameters=target)


@pytest.mark.parametrize(
    "changes",
    [
        {"summary": " "},
        {"summary": "two\nlines"},
        {"references": "a string"},
        {"api_version": "1"},
        {"api_version": -1},
    ],
)
def test_other_malformed_fields_are_refused(changes):
    with pytest.raises(ValueError, match=next(iter(changes))):
        spec(**changes)


def test_specs_cannot_be_changed():
    with pytest.raises(dataclasses.FrozenInstanceError):
        spec().name = "other"


def test_every_kind_has_a_documented_hook_and_a_protocol():
    hooks = {name for name in vars(specs) if name.startswith("hcss_register_")}
    assert {kind.hook for kind in Kind} == hooks
    for kind in Kind:
        assert getattr(specs, kind.hook).__doc__
        assert getattr(providers, kind.protocol).__name__ in getattr(specs, kind.hook).__doc__
    before = ["clouds", "sea", "optics", "atmosphere", "radiance", "elements"]
    assert [str(kind) for kind in Kind] == [*before, "surfaces", "variables", "sensors"]


def test_the_guide_for_plugin_authors_names_every_hook_protocol_and_kit():
    guide = (Path(__file__).parents[2] / "docs" / "how-to" / "write-a-plugin.md").read_text(encoding="utf-8")
    contracts = [name for name in hcss_author.__all__ if name.endswith("Contract")]
    assert len(contracts) == len(Kind) + len(Extension)
    for name in [*(kind.hook for kind in Kind), *(kind.protocol for kind in Kind), *contracts]:
        assert f"`{name}`" in guide
    assert f"version {API_VERSION}" in guide
