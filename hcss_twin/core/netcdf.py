"""The door to NetCDF files: one lock for all calls of the library, and one handle for each file that is read.

The libraries netCDF and HDF5 are not thread safe. Besides, HDF5 ends the process when it reads texts of a file that has
been opened twice and closed once (https://github.com/Unidata/netcdf4-python/issues/1444; netCDF4 1.6.5 to 1.7.5.1).
"""

from __future__ import annotations

import gc
import os
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache, partial
from typing import TYPE_CHECKING, Any, Literal, Self

if TYPE_CHECKING:
    import xarray as xr


NETCDF = (b"\x89HDF", b"CDF\x01", b"CDF\x02", b"CDF\x05")
"""First bytes of NetCDF-4 files and of older formats."""


class _Lock:
    """Re-entrant lock that includes xarray's lock for NetCDF, so that values read by others with xarray are safe, too.

    The garbage collector finds files that nobody uses in any thread, at any time. It must not wait for the lock, so
    these files are closed when the lock is free.
    """

    def __init__(self) -> None:
        self._own = threading.RLock()
        self._depth = 0
        self._others: list[Any] = []
        self._abandoned: deque[Callable[[], None]] = deque()
        if hasattr(os, "register_at_fork"):  # a copy of the process must not begin in the middle of a call
            os.register_at_fork(before=self.__enter__, after_in_parent=self.__exit__, after_in_child=self.__exit__)

    def __enter__(self) -> None:
        self._own.acquire()
        self._depth += 1
        try:
            if self._depth == 1:
                self._take_others(blocking=True)
        except BaseException:
            self.__exit__()
            raise

    def __exit__(self, *_: object) -> None:
        if self._depth == 1:
            while self._abandoned:
                self._abandoned.popleft()()
            while self._others:
                self._others.pop().release()
        self._depth -= 1
        self._own.release()

    def when_free(self, close: Callable[[], None]) -> None:
        """Call ``close`` now if no other code uses the library, otherwise when the lock is released."""
        self._abandoned.append(close)
        if not self._own.acquire(blocking=False):
            return
        if self._depth == 0:
            self._depth = 1
            if self._take_others(blocking=False):
                self.__exit__()
                return
            self._depth = 0
        self._own.release()

    def _take_others(self, blocking: bool) -> bool:
        backend = sys.modules.get("xarray.backends.netCDF4_")
        for lock in getattr(getattr(backend, "NETCDF4_PYTHON_LOCK", None), "locks", ()):
            if not lock.acquire(blocking):
                while self._others:
                    self._others.pop().release()
                return False
            self._others.append(lock)
        return True


@cache
def netcdf_lock() -> _Lock:
    """Return the lock of all calls of the NetCDF library by this package; computing must not hold it.

    A block that holds it must not use xarray's own NetCDF files, whose lock is not re-entrant.
    """
    return _Lock()


