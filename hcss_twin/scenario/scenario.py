"""A scenario: validated, immutable, serialisable."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Self, TypeVar

from pydantic import BaseModel, PrivateAttr, ValidationError

from hcss_twin.core.arguments import checked
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, Problem, ScenarioError, choose_from
from hcss_twin.core.notebook import as_html, as_text
from hcss_twin.core.own_packages import COMMANDS, how_to_install
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.models.parameters import DEFAULT_COEFFICIENTS
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.atmosphere import BAND_MODEL
from hcss_twin.scenario.cloud_types import CloudType, load_cloud_type
from hcss_twin.scenario.clouds import Layer, has_single_layer
from hcss_twin.scenario.instrument_keys import take_instrument
from hcss_twin.scenario.models import ScenarioModel
from hcss_twin.scenario.names import SECTIONS, misplaced_parameters, name_problems, normalise, provider_sections
from hcss_twin.scenario.overrides import apply_overrides
from hcss_twin.scenario.problems import problems_from
from hcss_twin.scenario.section_types import selected
from hcss_twin.scenario.sensor import fill_bands
from hcss_twin.scenario.skies import with_skies
from hcss_twin.scenario.summary import summary
from hcss_twin.scenario.viewing import as_given, viewing_problems, with_viewing

_Scenario = TypeVar("_Scenario", bound=ScenarioModel)

MANY = {
    "sweep": ("sweep", "the file describes many scenes, which `hcss sweep FILE -o FOLDER` computes"),
    "sensors": ("sweep", "the file describes many sensors of a scene, which `hcss sweep FILE -o FOLDER` computes"),
    "base": ("dataset", "the file describes a data set, which `hcss dataset FILE -o FOLDER` makes"),
}
"""Sections of files that describe many scenarios: command, and what the file is."""

UNCERTAIN = "uncertain"
"""Section that assigns distributions to keys."""

_NOT_CERTAIN = (
    "the file has uncertain keys, which `hcss propagate FILE` propagates (docs/how-to/uncertainty.md); allowed here: "
    f"a file without this section. The command comes with {COMMANDS['propagate']}: "
    f"{how_to_install(COMMANDS['propagate'])}"
)


class Scenario(ScenarioModel):
    """The user's description of a scene and its output.

    Create one with :meth:`load`, :meth:`from_toml`, :meth:`from_dict` or :meth:`from_cube`. Relative paths in it are
    resolved against ``base``, the folder of the scenario file.
    """

    _base: Path = PrivateAttr(default_factory=Path.cwd)
    _short: bool = PrivateAttr(default=False)
    _renamed: dict[str, str] = PrivateAttr(default={})
    _origin: str = PrivateAttr(default="scenario")
    _sections: dict[str, BaseModel] = PrivateAttr(default_factory=dict)
    _notes: tuple[str, ...] = PrivateAttr(default=())
    _json: str | None = PrivateAttr(default=None)

    def __eq__(self, other: object) -> bool:
        """Compare values and base, ignoring whether the cloud layer was written in short form."""
        if not isinstance(other, Scenario):
            return NotImplemented
        return self.base == other.base and self.to_json() == other.to_json()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        """Return the scene in a few lines, instead of all values."""
        return as_text(*summary(self, self.sections))

    __str__ = __repr__

    def _repr_html_(self) -> str:
        """Return the same as a table for notebooks, with all values folded below."""
        return as_html(*summary(self, self.sections), folded=("All values", self.to_json()))

    @property
    def base(self) -> Path:
        """Folder against which relative paths are resolved."""
        return self._base

    @property
    def origin(self) -> str:
        """Origin, for messages."""
        return self._origin

    @property
    def sections(self) -> Mapping[str, BaseModel]:
        """Sections that plugins own, by name (:mod:`hcss_twin.core.sections`)."""
        return self._sections

    @property
    def notes(self) -> tuple[str, ...]:
        """What reading changed: parameters of providers that overrides replace, skies whose package is missing."""
        return self._notes

    @property
    def coefficients(self) -> str | None:
        """Name of the coefficients of the band model; None for other providers, and with a file."""
        air = self.atmosphere
        if air.provider not in BAND_MODEL or "file" in air.parameters:
            return None
        return air.coefficients or DEFAULT_COEFFICIENTS

    def field_as_typed(self, field: str) -> str:
        """Convert a field path to the user's notation: short form of a single layer, keys of the instrument."""
        return _typed_fields(self._short, {}, self._renamed)(field)

    @classmethod
    @checked
    def of(cls, source: Scenario | str | Path | dict[str, Any], overrides: Mapping[str, Any] | None = None) -> Scenario:
        """Return a scenario from whatever describes one: itself, a shipped name, a path, or nested tables.

        Parameters
        ----------
        source : Scenario, str, Path or dict
            Text and paths are read as by :meth:`load`; relative paths in a dict refer to the working folder.
        overrides : mapping, optional
            As of :meth:`load`, which raises the same errors.
        """
        if isinstance(source, dict):
            return cls.from_dict(source, overrides)
        if not isinstance(source, Scenario):
            return cls.load(source, overrides)
        if not overrides:
            return source
        return cls.from_dict(json.loads(source.to_json()), overrides, base=source.base, origin=source.origin)

    @classmethod
    @checked
    def load(cls, source: str | Path, overrides: Mapping[str, Any] | None = None) -> Self:
        """Read a scenario by catalog name or from a ``.toml`` or ``.json`` file.

        Parameters
        ----------
        source : str or Path
            Name of a shipped scenario (``hcss scenarios`` lists them) or path of a file.
        overrides : mapping, optional
            Dotted key to value, for example ``{"view.zenith": 40}``.

        Raises
        ------
        ScenarioError
            With all problems.
        """
        raw, base = cls.read_file(source)
        return cls.from_dict(raw, overrides, base=base, origin=str(source))

    @classmethod
    @checked
    def from_toml(cls, text: str, overrides: Mapping[str, Any] | None = None, base: Path | None = None) -> Self:
        """Validate a scenario given as TOML text; raises :class:`ScenarioError`."""
        return cls.from_dict(_parse_toml(text, "scenario"), overrides, base=base)

    @classmethod
    @checked
    def from_dict(
        cls,
        raw: Mapping[str, Any] | object,
        overrides: Mapping[str, Any] | None = None,
        base: Path | None = None,
        origin: str = "scenario",
        *,
        shelf: ResultCache | None = None,
    ) -> Self:
        """Validate a scenario given as nested mappings; raises :class:`ScenarioError`.

        A shared ``shelf`` speeds up the validation of many scenarios.
        """
        base = (base or Path.cwd()).resolve()
        if not isinstance(raw, Mapping):
            raise ScenarioError([Problem("scenario", f"{Problem.shown(raw)} is not a table of keys")], origin)
        for section in MANY:
            if section in raw:
                raise ScenarioError([Problem(section, _not_one_scene(section))], origin)
        if UNCERTAIN in raw:
            raise ScenarioError([Problem(UNCERTAIN, _NOT_CERTAIN)], origin)
        data, problems, notes = apply_overrides(normalise(raw), overrides or {})
        catalog = Catalog(base=base)
        catalog.shelf = shelf or catalog.shelf
        of_instrument, renamed = take_instrument(data, catalog)
        problems += of_instrument
        fill_bands(data, catalog)
        short = has_single_layer(raw.get("clouds"))
        scenario: Self | None = None
        sections: dict[str, BaseModel] = {}
        on_grid = True
        if any(name not in ScenarioModel.model_fields for name in data):
            # not for scenarios without such sections
            from hcss_twin.scenario.plugin_sections import bring_rays, take_owned

            sections, of_sections = take_owned(data)
            problems += of_sections
            on_grid = not bring_rays(sections)
        try:
            scenario = cls.model_validate(data)
        except ValidationError as error:
            problems += problems_from(error, ScenarioModel, raw=data)
        else:
            problems += viewing_problems(scenario)
        reported = {problem.field for problem in problems}
        # Names are checked even if other keys are invalid, so that the user sees all problems at once.
        registry = catalog.shelf.get_or_compute("registry", Registry.discover)
        names = name_problems(data, registry, catalog)
        problems += [problem for problem in names if problem.field not in reported]
        if problems or scenario is None:
            typed = _typed_fields(short, overrides or {}, renamed)
            better = {problem.field: problem.message for problem in misplaced_parameters(data, registry, typed)}
            raise ScenarioError(
                [Problem(typed(problem.field), better.get(problem.field, problem.message)) for problem in problems],
                origin,
            )
        scenario, of_skies = with_skies(with_viewing(scenario), catalog, registry, origin)
        scenario = _with_coverage_modes(scenario, registry, on_grid)
        scenario._base = base
        scenario._short = short
        scenario._renamed = renamed
        scenario._origin = origin
        scenario._sections = sections
        scenario._notes = (*notes, *of_skies)
        return scenario

    @classmethod
    @checked
    def from_cube(cls, path: str | Path, overrides: Mapping[str, Any] | None = None, base: Path | None = None) -> Self:
        """Read the scenario of a cube; relative paths are resolved against ``base``.

        Cubes store all keys, so that later defaults do not change them.
        """
        from hcss_twin.cube.reader import scenario_text

        raw = _parse_json(scenario_text(path), str(path))
        return cls.from_dict(raw, overrides, base=base, origin=str(path))

    @staticmethod
    def cloud_type(name: str, catalog: Catalog) -> CloudType:
        """Read a cloud type by catalog name or from a user's TOML file; raises CatalogError and ScenarioError."""
        return load_cloud_type(name, catalog)

    def named_providers(self) -> set[tuple[Kind, str]]:
        """Return kind and name of each provider that the scenario selects."""
        return {
            (kind, section[SECTIONS[kind][1]])
            for _, section, kind in provider_sections(json.loads(self.to_json()))
            if isinstance(section, dict) and section.get(SECTIONS[kind][1])
        }

    @staticmethod
    def read_file(source: str | Path, folders: tuple[str, ...] = ("scenarios",)) -> tuple[dict[str, Any], Path]:
        """Read the unchecked keys of a scenario, and the folder of its relative paths.

        Parameters
        ----------
        source : str or Path
            Path of a ``.toml`` or ``.json`` file, or a name in one of ``folders``.
        folders : tuple of str
            Catalog folders, in the order of the search.

        Raises
        ------
        ScenarioError
            If there is no such file, or it has the wrong format.
        """
        path, origin = _locate(source, folders), str(source)
        try:
            text = path.read_text(encoding="utf-8-sig")
        except UnicodeDecodeError as error:
            cube = "; a cube? hcss verify and hcss report read it" if path.suffix == ".nc" else ""
            raise _bad_file(f"{path} is not a text file in UTF-8{cube}: {error}", origin) from error
        except OSError as error:
            raise _bad_file(f"{path} cannot be read: {error}", origin) from error
        parse = _parse_json if path.suffix.lower() == ".json" else _parse_toml
        # Files that a user adds to a shipped scenario are in the working folder, not in the installation.
        base = Path.cwd() if path.is_relative_to(Catalog().root) else path.parent
        return parse(text, origin), base

    def to_json(self) -> str:
        """Serialise with every default filled in; :meth:`load` reads it from a ``.json`` file.

        Default providers are written with the distribution name ``hcss-twin``, so that a plugin with the same name
        cannot replace them.
        """
        if self._json is not None:  # a point of a sweep is asked for it a dozen times
            return self._json
        data = as_given(self, self.model_dump(mode="json"))
        data |= {name: section.model_dump(mode="json", exclude_none=True) for name, section in self._sections.items()}
        for name in ("surfaces", "instrument", "sensor"):
            if getattr(self, name) is None:
                del data[name]
        atmosphere = data["atmosphere"]
        atmosphere["coefficients"] = self.coefficients
        for name in ("coefficients", "inversion"):
            if atmosphere[name] is None:
                del atmosphere[name]
        atmosphere["gases"] = {key: value for key, value in atmosphere["gases"].items() if value is not None}
        if not self.elements:
            del data["elements"]
        if not self.output.derived:
            del data["output"]["derived"]
        for key, section in data.items():
            for name in _PROVIDER_KEYS.get(key, ()):
                section[name] = selected(getattr(self, key), name)
        for layer, model in zip(data["clouds"]["layers"], self.clouds.layers, strict=True):
            layer["generator"] = selected(model, "generator")
            if model.optics is None:
                del layer["optics"]
            else:
                layer["optics"]["provider"] = selected(model.optics, "provider")
        if self.surfaces is not None:
            data["surfaces"]["provider"] = selected(self.surfaces, "provider")
        for section, element in zip(data.get("elements", ()), self.elements, strict=True):
            section["provider"] = selected(element, "provider")
        self._json = json.dumps(data, indent=1)
        return self._json

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy with other values."""
        copy = super().model_copy(update=update, deep=deep)
        copy._json = None
        return copy


def _with_coverage_modes(scenario: _Scenario, registry: Registry, on_grid: bool) -> _Scenario:
    """Return a valid scenario whose layers all have a coverage mode.

    A threshold of each frame changes pixels that no cloud moved into, which looks like targets; an image that is no
    grid on the ground has no frame to set it for.
    """

    def mode(layer: Layer) -> str:
        wind = scenario.motion.wind_speed if layer.wind_speed is None else layer.wind_speed
        still = scenario.motion.evolution_time == "frozen" and scenario.motion.platform_speed == wind == 0.0
        if on_grid and (scenario.frames.count == 1 or still):
            return "frame"
        entry = registry.resolve(Kind.CLOUDS, selected(layer, "generator"))
        # All generators of this package can; their code is not loaded here.
        can = entry.is_own or "coverage_mode" in getattr(registry.provider_class(entry), "honours", ())
        return "field" if can else "frame"

    layers = [layer if layer.coverage_mode else layer.model_copy(update={"coverage_mode": mode(layer)})
              for layer in scenario.clouds.layers]  # fmt: skip
    return scenario.model_copy(update={"clouds": scenario.clouds.model_copy(update={"layers": tuple(layers)})})


_PROVIDER_KEYS = {"atmosphere": ("provider",), "sea": ("model",), "optics": ("provider",), "radiance": ("model",)}


def _typed_fields(short: bool, overrides: Mapping[str, Any], renamed: Mapping[str, str]) -> Callable[[str], str]:
    """Return a function that converts fields to what the user typed.

    ``clouds.KEY`` for ``clouds.layers[0].KEY`` in short form, and keys of the instrument for what follows from them.
    """
    long = "clouds.layers[0]"

    def typed(field: str) -> str:
        field = renamed.get(field, field)
        if not field.startswith(f"{long}."):
            return field
        brief = f"clouds{field.removeprefix(long)}"
        overridden = any(brief == key or brief.startswith((f"{key}.", f"{key}[")) for key in overrides)
        return brief if short or overridden else field

    return typed


def _not_one_scene(section: str) -> str:
    command, kind = MANY[section]
    return (
        f"{kind} and `hcss validate FILE` checks; allowed here: a file without this section. The command comes with "
        f"{COMMANDS[command]}: {how_to_install(COMMANDS[command])}"
    )


def _locate(source: str | Path, folders: tuple[str, ...]) -> Path:
    try:
        path = Path(source).expanduser()
        if path.is_file():
            return path
        is_folder = path.is_dir() and str(source) != ""
    except (OSError, RuntimeError) as error:  # not a possible file name
        raise _bad_file(f"cannot be read: {getattr(error, 'strerror', error)}", str(source)) from error
    catalog = Catalog()
    for folder in folders:
        with suppress(CatalogError):
            return catalog.find(str(source), folder, ".toml")
    what = "a folder" if is_folder else "a pipe, socket or device" if str(source) and path.exists() else "no such file"
    choices = choose_from(str(source), {name for folder in folders for name in catalog.names(folder, ".toml")})
    if str(source) in catalog.names("sweeps", ".toml"):
        choices = f"it is a shipped sweep, which `hcss sweep {source} -o FOLDER` computes; {choices}"
    shipped = " or ".join(folder.removesuffix("s") for folder in folders)
    raise _bad_file(f"{what}, and no shipped {shipped} of that name; {choices}", str(source))


def _parse_toml(text: str, origin: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except ValueError as error:  # including numbers with thousands of digits
        raise _bad_file(f"not valid TOML: {error}", origin) from error
    except RecursionError as error:
        raise _bad_file("not valid TOML: nested too deeply", origin) from error


def _parse_json(text: str, origin: str) -> Any:
    try:
        raw = json.loads(text, object_pairs_hook=_distinct_keys)
        json.dumps(raw, ensure_ascii=False).encode()  # rejects lone surrogates
    except ValueError as error:
        raise _bad_file(f"not valid JSON: {error}", origin) from error
    except RecursionError as error:
        raise _bad_file("not valid JSON: nested too deeply", origin) from error
    return raw


def _distinct_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table: dict[str, Any] = {}
    for key, value in pairs:
        if key in table:
            raise ValueError(f"key '{key}' is given twice")
        table[key] = value
    return table


def _bad_file(message: str, origin: str) -> ScenarioError:
    return ScenarioError([Problem("file", message)], origin)
