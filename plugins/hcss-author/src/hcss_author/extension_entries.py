"""What packages add besides providers: commands, sections with rays or effects, light; found by name when installed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from hcss_twin.providers.registry.registry import Registry


class Extension(StrEnum):
    """A kind of extension.

    Attributes
    ----------
    human : str
        Name in messages.
    group : str
        Entry point group.
    contract : str
        Name of its class in ``hcss_author``.
    """

    human: str
    group: str
    contract: str

    RAYS = "rays", "section with rays", "hcss_twin.sections", "RaysContract"
    EFFECT = "effect", "section with an effect", "hcss_twin.sections", "EffectContract"
    SECTION = "section", "section", "hcss_twin.sections", "SectionContract"
    LIGHT = "light", "light", "hcss_twin.light", "LightContract"
    COMMAND = "command", "command", "hcss_twin.commands", "CommandContract"

    def __new__(cls, value: str, human: str = "", group: str = "", contract: str = "") -> Extension:
        """Create a member with string value ``value`` and the others as attributes."""
        member = str.__new__(cls, value)
        member._value_ = value
        member.human, member.group, member.contract = human, group, contract
        return member


@dataclass(frozen=True)
class ExtensionEntry:
    """An installed extension.

    Attributes
    ----------
    what
        Of ``Registry.extensions``: the section, the command or the light.
    """

    kind: Extension
    name: str
    what: Any

    @property
    def origin(self) -> Any:
        """Package that contains it: its distribution and version."""
        return self.what.origin

    @property
    def qualified_name(self) -> str:
        """The name: those of extensions are unique."""
        return self.name

    @property
    def distribution(self) -> str:
        """Distribution that contains it."""
        return str(self.origin.distribution)

    @property
    def label(self) -> str:
        """Label in messages."""
        return f"{self.kind.human} '{self.name}' of {self.origin}"


def extensions() -> Iterator[ExtensionEntry]:
    """Yield all installed extensions."""
    for name, section in Registry.extensions(Extension.SECTION.group).items():
        kind = Extension.SECTION
        if section.spec.rays is not None or section.spec.effect is not None:
            kind = Extension.EFFECT if section.spec.rays is None else Extension.RAYS
        yield ExtensionEntry(kind, name, section)
    for kind in (Extension.LIGHT, Extension.COMMAND):
        for name, what in Registry.extensions(kind.group).items():
            yield ExtensionEntry(kind, name, what)


def find_extension(name: str, kind: str | None = None) -> ExtensionEntry | None:
    """Return the installed extension of a name, by hyphens or underscores, and of a kind if given; None without one."""
    plain = name.replace("-", "_")
    found = [entry for entry in extensions() if entry.name.replace("-", "_") == plain and kind in (None, entry.kind)]
    return found[0] if found else None
