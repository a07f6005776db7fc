"""Plugins that keep a number in 34 kinds of places: does the fingerprint of their code change if, and only if, the
number does?

Each layout is written to a folder and asked in a new process for the number that it computes, which is the reference,
and for its fingerprint. A *change* gives the number another value; an *accident* changes something else.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import py_compile
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

HOMES = ("package", "module", "installed")
"""The provider is in a package on the path, in a single file on the path, or in an installed distribution."""

FIRST, SECOND = "0.98", "0.60"

Files = dict[str, str | bytes]


@dataclass(frozen=True)
class Place:
    """Where a plugin keeps its number.

    Attributes
    ----------
    source : str
        Source of the provider's module, with ``value()``; ``@HERE@`` is the folder of the plugin's modules.
    files : callable
        Other files by path, for a number as text. Paths that begin with ``@OWN@`` are in the provider's folder.
    requires : tuple of str
        Distributions that the provider's distribution requires.
    keeps_times : bool
        Whether the change restores the modification times.
    start : str
        Statements before the provider is imported.
    """

    source: str
    files: Callable[[str], Files]
    requires: tuple[str, ...] = ()
    keeps_times: bool = False
    start: str = ""


def _one(path: str, text: str = "E = {}\n") -> Callable[[str], Files]:
    return lambda number: {path: text.format(number)}


def _archive(number: str) -> Files:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        archive.writestr(zipfile.ZipInfo("st_zipped/__init__.py"), f"E = {number}\n")
    return {"lib.zip": content.getvalue()}


def _compiled(number: str) -> Files:
    folder = Path(os.environ.get("TMPDIR", "/tmp")) / f"pyc-{os.getpid()}"
    folder.mkdir(exist_ok=True)
    (folder / "m.py").write_text(f"E = {number}\n")
    py_compile.compile(str(folder / "m.py"), cfile=str(folder / "m.pyc"), dfile="m.py")
    return {"st_lib.pyc": (folder / "m.pyc").read_bytes()}


def _array(path: str, size: int = 1) -> Callable[[str], Files]:
    def files(number: str) -> Files:
        content = io.BytesIO()
        np.save(content, np.full(size, float(number)))
        return {path: content.getvalue()}

    return files


def _distribution(
    name: str, version: str, files: Files, requires: tuple[str, ...] = (), recorded: bool = True
) -> Files:
    """Return the files of a distribution, with those of its metadata."""
    folder = f"{name.replace('-', '_')}-{version}.dist-info"
    needed = "".join(f"Requires-Dist: {each}\n" for each in requires)
    own: Files = {**files, f"{folder}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n{needed}"}
    if recorded:
        rows = [f"{path},sha256={hashlib.sha256(_bytes(each)).hexdigest()},{len(each)}" for path, each in own.items()]
        own[f"{folder}/RECORD"] = "\n".join((*rows, f"{folder}/RECORD,,")) + "\n"
    return own


def _bytes(content: str | bytes) -> bytes:
    return content.encode() if isinstance(content, str) else content


def _in_place(number: str) -> Files:
    files = _distribution("st-lib", "1.0", {"st_lib/__init__.py": "E = 0.50\n"})
    return {**files, "st_lib/__init__.py": f"E = {number}\n"}


USE = "\ndef value():\n    return "
OF_LIB = "import st_lib" + USE + "st_lib.E"
FINDER = """import importlib.util, sys
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == "st_far":
            return importlib.util.spec_from_file_location(name, "@HERE@/../far/st_far.py")
sys.meta_path.append(Finder())
"""
READ = "from pathlib import Path\nimport json, tomllib, numpy as np\n"

LAZY = """from importlib import import_module
def __getattr__(n):
    return getattr(import_module(f'{__name__}.b'), n)
