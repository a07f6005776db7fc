"""Files that are kept between runs."""

import dataclasses
import hashlib
import multiprocessing
import os

import numpy as np
import pytest

from hcss_twin.core.cache import CacheError, Store, limit_bytes
from hcss_twin.core.errors import CacheWarning
from hcss_twin.core.records import read_record, write_record


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path))
    monkeypatch.delenv("HCSS_CACHE_MB", raising=False)
    return tmp_path / "things"


def store():
    return Store("things", ".bin")


def keep(key, size):
    store().keep(key, lambda path: path.write_bytes(b"x" * size))


def named(word):
    return hashlib.sha256(word.encode()).hexdigest()


def test_what_is_kept_is_found_and_nothing_else():
    assert store().find("a") is None
    keep("a", 10)
    assert store().find("a").read_bytes() == b"x" * 10
    assert store().find("b") is None


def test_the_least_recently_used_go_first(monkeypatch, folder):
    monkeypatch.setenv("HCSS_CACHE_MB", "0.002")
    for age, key in enumerate(("old", "middle", "new")):
        keep(named(key), 900)
        os.utime(folder / f"{named(key)}.bin", (1e9 + age, 1e9 + age))
        if key == "middle":
            assert store().find(named("old"))  # used now
    (folder / "mine.bin").write_bytes(b"a user's own file")
    keep(named("last"), 900)
    assert {each.path.stem for each in store().kept()} == {named("old"), named("last")}
    store().clear()
    assert [each.name for each in folder.iterdir()] == ["mine.bin"]


@pytest.mark.parametrize("text", ["many", "-1", "nan", "inf", "1e15"])
def test_a_limit_that_is_none_is_refused_by_name(monkeypatch, text):
    monkeypatch.setenv("HCSS_CACHE_MB", text)
    with pytest.raises(CacheError, match="HCSS_CACHE_MB"):
        limit_bytes()


def test_a_limit_of_zero_keeps_nothing(monkeypatch, folder):
    monkeypatch.setenv("HCSS_CACHE_MB", "0")
    keep("a", 10)
    assert not folder.exists()


def test_with_a_limit_of_zero_nothing_kept_is_read(monkeypatch):
    keep("a", 10)
    monkeypatch.setenv("HCSS_CACHE_MB", "0")
    assert store().find("a") is None


def _of_another_user(path):
    os.chown(path, 12345, -1)


def _linked_by_another_user(path):
    path.rename(path.with_name("moved"))
    path.symlink_to(path.with_name("moved"))
    os.chown(path, 12345, -1, follow_symlinks=False)


def _of_a_group(path):
    os.chown(path, -1, 12345)
    path.chmod(path.stat().st_mode | 0o020)


def _of_all(path):
    path.chmod(path.stat().st_mode | 0o002)


@pytest.mark.skipif(os.name == "nt", reason="owners and permissions of POSIX")
@pytest.mark.parametrize("what", ["things", f"things/{named('a')}.bin", "."])
@pytest.mark.parametrize("change", [_of_another_user, _linked_by_another_user, _of_a_group, _of_all])
def test_what_others_can_have_written_is_not_used_and_that_is_said(folder, what, change):
    if change in (_of_another_user, _linked_by_another_user, _of_a_group) and os.getuid() != 0:
        pytest.skip("only root gives files away")
    keep(named("a"), 10)
    path = (folder.parent / what).resolve()
    change(path)
    with pytest.warns(CacheWarning, match=f"the cache is not used: .*{path.name}"):
        assert store().find(named("a")) is None
    if path.name != f"{named('a')}.bin":
        with pytest.warns(CacheWarning, match="the cache is not used"):
            keep(named("b"), 10)
        assert not list(folder.glob(f"{named('b')}*"))


