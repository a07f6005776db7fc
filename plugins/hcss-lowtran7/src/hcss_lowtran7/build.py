"""Compile LOWTRAN7 once per machine, safely when several runs start at the same time."""

from __future__ import annotations

import hashlib
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Literal

from hcss_twin.providers import ProviderError

CACHE_VARIABLE = "HCSS_LOWTRAN7_CACHE"
"""Environment variable that names another folder for the compiled program."""

# Legacy: the source is Fortran 77 with extensions. Some of its variables are read before they are set,
# as compilers of its time zeroed all memory.
_FLAGS = ("-O2", "-std=legacy", "-w", "-finit-local-zero")

# Tables by wavenumber in TRANS: transmittance (906, 907) and thermal radiance (916, 917).
_TABLES = re.compile(r"^ {6}(?=WRITE\((?:IPR|IPR1|IPU),(?:906|907|916|917)\) +V,)", re.MULTILINE)

Precision = Literal["single", "double"]
_PRECISION_FLAGS: dict[Precision, tuple[str, ...]] = {"single": (), "double": ("-freal-4-real-8",)}


@dataclass(frozen=True)
class Program:
    """A compiled LOWTRAN7; ``precision`` is that of all its real numbers."""

    path: Path
    precision: Precision = "single"


def cache_folder() -> Path:
    """Return the user's folder for compiled programs; it need not exist."""
    chosen = os.environ.get(CACHE_VARIABLE)
    if chosen:
        return Path(chosen).expanduser()
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or str(Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = str(Path.home() / "Library" / "Caches")
    else:
        base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "hcss-lowtran7"


def build(source: Path, precision: Precision = "single", folder: Path | None = None) -> Program:
    """Return the program compiled from ``source`` and the driver, compiling it if necessary.

    The name holds a hash of source, driver, flags and platform, so that a new version is compiled
    anew. It is built in a folder of its own and moved into place, so that a program that is there is whole.

    Parameters
    ----------
    source : Path
        ``lowtran7.f``.
    precision : {"single", "double"}
        Single is the original; its ray tracing rounds lengths to some 1e-4 of a layer.
    folder : Path, optional
        Where the program is kept; :func:`cache_folder` by default.

    Raises
    ------
    ProviderError
        If there is no gfortran, it fails, or the folder cannot be written to.
    """
    fortran = obey_noprt(source.read_text(encoding="latin-1")).encode("latin-1")
    driver = files("hcss_lowtran7").joinpath("driver.f90").read_bytes()
    flags = (*_FLAGS, *_PRECISION_FLAGS[precision])
    digest = hashlib.sha256()
    for part in (fortran, driver, " ".join((*flags, sys.platform, platform.machine())).encode()):
        digest.update(hashlib.sha256(part).digest())
    folder = folder or cache_folder()
    suffix = ".exe" if sys.platform == "win32" else ""
    program = folder / f"lowtran7-{precision}-{digest.hexdigest()[:16]}{suffix}"
    if program.is_file():
        _require_own(folder)
        _require_own(program)
        return Program(program, precision)
    compiler = shutil.which("gfortran")
    if compiler is None:
        raise ProviderError(
            "lowtran7: LOWTRAN7 is compiled at its first use, and there is no 'gfortran' on the PATH; install "
            "it, for example with 'apt-get install gfortran', 'dnf install gcc-gfortran', 'brew install gcc' or "
            "'conda install gfortran', or choose another atmosphere.provider"
        )
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix="build-", dir=folder) as private:
            made = _compile([compiler, *flags], fortran, driver, Path(private) / program.name)
            _move(made, program)
    except OSError as error:
        raise ProviderError(
            f"lowtran7: cannot keep the compiled program in {folder}: {error}; "
            f"set the environment variable {CACHE_VARIABLE} to a folder that can be written to"
        ) from error
    return Program(program, precision)


def _require_own(path: Path) -> None:
    """Raise ProviderError for a program, or its folder, that another user owns or that all users may write to."""
    about = path.stat()
    if sys.platform != "win32" and (about.st_uid not in (os.getuid(), 0) or about.st_mode & 0o002):
        raise ProviderError(
            f"lowtran7: {path} may be the work of another user, and is not run; delete it, or set the environment "
            f"variable {CACHE_VARIABLE} to a folder of your own"
        )


def obey_noprt(source: str) -> str:
    """Return the source changed so that tables by wavenumber are written only if card 1 has NOPRT below 1.

    That is what the comments of LWTRN7 say of NOPRT; TRANS writes them always, which takes
    nineteen twentieths of its time.

    Raises
    ------
    ProviderError
        If the source is not the known one.
    """
    quiet, count = _TABLES.subn("      IF(NPR.LT.1)\n     1", source)
    if count != 5:
        raise ProviderError(f"lowtran7: the Fortran source has {count} tables by wavenumber; expected 5")
    return quiet


def _compile(compiler: list[str], fortran: bytes, driver: bytes, program: Path) -> Path:
    (program.parent / "lowtran7.f").write_bytes(fortran)
    (program.parent / "driver.f90").write_bytes(driver)
    command = [*compiler, "lowtran7.f", "driver.f90", "-o", program.name]
    done = subprocess.run(
        command, cwd=program.parent, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        tail = "\n".join(done.stderr.strip().splitlines()[-8:])
        raise ProviderError(f"lowtran7: '{' '.join(command)}' failed:\n{tail}")
    return program


def _move(made: Path, program: Path) -> None:
    try:
        os.replace(made, program)
    except PermissionError:
        # Windows refuses to replace a program that runs; then another run has put the same one there.
        if not program.is_file():
            raise
