"""Damage to the files of ``input_files.py``, and what the functions of ``file_readers.py`` do with damaged files.

Each damage is determined by its seed.
"""

import random
import re
import shutil
import traceback
import warnings
from collections import Counter

import netCDF4
import numpy as np
from file_readers import READERS
from hang import Hang, limited

from hcss_twin.core.errors import HcssError

WORDS = [b"", b"0", b"-1", b"1e999", b"nan", b"null", b"[]", b"{}", b"true", b'"x"', b"\xff", b"9" * 400, b"[" * 5000]


def damage(path, seed):
    """Damage a file, or one file of a folder, in place."""
    draw = random.Random(seed)
    if path.is_dir():
        path = draw.choice(sorted(each for each in path.rglob("*") if each.is_file()))
    if path.suffix == ".nc" and draw.random() < 0.5:
        return _damage_header(path, draw)
    if path.suffix in (".npz", ".state") and draw.random() < 0.5:
        return _damage_archive(path, draw)
    data = bytearray(path.read_bytes())
    for _ in range(draw.choice([1, 1, 2, 8])):
        place, kind = draw.randrange(len(data) + 1), draw.randrange(6)
        if kind == 0 and data:
            data[min(place, len(data) - 1)] ^= 1 << draw.randrange(8)
        elif kind == 1:
            del data[place : place + draw.choice([1, 4, 100])]
        elif kind == 2:
            data[place:place] = draw.choice(WORDS)
        elif kind == 3:
            data[place : place + 8] = bytes(draw.randrange(256) for _ in range(8))
        elif kind == 4 and draw.random() < 0.3:
            del data[place:]
        elif path.suffix not in BINARY:
            _replace_token(data, draw)
    path.write_bytes(data)
    return None


BINARY = (".nc", ".npy", ".npz", ".state", ".png", ".tif", ".jpg")


def _replace_token(data, draw):
    """Replace a word, a number or a bracket of a text."""
    tokens = [each.span() for each in re.finditer(rb'[\w.+-]+|"[^"]*"|\[[^\[\]]*\]|\{[^{}]*\}', bytes(data))]
    if tokens:
        first, last = draw.choice(tokens)
        data[first:last] = draw.choice(WORDS)


def _damage_header(path, draw):
    """Change an attribute, a value or a name of a NetCDF file to one of another kind."""
    values = ["", "x", "{}", "[]", '{"a": 1}', np.float64("nan"), np.int32(-1), 1e300, np.arange(3.0), "\x00", "9" * 99]
    with netCDF4.Dataset(path, "a") as file:
        owners = [file, *file.variables.values()]
        owner = draw.choice(owners)
        names = owner.ncattrs()
        kind = draw.randrange(4)
        if kind == 0 and names:
            owner.delncattr(draw.choice(names))
        elif kind == 1 and file.variables:
            file.renameVariable(draw.choice(sorted(file.variables)), "other")
        elif kind == 2 and owner is not file and owner.dtype is not str and owner.dtype.kind in "fiu" and owner.size:
            owner.set_auto_mask(False)
            owner[...] = draw.choice([0, 1, 100])
        elif names:
            name = draw.choice(names)
            if name not in ("_FillValue",):
                value = owner.getncattr(name)
                if isinstance(value, str) and value.startswith(("{", "[")) and draw.random() < 0.7:
                    text = bytearray(value.encode())
                    _replace_token(text, draw)
                    owner.setncattr(name, text.decode(errors="replace").replace("\0", ""))
                else:
                    owner.setncattr(name, draw.choice(values))


def _damage_archive(path, draw):
    """Change an array of a NumPy archive to one of another shape, kind or value, with a valid checksum."""
    with path.open("rb") as file, np.load(file) as archive:
        arrays = {name: archive[name] for name in archive.files}
    name = draw.choice(sorted(arrays))
    old = arrays[name]
    if old.dtype.kind in "SU" and draw.random() < 0.7:
        text = bytearray(str(old).encode())
        _replace_token(text, draw)
        arrays[name] = np.array(text.decode(errors="replace"))
    else:
        others = [np.zeros(0), np.array("x"), np.array(-1), old[..., None], old.ravel()[:1], old.astype("S8")]
        if old.dtype.kind == "f":
            others += [np.full_like(old, value) for value in (np.nan, np.inf, 1e300, 0.0)]
        chosen = draw.randrange(len(others) + 1)
        arrays.pop(name) if chosen == len(others) else arrays.update({name: others[chosen]})
    with path.open("wb") as file:
        np.savez(file, **arrays)


def fresh_copy(path, folder):
    """Return a copy of a file or folder, of the same name, in a folder."""
    copy = folder / path.name
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(path, copy) if path.is_dir() else shutil.copy(path, copy)
    return copy


def read_damaged(group, files, folder, number):
    """Damage the file that a seed draws from a group of readers, and read it.

    Returns
    -------
    outcome, file, reader, problem
        ``read``, ``refused``, ``not damaged`` or ``escaped``; the last is the exception that escaped.
    """
    draw = random.Random(f"{group} {number}")  # not the numbers that choose the damage
    name, reader = draw.choice([(name, reader) for name, own in READERS[group].items() for reader in own])
    copy = fresh_copy(files[name], folder)
    try:
        damage(copy, number)
    except Exception:  # the library that damages refuses
        return "not damaged", name, reader, None
    try:
        with warnings.catch_warnings(), limited():
            warnings.simplefilter("ignore")
            READERS[group][name][reader](copy)
    except HcssError:
        return "refused", name, reader, None
    except (Exception, Hang) as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        return "escaped", name, reader, f"{type(error).__name__} at {last.name}:{last.lineno}: {str(error)[:200]}"
    return "read", name, reader, None


def what_escapes(group, files, folder, seeds):
    """Damage a file for each seed; return exceptions other than the package's with their seeds, and outcomes."""
    escaped, outcomes = {}, Counter()
    for number in seeds:
        outcome, name, reader, problem = read_damaged(group, files, folder, number)
        outcomes[outcome] += 1
        if problem is not None:
            escaped.setdefault(f"{name} {reader}: {problem}", number)
    return escaped, dict(outcomes)