@pytest.mark.skipif(os.name == "nt", reason="permissions of POSIX")
def test_the_private_group_of_the_user_and_a_sticky_folder_above_are_trusted(tmp_path, monkeypatch):
    import pwd

    above = tmp_path / "above"
    monkeypatch.setenv("HCSS_CACHE_DIR", str(above / "own"))
    keep(named("a"), 10)
    (above / "own").chmod(0o775)
    above.chmod(0o1777)
    is_private = pwd.getpwuid(os.getuid()).pw_gid == (above / "own").stat().st_gid
    if is_private:
        assert store().find(named("a"))
    (above / "own").chmod(0o755)
    assert store().find(named("a"))
    above.chmod(0o777)
    with pytest.warns(CacheWarning, match="all users may write to .*above;"):
        assert store().find(named("a")) is None


@pytest.mark.skipif(os.name == "nt", reason="permissions of POSIX")
def test_new_folders_and_files_are_writable_by_their_owner_only(tmp_path, monkeypatch):
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path / "new" / "root"))
    before = os.umask(0)
    try:
        keep("a", 10)
    finally:
        os.umask(before)
    made = sorted((tmp_path / "new").rglob("*"))
    assert [oct(each.stat().st_mode & 0o777) for each in made] == ["0o755", "0o755", "0o644"]


def test_a_changed_byte_of_a_record_is_noticed(tmp_path):
    path, record = tmp_path / "record.npz", (np.arange(5.0), "text", 1.5)
    write_record(path, record, ())
    whole = path.read_bytes()
    for position in range(0, len(whole), 7):
        path.write_bytes(whole[:position] + bytes([whole[position] ^ 0x10]) + whole[position + 1 :])
        try:
            array, *rest = read_record(path, ())
        except Exception:
            continue
        assert array.tobytes() == record[0].tobytes()
        assert rest == list(record[1:])


def test_a_writer_that_fails_leaves_nothing(folder):
    def broken(path):
        path.write_bytes(b"half")
        raise OSError("disk full")

    store().keep("a", broken)
    assert not list(folder.iterdir())


def test_a_folder_whose_place_a_file_has_is_named_and_only_costs_time(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("in the way")
    for name in (tmp_path / "file", tmp_path / "file" / "below"):
        monkeypatch.setenv("HCSS_CACHE_DIR", str(name))
        with pytest.warns(CacheWarning, match=r"/file is no folder; set HCSS_CACHE_DIR to a folder, or HCSS_CACHE_MB"):
            keep("a", 10)
        with pytest.warns(CacheWarning, match="the cache is not used"):
            assert store().find("a") is None
        assert store().kept() == []


def _write_often(key):
    for _ in range(30):
        keep(key, 100_000)
        found = store().find(key)
        assert found is None or found.stat().st_size == 100_000


def test_processes_that_write_at_once_leave_whole_files(folder):
    context = multiprocessing.get_context("spawn")
    workers = [context.Process(target=_write_often, args=(key,)) for key in ("a", "a", "b")]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert [worker.exitcode for worker in workers] == [0, 0, 0]
    assert sorted(path.name for path in folder.iterdir()) == ["a.bin", "b.bin"]


@dataclasses.dataclass(frozen=True)
class Leaf:
    values: np.ndarray
    name: str


@dataclasses.dataclass(frozen=True)
class Tree:
    leaves: tuple
    size: float | None


CLASSES = (Leaf, Tree)


def test_records_come_back_to_the_bit(tmp_path):
    values = np.array([0.1, -0.0, np.pi, 5e-324]), np.arange(6, dtype=np.float32).reshape(2, 3)
    tree = Tree((Leaf(values[0], "a"), (Leaf(values[1], "b"), None)), 0.1 + 0.2)
    write_record(tmp_path / "tree.npz", tree, CLASSES)
    back = read_record(tmp_path / "tree.npz", CLASSES)
    assert back.size == tree.size
    assert back.leaves[0].values.tobytes() == values[0].tobytes()
    assert (back.leaves[1][0].values.dtype, back.leaves[1][1]) == (np.float32, None)
    assert back.leaves[1][0].values.tobytes() == values[1].tobytes()


def test_what_no_record_can_hold_is_refused(tmp_path):
    with pytest.raises(TypeError, match="set"):
        write_record(tmp_path / "tree.npz", Tree(({1},), None), CLASSES)