class _Guarded:
    """An object of ``netCDF4`` each use of which takes the lock."""

    def __init__(self, held: Any, file: NetcdfFile | None = None) -> None:
        vars(self).update(_held=held, _file=file)

    def __getattr__(self, name: str) -> Any:
        with netcdf_lock():
            self._prepare()
            return self._guard(getattr(self._held, name))

    def __setattr__(self, name: str, value: Any) -> None:
        with netcdf_lock():
            setattr(self._held, name, value)

    def __delattr__(self, name: str) -> None:
        with netcdf_lock():
            delattr(self._held, name)

    def __len__(self) -> int:
        with netcdf_lock():
            return len(self._held)

    def __repr__(self) -> str:
        with netcdf_lock():
            return repr(self._held)

    @property
    def _owner(self) -> Any:
        """The file, which stays open as long as one of its objects is used."""
        return self if self._file is None else self._file

    def _prepare(self) -> None:
        """Bring shared settings of the object into the state that the user of this one wants."""

    def _guard(self, value: Any) -> Any:
        import netCDF4

        if isinstance(value, netCDF4.Variable):
            return NetcdfVariable(value, self._owner)
        if isinstance(value, netCDF4.Dimension | netCDF4.Dataset):
            return (_Group if isinstance(value, netCDF4.Dataset) else _Guarded)(value, self._owner)
        if isinstance(value, Mapping):
            return {name: self._guard(item) for name, item in value.items()}
        return partial(self._call, value) if callable(value) and not isinstance(value, type) else value

    def _call(self, method: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
        with netcdf_lock():
            self._prepare()
            return self._guard(method(*args, **kwargs))


class NetcdfVariable(_Guarded):
    """A ``netCDF4.Variable``, with its own settings although others may read it through the same handle."""

    def __init__(self, held: Any, file: NetcdfFile | None = None) -> None:
        super().__init__(held, file)
        vars(self).update(_settings={f"set_{name}": True for name in _SETTINGS})

    def __getattr__(self, name: str) -> Any:
        if name in self._settings:
            return partial(self._settings.__setitem__, name)
        return super().__getattr__(name)

    def set_auto_maskandscale(self, flag: bool) -> None:
        """As in ``netCDF4.Variable``."""
        self._settings.update(set_auto_mask=flag, set_auto_scale=flag)

    def __getitem__(self, index: Any) -> Any:
        with netcdf_lock():
            self._prepare()
            return self._held[index]

    def __setitem__(self, index: Any, values: Any) -> None:
        with netcdf_lock():
            self._prepare()
            self._held[index] = values

    def __array__(self, *args: Any, **kwargs: Any) -> Any:
        import numpy as np

        return np.asarray(self[...]).__array__(*args, **kwargs)

    def _prepare(self) -> None:
        for setting, flag in self._settings.items():
            getattr(self._held, setting)(flag)


_SETTINGS = ("auto_mask", "auto_scale", "auto_chartostring", "always_mask")


class _Group(_Guarded):
    """A ``netCDF4.Group``."""

    def __init__(self, held: Any, file: NetcdfFile | None = None) -> None:
        super().__init__(held, file)
        vars(self).update(_variables={})

    @property
    def variables(self) -> dict[str, NetcdfVariable]:
        """Variables by name; each keeps its settings."""
        with netcdf_lock():
            for name, variable in self._held.variables.items():
                if name not in self._variables:
                    self._variables[name] = NetcdfVariable(variable, self._owner)
        return self._variables  # type: ignore[no-any-return]

    def createVariable(self, *args: Any, **kwargs: Any) -> NetcdfVariable:  # as in netCDF4
        """As in ``netCDF4.Dataset``."""
        with netcdf_lock():
            name = self._held.createVariable(*args, **kwargs).name
            return self.variables[name]

    def set_auto_mask(self, flag: bool) -> None:
        """Set for all variables, as in ``netCDF4.Dataset``."""
        for variable in self.variables.values():
            variable.set_auto_mask(flag)

    def set_auto_maskandscale(self, flag: bool) -> None:
        """Set for all variables, as in ``netCDF4.Dataset``."""
        for variable in self.variables.values():
            variable.set_auto_maskandscale(flag)

    def __getitem__(self, name: str) -> Any:
        found = self.variables.get(name)
        if found is not None:
            return found
        with netcdf_lock():
            return self._guard(self._held[name])


class NetcdfFile(_Group):
    """A ``netCDF4.Dataset`` for any thread: each use takes the lock, and files that nobody uses are closed.

    Files that are read are opened once in a process; their last user closes them.

    Parameters
    ----------
    path : path-like
        A file. Streams and network addresses are not opened.
    mode : {"r", "w", "a"}
        To read; for a new file; or to add to one. Files that are written must not be open elsewhere.
    """

    def __init__(self, path: str | os.PathLike[str], mode: Literal["r", "w", "a"] = "r") -> None:
        import netCDF4

        with netcdf_lock():
            dataset, leave = _shared_handles().open(path) if mode == "r" else (netCDF4.Dataset(path, mode), None)
            super().__init__(dataset)
            vars(self).update(_close=leave or dataset.close)

    @staticmethod
    def open_with_xarray(path: str | os.PathLike[str], **options: Any) -> xr.Dataset:
        """Open a NetCDF file as a dataset whose values are read on access, from any thread.

        Parameters
        ----------
        path : path-like
        **options
            As for ``xarray.open_dataset``.
        """
        import xarray as xr

        manager = _Reopened(os.path.abspath(path))
        with netcdf_lock():
            try:
                return xr.open_dataset(_store(manager), **options)
            except BaseException:
                manager.close()
                raise

    @staticmethod
    def write_with_xarray(dataset: xr.Dataset, path: str | os.PathLike[str], **options: Any) -> None:
        """Write a dataset in memory as a NetCDF-4 file, as ``to_netcdf``, from any thread.

        Parameters
        ----------
        dataset : Dataset
            Without values that are still in files of others.
        path : path-like
        **options
            As for ``xarray.Dataset.dump_to_store``.
        """
        manager = _Reopened(os.path.abspath(path), "w")
        with netcdf_lock():
            try:
                dataset.dump_to_store(_store(manager, mode="w"), **options)
            finally:
                manager.close()

    def isopen(self) -> bool:
        """Whether the file can be used."""
        return self._close is not None and bool(self._held.isopen())

    def close(self) -> None:
        """Close the file, unless others still read it; a second call does nothing."""
        close = self._close
        if close is not None:
            with netcdf_lock():
                vars(self).update(_close=None, _held=_Closed())
                close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        close = vars(self).get("_close")
        if close is not None:
            netcdf_lock().when_free(close)


class _Closed:
    """In place of a file that was closed."""

    def __getattr__(self, name: str) -> Any:
        raise RuntimeError("NetCDF: the file is closed")


class _Handles:
    """Open files that are read, with the number of their users.

    A file that a user of this package has open with netCDF4 or xarray is read through that handle, which stays open.
    """

    def __init__(self) -> None:
        self._open: dict[tuple[int, int], tuple[Any, int]] = {}

    def open(self, path: str | os.PathLike[str]) -> tuple[Any, Callable[[], None]]:
        """Return the dataset of a file, and the function by which its user leaves it."""
        import netCDF4

        about = os.stat(path)
        file = about.st_dev, about.st_ino
        if file not in self._open:
            foreign = _opened_by_others(file)
            if foreign is not None:
                return foreign, lambda: None
        dataset, users = self._open[file] if file in self._open else (netCDF4.Dataset(os.fspath(path)), 0)
        self._open[file] = dataset, users + 1
        return dataset, partial(self._leave, file)

    def _leave(self, file: tuple[int, int]) -> None:
        dataset, users = self._open.pop(file)
        if users > 1:
            self._open[file] = dataset, users - 1
        else:
            dataset.close()


def _opened_by_others(file: tuple[int, int]) -> Any:
    """Return an open dataset of a file, by device and inode, that other code of this process has; None without."""
    import netCDF4

    descriptors = "/proc/self/fd"  # a list: an iterator that is left early warns when it is collected
    if os.path.isdir(descriptors) and file not in (_identity(f"{descriptors}/{n}") for n in os.listdir(descriptors)):
        return None
    gc.unfreeze()  # hcss, and others before a fork, hide all objects from the search
    for candidate in gc.get_objects():
        if type(candidate) is netCDF4.Dataset and candidate.isopen() and _identity(candidate.filepath()) == file:
            return candidate
    return None


def _identity(path: Any) -> tuple[int, int] | None:
    try:
        about = os.stat(path)
    except (OSError, ValueError):  # closed meanwhile, or of another kind
        return None
    return about.st_dev, about.st_ino


@cache
def _shared_handles() -> _Handles:
    return _Handles()


class _Reopened:
    """What xarray calls a file manager: opens a file again after it was closed, or in another process."""

    def __init__(self, path: str, mode: Literal["r", "w"] = "r") -> None:
        self._path, self._mode = path, mode
        self._file: NetcdfFile | None = None

    def acquire(self, needs_lock: bool = True) -> NetcdfFile:
        with netcdf_lock():
            if self._file is None or not self._file.isopen():
                self._file = NetcdfFile(self._path, self._mode)
            return self._file

    @contextmanager
    def acquire_context(self, needs_lock: bool = True) -> Iterator[NetcdfFile]:
        yield self.acquire()

    def close(self, needs_lock: bool = True) -> None:
        with netcdf_lock():
            file, self._file = self._file, None
            if file is not None:
                file.close()

    def __reduce__(self) -> Any:
        return _Reopened, (self._path, self._mode)


def _store(manager: _Reopened, **options: Any) -> Any:
    """Return what xarray reads and writes; the file itself takes the lock."""
    import xarray as xr

    store: Any = xr.backends.NetCDF4DataStore
    return store(manager, lock=False, **options)
