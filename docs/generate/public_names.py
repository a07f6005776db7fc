"""List of the public names: all that packages, ours included, may import from ``hcss_twin``, with their units."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator
from importlib import import_module
from typing import Any, NamedTuple

from hcss_twin import providers

PAGE = "reference/public-names.md"

MOST = 180
"""Names on the page at most."""

_INTRODUCTION = """# Public names

{GENERATED}

Packages import from `hcss_twin` only these names. Those of `hcss_twin` and `hcss_twin.providers` stay as the [provider
API](provider-api.md) promises; all others may change with any release, which the change log announces. **Ours alone**
marks modules that only packages of this repository need. In brackets: units of arguments, attributes and results.
"""


class Topic(NamedTuple):
    """Public modules about one thing; ``ours``: only packages of this repository need them."""

    title: str
    ours: bool
    modules: tuple[str, ...]


TOPICS = (
    Topic("Scenes and cubes", False, ("hcss_twin", "hcss_twin.cube.frame_selection", "hcss_twin.engine.simulate",
         "hcss_twin.engine.certificate.certificate")),
    Topic("Providers", False, ("hcss_twin.providers", "hcss_twin.providers.registry.registry",
         "hcss_twin.providers.registry.discovery")),
    Topic("Laws of providers", False, ("hcss_twin.laws", "hcss_twin.laws.samples")),
    Topic("Commands", False, ("hcss_twin.cli.options",)),
    Topic(
        "Reports",
        False,
        ("hcss_twin.reports.page", "hcss_twin.reports.tables", "hcss_twin.reports.figures",
         "hcss_twin.reports.provenance", "hcss_twin.reports.power_spectrum", "hcss_twin.reports.cube_frames",
         "hcss_twin.reports.cloud_volume"),
    ),
    Topic(
        "Arguments, files and compiled loops",
        False,
        ("hcss_twin.core.arguments", "hcss_twin.core.cache", "hcss_twin.core.environment",
         "hcss_twin.core.errors", "hcss_twin.core.files",
         "hcss_twin.core.json_numbers", "hcss_twin.core.kernels", "hcss_twin.core.reading",
         "hcss_twin.core.result_cache"),
    ),
    Topic("Sections of scenarios", False, ("hcss_twin.core.units",)),
    Topic("Geometry", False, ("hcss_twin.physics.geodesy", "hcss_twin.physics.sun")),
    Topic(
        "Image geometries",
        False,
        ("hcss_twin.plan.rays", "hcss_twin.plan.assembly", "hcss_twin.plan.air_over_field",
         "hcss_twin.plan.combinations",
         "hcss_twin.cube.variables"),
    ),
    Topic("Light between columns", False, ("hcss_twin.providers.light", "hcss_twin.engine.stages.light")),
    Topic(
        "The plan of a scene",
        True,
        ("hcss_twin.plan.plan", "hcss_twin.plan.few_columns", "hcss_twin.scenario.bands"),
    ),
    Topic(
        "Frames in parts",
        True,
        ("hcss_twin.engine.compile", "hcss_twin.engine.tables.radiance_tables", "hcss_twin.engine.tables.look_up",
         "hcss_twin.engine.parts", "hcss_twin.engine.cluster", "hcss_twin.engine.stream", "hcss_twin.engine.clouds",
         "hcss_twin.engine.scene_around", "hcss_twin.engine.stages.element_paths"),
    ),
    Topic(
        "Sensors",
        True,
        ("hcss_twin.plan.sensor_stages",
         "hcss_twin.models.sensor.noise", "hcss_twin.models.sensor.parameters"),
    ),
    Topic(
        "Fractal clouds",
        True,
        ("hcss_twin.models.clouds.fractal.parameters", "hcss_twin.models.clouds.fractal.octaves",
         "hcss_twin.models.clouds.fractal.field",
         "hcss_twin.models.clouds.fractal.generator", "hcss_twin.models.clouds.fractal.expected_variogram"),
    ),
    Topic(
        "Images of clouds",
        True,
        ("hcss_twin.models.clouds.database", "hcss_twin.models.clouds.imagery.image",
         "hcss_twin.models.clouds.imagery.reader", "hcss_twin.models.clouds.imagery.parameters"),
    ),
    Topic(
        "Air and radiance",
        True,
        ("hcss_twin.models.atmosphere.climatology", "hcss_twin.models.atmosphere.profile_file",
         "hcss_twin.models.atmosphere.table_file",
         "hcss_twin.models.atmosphere.path_radiance", "hcss_twin.models.radiance.spectral_grid",
         "hcss_twin.models.radiance.brightness_temperature"),
    ),
)  # fmt: skip

UNITS = {
    "_m": "m", "_m1": "m-1", "_m2": "m2", "_m3": "m3", "_um": "um", "_cm1": "cm-1", "_deg": "deg", "_rad": "rad",
    "_K": "K", "_s": "s", "_m_s": "m s-1", "_rad_s": "rad s-1", "_hPa": "hPa", "_Pa": "Pa", "_au": "au", "_hz": "Hz",
    "_g_m3": "g m-3", "_kg_m3": "kg m-3", "_px": "pixels", "_pixels": "pixels",
}  # fmt: skip
"""Units of what has a name that ends so."""

_WRITTEN = {
    r"W m-2 sr-1": "W m-2 sr-1", r"(?<!W m-2 )\bsr-1\b": "sr-1", r"\bcm-1\b": "cm-1", r"\bum\b": "um", r"\bHz\b": "Hz",
    r"\b[Dd]egrees\b|\bdeg\b": "deg", r"\b[Rr]adians\b": "rad", r"\b[Mm]etres\b|\bin m\b|, m\b": "m",
    r"\b[Ss]econds\b|, s\b": "s", r"\bkelvin\b|, K\b": "K", r"\bg m-3\b": "g m-3", r"\bkm\b": "km",
}  # fmt: skip
"""Units in docstrings."""


def public() -> dict[str, tuple[str, ...]]:
    """Return the public names by their module."""
    return {name: tuple(import_module(name).__all__) for topic in TOPICS for name in topic.modules}


def count() -> int:
    """Return the number of names; those of both modules for everybody count once."""
    names = public()
    return len({*names.pop("hcss_twin"), *names.pop("hcss_twin.providers")}) + sum(map(len, names.values()))


def lines(generated: str) -> Iterator[str]:
    """Yield the page."""
    yield _INTRODUCTION.replace("{GENERATED}", generated)
    ours = sum(len(import_module(name).__all__) for topic in TOPICS if topic.ours for name in topic.modules)
    yield f"{count()} names, {ours} of them ours alone."
    for topic in TOPICS:
        yield f"\n## {topic.title}{' (ours alone)' if topic.ours else ''}"
        for name in topic.modules:
            if name == "hcss_twin.providers":
                yield f"\n`{name}`: names of the [provider reference](provider-reference.md)."
                continue
            listed = import_module(name).__all__
            if topic.ours:
                yield f"\n`{name}`: {', '.join(f'`{each}`' for each in listed)}"
                continue
            yield f"\n`{name}`:\n"
            both = [each for each in listed if name == "hcss_twin" and each in providers.__all__]
            for each in (each for each in listed if each not in both):
                about, units = described(name, each)
                yield f"* `{each}`: {about}{f' ({units})' if units else ''}"
            if both:
                shown = ", ".join(f"`{each}`" for each in both)
                yield f"* {shown}: those of the [provider reference](provider-reference.md)."


def described(module: str, name: str) -> tuple[str, str]:
    """Return the first sentence about a name, and the units of what it has, takes and returns."""
    value = getattr(import_module(module), name)
    about = _docstring(module, name, value)
    text = " ".join(about.split("\n\n")[0].split())
    first = re.split(r"(?<=[^.\d][.])\s+(?=[A-Z\"`])|(?<=\d[.])\s+(?=[A-Z])", text)[0]
    found = {unit for known in _names_in(name, value) for unit in _units_of(known)}
    found |= {unit for pattern, unit in _WRITTEN.items() if re.search(pattern, about)}
    shown = re.sub(r":\w+:`~?([^`]*)`", r"`\1`", first).replace("``", "`").replace("|", "\\|")
    return shown, ", ".join(unit for unit in dict.fromkeys((*UNITS.values(), *_WRITTEN.values())) if unit in found)


def _units_of(name: str) -> Iterator[str]:
    ends = [end for end in UNITS if name.casefold().endswith(end.casefold()) and (end != "_k" or name.endswith("_K"))]
    if ends:
        yield UNITS[max(ends, key=len)]


def _names_in(name: str, value: Any) -> Iterator[str]:
    """Yield the name and those of parameters, attributes and members."""
    yield name
    if inspect.isclass(value):
        yield from (each for each in vars(value) if not each.startswith("_"))
        for each in value.__mro__:
            yield from inspect.get_annotations(each)
        members = [each for each in vars(value).values() if inspect.isfunction(each)]
    else:
        members = [value] if inspect.isfunction(value) else []
    for member in members:
        yield from inspect.signature(member).parameters


def _docstring(module: str, name: str, value: Any) -> str:
    known = inspect.getdoc(value) if inspect.isclass(value) or inspect.isroutine(value) else None
    if known:
        return known
    if module == "hcss_twin":
        module = "hcss_twin.version"  # the only name there that is no class or function
    if module == "hcss_twin.providers":
        module = next(f"hcss_twin.{home}" for home, names in providers.HOMES.items() if name in names)
    body = ast.parse(inspect.getsource(import_module(module))).body
    for node, following in zip(body, [*body[1:], None], strict=True):
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if any(name == known for target in targets for known in _targets(target)):
            return ast.literal_eval(following.value) if isinstance(following, ast.Expr) else ""
        if isinstance(node, ast.FunctionDef) and node.name == name:  # compiled, or of another kind
            return ast.get_docstring(node) or ""
    return inspect.getdoc(value) or ""


def _targets(target: ast.expr | None) -> Iterator[str]:
    if isinstance(target, ast.Tuple):
        yield from (known for each in target.elts for known in _targets(each))
    elif isinstance(target, ast.Name):
        yield target.id
