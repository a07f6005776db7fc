"""Small input files that travel in the provenance of a cube, so that it can be recomputed where they do not exist."""

from __future__ import annotations

import base64
import hashlib
import json
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path, PurePath
from tempfile import TemporaryDirectory
from typing import Any

from hcss_twin.core.errors import CubeError

LARGEST_BYTES = 256 * 1024
"""Largest file that is stored; the hash of a larger one is."""

ALL_BYTES = 1024 * 1024
"""Size of all files that a run stores, the smallest of which come first."""

MOST_BYTES = 2 * ALL_BYTES
"""Size of all files in a cube: those of its scene, and those of a sensor that measured it later."""


def packed(paths: Mapping[str, Path], hashes: Mapping[str, str]) -> dict[str, str]:
    """Return small files for an attribute: content by SHA-256, compressed and in base64, without names or folders.

    Parameters
    ----------
    paths : mapping of str to Path
        Files by the names they have in ``hashes``.
    hashes : mapping of str to str
        SHA-256 of what was read; a file that has changed since is left out.
    """
    contents: dict[str, bytes] = {}
    for name, path in paths.items():
        try:
            content = path.read_bytes() if path.stat().st_size <= LARGEST_BYTES else None
        except OSError:  # deleted since it was read
            continue
        if content is not None and hashlib.sha256(content).hexdigest() == hashes[name]:
            contents[hashes[name]] = content
    stored, left = {}, ALL_BYTES
    for digest, content in sorted(contents.items(), key=lambda item: (len(item[1]), item[0])):
        left -= len(content)
        if left >= 0:
            stored[digest] = base64.b64encode(zlib.compress(content, 9)).decode("ascii")
    return stored


class StoredFiles:
    """Files that a cube stores, unpacked into a folder of their own as long as they are needed.

    Attributes
    ----------
    paths : mapping of str to Path
        Unpacked files by the name that the cube records: the absolute path at the time.
    """

    def __init__(self, paths: Mapping[str, Path]) -> None:
        self.paths = dict(paths)
        self._names = {path: name for name, path in self.paths.items()}

    @classmethod
    @contextmanager
    def unpacked(cls, text: Any, hashes: Mapping[str, str], cube: str) -> Iterator[StoredFiles]:
        """Unpack the files that :func:`packed` returned.

        Parameters
        ----------
        text : str or None
            As JSON; None if the cube stores none.
        hashes : mapping of str to str
            SHA-256 by recorded name.
        cube : str
            Name of the cube in messages.

        Raises
        ------
        CubeError
            If a stored file is not the one that was read, or cannot be unpacked.
        """
        contents = _contents(text, cube)
        own = {name: contents[digest] for name, digest in hashes.items() if digest in contents}
        with TemporaryDirectory(prefix="hcss-inputs-") as folder:
            paths = {}
            for name, content in own.items():
                parts = PurePath(name).parts
                if not PurePath(name).is_absolute() or ".." in parts:
                    continue
                # folders are kept, because a file may name its neighbours
                paths[name] = Path(folder).resolve().joinpath(*parts[1:])
                try:
                    paths[name].parent.mkdir(parents=True, exist_ok=True)
                    paths[name].write_bytes(content)
                except (OSError, ValueError) as error:  # a name that is too long, or that of a folder of another file
                    raise CubeError(f"{cube}: a stored input file cannot be unpacked: {error}") from error
            yield cls(paths)

    def find(self, path: Path) -> Path | None:
        """Return the unpacked file that a path of the scenario means, absolute or relative to its folder then."""
        if path.is_absolute():
            return self.paths.get(str(path))
        parts = tuple(part for part in path.parts if part not in ("..", "."))
        found = [file for name, file in self.paths.items() if parts and PurePath(name).parts[-len(parts) :] == parts]
        return found[0] if len(found) == 1 else None

    def name_of(self, path: Path) -> str | None:
        """Return the recorded name of an unpacked file; None for any other file."""
        return self._names.get(path)


def _contents(text: Any, cube: str) -> dict[str, bytes]:
    """Return the stored files by SHA-256."""
    try:
        table = {} if text is None else json.loads(text)
        contents, left = dict[str, bytes](), MOST_BYTES
        for digest, text_of_file in table.items():
            contents[str(digest)] = _inflated(base64.b64decode(text_of_file, validate=True), min(left, LARGEST_BYTES))
            left -= len(contents[str(digest)])
    except (ValueError, TypeError, AttributeError, RecursionError, zlib.error) as error:
        raise CubeError(f"{cube}: its stored input files are damaged: {error}") from error
    for digest, content in contents.items():
        if hashlib.sha256(content).hexdigest() != digest:
            raise CubeError(f"{cube}: a stored input file was altered: it does not have the SHA-256 {digest}")
    return contents


def _inflated(content: bytes, most: int) -> bytes:
    inflate = zlib.decompressobj()
    result = inflate.decompress(content, most + 1)
    if len(result) > most or not inflate.eof:
        raise ValueError(f"one is cut off, or larger than {LARGEST_BYTES} bytes, or all than {MOST_BYTES}")
    return result
