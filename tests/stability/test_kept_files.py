"""Files that a later run reads instead of computing them: what another program has changed is not used."""

import errno
import os
from pathlib import Path

import numpy as np
import pytest

from hcss_twin.core.errors import CubeError
from hcss_twin.core.files import Writing
from hcss_twin.core.records import read_arrays, write_arrays


def test_an_archive_gives_what_was_written_or_an_error(tmp_path):
    path = tmp_path / "a.npz"
    arrays = {
        "x": np.arange(6.0).reshape(2, 3).T,
        "text": np.array("naïve"),
        "none": np.zeros((0, 3)),
        "one": np.array(3),
    }
    write_arrays(path, arrays)
    read = read_arrays(path)
    assert read.keys() == arrays.keys()
    for name, array in arrays.items():
        assert read[name].dtype == array.dtype
        np.testing.assert_array_equal(read[name], array)
    with np.load(path) as archive:
        changed = dict(archive) | {"x": arrays["x"] + 1e-12}
    np.savez(path, **changed)
    with pytest.raises(ValueError, match="the checksum differs"):
        read_arrays(path)


def test_a_read_only_file_system_is_an_error_although_a_draft_cannot_be_removed_from_it(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(Path, "unlink", refuse)
    with pytest.raises(CubeError, match=r"cannot write .*Read-only"), Writing(tmp_path / "a", CubeError):
        refuse()
