"""A scenario: what the user asked for, validated, immutable, serialisable."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

from pydantic import PrivateAttr, ValidationError

from hcss_twin.catalog import Catalog
from hcss_twin.errors import CatalogError, Problem, ScenarioError, choose_from
from hcss_twin.registry.registry import Registry
from hcss_twin.scenario.models import ScenarioModel
from hcss_twin.scenario.names import name_problems, normalise
from hcss_twin.scenario.overrides import apply_overrides
from hcss_twin.scenario.problems import problems_from


class Scenario(ScenarioModel):
    """What the user asked for.

    Make one with :meth:`load`, :meth:`from_toml`, :meth:`from_dict` or :meth:`from_cube`. Relative
    paths in it are resolved against ``base``, the folder of the scenario file.
    """

    _base: Path = PrivateAttr(default_factory=Path.cwd)

    @property
    def base(self) -> Path:
        """Folder against which relative paths are resolved."""
        return self._base

    @classmethod
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
            With every problem found.
        """
        path = _locate(source)
        try:
            text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise ScenarioError([Problem("file", f"{path} cannot be read: {error}")], str(source)) from error
        if path.suffix == ".json":
            try:
                raw = json.loads(text)
            except json.JSONDecodeError as error:
                raise ScenarioError([Problem("file", f"not valid JSON: {error}")], str(source)) from error
        else:
            raw = _parse_toml(text, str(source))
        return cls.from_dict(raw, overrides, base=path.parent, origin=str(source))

    @classmethod
    def from_toml(
        cls, text: str, overrides: Mapping[str, Any] | None = None, base: Path | None = None
    ) -> Self:
        """Validate a scenario given as TOML text; raises :class:`ScenarioError`."""
        return cls.from_dict(_parse_toml(text, "scenario"), overrides, base=base)

    @classmethod
    def from_dict(
        cls,
        raw: Mapping[str, Any],
        overrides: Mapping[str, Any] | None = None,
        base: Path | None = None,
        origin: str = "scenario",
    ) -> Self:
        """Validate a scenario given as nested mappings; raises :class:`ScenarioError`."""
        base = (base or Path.cwd()).resolve()
        if not isinstance(raw, Mapping):
            raise ScenarioError([Problem("scenario", "is not a table of keys")], origin)
        data, problems = apply_overrides(normalise(raw), overrides or {})
        scenario: Self | None = None
        try:
            scenario = cls.model_validate(data)
        except ValidationError as error:
            problems += problems_from(error, ScenarioModel)
        reported = {problem.field for problem in problems}
        # Names are checked even where other keys are wrong, so that the user sees all at once.
        names = name_problems(data, Registry.discover(), Catalog(base=base))
        problems += [problem for problem in names if problem.field not in reported]
        if problems or scenario is None:
            raise ScenarioError(problems, origin)
        scenario._base = base
        return scenario

    @classmethod
    def from_cube(cls, path: str | Path, overrides: Mapping[str, Any] | None = None) -> Self:
        """Read back the scenario a cube was made from."""
        from hcss_twin.cube.reader import scenario_text

        return cls.from_dict(json.loads(scenario_text(path)), overrides, origin=str(path))

    def to_json(self) -> str:
        """Serialise with every default filled in; :meth:`load` reads it from a ``.json`` file."""
        return self.model_dump_json(indent=1)


def _locate(source: str | Path) -> Path:
    path = Path(source).expanduser()
    if path.is_file():
        return path
    catalog = Catalog()
    try:
        return catalog.find(str(source), "scenarios", ".toml")
    except CatalogError as error:
        choices = choose_from(str(source), catalog.names("scenarios", ".toml"))
        message = f"no such file, and no shipped scenario of that name; {choices}"
        raise ScenarioError([Problem("file", message)], str(source)) from error


def _parse_toml(text: str, origin: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError([Problem("file", f"not valid TOML: {error}")], origin) from error
