"""Fingerprint of the code of providers, so that no cached result outlives a change of what computed it.

The code of a provider is its own package and what that imports, at any depth: import statements are read from the
sources, at the top of a module or within functions, so it does not matter what a process has loaded before, or when.

* Of the distribution of a provider, and of modules that no distribution installed (editable installs, folders on the
  path, archives), the contents of all files count, data files included; of files above ``READ_BYTES`` size and times.
  Files outside a package count if its source names them.
* Of other installed distributions, the version and the list of installed files with their hashes (``RECORD``) count,
  and so do the distributions that they require; of those up to ``READ_BYTES``, and of this package, also sizes and
  times of the files. The standard library, and the libraries whose versions every cached result depends on, are not
  followed.
* Where a source imports computed names, everything that can be imported and that no distribution installed counts.

What code reads elsewhere (the network, other files, the environment) is a provider's to state, as ``cache_token``.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.util
import marshal
import os
import re
import struct
import sys
import sysconfig
import time
import uuid
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import suppress
from importlib.machinery import all_suffixes
from pathlib import Path

from hcss_twin.core.environment import LIBRARIES
from hcss_twin.core.plugins import OWN_DISTRIBUTION, normalised

READ_BYTES = 2_000_000
"""Largest file, and largest installed distribution, whose contents count."""

_OWN = __name__.partition(".")[0]
STARTED_S = time.time()
"""When this process loaded this module."""

_CODE = tuple(suffix for suffix in all_suffixes() if suffix != ".pyc")

_IMPORT = re.compile(r"(?:^|[;:])[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import\b|import[ \t]+([\w., \t]+))", re.MULTILINE)
_LOADER = r"\b(?:import_module|__import__|find_spec|run_module)\(\s*(?:name\s*=\s*)?"
_NAMED = re.compile(_LOADER + r"""f?["']([\w.]+)""")
_COMPUTED = re.compile(
    _LOADER
    + r"""(?!["'][\w.]+["']\s*[,)]|f?["'](?:\w*\.|\{__(?:name|package)__\}\.))"""
    + r"|\b(?:exec|run_path|spec_from_file_location|SourceFileLoader|entry_points)\("
)
_PATH = re.compile(r"""["']([^"'\s{}%*?<>|]{1,200})["']""")
_RECORDED = re.compile(r'^"?(.+?)"?,[^,\n]*,(\d*)\r?$', re.MULTILINE)
_REQUIRED = re.compile(r"^Requires-Dist:[ \t]*([\w.-]+)(.*)$", re.MULTILINE | re.IGNORECASE)


def code_fingerprint(distribution: str, targets: Sequence[str]) -> str:
    """Return a hash of the code that importing and using some objects can run.

    Code that changed after this process started may not be what the process has loaded, and Python runs compiled code
    of an earlier source of the same size and second. In both cases the hash is never returned again.

    Parameters
    ----------
    distribution : str
        The distribution that contains the objects; of this package's, all counts.
    targets : sequence of str
        ``"package.module:Class"``.
    """
    closure = _Closure()
    closure.follow(distribution, targets)
    lines = sorted(f"{name}\0{state}" for name, state in closure.states.items())
    changed = [uuid.uuid4().hex] if closure.changed_since_start else []
    return hashlib.sha256("\n".join([*targets, *lines, *changed]).encode("utf-8", "replace")).hexdigest()


