"""What packages add besides providers: commands, sections with rays or effects, light; found by name when installed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from hcss_twin.core.commands import collect
from hcss_twin.core.plugins import Origin, installed
from hcss_twin.core.sections import plugin_sections


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
        The section (``PluginSection``), the command (``PluginCommand``), or the entry point of a light.
    """

    kind: Extension
    name: str
    origin: Origin
    what: Any

    @property
    def qualified_name(self) -> str:
        """The name: those of extensions are unique."""
        return self.name

    @property
    def distribution(self) -> str:
        """Distribution that contains it."""
        return self.origin.distribution

    @property
    def label(self) -> str:
        """Label in messages."""
        return f"{self.kind.human} '{self.name}' of {self.origin}"


def extensions() -> Iterator[ExtensionEntry]:
    """Yield all installed extensions."""
    for name, section in plugin_sections().items():
        kind = Extension.SECTION
        if section.spec.rays is not None or section.spec.effect is not None:
            kind = Extension.EFFECT if section.spec.rays is None else Extension.RAYS
        yield ExtensionEntry(kind, name, section.origin, section)
    for origin, entry_point in installed(Extension.LIGHT.group):
        if not isinstance(entry_point, BaseException):
            yield ExtensionEntry(Extension.LIGHT, entry_point.name, origin, entry_point)
    commands, _, _ = collect(installed(Extension.COMMAND.group), (), ("atmosphere",))
    for name, command in commands.items():
        yield ExtensionEntry(Extension.COMMAND, name, command.origin, command)


def find_extension(name: str, kind: str | None = None) -> ExtensionEntry | None:
    """Return the installed extension of a name, by hyphens or underscores, and of a kind if given; None without one."""
    plain = name.replace("-", "_")
    found = [entry for entry in extensions() if entry.name.replace("-", "_") == plain and kind in (None, entry.kind)]
    return found[0] if found else None
