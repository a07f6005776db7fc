"""One provider in words: where it comes from and the parameters a scenario may give it."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Any

from hcss_twin.core.errors import ProviderNameError, choose_from

if TYPE_CHECKING:
    from hcss_twin.providers.registry.registry import Registry


_SELECTED_BY = {
    "clouds": "clouds.generator",
    "sea": "sea.model",
    "optics": "optics.provider",
    "atmosphere": "atmosphere.provider",
    "radiance": "radiance.model",
    "sensors": "sensor.model",
}


def described(registry: Registry, name: str) -> list[dict[str, Any]]:
    """Describe the providers of a name, of whatever kind.

    Parameters
    ----------
    registry : Registry
    name : str
        Plain, or with its distribution: ``"hcss-my-gas/my-gas"``.

    Returns
    -------
    list of dict
        ``kind``, ``name``, ``distribution``, ``version``, ``summary``, ``references``, ``selected_by`` (key of the
        scenario) and ``parameters``: dicts of ``name``, ``type``, ``allowed``, ``default``, ``description``.

    Raises
    ------
    ProviderNameError
        If there is none.
    ProviderError
        If its parameters cannot be imported.
    """
    from hcss_twin.scenario.reference import field_text

    entries = [entry for entry in registry.entries() if name in (entry.name, entry.qualified_name)]
    if not entries:
        names = sorted({entry.name for entry in registry.entries()})
        raise ProviderNameError(f"no provider is called '{name}'; {choose_from(name, names)}")
    found = []
    for entry in entries:
        model = registry.parameters_model(entry)
        fields = model.model_fields if model is not None else {}
        found.append(
            {
                "kind": entry.kind.human,
                "name": entry.name,
                "distribution": entry.distribution,
                "version": entry.version,
                "summary": entry.summary,
                "references": list(entry.references),
                "selected_by": _SELECTED_BY[str(entry.kind)],
                "parameters": [vars(field_text(key, field)) for key, field in fields.items()],
            }
        )
    return found


def provider_text(found: dict[str, Any]) -> str:
    """Return what :func:`described` says of one provider, for a screen."""
    lines = [
        f"{found['kind']} {found['name']}  [{found['distribution']} {found['version']}]",
        f"  {found['summary']}",
        f'  selected by {found["selected_by"]} = "{found["name"]}"',
        *(f"  reference: {reference}" for reference in found["references"]),
    ]
    section = found["selected_by"].partition(".")[0]
    lines.append(f"  {section}.parameters:" if found["parameters"] else "  It has no parameters.")
    for each in found["parameters"]:
        facts = [each["type"], each["allowed"], f"default {each['default']}" if each["default"] else ""]
        told = ", ".join(fact for fact in facts if fact).replace("default **required**", "required")
        lines.append(f"    {each['name']}  ({told})".replace("`", ""))
        lines += textwrap.wrap(
            each["description"].replace("`", ""), 100, initial_indent=" " * 8, subsequent_indent=" " * 8
        )
    return "\n".join(lines)
