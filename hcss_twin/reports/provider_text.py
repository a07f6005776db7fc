"""Description of a provider: its origin, its scenario parameters and its errors."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Any

from hcss_twin.core.errors import ProviderNameError, choose_from
from hcss_twin.reports.model_error_text import stated_error_lines, stated_errors

if TYPE_CHECKING:
    from hcss_twin.providers.registry.registry import Registry


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
        raise ProviderNameError(f"no provider is named '{name}'; {choose_from(name, names)}")
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
    for each in parameters:
        default = f"default {each['default']}".replace("default **required**", "required") if each["default"] else ""
        facts = ", ".join(fact for fact in (each["type"], each["allowed"], default) if fact)
        description = textwrap.indent(textwrap.fill(each["description"], 92), " " * 8)
        lines += [f"    {each['name']}  ({facts})", *([description] if description else [])]
    lines += stated_error_lines(provider["model_errors"])
    return "\n".join(lines).replace("`", "")
