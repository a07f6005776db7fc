"""Atomic, durable writing of files that never replaces an input."""

from __future__ import annotations

import contextlib
import os
import platform
import re
import secrets
import shutil
import time
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from hcss_twin.core.errors import CatalogError, HcssError
from hcss_twin.core.reading import Reading

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Writing"]

REMEDY = "give another name with -o, or --force"

FORMS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "NetCDF": (".nc", ".nc4", ".cdf", ".netcdf", ".h5", ".hdf5", ".he5"),
        "Zarr": (".zarr",),
        "HTML": (".html", ".htm"),
        "JSON": (".json", ".txt"),
        "TOML": (".toml", ".txt"),
        "PNG": (".png",),
        "picture": (".png", ".svg", ".pdf", ".jpg", ".jpeg", ".tif", ".tiff", ".webp", ".eps", ".ps"),
        "other": (".txt", ".csv", ".md", ".py", ".npy", ".npz", ".gif", ".bmp", ".fits", ".fit", ".img", ".hdr", ".zip",
                  ".gz", ".tar", ".grb", ".grib", ".grib2", ".xml", ".yaml", ".yml", ".oem", ".aem", ".tle"),
    }
)  # fmt: skip
"""Forms of files with the suffixes of their names. The first is the usual one; no command writes the form "other"."""

_FIRST_BYTES = {"NetCDF": (b"\x89HDF", b"CDF"), "HTML": (b"<",), "JSON": (b"{", b"[")}
"""How files of a form begin; a file that begins otherwise is somebody's own and is not replaced."""


