"""Scenario reference: keys of the scenario models, bands, units, and parameters of the built-in providers."""

from __future__ import annotations

import inspect
import re
import sys
import tomllib
import typing
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.own_packages import SECTIONS
from hcss_twin.core.units import UNITS
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.scenario.bands import named_bands
from hcss_twin.scenario.clouds import Layer
from hcss_twin.scenario.models import ScenarioModel
from hcss_twin.scenario.reference import field_text, is_model

PAGE = "reference/scenario.md"

PLUGINS = Path(__file__).parents[2] / "plugins"

_INTRODUCTION = """# Scenario reference

{GENERATED}

A scenario is a TOML file. Only `time` and `place` are required. Unknown keys and impossible values are errors, all
reported at once (`hcss validate`). `hcss plugins` lists generators, models and providers that a key may name.

```toml
time = 2024-04-20T12:30:00+10:00
place = {latitude = 35.0, longitude = 150.0}
clouds.type = "stratus"
```

**Numbers** are in SI units, angles in degrees, or text with a [unit](#units): `pixel_size = "1 km"`,
`temperature = "18 degC"`. `0..1` are limits, `>0..1` without the first. Keys without a default may be left out.

**Directions** and coordinates follow the [conventions](conventions.md).

**Other sections:** [`[sweep]`](../how-to/sweeps.md), [`[[sensors]]`](../how-to/sweeps.md#one-sky-several-sensors),
[`[uncertain]`](../how-to/uncertainty.md).

**From the command line:** `hcss run stratus --set view.zenith=40 --set 'bands=["mwir", [3.4, 4.1]]'`. Another provider
removes the `parameters` of the one it replaces; set its own after it:
`--set clouds.generator=fractal --set clouds.parameters.H=0.3`.
"""


_LONG = 5
"""Words of a description from which it is given once, where the key comes first."""


def lines(generated: str) -> Iterator[str]:
    """Yield the page; one line refers to the section that has keys with the same meaning first."""
    place, places, header = "", dict[tuple[str, str], tuple[str, str]](), ""
    alike: dict[str, list[str]] = {}
    for line in (*_lines(generated), ""):
        row = re.fullmatch(r"\| `(\w+)` \|.*\| ([^|]*) \| ([^|]+) \|", line)
        if line.startswith(_HEADER):
            header = line
        elif row is None:
            yield from (f"\nAs for {first}: {', '.join(keys)}." for first, keys in alike.items())
            alike = {}
            for part in line.split("\n"):
                if part.startswith("#"):
                    place = part.lstrip("# ")
            yield line
        else:
            key, default, meaning = row.groups()
            first, known = places.setdefault((key, meaning), (place, default))
            if first == place or len(meaning.split()) < _LONG:
                yield from filter(None, (header, line))
                header = ""
            else:
                differs = "" if known == default else f" (default {default or 'none'})"
                alike.setdefault(first, []).append(f"`{key}`{differs}")


_HEADER = "| key |"


def _lines(generated: str) -> Iterator[str]:
    yield _INTRODUCTION.replace("{GENERATED}", generated)
    yield "## Top level\n"
    yield from _table(ScenarioModel, skip_models=True)
    for name, field in ScenarioModel.model_fields.items():
        model = _model_of(field) or _optional_model(field)
        if model is None or name == "bands":
            continue
        yield f"\n## `[{name}]`\n"
        yield f"{inspect.cleandoc(model.__doc__ or '')}\n"
        if name == "clouds":
            yield (
                'The keys of a single layer go in `[clouds]` itself (`clouds.type = "stratus"`), those of several in '
                "`[[clouds.layers]]`.\n"
            )
            yield from _table(Layer)
        else:
            yield from _table(model)
            for key, each in model.model_fields.items():
                part = _model_of(each) or _optional_model(each)
                if part is not None:
                    yield f"\n### `[{name}.{key}]`\n"
                    yield f"{inspect.cleandoc(part.__doc__ or '')}\n"
                    yield from _table(part)
    yield from _plugins()
    yield from _bands()
    yield from _units()
    yield from _providers()


def _plugins() -> Iterator[str]:
    """Yield the sections of the packages in ``plugins/``, whether these are installed or not."""
    packages = sorted(set(SECTIONS.values()))
    yield "\n## Sections of plugins\n"
    yield (
        "They need the package in their heading. `[camera]` follows from [`[instrument]`](#instrument) if there is one."
    )
    for package in packages:
        for name, model in _models_of(package):
            yield f"\n### `[{name}]` ({package})\n"
            yield f"{inspect.cleandoc(model.__doc__ or '')}\n"
            yield from _table(model)
            for key, field in model.model_fields.items():
                part = next(filter(is_model, typing.get_args(field.annotation)), None)
                if part is not None:
                    yield f"\n#### `[[{name}.{key}]]`\n"
                    yield f"{inspect.cleandoc(part.__doc__ or '')}\n"
                    yield from _table(part)