class _Closure:
    """The state of all code that some modules lead to, by name of its file or distribution."""

    def __init__(self) -> None:
        self.states: dict[str, str] = {}
        self.changed_since_start = False
        self._modules: list[str] = []
        self._seen: set[str] = {*sys.stdlib_module_names, *LIBRARIES}
        self._distributions: set[str] = {normalised(library) for library in LIBRARIES}
        self._files: set[str] = set()
        self._records: dict[Path, dict[Path, bytes]] = {}

    def follow(self, distribution: str, targets: Sequence[str]) -> None:
        """Add all code that some objects of a distribution lead to."""
        if distribution == OWN_DISTRIBUTION:  # what it requires is stated by the versions of LIBRARIES
            root = Path(__file__).parents[1]
            for file in _files(root):
                self._file(os.path.relpath(file, root), file, reads=False)
            return
        self._seen.add(_OWN)
        self._distributions.add(OWN_DISTRIBUTION)
        self._distribution(distribution, follows=True)
        self._modules += [target.partition(":")[0].partition(".")[0] for target in targets]
        while self._modules:
            name = self._modules.pop()
            if name not in self._seen:
                self._seen.add(name)
                self._module(name)

    def _module(self, name: str) -> None:
        """Add a top-level module or package."""
        try:
            spec = importlib.util.find_spec(name)
        except Exception:  # a module without a spec, or another package's finder
            spec = None
        loaded = sys.modules.get(name)
        origin = getattr(loaded, "__file__", None) if spec is None else spec.origin
        if origin in ("built-in", "frozen"):
            return
        folders = getattr(loaded, "__path__", None) or (() if spec is None else spec.submodule_search_locations or ())
        roots = [Path(folder) for folder in folders] or [Path(origin) for origin in (origin,) if origin]
        if not roots:
            self.states[name] = "absent"
        for root in roots:
            owners = self._owners(root)
            for owner in owners:
                self._installed(owner)
            if not owners:
                self._local(name, root)

    def _owners(self, root: Path) -> list[Path]:
        """Return the folders of metadata of the distributions that installed a file or package."""
        folder, name = root.parent, root.name.encode()
        if folder not in self._records:
            self._records[folder] = {record: record.read_bytes() for record in folder.glob("*.dist-info/RECORD")}
        starts = name + b"/", name + b","
        return [
            path.parent
            for path, record in self._records[folder].items()
            if record.startswith(starts) or any(b"\n" + start in record for start in starts)
        ]

    def _local(self, name: str, root: Path) -> None:
        """Add files of no distribution."""
        if not root.exists():  # within an archive
            root = next((parent for parent in root.parents if parent.is_file()), root)
        for file in _files(root):
            self._file(f"{name}/{os.path.relpath(file, root.parent)}", file)

    def _file(self, label: str, file: Path, reads: bool = True, installed_ns: int | None = None) -> None:
        """Add a file: its contents and what they lead to, or its size and times.

        One without a label counts wherever it lies, as its folder may be moved. Installers (uv) link equal files of
        several environments to one, which changes its change time: then the time of the installation counts instead.
        """
        try:
            about = file.stat()
            source = reads and file.suffix == ".py"
            content = file.read_bytes() if source or (reads and about.st_size <= READ_BYTES) else None
        except OSError:  # a dangling link, or removed meanwhile
            return
        # The change time is of the system's clock, and no program sets it; Windows has none.
        times = about.st_mtime_ns, about.st_ctime_ns
        if installed_ns is not None and about.st_nlink > 1:
            times = about.st_mtime_ns, max(installed_ns, about.st_mtime_ns)
        state = f"{about.st_size} {times}" if content is None else hashlib.sha256(content).hexdigest()
        self.states[label or f"{file.name} {state}"] = state
        self.changed_since_start |= file.name.endswith(_CODE) and times[os.name != "nt"] > STARTED_S * 1e9
        if source and content is not None:
            self.changed_since_start |= _runs_old_bytecode(file, content, times[1])
            self._source(content.decode("utf-8", "replace"), file)
        elif reads and (file.suffix in (".zip", ".egg", ".whl", ".pyz") or str(file) in sys.path):
            with suppress(zipfile.BadZipFile, OSError), zipfile.ZipFile(file) as archive:
                for member in archive.namelist():
                    if member.endswith(".py"):
                        self._source(archive.read(member).decode("utf-8", "replace"), file)

    def _source(self, text: str, file: Path) -> None:
        """Follow a source to the modules and files that it names."""
        modules = set(_NAMED.findall(text))
        for whole, several in _IMPORT.findall(text.replace("\\\n", " ")):
            modules |= {whole} if whole else {words[0] for name in several.split(",") if (words := name.split())}
        modules = {module.partition(".")[0] for module in modules} - self._seen - {""}
        self._modules += sorted(modules)
        if _COMPUTED.search(text):
            self._modules += sorted(_uninstalled())
        named = sorted(set(_PATH.findall(text)) - {".", "..", "/"})
        near = [file.parent, file.parent.parent, Path.cwd()]
        with suppress(OSError, ValueError):
            folders = [folder / name for folder in near for name in named if (folder / name).is_dir()]
            # A folder that the source names may be put on the path when the provider is called.
            for path in [folder / f"{module}{end}" for folder in folders for module in modules for end in ("", ".py")]:
                self._named(path)
            for path in [folder / name for folder in (*near, *folders) for name in named if "." in name or "/" in name]:
                self._named(path)

    def _named(self, path: Path) -> None:
        """Add a file or package that a source names, if there is one."""
        for file in _files(path) if path.is_file() or (path / "__init__.py").is_file() else ():
            real = os.path.realpath(file)
            if real not in self._files:
                self._files.add(real)
                self._file("", file)

    def _distribution(self, name: str, follows: bool = False) -> None:
        """Add a distribution that is the provider's or required, and those that it requires."""
        try:
            found = importlib.metadata.distribution(name)
            folder = getattr(found, "_path", None)
            version, text = found.version, found.read_text("METADATA") or found.read_text("PKG-INFO") or ""
        except Exception:  # not installed, or its metadata are damaged
            self.states[f"distribution {name}"] = "absent"
            return
        if isinstance(folder, Path) and (folder / "RECORD").is_file():
            self._installed(folder, follows)
        else:
            self.states[f"distribution {name}"] = version
            self._require(name, text)

    def _installed(self, folder: Path, follows: bool = False) -> None:
        """Add an installed distribution by its folder of metadata."""
        name = folder.name.partition("-")[0]
        if normalised(name) in self._distributions:
            return
        record, installed_ns = (folder / "RECORD").read_bytes(), (folder / "RECORD").stat().st_ctime_ns
        self.states[f"distribution {folder.name}"] = hashlib.sha256(record).hexdigest()
        files = [(path, int(size or 0)) for path, size in _RECORDED.findall(record.decode("utf-8", "replace"))]
        if follows or sum(size for _, size in files) <= READ_BYTES:
            for path, _ in files:
                if not path.endswith(".pyc") and not path.partition("/")[0].endswith(".dist-info"):
                    self._file(f"{name}/{path}", folder.parent / path, follows, installed_ns)
        with suppress(OSError):
            self._require(name, (folder / "METADATA").read_text(encoding="utf-8", errors="replace"))

    def _require(self, name: str, metadata: str) -> None:
        self._distributions.add(normalised(name))
        for required, condition in _REQUIRED.findall(metadata.partition("\n\n")[0]):
            if "extra" not in condition and normalised(required) not in self._distributions:
                self._distribution(required)


