"""Write a small, tested and typed package with one provider, from the templates beside this file.

The module of each kind is a template of its own (``templates/sea.py``): it has no placeholders, so that it is checked
like all code. The other files are common to all kinds.
"""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

from hcss_twin import __version__
from hcss_twin.core.errors import OptionError
from hcss_twin.providers import API_VERSION, HcssError, Kind, choose_from

if TYPE_CHECKING:
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
"""Files of a package and their templates."""


def contract_name(kind: Kind) -> str:
    """Return the name of the class in ``hcss_author`` that tests a kind: ``SeaModelContract``."""
    return f"{kind.protocol.removesuffix('Provider')}Contract"


def check_new(kind: str, name: str, folder: Path, registry: Registry) -> Kind:
    """Return the kind of a new provider after checking that it can be written and selected.

    Raises
    ------
    OptionError
        If the kind is unknown, the name is malformed or taken, or the folder exists or cannot be made.
    """
    if kind not in list(Kind):
        raise OptionError(f"KIND is '{kind}'; {choose_from(kind, Kind)}")
    if not _NAME.fullmatch(name):
        closest = "-".join(re.findall(r"[a-z0-9]+", re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", name).lower()))
        hint = f"; closest is '{closest}'" if _NAME.fullmatch(closest) else ""
        raise OptionError(
            f"NAME is '{name}'; allowed: lower-case letters, digits and inner hyphens, a letter first{hint}"
        )
    wanted = Kind(kind)
    for entry in registry.entries(wanted):
        if entry.name == name:
            raise OptionError(f"NAME is '{name}', a {wanted.human} of {entry.origin}; allowed: a name not yet in use")
    if folder.exists() or folder.is_symlink():
        raise OptionError(f"folder {folder} exists; allowed: a new one (--folder)")
    if not folder.absolute().parent.is_dir():
        raise OptionError(f"folder {folder} cannot be made: there is no folder {folder.absolute().parent}")
    return wanted


def package_files(kind: Kind, name: str) -> dict[str, str]:
    """Return the text of every file of a package by its path within it."""
    values = {
        "name": name,
        "module": f"hcss_{name.replace('-', '_')}",
        "short": name.replace("-", "_"),
        "kind": kind.value,
        "human": kind.human,
        "hook": kind.hook,
        "contract": contract_name(kind),
        "api_version": API_VERSION,
        "version": __version__,
    }
    templates = files(__package__) / "templates"

    def text(template: str) -> str:
        if not template:
            return (templates / f"{kind}.py").read_text(encoding="utf-8")
        return Template((templates / template).read_text(encoding="utf-8")).substitute(values)

    return {Template(path).substitute(values): text(template) for path, template in _COMMON.items()}


def write_package(kind: Kind, name: str, folder: Path) -> list[Path]:
    """Write the package of a new provider and return its files.

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