"""

PLACES: dict[str, Place] = {
    "another module": Place(OF_LIB, _one("st_lib.py")),
    "module imported in a method": Place("def value():\n    from st_lib import E\n    return E", _one("st_lib.py")),
    "module of another package": Place(
        "from st_pack.sub.deep import E" + USE + "E",
        lambda number: {
            "st_pack/__init__.py": "",
            "st_pack/sub/__init__.py": "",
            "st_pack/sub/deep.py": f"E = {number}\n",
        },
    ),
    "namespace package": Place("import st_space.inner as inner" + USE + "inner.E", _one("st_space/inner.py")),
    "from a namespace package": Place("from st_space import inner" + USE + "inner.E", _one("st_space/inner.py")),
    "helper of a helper's helper": Place(
        "import st_a1" + USE + "st_a1.f()",
        lambda number: {
            "st_a1.py": "import st_a2\ndef f():\n    return st_a2.f()\n",
            "st_a3.py": f"E = {number}\n",
            "st_a2.py": "def f():\n    import st_a3\n    return st_a3.E\n",
        },
    ),
    "star import": Place("from st_lib import *" + USE + "E", _one("st_lib.py")),
    "import after another statement": Place("import os; import st_lib" + USE + "st_lib.E", _one("st_lib.py")),
    "import on the line of try": Place(
        "try: import st_lib\nexcept ImportError: raise" + USE + "st_lib.E", _one("st_lib.py")
    ),
    "several imports with aliases": Place("import os as o, \\\n    st_lib as lib" + USE + "lib.E", _one("st_lib.py")),
    "import in brackets": Place(
        "from st_pack import (\n    a,\n    E,\n)" + USE + "E",
        lambda number: {"st_pack/__init__.py": "a = 1\nfrom .b import E\n", "st_pack/b.py": f"E = {number}\n"},
    ),
    "import_module with a name": Place(
        "import importlib" + USE + 'importlib.import_module("st_lib").E', _one("st_lib.py")
    ),
    "import_module with a computed name": Place(
        "from importlib import import_module" + USE + 'import_module("st_" + "lib").E', _one("st_lib.py")
    ),
    "__import__": Place("st = __import__('st_lib')" + USE + "st.E", _one("st_lib.py")),
    "lazy attribute of a package": Place(
        "import st_pack" + USE + "st_pack.E",
        lambda number: {"st_pack/b.py": f"E = {number}\n", "st_pack/__init__.py": LAZY},
    ),
    "archive": Place(
        "import st_zipped" + USE + "st_zipped.E", _archive, start="import sys; sys.path.insert(0, '@HERE@/lib.zip')"
    ),
    "module without source": Place(OF_LIB, _compiled),
    "text in the package": Place(
        READ + USE + 'tomllib.loads((Path(__file__).parent / "t.toml").read_text())["E"]',
        _one("@OWN@/t.toml", "E = {}\n"),
    ),
    "resource of another package": Place(
        "import importlib.resources as r, st_pack" + USE + 'float((r.files("st_pack") / "data" / "t.csv").read_text())',
        lambda number: {"st_pack/__init__.py": "", "st_pack/data/t.csv": number},
    ),
    "array in the package": Place(
        READ + USE + 'float(np.load(Path(__file__).with_name("t.npy"))[0])', _array("@OWN@/t.npy")
    ),
    "array in a folder beside": Place(
        READ + USE + 'float(np.load(Path(__file__).parent / "tables" / "t.npy")[0])', _array("@OWN@/tables/t.npy")
    ),
    "large array, same size and times": Place(
        READ + USE + 'float(np.load(Path(__file__).with_name("t.npy"))[0])',
        _array("@OWN@/t.npy", 600_000),
        keeps_times=True,
    ),
    "same size and times": Place(
        OF_LIB, _one("st_lib.py"), keeps_times=True, start="import sys; sys.dont_write_bytecode = True"
    ),
    "file named by its path": Place(
        READ + USE + 'json.loads(open("@HERE@/../far/e.json").read())', _one("../far/e.json", "{}")
    ),
    "file in the working folder": Place(
        READ + USE + 'float(open("coefficient.txt").read())', _one("../work/coefficient.txt", "{}")
    ),
    "executed file": Place(READ + 'exec(Path("@HERE@", "st_part.txt").read_text())' + USE + "E", _one("st_part.txt")),
    "folder added to the path": Place(
        "def value():\n    import sys\n    sys.path.insert(0, '@HERE@/../far')\n    import st_far\n    return st_far.E",
        _one("../far/st_far.py"),
    ),
    "editable by a path file": Place(
        "import st_far" + USE + "st_far.E", _one("../far/st_far.py"), start="import site; site.addsitedir('@HERE@')"
    ),
    "editable by a finder": Place("import st_far" + USE + "st_far.E", _one("../far/st_far.py"), start=FINDER),
    "installed, same version again": Place(
        OF_LIB, lambda number: _distribution("st-lib", "1.0", {"st_lib/__init__.py": f"E = {number}\n"})
    ),
    "installed, changed in place": Place(OF_LIB, _in_place),
    "installed, another version": Place(
        "from importlib.metadata import version" + USE + 'float("0." + version("st-lib"))',
        lambda number: _distribution("st-lib", number.partition(".")[2], {"st_lib/__init__.py": ""}),
        requires=("st-lib>=1",),
    ),
    "required by what is required": Place(
        "import st_mid" + USE + "st_mid.f()",
        lambda number: {
            **_distribution(
                "st-mid",
                "1.0",
                {"st_mid.py": "def f():\n    n = 'st_' + 'low'\n    return __import__(n).E\n"},
                ("st-low",),
            ),
            **_distribution("st-low", "1.0", {"st_low.py": f"E = {number}\n"}),
        },
        requires=("st-mid",),
    ),
    "default of parameters": Place(
        "from st_pars import P" + USE + "P().e", _one("st_pars.py", "class P:\n    e = {}\n")
    ),
}

ACCIDENTS: dict[str, Callable[[Layout], None]]


@dataclass
class Layout:
    """A plugin in a folder."""

    folder: Path
    place: Place
    home: str
    site: Path = field(init=False)
    arguments: list[str] = field(default_factory=list)
    environment: dict[str, str] = field(default_factory=dict)
    start: str = ""
    work: Path = field(init=False)

    def __post_init__(self) -> None:
        self.site, self.work = self.folder / "site", self.folder / "work"
        for each in (self.site, self.work, self.folder / "far"):
            each.mkdir(parents=True)

    def write(self, number: str) -> None:
        """Write all files for a number."""
        module = "st_ap.py" if self.home == "module" else "st_ap/__init__.py"
        own = "" if self.home == "module" else "st_ap/"
        here = str(self.site)
        source: Files = {module: self.place.source.replace("@HERE@", here) + "\n"}
        every = {path.replace("@OWN@/", own): each for path, each in self.place.files(number).items()}
        provider = {path: each for path, each in every.items() if own and path.startswith(own)}
        helpers = {path: each for path, each in every.items() if path not in provider}
        files = _distribution("st-ap", "0.1", source | provider, self.place.requires, recorded=self.home == "installed")
        if "path file" in self.place.start or "addsitedir" in self.place.start:
            files["far.pth"] = str(self.folder / "far") + "\n"
        for old in self.site.glob("st_lib-*"):  # another version replaces the first
            shutil.rmtree(old)
        for path, content in (files | helpers).items():
            file = self.site / path
            file.parent.mkdir(parents=True, exist_ok=True)
            if not file.exists() or file.read_bytes() != _bytes(content):
                before = file.stat().st_mtime_ns if file.exists() else None
                file.write_bytes(_bytes(content))
                if before is not None:  # later by seconds, or Python itself would run the compiled code of the first
                    now = before if self.place.keeps_times else before + 2_000_000_000
                    os.utime(file, ns=(now, now))

    def ask(self) -> tuple[float, str]:
        """Return the number and the fingerprint, of a new process."""
        start = self.place.start.replace("@HERE@", str(self.site))
        code = (
            f"{start}\n{self.start}\nimport json, st_ap\nfrom hcss_twin.core.code_fingerprint import code_fingerprint\n"
            "code = code_fingerprint('st-ap', ['st_ap:value'])\nprint(json.dumps([float(st_ap.value()), code]))"
        )
        path = os.pathsep.join([str(self.site), *filter(None, [self.environment.get("PYTHONPATH")])])
        environment = {**os.environ, **self.environment, "PYTHONPATH": path}
        done = subprocess.run(
            [sys.executable, *self.arguments, "-c", code],
            env=environment,
            cwd=self.work,
            capture_output=True,
            text=True,
        )
        if done.returncode:
            raise RuntimeError(done.stderr)
        number, fingerprint = json.loads(done.stdout)
        return number, fingerprint


def _written(path: str, content: str = "x = 1\n") -> Callable[[Layout], None]:
    def write(layout: Layout) -> None:
        file = layout.folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content)

    return write


def _set(**environment: str) -> Callable[[Layout], None]:
    return lambda layout: layout.environment.update(environment)


def _began(statement: str) -> Callable[[Layout], None]:
    def begin(layout: Layout) -> None:
        layout.start = statement

    return begin


def _argument(*arguments: str) -> Callable[[Layout], None]:
    return lambda layout: layout.arguments.extend(arguments)


def _touched(layout: Layout) -> None:
    for file in layout.site.rglob("*.py"):
        os.utime(file)


def _rewritten(layout: Layout) -> None:
    for file in [each for each in layout.site.rglob("*") if each.suffix in (".py", ".npy", ".toml", ".csv")]:
        content = file.read_bytes()
        file.unlink()
        file.write_bytes(content)


def _moved(layout: Layout) -> None:
    layout.site = layout.site.rename(layout.folder / "elsewhere")


def _linked(layout: Layout) -> None:
    (layout.folder / "link").symlink_to(layout.site)
    layout.site = layout.folder / "link"


def _elsewhere(layout: Layout) -> None:
    layout.work = layout.folder / "other-work"
    layout.work.mkdir()


def _other_plugin(layout: Layout) -> None:
    for path, content in _distribution("st-other", "2.0", {"st_other/__init__.py": "E = 3\n"}).items():
        _written(f"site/{path}", str(content))(layout)


def _uncompiled(layout: Layout) -> None:
    for folder in list(layout.site.rglob("__pycache__")):
        shutil.rmtree(folder)


ACCIDENTS = {
    "nothing": lambda layout: None,
    "compiled files removed": _uncompiled,
    "no compiled files written": _set(PYTHONDONTWRITEBYTECODE="1"),
    "touched": _touched,
    "written again": _rewritten,
    "permissions": lambda layout: [each.chmod(0o600) for each in layout.site.rglob("*.py")] and None,
    "a module that is not imported": _written("site/st_unrelated.py"),
    "a package that is not imported": _written("site/st_unrelated/__init__.py"),
    "another plugin installed": _other_plugin,
    "a cube in the working folder": _written("work/cube.nc", "CDF"),
    "a module in the working folder": _written("work/study.py"),
    "a cube beside the site": _written("cube.nc", "CDF"),
    "text beside the modules": _written("site/README.md", "# Read me\n"),
    "a log in the working folder": _written("work/run.log", "done\n"),
    "hidden file of an editor": _written("site/.st_ap.py.swp", "x"),
    "hidden folder": _written("site/.git/HEAD", "ref"),
    "another working folder": _elsewhere,
    "moved": _moved,
    "through a link": _linked,
    "environment variable": _set(ST_DEBUG="1"),
    "another folder on the path": _set(PYTHONPATH="/usr"),
    "hash seed": _set(PYTHONHASHSEED="7"),
    "locale": _set(LC_ALL="C"),
    "time zone": _set(TZ="Asia/Tokyo"),
    "optimised": _argument("-O"),
    "warnings": _argument("-W", "error"),
    "other modules loaded before": _began("import json, decimal, numpy, hcss_twin.core.cache"),
    "called before": _began("import st_ap; st_ap.value()"),
    "in a thread": _began(
        "import threading; t = threading.Thread(target=lambda: __import__('st_ap')); t.start(); t.join()"
    ),
    "another importable module loaded before": _began("import st_unrelated2"),
    "installer's notes": _written("site/st_ap-0.1.dist-info/INSTALLER", "pip\n"),
    "tests beside the package": _written("site/tests/test_a.py"),
    "another program": _began("import sys; sys.argv = ['study.py']"),
    "another cache": _set(HCSS_CACHE_DIR="/nowhere/cache"),
}

ACCIDENTAL = ("another module", "module imported in a method", "array in the package")
"""Places of the layouts with accidents, one for each home."""


def cases() -> Iterator[tuple[str, str, str, str]]:
    """Yield kind (``change`` or ``accident``), place, home, and accident of every case: 102 of each kind."""
    for place in PLACES:
        for home in HOMES:
            yield "change", place, home, ""
    for accident in ACCIDENTS:
        for place, home in zip(ACCIDENTAL, HOMES, strict=True):
            yield "accident", place, home, accident


def outcome(case: tuple[str, str, str, str], folder: Path) -> str:
    """Return ``right``, ``stale`` (a change unnoticed) or ``lost`` (a needless change) for a case."""
    kind, place, home, accident = case
    layout = Layout(folder, PLACES[place], home)
    _written("site/st_unrelated2.py")(layout)
    layout.write(FIRST)
    first = layout.ask()
    if kind == "change":
        layout.write(SECOND)
    else:
        ACCIDENTS[accident](layout)
    second = layout.ask()
    if (first[0] != second[0]) != (kind == "change"):
        raise RuntimeError(f"{case}: the number went from {first[0]} to {second[0]}")
    if (first[1] != second[1]) == (kind == "change"):
        return "right"
    return "stale" if kind == "change" else "lost"
