"""Provenance attributes of a cube, and their comparison with the current environment."""

from __future__ import annotations

import hashlib
import importlib.util
import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.environment import installed_version, versions
from hcss_twin.core.errors import CubeError, ProviderError
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.core.stored_files import StoredFiles, packed
from hcss_twin.cube.header import FORMAT_ATTRIBUTE, SCENARIO_ATTRIBUTE
from hcss_twin.plan.description import describe_particles, describe_providers
from hcss_twin.plan.plan import Plan
from hcss_twin.providers.registry.checks import kept_check
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.registry import Registry

if TYPE_CHECKING:
    from hcss_twin.engine.tables.radiance_tables import RadianceTables

LAWS = "hcss_provider_laws"
"""Attribute of cubes made with providers of other packages: laws of the conformance kit by outcome."""

VERSIONS, PROVIDERS, FILES = "hcss_versions", "hcss_providers", "hcss_files_sha256"

STORED = "hcss_input_files"
"""Attribute with the small files of the user that were read."""

HERE = "./"
"""First letters of the name of a recorded file below the folder of the scenario, as catalog names have none."""

PACKAGE = "package:"
"""First letters of the name of a recorded file that a package ships, by its path from the folder of the package."""

CERTIFICATE = (
    "hcss_certificate",
    "hcss_accuracy_achieved",
    "hcss_accuracy_achieved_kelvin",
    "hcss_certificate_terms",
    "hcss_certificate_pixels",
    "hcss_certificate_strata",
    "hcss_beyond_accuracy",
    "hcss_left_out",
    "hcss_error_budget",
    "hcss_monte_carlo",
)
"""Certificate attributes, which a verification does not recompute because it compares all pixels."""

CLEAN_CERTIFICATE = "hcss_clean_certificate"
"""Attribute in which a sensor cube quotes the certificate of the clean cube."""


def provenance(plan: Plan, tables: RadianceTables | None) -> dict[str, str | float | int]:
    """Global attributes: scenario, seed, versions, plugin distributions, hashes of the files used.

    Call it after the tables are compiled, because files are read on demand.
    """
    scenario = plan.scenario
    attributes: dict[str, str | float | int] = {
        "title": scenario.title or "Simulated infrared image sequence of clouds over sea",
        "summary": _summary(plan),
        SCENARIO_ATTRIBUTE: scenario.to_json(),
        "hcss_seed": str(scenario.seed),
        VERSIONS: json.dumps(plan.catalog.shelf.versions()),
        PROVIDERS: json.dumps(describe_providers(plan.assembly.entries)),
        FILES: json.dumps(recorded_files(plan.catalog, json.loads(scenario.to_json()))),
        "hcss_filled_in": json.dumps([_as_stored(item.as_dict()) for item in plan.filled_in]),
        "hcss_skipped": json.dumps([vars(item) for item in plan.omissions]),
        "hcss_particles": json.dumps([describe_particles(layer) for layer in plan.layers]),
        "hcss_notes": json.dumps(plan.notes),
    }
    attributes |= stored_attribute(plan.catalog, scenario.output.store_inputs)
    laws = _laws_of_plugins(plan)
    if laws:
        attributes[LAWS] = json.dumps(laws)
    if plan.needs_radiance:
        attributes["hcss_accuracy_requested"] = plan.accuracy.relative
    if plan.needs_radiance and plan.accuracy.kelvin is not None:
        attributes["hcss_accuracy_requested_kelvin"] = plan.accuracy.kelvin
    wave_height = getattr(plan.assembly.sea, "significant_wave_height_m", None)
    if wave_height is not None:
        attributes["hcss_significant_wave_height_m"] = float(wave_height)
    attributes |= {f"hcss_{name}": json.dumps(value) for name, value in plan.light.described().items()}
    if tables is not None:
        attributes["hcss_table_error_estimated"] = tables.estimated_error
        attributes["hcss_table_errors"] = json.dumps(vars(tables.errors))
        attributes["hcss_wavenumbers_used"] = int(tables.spectrum.nodes.wavenumber_cm1.size)
        attributes["hcss_wavenumbers_known"] = tables.spectrum.dense
    return attributes


def recorded_files(catalog: Catalog, scenario: Mapping[str, Any]) -> dict[str, str]:
    """Return SHA-256 of the files that a catalog opened, by names that tell nothing of the folders of a machine.

    They are catalog names, for files of plugins paths from the folder of their package, and for files of the user paths
    from the folder of the scenario, where they are below it or the scenario names them so; other paths are absolute.
    """
    base = catalog.base.resolve()
    given = {str((base / text).resolve()): text for text in _relative_paths(scenario)}
    return dict(sorted((_recorded_name(name, base, given), digest) for name, digest in catalog.used.items()))


