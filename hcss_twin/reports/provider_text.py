"""Description of a provider: its origin, its scenario parameters and its errors."""

from __future__ import annotations

import inspect
import textwrap
from dataclasses import asdict
from itertools import groupby
from typing import TYPE_CHECKING, Any

from hcss_twin.core.errors import ProviderNameError, choose_from
from hcss_twin.core.own_packages import PROVIDERS, comes_with

if TYPE_CHECKING:
    from hcss_twin.providers.registry.registry import Registry

_SUNLIGHT = {None: "", True: "with sunlight", False: "without sunlight"}


def stated_errors(provider: type) -> list[dict[str, Any]] | None:
    """Return the fields of each ``ModelError`` of a provider.

    Returns
    -------
    list of dict or None
        Empty if it states none; None if the figures belong to an instance, and so to a scene.
    """
    method = inspect.getattr_static(provider, "model_errors", None)
    if method is None:
        return []
    if not isinstance(method, staticmethod | classmethod):
        return None
    return [asdict(error) | {"zenith_deg": list(error.zenith_deg)} for error in provider.model_errors()]  # type: ignore[attr-defined]


def stated_error_lines(errors: list[dict[str, Any]] | None) -> list[str]:
    """Return stated errors as text: each cause and reference once, then a line for each band, path and column."""
    if errors is None:
        return ["  stated error: depends on the scene, see hcss plan"]
    lines = ["  stated error:"] if errors else []
    for (name, source, condition, command), alike in groupby(
        errors, lambda error: tuple(error[key] for key in ("name", "source", "condition", "command"))
    ):
        lines += [
            f"    {name}, against {source}",
            f"      {'; '.join(filter(None, (condition, command or 'from notes')))}",
        ]
        for error in alike:
            sizes = [f"{100.0 * error['relative']:.3g} %"] if error["relative"] is not None else []
            sizes += [f"{error['kelvin']:.3g} K"] if error["kelvin"] is not None else []
            low, high = error["zenith_deg"]
            path = "" if error["path"] == "up" else f"path {error['path']}"
            view = "" if (low, high) == (0.0, 90.0) else f"zenith {low:g}-{high:g} deg"
            of = ", ".join(filter(None, (path, error["column"], _SUNLIGHT[error["sunlight"]], view)))
            um = f"{error['lower_um']:.3g}-{error['upper_um']:.3g} um"
            lines.append(f"      {um:<14}{', '.join(sizes):<18}{error['statistic']:<16}{of}".rstrip())
    return lines


_SELECTED_BY = {
    "clouds": "clouds.generator",
    "sea": "sea.model",
    "optics": "optics.provider",
    "atmosphere": "atmosphere.provider",
    "radiance": "radiance.model",
    "elements": "elements.provider",
    "surfaces": "surfaces.provider",
    "variables": "output.derived.provider",
    "sensors": "sensor.model",
}


def described(registry: Registry, name: str) -> list[dict[str, Any]]:
    """Describe the providers with this name, of any kind.

    Parameters
    ----------
    registry : Registry
    name : str
        Plain, or with its distribution: ``"hcss-my-gas/my-gas"``.

    Returns
    -------
    list of dict
        ``kind``, ``name``, ``distribution``, ``version``, ``summary``, ``references``, ``selected_by`` (key of the
        scenario), ``parameters``: dicts of ``name``, ``type``, ``allowed``, ``default``, ``description``, and
        ``model_errors``, as of :func:`stated_errors`.

    Raises
    ------
    ProviderNameError
        If there is none.
    ProviderError
        If its parameters or its class cannot be imported.
    """
    from hcss_twin.scenario.reference import field_text

    entries = [entry for entry in registry.entries() if name in (entry.name, entry.qualified_name)]
    if not entries:
        names = sorted({entry.name for entry in registry.entries()})
        text = f"no provider is named '{name}'; {choose_from(name, names)}"
        package = comes_with(PROVIDERS, name.rpartition("/")[2])
        raise ProviderNameError(f"{text}. {package}" if package else text)
    descriptions = []
    for entry in entries:
        model = registry.parameters_model(entry)
        fields = model.model_fields if model is not None else {}
        descriptions.append(
            {
                "kind": entry.kind.human,
                **{key: getattr(entry, key) for key in ("name", "distribution", "version", "summary")},
                "references": list(entry.references),
                "selected_by": _SELECTED_BY[str(entry.kind)],
                "parameters": [vars(field_text(key, field)) for key, field in fields.items()],
                "model_errors": stated_errors(registry.provider_class(entry)),
            }
        )
    return descriptions


def provider_text(provider: dict[str, Any]) -> str:
    """Format one provider from :func:`described` for a terminal."""
    parameters = provider["parameters"]
    section = provider["selected_by"].partition(".")[0]
    lines = [
        f"{provider['kind']} {provider['name']}  [{provider['distribution']} {provider['version']}]",
        f"  {provider['summary']}",
        f'  selected by {provider["selected_by"]} = "{provider["name"]}"',
        *(f"  reference: {reference}" for reference in provider["references"]),
        f"  {section}.parameters:" if parameters else "  It has no parameters.",
    ]
    for parameter in parameters:
        default = (
            f"default {parameter['default']}".replace("default **required**", "required")
            if parameter["default"]
            else ""
        )
        facts = ", ".join(fact for fact in (parameter["type"], parameter["allowed"], default) if fact)
        description = textwrap.indent(textwrap.fill(parameter["description"], 92), " " * 8)
        lines += [f"    {parameter['name']}  ({facts})", *([description] if description else [])]
    lines += stated_error_lines(provider["model_errors"])
    return "\n".join(lines).replace("`", "")