def _runs_old_bytecode(file: Path, content: bytes, changed_ns: int) -> bool:
    """Return whether Python runs compiled code of an earlier source, of the same size and second."""
    try:
        cached = Path(importlib.util.cache_from_source(str(file)))
        if cached.stat().st_ctime_ns > changed_ns:
            return False
        head, about = cached.read_bytes(), file.stat()
        if head[:4] != importlib.util.MAGIC_NUMBER or head[4:16] != struct.pack(
            "<III", 0, int(about.st_mtime) & 0xFFFFFFFF, about.st_size & 0xFFFFFFFF
        ):
            return False
        old: bool = marshal.loads(head[16:]) != compile(content, str(file), "exec", dont_inherit=True)
    except (OSError, ValueError, SyntaxError, EOFError, TypeError, NotImplementedError):
        return False
    return old


def _files(root: Path) -> Iterator[Path]:
    """Yield a file, or all files of a package that can affect what it computes."""
    if not root.is_dir():
        yield root
        return
    for folder, inner, names in os.walk(root, followlinks=True):
        inner[:] = sorted(
            subfolder for subfolder in inner if subfolder != "__pycache__" and not subfolder.startswith(".")
        )
        yield from (Path(folder, name) for name in sorted(names) if not name.startswith("."))


def _uninstalled() -> Iterator[str]:
    """Yield the names of the top-level modules on the path that no distribution installed."""
    paths = sysconfig.get_paths()
    shipped = {Path(paths[name]).resolve() for name in ("stdlib", "platstdlib", "purelib", "platlib")}
    for folder in {Path(entry or ".").resolve() for entry in sys.path}:
        if folder.is_dir() and not any(folder == root or root in folder.parents for root in shipped):
            for file in folder.iterdir():
                if file.name.endswith(_CODE) or (file / "__init__.py").is_file():
                    yield file.name.partition(".")[0]
