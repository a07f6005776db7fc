"""hcss plugins NAME: what a provider takes, and how far off it says it is."""

import csv
import json
from pathlib import Path
from typing import Literal

import pytest
from click.testing import CliRunner
from installed_providers import install
from pydantic import BaseModel, Field

from hcss_twin import models
from hcss_twin.cli.main import cli
from hcss_twin.core.errors import ProviderError
from hcss_twin.providers import ModelError
from hcss_twin.providers.registry import ProviderSpec, Registry, hookimpl
from hcss_twin.reports.provider_text import described, provider_text


class Parameters(BaseModel):
    depth: float = Field(ge=0, lt=5, description="Optical depth of the air.")
    shape: Literal["round", "long"] = Field("long", description="Shape of `drops`.")
    levels: tuple[float, ...] = Field((), max_length=9, description="Altitudes.")
    file: str | None = Field(None, description="A table.")


class Drops:
    @staticmethod
    def model_errors():
        same = {"name": "particles", "source": "a Mie code", "condition": "10 drops"}
        return (
            ModelError(lower_um=3.0, upper_um=5.0, relative=0.023, kelvin=0.51, column="water", sunlight=True, **same),
            ModelError(lower_um=8.0, upper_um=14.0, kelvin=1.0, statistic="largest", zenith_deg=(0, 60), **same),
            ModelError(name="drizzle", lower_um=8.0, upper_um=14.0, relative=1e-4, source="a radar", command="ada.py"),
        )


class Sea:
    def model_errors(self):
        return ()


class Ada:
    @hookimpl
    def hcss_register_optics(self):
        return [ProviderSpec("ada", f"{__name__}:Drops", f"{__name__}:Parameters", 3, "drops by Ada", ("Ada, 1843",))]

    @hookimpl
    def hcss_register_sea_models(self):
        return [ProviderSpec("ada", f"{__name__}:Sea", None, 3, "a sea by Ada")]


@pytest.fixture
def registry(monkeypatch):
    return install(monkeypatch, Ada(), "ada")


def test_parameters_are_told_with_type_limits_default_and_description(registry):
    (optics,) = (each for each in described(registry, "hcss-ada/ada") if each["selected_by"] == "optics.provider")
    fields = {each.pop("name"): each for each in optics["parameters"]}
    assert fields == {
        "depth": {
            "type": "number",
            "allowed": "≥ 0, < 5",
            "default": "**required**",
            "description": "Optical depth of the air.",
        },
        "shape": {
            "type": '`"round"` or `"long"`',
            "allowed": "",
            "default": "`long`",
            "description": "Shape of `drops`.",
        },
        "levels": {"type": "list", "allowed": "length ≤ 9", "default": "none", "description": "Altitudes."},
        "file": {"type": "text", "allowed": "", "default": "", "description": "A table."},
    }


def test_text_of_all_providers_of_a_name(registry):
    done = CliRunner().invoke(cli, ["plugins", "ada"])
    assert done.exit_code == 0
    (sea,) = (each for each in done.output.split("\n\n") if each.startswith("sea model ada  [hcss-ada 1.0]"))
    (optics,) = (each for each in done.output.split("\n\n") if each.startswith("optics provider ada  [hcss-ada 1.0]"))
    said = {
        sea: ('sea.model = "ada"', "no parameters"),
        optics: (
            *('optics.provider = "ada"', "Ada, 1843", "optics.parameters:", "≥ 0, < 5, required", "length ≤ 9"),
            *('"round" or "long", default long', "against a Mie code", "2.3 %, 0.51 K", "zenith 0-60 deg"),
        ),
    }
    assert [each for text, words in said.items() for each in words if each not in text] == []


def test_json_is_what_is_described(registry):
    done = CliRunner().invoke(cli, ["plugins", "ada", "--json"])
    assert json.loads(done.stdout) == described(registry, "ada")


def test_figures_of_shipped_providers_are_those_of_their_tables():
    stated = {each["name"]: each["model_errors"] for each in described(Registry.defaults_only(), "cox-munk")}
    text = (Path(models.__file__).parent / "sea" / "model_errors.csv").read_text(encoding="utf-8")
    table = csv.DictReader(text.splitlines())
    relative = [float(row["relative"]) for row in table if row["provider"] == "cox-munk"]
    assert [each["relative"] for each in stated["cox-munk"]] == relative


def test_every_shipped_provider_can_be_described():
    registry = Registry.defaults_only()
    for entry in registry.entries():
        texts = [provider_text(found) for found in described(registry, entry.name)]
        assert any(entry.summary in text for text in texts)
        assert not any("`" in text or "**" in text for text in texts)


def test_an_unknown_name_is_refused_with_the_closest_one(registry):
    with pytest.raises(ProviderError, match=r"no provider is named 'fractl'; .*fractal"):
        described(registry, "fractl")


def test_the_name_of_a_provider_that_is_not_installed_names_its_package(registry):
    with pytest.raises(ProviderError, match=r"no provider is named 'surrogate'.*It comes with hcss-skies: pip install"):
        described(registry, "surrogate")
