import sys
from types import ModuleType

import pytest
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.core.errors import CatalogError, ProviderError
from hcss_twin.providers import SeaDeclaration
from hcss_twin.providers.registry import Entry, Kind, Origin, ProviderSpec, Registry

LABEL = "sea model 'toy' of hcss-a 1.2"


class Parameters(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)
    colour: str = Field("blue", description="Colour.")


class Other(BaseModel):
    """Somebody else's parameters."""


class Sea:
    def __init__(self, inputs, parameters):
        self.inputs, self.parameters = inputs, parameters
        self.declares = SeaDeclaration()

    def emissivity(self, wavenumber_cm1, mu): ...

    def brdf(self, wavenumber_cm1, mu_out, mu_in, relative_azimuth): ...


class Raises(Sea):
    def __init__(self, inputs, parameters):
        raise RuntimeError("boom")


class Refuses(Sea):
    def __init__(self, inputs, parameters):
        raise CatalogError("no file 'x'")


class TakesNothing(Sea):
    def __init__(self):
        pass


class LacksMethod(Sea):
    brdf = None


class LacksDeclares(Sea):
    def __init__(self, inputs, parameters):
        pass


class DeclaresText(Sea):
    def __init__(self, inputs, parameters):
        self.declares = "nothing"


class DeclaresNonsense(Sea):
    def __init__(self, inputs, parameters):
        self.declares = SeaDeclaration(depends_on=frozenset({"view_zenit"}))


class DeclaresInverted(Sea):
    def __init__(self, inputs, parameters):
        self.declares = SeaDeclaration(valid={"wavenumber_cm1": (4000.0, 500.0)})


class DeclaresUnknownRange(Sea):
    def __init__(self, inputs, parameters):
        self.declares = SeaDeclaration(valid={"wavenumber": (500.0, 4000.0)})


class DeclaresOneNote(Sea):
    def __init__(self, inputs, parameters):
        self.declares = SeaDeclaration(notes="calm water only")


class WavesAsText(Sea):
    significant_wave_height_m = "2 m"


class WeightsAreNoMethod(Sea):
    reflection_weights = (0.5, 0.5)


@pytest.fixture
def entry(monkeypatch):
    module = ModuleType("hcss_toy_sea")
    vars(module).update(globals())
    monkeypatch.setitem(sys.modules, "hcss_toy_sea", module)

    def make(target="Sea", parameters="Parameters"):
        spec = ProviderSpec(
            name="toy",
            target=f"hcss_toy_sea:{target}",
            parameters=parameters and f"hcss_toy_sea:{parameters}",
            api_version=3,
            summary="a toy",
        )
        return Entry(Kind.SEA, spec, Origin("a", "hcss-a", "1.2"))

    return make


def test_class_is_called_with_inputs_and_parameters(entry):
    provider = Registry().create(entry(), "inputs", Parameters(colour="grey"))
    assert (provider.inputs, provider.parameters.colour) == ("inputs", "grey")


def test_missing_parameters_are_the_models_defaults(entry):
    assert Registry().create(entry(), "inputs").parameters == Parameters()
    assert Registry().create(entry(parameters=None), "inputs").parameters is None


def test_parameters_model_is_imported_on_request(entry):
    assert Registry().parameters_model(entry()) is Parameters
    assert Registry().parameters_model(entry(parameters=None)) is None


@pytest.mark.parametrize(
    ("target", "message"),
    [
        ("Missing", "cannot import 'hcss_toy_sea:Missing': AttributeError"),
        ("Raises", "cannot be constructed: RuntimeError: boom"),
        ("TakesNothing", "cannot be constructed: TypeError"),
        ("LacksMethod", r"lacks brdf\(\) of hcss_twin.providers.SeaModel"),
        ("LacksDeclares", "lacks declares"),
        ("DeclaresText", "declares is str; expected hcss_twin.providers.SeaDeclaration"),
        ("DeclaresNonsense", "'view_zenit'.*closest is 'view_zenith'"),
        ("DeclaresInverted", r"valid\['wavenumber_cm1'\]"),
        ("DeclaresUnknownRange", "'wavenumber', which the engine does not use.*closest is 'wavenumber_cm1'"),
        ("DeclaresOneNote", "declares.notes is 'calm water only'; expected a tuple of strings"),
        ("WavesAsText", "significant_wave_height_m is '2 m'; expected a number of metres"),
        ("WeightsAreNoMethod", r"reflection_weights is \(0.5, 0.5\); expected a method"),
    ],
)
def test_bad_class_is_an_error_that_names_provider_and_distribution(entry, target, message):
    with pytest.raises(ProviderError, match=message) as error:
        Registry().create(entry(target), "inputs")
    assert str(error.value).startswith(LABEL)


def test_cause_of_a_failed_construction_is_kept(entry):
    with pytest.raises(ProviderError) as error:
        Registry().create(entry("Raises"), "inputs")
    assert isinstance(error.value.__cause__, RuntimeError)


def test_deliberate_error_passes_unchanged(entry):
    with pytest.raises(CatalogError, match="no file 'x'"):
        Registry().create(entry("Refuses"), "inputs")


def test_wrong_parameters_are_refused(entry):
    with pytest.raises(ProviderError, match="accepts no parameters"):
        Registry().create(entry(parameters=None), "inputs", Parameters())
    with pytest.raises(ProviderError, match="parameters are Other; expected Parameters"):
        Registry().create(entry(), "inputs", Other())
    with pytest.raises(ProviderError, match="is no pydantic model"):
        Registry().parameters_model(entry(parameters="Sea"))


def test_module_that_cannot_be_imported_is_named():
    spec = ProviderSpec(name="toy", target="no_such_module_x:Y", parameters=None, api_version=3, summary="a toy")
    with pytest.raises(ProviderError, match="cannot import 'no_such_module_x:Y': ModuleNotFoundError"):
        Registry().create(Entry(Kind.SEA, spec, Origin("a", "hcss-a", "1.2")), "inputs")