class Writing:
    """Yields a hidden path to write to, which is renamed to ``path`` if the ``with`` block raises no exception.

    The draft is in the same folder, so that renaming is atomic: an older file stays intact or is replaced.
    Any exception in the block, including Ctrl-C, removes the draft.

    Parameters
    ----------
    path : Path
        Final name; its folder must exist.
    error : type
        Exception to raise if the system or a library reports an OSError or RuntimeError.
    form : str
        What is written, of :data:`FORMS`; empty for files whose names users do not choose.
    read : iterable of Path
        Files that are inputs.
    """

    def __init__(self, path: Path, error: type[HcssError], form: str = "", read: Iterable[Path] = ()) -> None:
        self._path, self._error, self._form, self._read = path, error, form, tuple(read)
        self._drafted = self._draft()

    def check(self) -> None:
        """Refuse a name that an output file cannot have, before what it shall hold is computed.

        That is the name of a folder, of a device such as /dev/null, a pipe or a socket: renaming a draft would replace
        a device for all processes of the machine. Of an output of a ``form``, it is also a name with the suffix of
        another form, which its readers would believe, and that of a file with other contents. A symbolic link is
        replaced, and its target is not touched. Nor may it be one of the inputs, or a folder that holds one.

        Raises
        ------
        HcssError
            Of the type ``error``, with the path.
        """
        path, error = self._path, self._error
        if path.is_dir():
            raise error(f"cannot write {path}: it is a folder")
        if is_device(path):
            raise error(f"cannot write {path}: it is a device, pipe or socket; allowed: a new name, or that of a file")
        if self._form:
            _require_form(path, error, self._form)
        require_not_read(path, self._read, error)

    def arrays(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Write arrays of numbers or text as an archive of numpy with their checksum, for :meth:`Reading.arrays`."""
        from hcss_twin.core.records import write_arrays

        with self as draft:
            write_arrays(draft, arrays)

    def __enter__(self) -> Path:
        self.check()
        return self._drafted.__enter__()

    def __exit__(self, *raised: Any) -> bool | None:
        return self._drafted.__exit__(*raised)

    @staticmethod
    def flush(path: Path) -> None:
        """Flush a file, or the entries of a folder, to disk."""
        if path.is_dir():
            # some systems cannot open folders; the rename may then not be durable
            with contextlib.suppress(OSError):
                _flush_handle(os.open(path, os.O_RDONLY))
            return
        _flush_handle(os.open(path, os.O_RDWR))

    @staticmethod
    def remove_orphans(folder: Path, every: bool = False) -> None:
        """Remove the drafts that killed processes of this machine left in a folder, or ``every`` draft."""
        for path in folder.glob(".*.partial"):
            about = _DRAFT.fullmatch(path.name)
            if about and (every or (about["machine"] == _machine() and not _is_running(int(about["process"])))):
                shutil.rmtree(path, ignore_errors=True)
                with contextlib.suppress(OSError):
                    path.unlink()

    @contextmanager
    def _draft(self) -> Iterator[Path]:
        path, draft = self._path, draft_of(self._path)
        try:
            yield draft
            with draft.open("rb+") as file:
                os.fsync(file.fileno())
            os.replace(draft, path)
        except (OSError, RuntimeError, ValueError) as cause:  # ValueError: the name is not UTF-8, or has a null byte
            raise self._error(f"cannot write {path}: {getattr(cause, 'strerror', None) or cause}") from cause
        finally:
            with contextlib.suppress(OSError, ValueError):  # never written: no folder, a read-only file system
                draft.unlink()


def _require_form(path: Path, error: type[HcssError], form: str) -> None:
    """Refuse the suffix of another form, and to replace a file with other contents."""
    suffix = Path(f"x{path.name}").suffix.lower()  # that of .zarr, too
    others = {suffix for name, suffixes in FORMS.items() if name != form for suffix in suffixes}
    if suffix not in FORMS[form] and suffix and (suffix in others or form in ("PNG", "picture")):
        closest = path.with_name(f"{path.name.removesuffix(path.suffix)}{FORMS[form][0]}")
        what = f"a {form}" if form == "picture" else form
        raise error(f"cannot write {path}: the output is {what}, not {suffix}; closest is {closest}")
    first = _FIRST_BYTES.get(form)
    if first and path.is_file():
        begins = b""
        with contextlib.suppress(OSError), path.open("rb") as file:  # whether it can be replaced shows later
            begins = file.read(4).lstrip()
        if begins and not begins.startswith(first):
            raise error(f"cannot write {path}: the file there is no {form}, and is not replaced; give another name")


def is_device(path: Path) -> bool:
    """Whether a path is that of a device, a pipe or a socket."""
    return path.exists() and not (path.is_file() or path.is_dir())


def draft_of(path: Path) -> Path:
    """Return a new hidden file name beside a file: with time, machine and process, ending in .partial."""
    about = f"{time.time_ns():016x}-{secrets.token_hex(2)}-{_machine()}-{os.getpid()}"
    return path.with_name(f".{path.name}.{about}.partial")


_DRAFT = re.compile(r"\.(?P<name>.+)\.[0-9a-f]{16}-[0-9a-f]{4}-(?P<machine>[0-9a-f]{8})-(?P<process>[0-9]+)\.partial")


def require_first(draft: Path, path: Path, error: type[HcssError]) -> None:
    """Raise ``error`` if another process began to write the file before ``draft`` was created."""
    for other_draft in path.parent.glob(".*.partial"):
        about = _DRAFT.fullmatch(other_draft.name)
        if about and about["name"] == path.name and other_draft.name < draft.name:
            raise error(f"cannot write {path}: process {about['process']} is writing it; {REMEDY}")


def publish(draft: Path, path: Path, error: type[HcssError], replace: bool = True) -> None:
    """Give a finished file its final name; raises ``error`` if a file of that name exists and must not be replaced."""
    if not replace:
        try:
            os.link(draft, path)
        except OSError:  # the file exists, or the file system has no links
            if path.exists():
                raise error(f"cannot write {path}: another process has written it; {REMEDY}") from None
    os.replace(draft, path)  # does nothing if both are links to one file
    with contextlib.suppress(FileNotFoundError):
        draft.unlink()


def _machine() -> str:
    """Return a hash of the machine, or of the container if it has its own process numbers."""
    try:
        container = os.stat("/proc/self/ns/pid").st_ino
    except OSError:
        container = 0
    return f"{zlib.crc32(f'{platform.node()} {container}'.encode()):08x}"


def _is_running(process: int) -> bool:
    if os.name == "nt":  # signal 0 would end the process
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        pass  # a process of another user
    return True


def require_not_read(output: Path, read: Iterable[Path], error: type[HcssError]) -> None:
    """Refuse to overwrite an input file, or a folder that contains one.

    Raises
    ------
    HcssError
        Of the type ``error``, with the path.
    """
    for path in read:
        same = output.is_file() and path.is_file() and os.path.samefile(output, path)
        if same or (output.is_dir() and path.resolve().is_relative_to(output.resolve())):
            raise error(f"cannot write {output}: it is an input of this command ({path}); give another name")


def _flush_handle(handle: int) -> None:
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def open_format(path: Path, name: str, *versions: int) -> Iterator[Any]:
    """Open a NetCDF file with the expected attributes ``format`` and, among ``versions``, ``format_version``.

    Raises
    ------
    CatalogError
        If it is not NetCDF or has another format.
    """
    with Reading(path, CatalogError, "not a readable NetCDF file").netcdf() as dataset:
        actual = (getattr(dataset, "format", None), int(getattr(dataset, "format_version", 0)))
        if actual[0] != name or actual[1] not in versions:
            allowed = " or ".join(map(str, versions))
            raise CatalogError(f"{path}: format {actual[0]!r} version {actual[1]}; allowed: {name!r} version {allowed}")
        yield dataset