def _models_of(package: str) -> Iterator[tuple[str, type[BaseModel]]]:
    """Yield names and models of the sections of a package, as its project file names them."""
    folder = PLUGINS / package
    project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    if str(folder / "src") not in sys.path:
        sys.path.append(str(folder / "src"))
    for module in project["entry-points"]["hcss_twin.sections"].values():
        for spec in import_module(module).hcss_sections():
            home, _, model = spec.model.partition(":")
            yield spec.name, getattr(import_module(home), model)


def _bands() -> Iterator[str]:
    yield "\n## Bands\n"
    yield (
        "`bands` lists names from the table below, limits in um (`[3.4, 4.1]`, or with a name "
        '`{name = "narrow", limits = [3.4, 4.1]}`), Gaussian responses (`{name = "g", center_um = 4.0, '
        "fwhm_um = 0.2}`, "
        "peak 1, truncated at 1e-4, 1.82 widths from the centre), or "
        'measured responses (`{name = "channel 7", response = "channel7.csv"}`).\n'
    )
    yield (
        "A response file is text as agencies publish it: rows of numbers below lines that label them. The labels "
        "name the column of wavelength or wavenumber (without labels the first) and its unit; else `unit` does, "
        "or the numbers: um up to 100, nm from 200 under a label that says wavelength. The response is the only "
        "other column, the only one labelled as response, RSR, SRF or transmission, the one with the name of the "
        "band, or `column` (label or number); a fraction of 1, or in percent if label, percent signs or a "
        "peak above 1.5 say so. Rows may begin with names of bands, or with detectors, which are averaged. "
        "Negative values down to 1 % of the peak count as 0, -99 (-999, ...) as missing. "
        "`hcss plan` states how a file was read.\n"
    )
    yield "| name | um | |\n|---|---|---|"
    for name, band in named_bands(Catalog()).items():
        low, high = band["limits_um"]
        yield f"| `{name}` | {low:g}-{high:g} | {band['description']} |"


def _units() -> Iterator[str]:
    yield "\n## Units\n\nThe first unit is that of plain numbers.\n\n| quantity | units of text |\n|---|---|"
    for dimension, units in UNITS.items():
        names = [name for name in units if name]
        plain = ["1"] if "" in units else []
        yield f"| {dimension} | {', '.join((*plain, *(f'`{name}`' for name in names)))} |"


def _providers() -> Iterator[str]:
    yield (
        "\n## Parameters of the shipped providers\n\n"
        "They belong in the `parameters` of the section that selects the provider. `hcss plugins NAME` lists those of "
        "plugins.\n"
    )
    # The page must not depend on what else is installed.
    registry = Registry.defaults_only()
    for entry in registry.entries():
        yield f"\n### {entry.kind.human} `{entry.name}`\n"
        yield f"{entry.summary[0].upper()}{entry.summary[1:]}.\n"
        model = registry.parameters_model(entry)
        if model is None or not model.model_fields:
            yield "No parameters."
        else:
            yield from _table(model)


def _table(model: type[BaseModel], skip_models: bool = False) -> Iterator[str]:
    yield f"{_HEADER} value | default | meaning |\n|---|---|---|---|"
    for name, field in model.model_fields.items():
        if skip_models and (_model_of(field) or _optional_model(field)) is not None and name != "bands":
            continue
        text = field_text(name, field)
        allowed = re.sub(r"(?:≥ |(> ?))(\S+), (?:≤ |(< ?))(\S+)", _range, text.allowed)
        value = allowed or text.type if text.type == "number" else ", ".join(filter(None, (text.type, allowed)))
        choices = re.findall(r'`("[^`]+")`', text.type)
        if choices and all(choice in text.description for choice in choices):
            value = "" if text.type.startswith("`") else "number, or text"
        value = _shorter(value)
        default = "" if text.default in ("none", "empty") else text.default
        cells = (f"`{name}`", value, default, text.description.replace(" (see `hcss plugins`)", ""))
        yield f"| {' | '.join(cells)} |"


def _shorter(value: str) -> str:
    """Return a type and its limits without the length of lists and texts, and without words that commas replace."""
    plain = re.sub(r", length ≤ \d+", "", value).replace("whole number", "integer")
    return re.sub(r",? or ", ", ", plain)


def _range(bounds: re.Match[str]) -> str:
    """Return bounds as 0..1, with a sign before one that is excluded."""
    above, low, below, high = bounds.groups()
    return f"{'>' if above else ''}{low}..{'<' if below else ''}{high}"


def _model_of(field: FieldInfo) -> type[BaseModel] | None:
    annotation: Any = field.annotation
    return annotation if is_model(annotation) else None


def _optional_model(field: FieldInfo) -> type[BaseModel] | None:
    """Return the model of an optional section."""
    choices = typing.get_args(field.annotation) if type(None) in typing.get_args(field.annotation) else ()
    return next(filter(is_model, choices), None)
