"""Write a small, tested and typed package with one provider or extension, from the templates beside this file.

The module of each kind is a template of its own (``templates/sea.py``): it has no placeholders, so that it is checked
like all code. The other files are common to all kinds.
"""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

from hcss_author.extension_entries import Extension, ExtensionEntry, extensions
from hcss_twin import __version__
from hcss_twin.core.errors import OptionError
from hcss_twin.providers import API_VERSION, HcssError, Kind, choose_from

if TYPE_CHECKING:
    from hcss_twin.providers.registry.discovery import Entry
    from hcss_twin.providers.registry.registry import Registry

_NAME = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")

_COMMON = {
    "pyproject.toml": "pyproject.toml.txt",
    "README.md": "README.md.txt",
    "src/$module/__init__.py": "hook.py.txt",
    "src/$module/provider.py": "",  # that of the kind
    "src/$module/py.typed": "py.typed",
    "tests/test_$short.py": "test.py.txt",
}
"""Files of a package with a provider, and their templates."""

_EXTENSION = {
    "pyproject.toml": "pyproject.toml.txt",
    "README.md": "README_extension.md.txt",
    "src/$module/__init__.py": "hook_$hook.py.txt",
    "src/$module/$kind.py": "",
    "src/$module/py.typed": "py.typed",
    "tests/test_$short.py": "test_extension.py.txt",
}
"""Files of a package with an extension."""

_USE = {
    Extension.RAYS: "scenarios select it by `[$short]`",
    Extension.EFFECT: "scenarios select it by `[$short]`",
    Extension.SECTION: "scenarios have it as `[$short]`",
    Extension.LIGHT: 'scenarios select it by `radiance.light = "$name"`',
    Extension.COMMAND: "`hcss $name --help` says what it does",
}
_NEEDS = '"numpy>=1.26", "pydantic>=2.7"'

KINDS = (*Kind, *Extension)
"""What can be written."""


def contract_name(kind: Kind | Extension) -> str:
    """Return the name of the class in ``hcss_author`` that tests a kind: ``SeaModelContract``."""
    if isinstance(kind, Extension):
        return kind.contract
    return f"{kind.protocol.removesuffix('Provider')}Contract"


def check_new(kind: str, name: str, folder: Path, registry: Registry) -> Kind | Extension:
    """Return the kind of a new provider or extension after checking that it can be written and selected.

    Raises
    ------
    OptionError
        If the kind is unknown, the name is malformed or taken, or the folder exists or cannot be made.
    """
    if kind not in KINDS:
        stage = "; stages of the engine have no public protocol" if kind == "stage" else ""
        raise OptionError(f"KIND is '{kind}'; {choose_from(kind, KINDS)}{stage}")
    if not _NAME.fullmatch(name):
        closest = "-".join(re.findall(r"[a-z0-9]+", re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", name).lower()))
        hint = f"; closest is '{closest}'" if _NAME.fullmatch(closest) else ""
        raise OptionError(
            f"NAME is '{name}'; allowed: lower-case letters, digits and inner hyphens, a letter first{hint}"
        )
    wanted = Extension(kind) if kind in list(Extension) else Kind(kind)
    taken: list[Entry | ExtensionEntry] = []
    if isinstance(wanted, Kind):
        taken += [entry for entry in registry.entries(wanted) if entry.name == name]
    else:
        of_group = [entry for entry in extensions() if entry.kind.group == wanted.group]
        taken += [entry for entry in of_group if entry.name.replace("_", "-") == name]
    if taken:
        raise OptionError(f"NAME is '{name}', a {wanted.human} of {taken[0].origin}; allowed: a name not yet in use")
    if folder.exists() or folder.is_symlink():
        raise OptionError(f"folder {folder} exists; allowed: a new one (--folder)")
    if not folder.absolute().parent.is_dir():
        raise OptionError(f"folder {folder} cannot be made: there is no folder {folder.absolute().parent}")
    return wanted


def package_files(kind: Kind | Extension, name: str) -> dict[str, str]:
    """Return the text of every file of a package by its path within it."""
    short = name.replace("-", "_")
    module = f"hcss_{short}"
    values = {
        "name": name,
        "module": module,
        "short": short,
        "kind": kind.value,
        "human": kind.human,
        "contract": contract_name(kind),
        "api_version": API_VERSION,
        "version": __version__,
        "entry": f"{module}.light:Light" if kind is Extension.LIGHT else module,
        "needs": '"click>=8.1", "xarray>=2024.1"' if kind is Extension.COMMAND else _NEEDS,
    }
    if isinstance(kind, Extension):
        part = {Extension.RAYS: ", rays=", Extension.EFFECT: ", effect="}.get(kind, "")
        values |= {
            "hook": "section" if kind.group == Extension.SECTION.group else kind.value,
            "group": kind.group,
            "selected": short if kind.group == Extension.SECTION.group else name,
            "parts": part and f'{part}"{module}.{kind}:make_{kind}"',
            "use": Template(_USE[kind]).substitute(short=short, name=name),
        }
    else:
        values |= {"hook": kind.hook, "group": "hcss_twin"}
    common = _EXTENSION if isinstance(kind, Extension) else _COMMON
    templates = files(__package__) / "templates"

    def text(template: str) -> str:
        if not template:
            return (templates / f"{kind}.py").read_text(encoding="utf-8")
        return Template((templates / Template(template).substitute(values)).read_text(encoding="utf-8")).substitute(
            values
        )

    return {Template(path).substitute(values): text(template) for path, template in common.items()}


def write_package(kind: Kind | Extension, name: str, folder: Path) -> list[Path]:
    """Write the package of a new provider or extension and return its files.

    Raises
    ------
    HcssError
        If a file cannot be written.
    """
    written = []
    try:
        folder.mkdir()
        for path, text in package_files(kind, name).items():
            file = folder / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
            written.append(file)
    except OSError as error:
        raise HcssError(f"cannot write {folder}: {error}") from error
    return written