def _recorded_name(name: str, base: Path, given: Mapping[str, str]) -> str:
    path = Path(name)
    if not path.is_absolute():
        return name
    if path.is_relative_to(base):
        return HERE + path.relative_to(base).as_posix()
    if name in given:
        return HERE + PurePath(given[name]).as_posix()
    packages = [folder for folder in path.parents if (folder / "__init__.py").is_file()]
    if packages and _folder_of_package(packages[-1].name) == packages[-1]:
        return PACKAGE + path.relative_to(packages[-1].parent).as_posix()
    return name


def _folder_of_package(name: str) -> Path | None:
    """Return where a package is installed, without importing it."""
    try:
        spec = importlib.util.find_spec(name) if name.isidentifier() else None
    except (ImportError, ValueError):
        return None
    return None if spec is None or spec.origin is None else Path(spec.origin).resolve().parent


def _relative_paths(scenario: Mapping[str, Any]) -> Iterator[str]:
    """Yield the values of a scenario that may be paths from its folder to files outside it."""
    for _, text in leaves(scenario):
        if isinstance(text, str) and PurePath(text).parts[:1] == ("..",):
            yield text


def stored_attribute(catalog: Catalog, wanted: bool, before: Any = None) -> dict[str, str]:
    """Return the attribute with the small files of the user that a catalog opened, and those stored before, if any."""
    if not wanted:
        return {}
    used = catalog.used
    paths = {name: path for name, path in catalog.shelf.user_files.items() if name in used}
    if not paths and before is None:
        return {}
    return {STORED: json.dumps(json.loads(str(before or "{}")) | packed(paths, used), sort_keys=True)}


def _as_stored(filled_in: Mapping[str, str]) -> dict[str, str]:
    """Return a value that was filled in with the field as stored scenarios have it, which list their cloud layers."""
    return {**filled_in, "field": re.sub(r"^clouds\.(?!layers\b)", "clouds.layers[0].", filled_in["field"])}


def _laws_of_plugins(plan: Plan) -> dict[str, Any]:
    """Return how providers of other packages fared with the laws of the conformance kit: in this run, and checked."""
    probed = {probe.label: probe for probe in plan.probes}
    laws: dict[str, Any] = {}
    for label, built in plan.assembly.built.items():
        if not built.entry.is_own:
            in_run = probed.get(label)
            checked = kept_check(built.entry, built.parameters, plan.catalog.shelf)
            laws[label] = {
                "probes": "none" if in_run is None else in_run.count,
                "hcss check": "not checked" if checked is None else checked,
            }
    return laws


def _summary(plan: Plan) -> str:
    names = [layer.name for layer in reversed(plan.layers)]
    clouds = f"{' over '.join(names)} clouds" if names else "clear sky"
    bands = ", ".join(f"{band.lower_um:g}-{band.upper_um:g} um" for band in plan.bands)
    points = plan.samples_per_pixel
    averaged = f", each pixel the mean of {points} x {points} points" if points > 1 else ""
    below = " and ".join(name for surfaces in plan.assembly.surfaces for name in surfaces.names) or "sea"
    return (
        f"Band-integrated radiance at the sensor of {clouds} over {below} in {bands}{averaged}, computed by hcss_twin "
        f"with the radiance model '{plan.scenario.radiance.model}'."
    )


