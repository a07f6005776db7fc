"""Whether other users could have written a file: cached results determine the values of cubes.

On Windows, where owners and permissions are of another kind, nothing is examined.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path


def distrust(path: Path) -> str:
    """Return why a file or folder may be the work of another user; empty if it cannot, or does not exist.

    It must belong to this user or to root, and nobody else may write to it: neither all users nor a group, except the
    private group of this user, of that name and without other members, with which many systems create files. Neither
    may it be a symbolic link that belongs to another user. All users may write to none of the folders above it, unless
    they can rename nothing there but their own files (the sticky bit, as of /tmp). Folders above that a group may write
    to are accepted: a team may keep the homes of its members in one.
    """
    if os.name == "nt":
        return ""
    try:
        about, link = path.stat(), path.lstat()
    except (FileNotFoundError, NotADirectoryError):
        return ""
    except OSError as error:
        return f"{path} cannot be examined: {error.strerror}"
    for status in (link, about):
        if status.st_uid not in (os.getuid(), 0):
            return f"{path} belongs to another user (number {status.st_uid})"
    if about.st_mode & stat.S_IWOTH:
        return f"all users may write to {path}"
    if about.st_mode & stat.S_IWGRP and not _is_private(about.st_gid):
        return f"a group (number {about.st_gid}) may write to {path}"
    for above in path.resolve().parents:
        mode = above.stat().st_mode
        if mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
            return f"all users may write to {above}"
    return ""


def _is_private(group: int) -> bool:
    """Whether a group has the name of this user and no other member."""
    import grp
    import pwd

    try:
        name, about = pwd.getpwuid(os.getuid()).pw_name, grp.getgrgid(group)
    except KeyError:  # a user or a group without a name
        return False
    return about.gr_name == name and set(about.gr_mem) <= {name}


def make_private(folder: Path) -> None:
    """Make a folder and those above it that do not exist, writable by this user only."""
    if not folder.is_dir():
        make_private(folder.parent)
        folder.mkdir(mode=0o755, exist_ok=True)


def withhold(path: Path) -> None:
    """Take the permission to write a new file from all other users, whatever the user's mask gives them."""
    path.chmod(stat.S_IMODE(path.stat().st_mode) & ~(stat.S_IWGRP | stat.S_IWOTH))
