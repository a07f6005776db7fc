"""The ``[sensor]`` section, and its merging with the instrument it names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator
from pydantic_core import PydanticCustomError

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, ScenarioError
from hcss_twin.core.plugins import OWN_DISTRIBUTION
from hcss_twin.core.units import QuantityParser
from hcss_twin.scenario.instrument import DEFAULT_MODEL, NamedInstrument, load_instrument
from hcss_twin.scenario.section_types import ScenarioSection


class StageSection(ScenarioSection):
    """One stage of a sensor; the input of each is the measured radiance of the one before it."""

    name: str | None = Field(
        None,
        min_length=1,
        description="Catalog name or TOML file of an instrument, for what the scenario does not give.",
    )
    model: str | None = Field(
        None, description=f"Sensor model (see `hcss plugins`); default: that of `name`, or `{DEFAULT_MODEL}`."
    )
    parameters: dict[str, Any] = Field(
        default_factory=dict, description="Parameters of the model; they override those of `name`."
    )
    seed: QuantityParser.Whole | None = Field(
        None,
        ge=0,
        lt=2**63,
        description="Seed of the noise; default: that of the scenario, another for each later stage.",
    )


class SensorSection(StageSection):
    """The sensor: with this section a run writes `NAME.sensor.nc` in addition to the clean `NAME.nc`."""

    variables: tuple[str, ...] = Field(
        (), description='Variables beside radiance and truth: "photon_rate", "digital_number", "saturated", or "all".'
    )
    stages: tuple[StageSection, ...] = Field(
        (),
        max_length=20,
        description="`[[sensor.stages]]` with `name`, `model`, `parameters` and `seed`: a chain of sensors.",
    )

    @model_validator(mode="after")
    def _is_one_or_a_chain(self) -> Self:
        given = [key for key in ("name", "model", "parameters") if self.stages and getattr(self, key)]
        if given:
            raise PydanticCustomError(
                "stages", f"{', '.join(given)} with [[sensor.stages]]; allowed: these keys in [sensor] or in its stages"
            )
        return self

    @model_serializer(mode="wrap")
    def _without_empty_stages(self, dumped: SerializerFunctionWrapHandler) -> dict[str, Any]:
        data: dict[str, Any] = dumped(self)
        if not self.stages:
            del data["stages"]
        return data


@dataclass(frozen=True)
class SensorChoice:
    """A section merged with the instrument it names.

    Attributes
    ----------
    model : str
        Name that selects the provider.
    parameters : mapping
        Provider parameters, as typed.
    named : NamedInstrument or None
        The instrument file.
    """

    model: str
    parameters: Mapping[str, Any]
    named: NamedInstrument | None


def choose_sensor(section: StageSection, catalog: Catalog) -> SensorChoice:
    """Merge a section with the instrument it names.

    The default model is always the one of this package. Parameters of a named instrument belong to its own model: if
    the section selects another, they are ignored.

    Raises
    ------
    CatalogError, ScenarioError
        As :func:`hcss_twin.scenario.instrument.load_instrument`.
    """
    named = None if section.name is None else load_instrument(section.name, catalog)
    default_model = f"{OWN_DISTRIBUTION}/{DEFAULT_MODEL}"
    usual = default_model if named is None or named.model == DEFAULT_MODEL else named.model
    model = section.model or usual
    same = named is not None and model.rpartition("/")[2] == named.model.rpartition("/")[2]
    parameters = {**(named.sensor_parameters() if named is not None and same else {}), **section.parameters}
    return SensorChoice(model, parameters, named)


def fill_bands(data: dict[str, Any], catalog: Catalog) -> None:
    """Add the bands of the named instrument to a raw scenario without bands; file errors are reported elsewhere."""
    for _, section in raw_stages(data):
        name = section.get("name") if isinstance(section, Mapping) else None
        if not isinstance(name, str) or "bands" in data:
            continue
        try:
            named = load_instrument(name, catalog)
        except (CatalogError, ScenarioError, OSError, RuntimeError, ValueError):  # reported at sensor.name
            continue
        if (bands := named.band_keys()) is not None:
            data["bands"] = bands


def raw_stages(data: Mapping[str, Any]) -> list[tuple[str, Any]]:
    """Return path and content of each stage of the sensor of a raw scenario; of its only section without stages."""
    section = data.get("sensor")
    stages = section.get("stages") if isinstance(section, Mapping) else None
    if isinstance(stages, list) and stages:
        return [(f"sensor.stages[{index}]", stage) for index, stage in enumerate(stages)]
    return [("sensor", section)] if "sensor" in data else []