def leaves(value: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Yield values of nested tables and lists by dotted key; empty tables and lists count as values."""
    if isinstance(value, dict) and value:
        for name, item in value.items():
            yield from leaves(item, f"{key}.{name}" if key else name)
    elif isinstance(value, list) and value:
        for index, item in enumerate(value):
            yield from leaves(item, f"{key}[{index}]")
    else:
        yield key, value


@dataclass(frozen=True)
class Change:
    """A difference from the record in the cube.

    Attributes
    ----------
    what : str
        A library, a kind of provider, a key of the scenario, a dimension.
    recorded, now : str
        Value in the cube, and in its recomputation.
    """

    what: str
    recorded: str
    now: str


@dataclass(frozen=True)
class FileChange:
    """A file that differs from the one used for the cube.

    Attributes
    ----------
    name : str
        Catalog name or path, as recorded in the cube.
    state : str
        ``changed``, ``missing``, ``no longer read``, ``not read before``, or ``not read`` because it is not in
        one of the allowed folders.
    recorded_sha256, now_sha256 : str or None
        None if there is no such file.
    now_at : str
        Path of the current file.
    """

    name: str
    state: str
    recorded_sha256: str | None
    now_sha256: str | None
    now_at: str


@dataclass(frozen=True)
class Recorded:
    """Provenance of a cube.

    Attributes
    ----------
    attributes : mapping
        Global attributes of the file.
    scenario : mapping
        In JSON form.
    versions : mapping of str to str
        Versions by distribution.
    providers : mapping
        ``name``, ``distribution`` and ``version`` by kind; clouds of several layers are numbered.
    files : mapping of str to str
        SHA-256 by catalog name or absolute path, in ``base`` where the cube records it relative to its scenario.
    base : Path
        Folder in which the scenario's relative paths refer to the recorded files; else the working folder.
    names : mapping of str to str
        As recorded, of the names in ``files``.
    """

    attributes: Mapping[str, Any]
    scenario: Mapping[str, Any]
    versions: Mapping[str, str]
    providers: Mapping[str, Mapping[str, str]]
    files: Mapping[str, str]
    base: Path
    names: Mapping[str, str]

    @classmethod
    def of(
        cls, attributes: Mapping[str, Any], path: str, base: Path | None = None, near: Iterable[Path] = ()
    ) -> Recorded:
        """Read the provenance attributes of a cube.

        Parameters
        ----------
        attributes : mapping
            Global attributes of the file.
        path : str
            Of the file, for messages; its folder is searched for the recorded files.
        base : Path, optional
            Folder of the scenario's relative paths.
        near : iterable of Path
            Other files or folders in which the recorded files may be.

        Raises
        ------
        CubeError
            If one is missing or malformed.
        """
        tables: list[dict[str, Any]] = []
        for name in (SCENARIO_ATTRIBUTE, VERSIONS, PROVIDERS, FILES):
            if not isinstance(attributes.get(name), str):
                raise CubeError(f"{path} carries no {name}; this global attribute is needed to recompute a cube")
            try:
                table = json.loads(attributes[name])
            except (ValueError, RecursionError) as error:
                raise CubeError(f"{path}: the global attribute {name} is not valid JSON: {error}") from error
            of_texts = name == SCENARIO_ATTRIBUTE or _is_table_of_texts(table, nested=name == PROVIDERS)
            if not isinstance(table, dict) or not of_texts:
                raise CubeError(f"{path}: the global attribute {name} is malformed")
            tables.append(table)
        scenario, versions, providers, files = tables
        if base is None:
            base = _base_of(scenario, files, [Path(path).parent, Path.cwd(), *near])
        names = {_absolute(name, base): name for name in files}
        absolute = {name: files[recorded] for name, recorded in names.items()}
        return cls(attributes, scenario, versions, providers, absolute, base, names)

    def stored_files(self, cube: str) -> AbstractContextManager[StoredFiles]:
        """Unpack the input files that the cube stores as long as they are needed; raises CubeError if altered."""
        return StoredFiles.unpacked(self.attributes.get(STORED), self.files, cube)

    def version_changes(self) -> tuple[Change, ...]:
        """Return the distributions with another installed version."""
        now = versions()
        changes = (
            Change(name, version, now.get(name) or installed_version(name)) for name, version in self.versions.items()
        )
        return tuple(change for change in changes if change.now != change.recorded)

    def provider_changes(self, entries: Mapping[str, Entry] | None) -> tuple[Change, ...]:
        """Return the providers that are missing or come from another package or version.

        Parameters
        ----------
        entries : mapping of str to Entry or None
            Providers of the recomputation, by kind; None if missing.
        """
        registry, changes = Registry.discover(), []
        for kind, recorded in self.providers.items():
            name, distribution = recorded["name"], recorded["distribution"]
            entry = (entries or {}).get(kind)
            try:
                entry = entry or registry.resolve(kind.partition("[")[0], f"{distribution}/{name}")
                now = f"{entry.name} of {entry.origin}"
            except (ProviderError, ValueError):
                version = installed_version(distribution)
                absence = "is not installed" if version == "not installed" else f"{version} does not bring it"
                now = f"{distribution} {absence}"
            changes.append(Change(kind, f"{name} of {distribution} {recorded['version']}", now))
        return tuple(change for change in changes if change.now != change.recorded)

    def file_changes(self, used: Mapping[str, str] | None, shelf: ResultCache) -> tuple[FileChange, ...]:
        """Return the files that differ from those used for the cube.

        Parameters
        ----------
        used : mapping of str to str or None
            SHA-256 of the files that the recomputation read, by name; None if unknown.
        shelf : ResultCache
            States which of the user's files may be read.
        """
        new = {name: digest for name, digest in (used or {}).items() if name not in self.files}
        changes = []
        for name, recorded in self.files.items():
            at, now, state = name, (used or {}).get(name), "changed"
            # A user's file of the same name elsewhere was read instead.
            alike = [file for file in new if Path(file).is_absolute() and Path(file).name == Path(name).name]
            if now is None and Path(name).is_absolute() and len(alike) == 1:
                at, now = alike[0], new.pop(alike[0])
            if used is None and shelf.stored is not None and name in shelf.stored.paths:
                continue
            if now is None and _is_elsewhere(name) and not shelf.may_read(Path(name)):
                state = "not read, because it is not under the cube's folder; name it with --data"
            elif now is None:
                now = _digest(name)
                state = "missing" if now is None else state if used is None else "no longer read"
            if now != recorded or state != "changed":
                own = self.names[name]
                changes.append(FileChange(own, state, recorded, now, own if now is None else at))
        changes += [FileChange(name, "not read before", None, digest, name) for name, digest in new.items()]
        return tuple(changes)

    def attribute_changes(self, now: Mapping[str, Any]) -> tuple[Change, ...]:
        """Return scenario keys and engine attributes that differ in the recomputation.

        Parameters
        ----------
        now : mapping
            Global attributes of the recomputation.
        """
        repeated = (
            SCENARIO_ATTRIBUTE,
            VERSIONS,
            PROVIDERS,
            FILES,
            STORED,
            LAWS,
            FORMAT_ATTRIBUTE,
            *CERTIFICATE,
            CLEAN_CERTIFICATE,
        )
        before, after = dict(leaves(self.scenario)), dict(leaves(json.loads(now[SCENARIO_ATTRIBUTE])))
        pairs = [(f"scenario key {key}", before.get(key), after.get(key)) for key in dict.fromkeys((*before, *after))]
        pairs += [
            (name, self.attributes.get(name), now.get(name))
            for name in dict.fromkeys((*self.attributes, *now))
            if name.startswith("hcss_") and name not in repeated
        ]
        return tuple(
            Change(name, _short(recorded), _short(value))
            for name, recorded, value in pairs
            if not np.array_equal(recorded, value)  # type: ignore[arg-type]
        )


def _absolute(name: str, base: Path) -> str:
    if name.startswith(PACKAGE):
        package, _, rest = name.removeprefix(PACKAGE).partition("/")
        folder = _folder_of_package(package)
        return name if folder is None else os.path.realpath(folder / rest)
    return os.path.realpath(base / name) if name.startswith(HERE) else name


def _base_of(scenario: Mapping[str, Any], files: Iterable[str], folders: Iterable[Path]) -> Path:
    """Return the folder in which the scenario's relative paths refer to the recorded files; else the working folder."""
    relative = [name for name in files if name.startswith(HERE)]
    folders = [folder for folder in folders if folder.is_dir()] if relative else []
    below = [child for folder in dict.fromkeys(folders) for child in _folders_in(folder)]
    for several in (*([folder] for folder in folders), below):
        known = [folder for folder in several if any(_is_file(folder / name) for name in relative)]
        if len(known) == 1:
            return known[0]
    found: set[Path] = set()
    for _, text in leaves(scenario):
        parts = PurePath(text).parts if isinstance(text, str) else ()
        for file in map(Path, files):  # of cubes that record absolute paths
            if 0 < len(parts) < len(file.parts) and file.is_absolute() and file.parts[-len(parts) :] == parts:
                found.add(file.parents[len(parts) - 1])
    known = [folder for folder in found if folder.is_dir()]
    return known[0] if len(known) == 1 else Path.cwd()


def _folders_in(folder: Path) -> list[Path]:
    try:
        return [child for child in folder.iterdir() if child.is_dir()]
    except OSError:  # not readable
        return []


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _is_table_of_texts(table: Any, nested: bool) -> bool:
    if nested and isinstance(table, dict):
        wanted = {"name", "distribution", "version"}
        return all(_is_table_of_texts(entry, False) and wanted <= set(entry) for entry in table.values())
    return isinstance(table, dict) and all(isinstance(text, str) for text in table.values())


def _is_elsewhere(name: str) -> bool:
    """Whether a recorded file is no catalog file, and exists."""
    return Path(name).is_absolute() and _is_file(Path(name))


def _digest(name: str) -> str | None:
    """Hash the current version of a recorded file; None if it is missing or its name points outside the catalog."""
    path = Path(name) if Path(name).is_absolute() else Catalog().root / name
    if ".." in path.parts:
        return None
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else None
    except (OSError, ValueError):
        return None


def _short(value: Any) -> str:
    text = "none" if value is None else str(value)
    return text if len(text) <= 120 else f"{text[:117]}..."
